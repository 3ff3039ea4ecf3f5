//! Names inside subgraphs and loops.
//!
//! A pass of a subgraph sees the subgraph's parameters, its inputs (which stand for resources of the user) and its own
//! resources and passes, under the names that the subgraph's author gave them. Outside they carry the name of the
//! instance in front: `blur.half`. A pass of a loop sees the loop's variable. An [`Environment`] is the map from the
//! one to the other; it is made once for each instance and shared by all of its passes.
//!
//! Expressions of a subgraph that the pipeline itself declares see the parameters, features and resources of the
//! pipeline too. Those of a subgraph in a file of its own do not: what the file means depends on what it is given under
//! `with`, not on which names a pipeline happens to have.
//!
//! Expressions are closed over their environment when they are parsed: locals become literals, names of resources
//! become those outside, and so do references: `"=&chain@down[level - 1]"`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::pipeline::names::identifiers::VIEWPORT;
use umbragraph_text::diagnostic::{Diagnostic, codes};
use umbragraph_text::expression::{
    self, ErrorKind, Expression, ExpressionError, ExpressionKind, Scope, Value,
};
use umbragraph_text::language::{Expr, Reference, Written};
use umbragraph_text::source::Span;

/// The prefix that marks a name as invisible to a subgraph file. Names in documents cannot contain the prefix.
const UNSEEN: char = '^';

/// The scope of names in one instance of a subgraph or one iteration of a loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// The prefix that names of the subgraph have outside of it: empty at the top level, else ends in a dot.
    pub(crate) prefix: String,
    /// Whether this is a subgraph in a file of its own, which sees only its own names and arguments.
    pub(crate) is_file: bool,
    /// The values of parameters and derived values of the subgraph, and of variables of loops, by name.
    pub(crate) locals: BTreeMap<String, Value>,
    /// The internal names, outside of the subgraph, of locals whose values depend on parameters of the pipeline.
    pub(crate) following: BTreeMap<String, String>,
    /// The allowed words of locals that are enumerations, by name.
    pub(crate) words: BTreeMap<String, Vec<String>>,
    /// The inputs of the subgraph, by name.
    pub(crate) inputs: BTreeMap<String, Input>,
    /// The places where the enclosing subgraphs are used, the innermost first.
    pub(crate) used_at: Vec<Span>,
    /// The toggle conditions of the enclosing uses of subgraphs, as written: `bloom` or `!bloom`.
    pub(crate) toggles: Vec<String>,
    /// Whether an enclosing use of a subgraph has a side effect, so that its passes are kept even if nothing reads
    /// their outputs.
    pub(crate) side_effect: bool,
}

/// The resource that is passed to an input of a subgraph.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Input {
    /// The resource that the user of the subgraph passes.
    pub(crate) reference: Reference,
    /// The argument as the user of the subgraph wrote it. For an input that is passed through several subgraphs, the
    /// argument of the outermost use.
    pub(crate) given: Given,
}

/// The argument of an input of a subgraph, and the scope of its names.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Given {
    /// The name of the resource, without a version.
    pub(crate) name: String,
    /// The text of the reference as it is written.
    pub(crate) text: String,
    /// The place of the text in the document.
    pub(crate) place: Span,
    /// The JSON pointer of the text.
    pub(crate) pointer: String,
    /// The scope of names at the place of the argument.
    pub(crate) environment: Arc<Environment>,
}

impl Environment {
    /// The value that an axis of this name takes if a pass does not set it; `None` for the axis's default.
    pub(crate) fn axis(&self, name: &str, scope: &dyn Scope) -> Option<Value> {
        if self.is_file { self.locals.get(name).cloned() } else { scope.lookup(name) }
    }

    /// Adds the places where the enclosing subgraphs are used to a diagnostic, as related places.
    pub fn told(&self, diagnostic: Diagnostic) -> Diagnostic {
        self.used_at.iter().fold(diagnostic, |told, place| told.related(*place, "used here"))
    }

    /// Returns `true` at the top level of a pipeline, outside of subgraphs and loops.
    pub fn is_top(&self) -> bool {
        self.prefix.is_empty() && self.locals.is_empty()
    }

    /// Returns the name that a resource or blackboard data of the subgraph has outside of it.
    pub(crate) fn resource<'a>(&'a self, name: &'a str) -> Cow<'a, str> {
        match self.inputs.get(name) {
            Some(input) => input.reference.resource.as_str().into(),
            None if self.prefix.is_empty() => name.into(),
            None => self.pass(name).into(),
        }
    }

    /// Converts a reference to names outside of the subgraph. For an input, the frames that its argument goes back are
    /// added to the frames that the reference goes back.
    pub(crate) fn reference(&self, reference: &Reference) -> Reference {
        let input = self.inputs.get(&reference.resource).map(|input| &input.reference);
        let version = match reference.version.as_deref() {
            None => input.and_then(|input| input.version.clone()),
            Some("0") => reference.version.clone(),
            Some(pass) => Some(self.pass(pass)),
        };
        let back = input.map_or(0, |input| input.back).saturating_add(reference.back);
        Reference { resource: self.resource(&reference.resource).into_owned(), version, back }
    }

    /// Returns the name that a pass of the subgraph has outside of it.
    pub(crate) fn pass(&self, name: &str) -> String {
        [self.prefix.as_str(), name].concat()
    }

    /// Returns the name that a resource has inside the subgraph, given its name outside. `None` if the subgraph cannot
    /// name the resource.
    pub(crate) fn resource_inside<'a>(&'a self, outside: &'a str) -> Option<&'a str> {
        let is_it = |(_, input): &(&String, &Input)| input.reference.resource == outside;
        match self.inputs.iter().find(is_it) {
            Some((name, _)) => Some(name),
            None => self.pass_inside(outside).filter(|name| !self.inputs.contains_key(*name)),
        }
    }

    /// Returns the name that a pass has inside the subgraph, given its name outside. `None` if the pass is not part of
    /// the subgraph.
    pub(crate) fn pass_inside<'a>(&self, outside: &'a str) -> Option<&'a str> {
        outside.strip_prefix(&self.prefix)
    }

    /// Adds the names that are visible in this scope to the suggestions of an error about an unknown name. `outside`
    /// are the names of all resources.
    pub fn widen<'a>(&self, error: &mut ExpressionError, outside: impl Iterator<Item = &'a str> + Clone) {
        let Some(unknown) = error.unknown.as_mut().filter(|unknown| !unknown.is_complete) else { return };
        if let Some(name) = unknown.name.strip_prefix(UNSEEN).map(str::to_owned) {
            error.message = format!("there is no \"{name}\"");
            unknown.name.clone_from(&name);
            let head = name.split_once('.').map_or(name.as_str(), |(head, _)| head);
            let is_setting = unknown.known.contains(&name);
            let is_outside = is_setting || outside.clone().any(|resource| resource == head);
            if self.is_file {
                unknown.known.retain(|known| VIEWPORT.contains(&known.as_str()));
            }
            if self.is_file && is_outside && !self.inputs.contains_key(head) {
                error.message = format!("a subgraph file does not see \"{head}\" of the pipeline");
                let section = if is_setting { "parameters" } else { "inputs" };
                error.help = Some(format!(
                    "declare \"{head}\" under \"{section}\" of the file, and pass it through \"with\" where the file is used"
                ));
                unknown.known.clear();
                return;
            }
        }
        unknown.known.extend(self.locals.keys().cloned());
        unknown.known.extend(outside.filter_map(|name| self.resource_inside(name).map(str::to_owned)));
    }

    /// Returns the diagnostic for an input whose argument names no resource, placed at the argument. `outside` are the
    /// names of all resources. `None` if `name` is not an input, or if the argument names a resource.
    pub fn argument_error<'a>(
        &self,
        name: &str,
        outside: impl Iterator<Item = &'a str> + Clone,
    ) -> Option<Diagnostic> {
        let name = name.strip_prefix(UNSEEN).unwrap_or(name);
        let head = name.split_once('.').map_or(name, |(head, _)| head);
        let input = self.inputs.get(head)?;
        if outside.clone().any(|resource| resource == input.reference.resource) {
            return None;
        }
        let Given { name, text, place, pointer, environment } = &input.given;
        let message = format!("there is no resource \"{name}\"");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_RESOURCE, *place, message).pointer(pointer);
        let written = reference_in(text, name).and_then(|range| place.of_quoted(text, range));
        let names: Vec<&str> = outside.filter_map(|name| environment.resource_inside(name)).collect();
        let diagnostic =
            diagnostic.suggest(name, names, written, |_| "declare it under \"resources\"".to_owned());
        Some(environment.told(diagnostic))
    }

    /// Evaluates an expression that is written in this scope. `is_resource` returns `true` if a name outside of the
    /// subgraph is a resource.
    ///
    /// # Errors
    /// Returns the first error, with names as they are outside of the subgraph.
    pub(crate) fn evaluate(
        &self,
        expression: &Expression,
        is_resource: &dyn Fn(&str) -> bool,
        scope: &dyn Scope,
    ) -> Result<Value, ExpressionError> {
        self.check_words(expression, scope)?;
        if self.is_top() {
            return expression::evaluate(expression, scope);
        }
        let inside = Inside { environment: self, is_resource, scope };
        expression::evaluate(expression, &inside)
            .or_else(|_| expression::evaluate(&self.close(expression, is_resource), scope))
    }

    /// Checks the string literals that an expression of this scope compares with enumerations.
    ///
    /// # Errors
    /// Returns an error for the first literal that is not a word of its enumeration.
    pub fn check_words(&self, expression: &Expression, scope: &dyn Scope) -> Result<(), ExpressionError> {
        let inside = Inside { environment: self, is_resource: &|_| false, scope };
        expression::unknown_word(expression, &inside).map_or(Ok(()), Err)
    }

    /// The scope of expressions in this environment before sizes are known.
    pub(crate) fn seen<'a>(&'a self, scope: &'a dyn Scope) -> impl Scope + 'a {
        Inside { environment: self, is_resource: &|_| false, scope }
    }

    /// Returns the name outside of the subgraph that determines the value of a name; `None` if the value is fixed or
    /// not visible.
    pub(crate) fn followed<'a>(&'a self, name: &'a str) -> Option<&'a str> {
        match self.locals.contains_key(name) {
            true => self.following.get(name).map(String::as_str),
            false => self.sees(name).then_some(name),
        }
    }

    /// Returns `true` if a name that is neither a local nor a resource means the same as outside of the subgraph.
    fn sees(&self, name: &str) -> bool {
        let head = name.split_once('.').map_or(name, |(head, _)| head);
        // What stands for an input with an argument error is not what has its name outside.
        VIEWPORT.contains(&name) || !self.is_file && !self.inputs.contains_key(head)
    }

    /// Rewrites an expression from names inside a subgraph to names outside, and replaces locals with their values.
    /// `is_resource` returns `true` if a name outside is a resource.
    pub fn close(&self, expression: &Expression, is_resource: &dyn Fn(&str) -> bool) -> Expression {
        self.close_with(expression, &|name| self.closed(name, is_resource))
    }

    /// Rewrites an expression from names inside a subgraph to names outside. Locals that depend on parameters stay
    /// names; all other locals are replaced with their values.
    pub(crate) fn close_live(
        &self,
        expression: &Expression,
        is_resource: &dyn Fn(&str) -> bool,
    ) -> Expression {
        self.close_with(expression, &|name| match self.following.get(name) {
            Some(outside) => ExpressionKind::Name(outside.clone()),
            None => self.closed(name, is_resource),
        })
    }

    fn close_with(&self, expression: &Expression, replaced: &dyn Fn(&str) -> ExpressionKind) -> Expression {
        let mut closed = expression.clone();
        closed.visit_mut(&mut |inner| match &mut inner.kind {
            ExpressionKind::Name(name) => inner.kind = replaced(name),
            ExpressionKind::Reference(reference) => *reference = self.reference(reference),
            _ => {}
        });
        closed
    }

    fn closed(&self, name: &str, is_resource: &dyn Fn(&str) -> bool) -> ExpressionKind {
        match self.locals.get(name) {
            Some(value) => ExpressionKind::Literal(value.clone()),
            None => ExpressionKind::Name(self.close_name(name, is_resource).into_owned()),
        }
    }

    fn close_name<'a>(&self, name: &'a str, is_resource: &dyn Fn(&str) -> bool) -> Cow<'a, str> {
        let (head, tail) = name.split_once('.').map_or((name, None), |(head, tail)| (head, Some(tail)));
        let outside = self.resource(head);
        let is_input = self.inputs.contains_key(head);
        if !(is_input || outside != head) || !is_resource(&outside) {
            return if self.sees(name) { name.into() } else { format!("{UNSEEN}{name}").into() };
        }
        match tail {
            None => outside.into_owned().into(),
            Some(tail) => format!("{outside}.{tail}").into(),
        }
    }

    /// Returns the word that a string of a document contains literally, or that its expression yields.
    ///
    /// # Errors
    /// Returns an error of the expression, or an error for a value that is not a word.
    pub(crate) fn word<'a>(&self, text: &'a str, scope: &dyn Scope) -> Result<Cow<'a, str>, ExpressionError> {
        match Written::of(text) {
            Written::Plain(word) => Ok(word.into()),
            _ => match self.evaluate(&Expr::parse_text(text)?, &|_| false, scope)? {
                Value::Text(word) => Ok(word.into()),
                other => {
                    let message = format!("a word is wanted here, this is {}", other.kind_name());
                    Err(ExpressionError::new(ErrorKind::Type, 0..0, message))
                }
            },
        }
    }

    /// Resolves a reference in a document to names outside of the subgraph.
    ///
    /// # Errors
    /// Returns an error of the expression, or an error for a value that is not a reference.
    pub(crate) fn refer(&self, text: &str, scope: &dyn Scope) -> Result<Reference, ExpressionError> {
        match self.evaluate(&Expr::parse_text(text)?, &|_| false, scope)? {
            Value::Reference(reference) => Ok(reference),
            other => {
                let message = format!("a reference is wanted here, this is {}", other.kind_name());
                let help = Some("let the expression yield a reference, such as &maps".to_owned());
                Err(ExpressionError { help, ..ExpressionError::new(ErrorKind::Type, 0..0, message) })
            }
        }
    }
}

/// The byte range of a resource's name in the text of a reference; `None` if the name is not there.
pub(crate) fn reference_in(text: &str, name: &str) -> Option<Range<usize>> {
    let is_end = |end: usize| {
        let next = text[end..].chars().next();
        next.is_none_or(|next| !(next.is_alphanumeric() || matches!(next, '_' | '.')))
    };
    let mut found = text.match_indices(name).map(|(at, name)| at..at + name.len());
    found.find(|range| is_end(range.end) && text[..range.start].ends_with('&'))
}

/// Returns a copy of an expression in which `replaced` replaces each name.
pub fn with_names(expression: &Expression, replaced: &dyn Fn(&str) -> ExpressionKind) -> Expression {
    let mut expression = expression.clone();
    expression.visit_mut(&mut |inner| {
        if let ExpressionKind::Name(name) = &inner.kind {
            inner.kind = replaced(name);
        }
    });
    expression
}

/// The scope of names that an expression in an environment can see.
struct Inside<'a> {
    environment: &'a Environment,
    is_resource: &'a dyn Fn(&str) -> bool,
    scope: &'a dyn Scope,
}

impl Scope for Inside<'_> {
    fn lookup(&self, name: &str) -> Option<Value> {
        match self.environment.locals.get(name) {
            Some(value) => Some(value.clone()),
            None => self.scope.lookup(&self.environment.close_name(name, self.is_resource)),
        }
    }

    fn reference(&self, reference: &Reference) -> Reference {
        self.environment.reference(reference)
    }

    fn words(&self, name: &str) -> Option<&[String]> {
        match self.environment.locals.contains_key(name) {
            true => self.environment.words.get(name).map(Vec::as_slice),
            false => self.scope.words(&self.environment.close_name(name, self.is_resource)),
        }
    }

    fn names(&self) -> Vec<String> {
        let outside = if self.environment.is_file { Vec::new() } else { self.scope.names() };
        outside.into_iter().chain(self.environment.locals.keys().cloned()).collect()
    }

    fn is_broken(&self, name: &str) -> bool {
        !self.environment.locals.contains_key(name)
            && self.scope.is_broken(&self.environment.close_name(name, self.is_resource))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::StaticScope;

    fn environment() -> Environment {
        Environment {
            following: BTreeMap::new(),
            prefix: "blur.".to_owned(),
            is_file: false,
            words: BTreeMap::new(),
            locals: BTreeMap::from([("level".to_owned(), Value::Number(2.0))]),
            inputs: BTreeMap::from([(
                "image".to_owned(),
                Input {
                    reference: Reference::parse("moments@warp").unwrap(),
                    given: Given {
                        name: "moments".to_owned(),
                        text: "moments@warp".to_owned(),
                        place: Span::new(umbragraph_text::source::Sources::new().add("a", ""), 0..0),
                        pointer: String::new(),
                        environment: Arc::default(),
                    },
                },
            )]),
            toggles: Vec::new(),
            side_effect: false,
            used_at: Vec::new(),
        }
    }

    #[test]
    fn names_inside_become_names_outside() {
        let environment = environment();
        assert_eq!(environment.resource("image"), "moments");
        for (inside, outside) in
            [("image", "moments@warp"), ("image@down", "moments@blur.down"), ("half@-1", "blur.half@-1")]
        {
            let reference = environment.reference(&Reference::parse(inside).unwrap());
            assert_eq!(reference.to_string(), outside);
        }
        assert_eq!(environment.resource("half"), "blur.half");
        let two = expression::parse("level * 2 + 1").unwrap();
        let evaluated = environment.evaluate(&two, &|_| false, &StaticScope::default());
        assert_eq!(evaluated, Ok(Value::Number(5.0)));
        let expression = expression::parse("image.width / level + half.height + radius").unwrap();
        let closed = environment.close(&expression, &|name| name == "moments" || name == "blur.half");
        assert_eq!(closed, {
            let mut wanted = expression::parse("image.width / level + half.height + radius").unwrap();
            fn rename(expression: &mut Expression) {
                match &mut expression.kind {
                    ExpressionKind::Name(name) => match name.as_str() {
                        "image.width" => *name = "moments.width".to_owned(),
                        "half.height" => *name = "blur.half.height".to_owned(),
                        "level" => expression.kind = ExpressionKind::Literal(Value::Number(2.0)),
                        _ => {}
                    },
                    ExpressionKind::Binary(_, a, b) => {
                        rename(a);
                        rename(b);
                    }
                    _ => {}
                }
            }
            rename(&mut wanted);
            wanted
        });
    }

    #[test]
    fn references_follow_an_ampersand_or_are_computed() {
        let refer = |text| {
            let found = environment().refer(text, &StaticScope::default());
            found.map(|reference| reference.to_string()).map_err(|error| (error.kind, error.range))
        };
        for (text, outside) in [
            ("&image", "moments@warp"),
            ("&half@-2", "blur.half@-2"),
            ("=level > 1 ? &half : &image", "blur.half"),
            ("=[&half, &image][level - 1]", "moments@warp"),
            ("=&half@down[level - 1]", "blur.half@blur.down.1"),
        ] {
            assert_eq!(refer(text).as_deref(), Ok(outside), "{text}");
        }
        for (text, kind, range) in [
            ("=level", ErrorKind::Type, 0..0),
            ("=&half[level]", ErrorKind::Type, 7..12),
            ("=&half@down[level / 4]", ErrorKind::Arithmetic, 12..21),
            ("=&half@", ErrorKind::Reference, 1..7),
            ("&half@a@b", ErrorKind::Reference, 0..0),
        ] {
            assert_eq!(refer(text), Err((kind, range)), "{text}");
        }
    }
}
