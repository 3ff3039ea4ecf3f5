//! Values that are set: of arrays and objects only what differs.

use std::collections::HashMap;

use serde_json::Value as Json;

use super::arrange::{Item, Wanted, arrange, laid_out};
use super::layout::{Layout, line_start};
use super::{Edit, EditError, Edits};
use crate::document::{Kind, Value};

/// Returns the edits that change the JSON value `value` of a text to `new`.
///
/// Unchanged members and elements keep their source text. In an array, equal elements at the start and at the end are
/// kept. In an object, members with the same keys are kept; if their order changes, the object is replaced.
///
/// # Errors
/// A value that is not in this text.
pub fn set(text: &str, value: &Value, new: &Json) -> Result<Edits, EditError> {
    let mut edits = Vec::new();
    change(text, value, new, &mut edits)?;
    Edits::new(edits)
}

/// Returns the edits that write values as the defaults of parameters or features into a document. `section` is
/// `parameters` or `features`, and `values` has the new defaults by name. A parameter or feature that only an extended
/// or included file declares gets a member in this file with nothing but the default.
///
/// # Errors
/// A document in which the section, or a declaration in the section, is not an object.
pub fn save<'a>(
    text: &str,
    document: &Value,
    section: &str,
    values: impl IntoIterator<Item = (&'a str, Json)>,
) -> Result<Edits, EditError> {
    fn member<'j>(of: &'j mut Json, key: &str) -> Result<&'j mut Json, EditError> {
        let members = of.as_object_mut().ok_or(EditError::NoContainer)?;
        Ok(members.entry(key).or_insert_with(|| Json::Object(Default::default())))
    }
    let mut saved = document.to_json();
    for (name, value) in values {
        let declaration = member(member(&mut saved, section)?, name)?;
        *member(declaration, "default")? = value;
    }
    set(text, document, &saved)
}

fn change(text: &str, value: &Value, json: &Json, edits: &mut Vec<Edit>) -> Result<(), EditError> {
    if is_same(value, json) {
        return Ok(());
    }
    let items: Vec<Item>;
    let mut wanted = Vec::new();
    match (&value.kind, json) {
        (Kind::Array(old), Json::Array(new)) => {
            let alike = old.iter().zip(new).take_while(|(old, new)| is_same(old, new)).count();
            let (olds, news) = (&old[alike..], &new[alike..]);
            let ends = olds.iter().rev().zip(news.iter().rev()).take_while(|(old, new)| is_same(old, new));
            let ends = ends.count();
            let changed = olds.len().min(news.len()) - ends;
            for (old, new) in olds.iter().zip(news).take(changed) {
                change(text, old, new, edits)?;
            }
            items = news[changed..news.len() - ends].iter().cloned().map(Item::element).collect();
            wanted.extend((0..alike + changed).map(Wanted::Kept));
            wanted.extend(items.iter().map(Wanted::New));
            wanted.extend((old.len() - ends..old.len()).map(Wanted::Kept));
        }
        (Kind::Object(old), Json::Object(new)) => {
            let known: HashMap<&str, usize> =
                old.iter().enumerate().map(|(at, entry)| (entry.key.as_str(), at)).collect();
            let places: Vec<Option<usize>> = new.keys().map(|key| known.get(key.as_str()).copied()).collect();
            if !places.iter().flatten().is_sorted() {
                return replace(text, value, json, edits);
            }
            let added = new.iter().zip(&places).filter(|(_, place)| place.is_none());
            items = added.map(|((key, value), _)| Item::member(key, value.clone())).collect();
            let mut added = items.iter();
            for (place, value) in places.iter().zip(new.values()) {
                match *place {
                    Some(at) => {
                        change(text, &old[at].value, value, edits)?;
                        wanted.push(Wanted::Kept(at));
                    }
                    None => wanted.extend(added.next().map(Wanted::New)),
                }
            }
        }
        _ => return replace(text, value, json, edits),
    }
    edits.append(&mut arrange(&Layout::of(text, value)?, &wanted));
    Ok(())
}

/// Adds the edit that replaces the entire source text of a value.
fn replace(text: &str, old: &Value, new: &Json, edits: &mut Vec<Edit>) -> Result<(), EditError> {
    let range = old.span.range();
    let before = text.get(..range.start).ok_or(EditError::Outside(range.clone()))?;
    let line = &before[line_start(text, range.start)..];
    let indentation = &line[..line.len() - line.trim_start_matches([' ', '\t']).len()];
    let replacement = laid_out(text, None, new, line.chars().count(), indentation);
    edits.push(Edit { range, replacement });
    Ok(())
}

fn is_same(old: &Value, new: &Json) -> bool {
    match (&old.kind, new) {
        (Kind::Array(old), Json::Array(new)) => {
            old.len() == new.len() && old.iter().zip(new).all(|(old, new)| is_same(old, new))
        }
        (Kind::Object(old), Json::Object(new)) => {
            let mut members = old.iter().zip(new);
            old.len() == new.len()
                && members.all(|(old, (key, new))| old.key == *key && is_same(&old.value, new))
        }
        (Kind::Array(_) | Kind::Object(_) | Kind::Missing, _) => false,
        _ => old.to_json() == *new,
    }
}
