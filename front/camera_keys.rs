//! The file of a camera path: its keys, or the first reason for which a camera cannot follow them.

use std::path::Path;

use super::camera_path::{CAMERA_PATH, Key};
use crate::diagnostic::{Diagnostic, codes, suggested_name};
use crate::glam::DVec3;
use crate::low_level::document::schema::unknown_key;
use crate::low_level::document::{self, Entry, Kind, Value};
use crate::low_level::source::Sources;

/// The largest number that a camera can use, in metres or seconds.
const MAX_NUMBER: f64 = 1e12;

/// Reads the keys of a camera path. The file is added to `sources`, in which the error has its place.
///
/// # Errors
/// A file that cannot be read, is no camera path, or has values that no camera can use.
pub(super) fn read(path: &Path, sources: &mut Sources) -> Result<Vec<Key>, Diagnostic> {
    let name = path.display().to_string();
    let meant = suggested_name(&name, ["orbit", "walk", "random"]);
    if let Some(meant) = meant.filter(|_| !path.exists()) {
        let message = format!("there is no camera path \"{name}\", and no such file");
        return Err(
            Diagnostic::in_file(CAMERA_PATH, name, "", message).help(format!("did you mean \"{meant}\"?"))
        );
    }
    let file = crate::low_level::read_source(path, sources)?;
    let parsed = document::parse(sources, file);
    if let Some(first) = parsed.diagnostics.iter().next() {
        let mut error = first.clone();
        (error.code, error.message) = (CAMERA_PATH, format!("this is no camera path: {}", first.message));
        error.help = error.help.filter(|_| first.code != codes::SYNTAX);
        return Err(if error.help.is_none() { error.help(FORM) } else { error });
    }
    keys(&parsed.document.root)
}

const FORM: &str = "a path is { \"keys\": [ { \"time\": seconds, \"position\": [x, y, z], \"target\": [x, y, z] }, … ] }; \
                    there are orbit, walk and random, too";

fn keys(root: &Value) -> Result<Vec<Key>, Diagnostic> {
    if root.elements().is_some() {
        let message = "a camera path is an object, this is an array";
        return Err(wrong(root, message).help("put the list under \"keys\": { \"keys\": [ … ] }"));
    }
    members(root, "a camera path", &["keys"])?;
    let list = member(root, "keys", "a camera path")?;
    let Some(list_of_keys) = list.elements() else {
        return Err(wrong(list, format!("\"keys\" is an array, this is {}", list.kind_name())).help(FORM));
    };
    if list_of_keys.is_empty() {
        return Err(wrong(list, "a camera path has no keys").help(FORM));
    }
    let mut keys: Vec<Key> = Vec::with_capacity(list_of_keys.len());
    for (at, value) in list_of_keys.iter().enumerate() {
        let key = key(at, value)?;
        if let Some(before) = keys.last().filter(|before| before.time >= key.time) {
            let message = format!("key {at} is at {} s, key {} at {} s", key.time, at - 1, before.time);
            let error = wrong(value.get("time").unwrap_or(value), message);
            let before = list_of_keys[at - 1].span;
            return Err(error.related(before, "the key before").help("sort the keys; no two have one time"));
        }
        keys.push(key);
    }
    Ok(keys)
}

fn key(at: usize, value: &Value) -> Result<Key, Diagnostic> {
    let what = format!("key {at}");
    members(value, &what, &["time", "position", "target"])?;
    let [time, position, target] = ["time", "position", "target"].map(|name| member(value, name, &what));
    let (time, position, target) = (number(time?, "time", &what)?, position?, target?);
    let key =
        Key { time, position: point(position, "position", &what)?, target: point(target, "target", &what)? };
    if key.rotation().is_some() {
        return Ok(key);
    }
    let (from, to) = (DVec3::from(key.position), DVec3::from(key.target));
    let [x, y, z] = key.position;
    if from == to {
        let message = format!("{what} looks nowhere: \"position\" and \"target\" are both [{x}, {y}, {z}]");
        return Err(wrong(target, message).help("move one of the two"));
    }
    let direction = if to.y > from.y { "up" } else { "down" };
    let [tx, ty, tz] = key.target;
    let message = format!(
        "{what} looks straight {direction}, from [{x}, {y}, {z}] to [{tx}, {ty}, {tz}], and up is +Y"
    );
    let help = format!("move \"position\" a little aside: [{x}, {y}, {}]", z + 0.01);
    Err(wrong(position, message).help(help))
}

fn wrong(value: &Value, message: impl Into<String>) -> Diagnostic {
    Diagnostic::error(CAMERA_PATH, value.span, message)
}

/// Checks that a value is an object with no other keys than `known`.
fn members(value: &Value, what: &str, known: &[&str]) -> Result<(), Diagnostic> {
    let Some(entries) = value.entries() else {
        return Err(wrong(value, format!("{what} is an object, this is {}", value.kind_name())).help(FORM));
    };
    let is_unknown = |entry: &&Entry| !known.contains(&entry.key.as_str());
    entries.iter().find(is_unknown).map_or(Ok(()), |entry| {
        let mut error = unknown_key(entry, known, entries);
        (error.code, error.message) = (CAMERA_PATH, format!("{what} has an {}", error.message));
        Err(error)
    })
}

fn member<'v>(value: &'v Value, name: &str, what: &str) -> Result<&'v Value, Diagnostic> {
    value.get(name).ok_or_else(|| wrong(value, format!("{what} has no \"{name}\"")).help(FORM))
}

fn number(value: &Value, name: &str, what: &str) -> Result<f64, Diagnostic> {
    let Kind::Number(number) = &value.kind else {
        let message = format!("\"{name}\" of {what} is a number, this is {}", value.kind_name());
        return Err(wrong(value, message).help(FORM));
    };
    number.as_f64().filter(|number| number.is_finite() && number.abs() < MAX_NUMBER).ok_or_else(|| {
        let message = format!("{what} has a number that no camera can use, in \"{name}\"");
        wrong(value, message).help("numbers lie within 1e12 of zero")
    })
}

fn point(value: &Value, name: &str, what: &str) -> Result<[f64; 3], Diagnostic> {
    let numbers = value.elements().unwrap_or_default().iter().map(|one| number(one, name, what));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    <[f64; 3]>::try_from(numbers).map_err(|numbers| {
        let found = match value.elements() {
            Some(_) => format!("this list has {} elements", numbers.len()),
            None => format!("this is {}", value.kind_name()),
        };
        let sides = ["x", "y", "z"].map(|side| match value.get(side).map(|value| &value.kind) {
            Some(Kind::Number(number)) => number.to_string(),
            _ => side.to_owned(),
        });
        let message = format!("\"{name}\" of {what} is a list of three numbers, {found}");
        wrong(value, message).help(format!("write [{}]", sides.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> (String, String) {
        let mut sources = Sources::new();
        let file = sources.add("keys.json", text);
        let error = keys(&document::parse(&sources, file).document.root).unwrap_err();
        let marked = error.span().map(|span| sources.text(span).to_owned()).unwrap_or_default();
        (format!("{}; {}", error.message, error.help.unwrap_or_default()), marked)
    }

    #[test]
    fn each_mistake_in_keys_is_marked_with_a_way_out() {
        let key = |position: &str, target: &str| {
            format!("{{ \"keys\": [{{ \"time\": 0, \"position\": {position}, \"target\": {target} }}] }}")
        };
        for (text, says, marks) in [
            ("[1]".to_owned(), "put the list under \"keys\"", "[1]"),
            (
                "{ \"keys\": [{ \"time\": 0, \"position\": [0, 1, 2] }] }".to_owned(),
                "key 0 has no \"target\"",
                "{",
            ),
            (key("{ \"x\": 0, \"y\": 2, \"z\": 8 }", "[0, 1, 0]"), "write [0, 2, 8]", "{ \"x\""),
            (key("[0, 1]", "[0, 1, 0]"), "this list has 2 elements", "[0, 1]"),
            (key("[0, 1, 0]", "[0, 1, 0]"), "are both [0, 1, 0]", "[0, 1, 0]"),
            (key("[0, 8, 0]", "[0, 1, 0]"), "straight down, from [0, 8, 0] to [0, 1, 0]", "[0, 8, 0]"),
            (key("[0, 1e300, 0]", "[0, 1, 0]"), "no camera can use", "1e300"),
            (
                key("[0, 8, 0]", "[0, 1, 0]").replace("target", "traget"),
                "did you mean \"target\"",
                "\"traget\"",
            ),
        ] {
            let (message, marked) = said(&text);
            assert!(message.contains(says) && marked.starts_with(marks), "{text}: {message} at {marked}");
        }
        let pair = "{ \"keys\": [{ \"time\": 1, \"position\": [0, 2, 8], \"target\": [0, 1, 0] },\
                     { \"time\": 0, \"position\": [0, 2, 8], \"target\": [0, 1, 0] }] }";
        assert!(said(pair).0.starts_with("key 1 is at 0 s, key 0 at 1 s; sort the keys"));
    }
}
