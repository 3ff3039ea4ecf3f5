//! The filters, tests and functions that templates may use.
//!
//! The list is short, so that a template is readable without the template engine's manual. No filter can grow a value
//! without bound: the engine's filters that can (`format`, `list`, `batch`, ..) are left out, and `replace`, `join` and
//! `indent` are reimplemented with a limit.

use minijinja::value::{Kwargs, Value, ValueKind};
use minijinja::{Environment, Error, State, UndefinedBehavior, escape_formatter, filters, functions, tests};

use super::guard;
use super::scan::syntax;

/// The functions that every template can call.
pub(crate) const FUNCTIONS: &[&str] =
    &["range", "namespace", "dict", guard::FITS, guard::FACTOR, guard::SEEN, guard::INDEXED];

/// The filters that templates can use.
pub(crate) const FILTERS: &[&str] = &[
    "abs", "count", "default", "first", "float", "indent", "int", "join", "last", "length", "lower", "max",
    "min", "replace", "round", "trim", "upper",
];

/// The tests that templates can use after `is`.
pub(crate) const TESTS: &[&str] =
    &["defined", "divisibleby", "even", "in", "integer", "none", "number", "odd", "string", "undefined"];

/// Creates a minijinja environment with the allowed filters, tests and functions, and without templates.
pub(crate) fn environment() -> Environment<'static> {
    let mut environment = Environment::empty();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_debug(true);
    environment.set_syntax(syntax());
    environment.set_formatter(|out, state, value| {
        if value.kind() == ValueKind::Bool {
            return out.write_str(if value.is_true() { "true" } else { "false" }).map_err(Error::from);
        }
        match value.as_str() {
            Some(text) => {
                guard::written(text.len())?;
                out.write_str(text).map_err(Error::from)
            }
            None if value.is_number() => {
                let text = value.to_string();
                guard::written(text.len())?;
                out.write_str(&text).map_err(Error::from)
            }
            None if value.is_undefined() => escape_formatter(out, state, value),
            None => Err(Error::new(
                minijinja::ErrorKind::InvalidOperation,
                format!("a {} cannot be written into WGSL", value.kind()),
            )),
        }
    });
    add_filters(&mut environment);
    add_tests(&mut environment);
    environment.add_function("range", functions::range);
    environment.add_function("namespace", functions::namespace);
    environment.add_function("dict", functions::dict);
    environment.add_function(guard::FITS, guard::grown);
    environment.add_filter(guard::FITS, guard::grown);
    environment.add_function(guard::FACTOR, guard::factor);
    environment.add_function(guard::SEEN, guard::seen);
    environment.add_function(guard::INDEXED, guard::indexed);
    environment
}

fn add_filters(environment: &mut Environment<'static>) {
    environment.add_filter("abs", filters::abs);
    environment.add_filter("count", length);
    environment.add_filter("default", filters::default);
    environment.add_filter("first", filters::first);
    environment.add_filter("float", filters::float);
    environment.add_filter("indent", indent);
    environment.add_filter("int", filters::int);
    environment.add_filter("join", join);
    environment.add_filter("last", filters::last);
    environment.add_filter("length", length);
    environment.add_filter("lower", lower);
    environment.add_filter("max", max);
    environment.add_filter("min", min);
    environment.add_filter("replace", replace);
    environment.add_filter("round", filters::round);
    environment.add_filter("trim", trim);
    environment.add_filter("upper", upper);
}

fn add_tests(environment: &mut Environment<'static>) {
    environment.add_test("defined", tests::is_defined);
    environment.add_test("divisibleby", tests::is_divisibleby);
    environment.add_test("even", tests::is_even);
    environment.add_test("in", tests::is_in);
    environment.add_test("integer", tests::is_integer);
    environment.add_test("none", tests::is_none);
    environment.add_test("number", tests::is_number);
    environment.add_test("odd", tests::is_odd);
    environment.add_test("string", tests::is_string);
    environment.add_test("undefined", tests::is_undefined);
}

/// Returns the string if it is at most [`guard::MAX_VALUE`] bytes long, and counts the work of scanning it.
fn read(text: &str) -> Result<&str, Error> {
    if text.len() > guard::MAX_VALUE {
        return Err(guard::limit("a filter gets a value larger than 1 MiB"));
    }
    guard::work(1, text.len()).map(|()| text)
}

fn length(value: &Value) -> Result<usize, Error> {
    guard::work(1, value.as_str().map_or(0, str::len))?;
    filters::length(value)
}

fn lower(value: &str) -> Result<String, Error> {
    Ok(read(value)?.to_lowercase())
}

fn upper(value: &str) -> Result<String, Error> {
    Ok(read(value)?.to_uppercase())
}

fn trim(value: &str, characters: Option<&str>) -> Result<String, Error> {
    let value = read(value)?;
    Ok(match characters {
        Some(characters) => value.trim_matches(|one| characters.contains(one)).to_owned(),
        None => value.trim().to_owned(),
    })
}

fn max(state: &State<'_, '_>, value: Value, options: Kwargs) -> Result<Value, Error> {
    guard::work(value.len().unwrap_or(1), 0)?;
    filters::max(state, value, options)
}

fn min(state: &State<'_, '_>, value: Value, options: Kwargs) -> Result<Value, Error> {
    guard::work(value.len().unwrap_or(1), 0)?;
    filters::min(state, value, options)
}

/// Returns an error if a filter's result of this size would exceed [`guard::MAX_VALUE`].
fn may_make(bytes: usize) -> Result<(), Error> {
    if bytes > guard::MAX_VALUE {
        return Err(guard::limit("a filter makes a value larger than 1 MiB"));
    }
    Ok(())
}

fn replace(value: &str, from: &str, to: &str) -> Result<String, Error> {
    let value = read(value)?;
    may_make(value.len().saturating_add(value.matches(from).count().saturating_mul(to.len())))?;
    Ok(value.replace(from, to))
}

fn join(value: &Value, joiner: Option<&str>) -> Result<String, Error> {
    let joiner = joiner.unwrap_or_default();
    let mut text = String::new();
    for (at, item) in value.try_iter()?.enumerate() {
        if at > 0 {
            text.push_str(joiner);
        }
        match item.as_str() {
            Some(item) => text.push_str(item),
            None if item.is_number() => text.push_str(&item.to_string()),
            None => {
                let message = format!("a {} cannot be joined into a text", item.kind());
                return Err(Error::new(minijinja::ErrorKind::InvalidOperation, message));
            }
        }
        may_make(text.len())?;
        guard::work(1, 0)?;
    }
    guard::work(0, text.len())?;
    Ok(text)
}

fn indent(value: &str, width: Option<usize>, first: Option<bool>) -> Result<String, Error> {
    let value = read(value)?;
    let width = width.unwrap_or(4).min(256);
    may_make(value.len().saturating_add(value.lines().count().saturating_mul(width)))?;
    let pad = " ".repeat(width);
    let mut text = String::with_capacity(value.len() + 64);
    for (at, line) in value.split('\n').enumerate() {
        if at > 0 {
            text.push('\n');
        }
        if !line.trim().is_empty() && (at > 0 || first.unwrap_or(false)) {
            text.push_str(&pad);
        }
        text.push_str(line);
    }
    Ok(text)
}

#[cfg(test)]
mod tests_of_names {
    use super::*;

    #[test]
    fn every_name_that_is_proposed_is_one() {
        let environment = environment();
        let kinds = |names: &[&str], text: &dyn Fn(&str) -> String| -> Vec<Option<minijinja::ErrorKind>> {
            let render =
                |name: &&str| environment.render_str(&text(name), ()).err().map(|error| error.kind());
            names.iter().map(render).collect()
        };
        use minijinja::ErrorKind as Kind;
        let filters = kinds(FILTERS, &|name| format!("{{{{ 1|{name} }}}}"));
        assert!(!filters.contains(&Some(Kind::UnknownFilter)));
        let tests = kinds(TESTS, &|name| format!("{{% if 1 is {name} %}}{{% endif %}}"));
        assert!(!tests.contains(&Some(Kind::UnknownTest)));
        assert_eq!(kinds(&["abss"], &|name| format!("{{{{ 1|{name} }}}}")), [Some(Kind::UnknownFilter)]);
    }
}
