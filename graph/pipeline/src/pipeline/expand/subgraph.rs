//! The scope of names in one use of a subgraph: its inputs, parameters and derived values.
//!
//! An input stands for a resource of the user, with the version and the frame that the user names; one that is handed
//! on through several subgraphs keeps the place of the outermost user, who can mend it. A parameter has the value that
//! `with` gives, an expression in the scope of the user, else its default. What follows from live parameters of the
//! pipeline is noted with its expression, so that it is evaluated again when they change.
//!
//! Limits: what is misspelt under `with` is the diagnostic, and that the key which was meant is missing is not said.

use std::rc::Rc;
use std::sync::Arc;

use crate::pipeline::expand::{Expander, Gap, gap};
use crate::pipeline::names::{Environment, Given, Input, Instance, expression_diagnostic};
use crate::pipeline::settings::{derived, setting};
use umbragraph_text::compose::is_path;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, suggested_name};
use umbragraph_text::document::{self, Entry, Kind, Signs, pointer_join};
use umbragraph_text::expression::{Expression, Value};
use umbragraph_text::language::{Expr, ParameterDeclaration, ParameterType};
use umbragraph_text::source::Span;

impl<'a> Expander<'a, '_> {
    /// Creates the scope of names for a pass that uses a subgraph; returns `None` after a diagnostic.
    pub(super) fn environment_of(&mut self, pass: &Instance<'a>, subgraph: &'a Entry) -> Option<Environment> {
        let Instance { name, entry, pointer, environment: outer, .. } = pass;
        let section = |name: &str| subgraph.value.entries_of(name);
        let with = entry.value.entries_of("with");
        let at = format!("{pointer}/with");
        self.shared.fix_order(pass);
        let mut inner = Environment {
            prefix: format!("{name}."),
            is_file: is_path(&subgraph.key),
            used_at: [entry.key_span].into_iter().chain(outer.used_at.iter().copied()).collect(),
            ..Environment::default()
        };
        let known = section("inputs").iter().chain(section("parameters"));
        let known: Vec<&str> = known.map(|entry| entry.key.as_str()).collect();
        let misspelt: Vec<&Entry> = with.iter().filter(|given| !known.contains(&&*given.key)).collect();
        for given in &misspelt {
            let diagnostic = document::schema::unknown_key(given, &known, with);
            self.shared.diagnostics.push(diagnostic.pointer(pointer_join(&at, &given.key)));
        }
        let mut fine = misspelt.is_empty();
        for input in section("inputs") {
            let given = with.iter().find(|given| given.key == input.key);
            let found = given.map(|given| self.input(&input.key, &given.value, &at, outer));
            match found {
                Some(Ok(found)) => drop(inner.inputs.insert(input.key.clone(), found)),
                Some(Err(gap)) => {
                    self.shared.diagnostics.extend(gap.map(|diagnostic| *diagnostic));
                    fine = false;
                }
                None if misspelt.iter().any(|one| suggested_name(&one.key, [&*input.key]).is_some()) => {}
                None => {
                    let message = format!("the input \"{}\" of \"{}\" is not given", input.key, subgraph.key);
                    let diagnostic = Diagnostic::error(codes::MISSING_KEY, entry.key_span, message)
                        .related(input.key_span, "declared here")
                        .help(format!("add \"{}\" to \"with\"", input.key));
                    self.shared.diagnostics.push(diagnostic.pointer(&at));
                    fine = false;
                }
            }
        }
        let inside = pointer_join("/subgraphs", &subgraph.key);
        for parameter in section("parameters") {
            let is_broken = (self.is_broken)(&pointer_join(&format!("{inside}/parameters"), &parameter.key));
            let given = with.iter().find(|given| given.key == parameter.key).map(|given| &given.value);
            let here = pointer_join(&at, &parameter.key);
            fine &= !is_broken && self.parameter(parameter, given, &here, outer, &mut inner).is_some();
        }
        if fine && !section("derived").is_empty() {
            fine = self.derive(section, &format!("{inside}/derived"), &mut inner);
        }
        fine.then_some(inner)
    }

    /// Resolves the argument of a subgraph's input to a resource.
    fn input(
        &mut self,
        name: &str,
        given: &document::Value,
        at: &str,
        outer: &Arc<Environment>,
    ) -> Result<Input, Gap> {
        let Some(written) = given.text() else {
            let message = format!("the input \"{name}\" is a resource, this is {}", given.kind_name());
            return Err(gap(codes::WRONG_TYPE, given, at, message, "name a resource"));
        };
        let pointer = pointer_join(at, name);
        if let Some(unsigned) = Signs::Reference.check(given) {
            return Err(Some(Box::new(unsigned.pointer(pointer))));
        }
        self.settle(given, &pointer, outer);
        let reference = outer.refer(written, &self.shared.scope).map_err(|mut error| {
            outer.widen(&mut error, std::iter::empty());
            expression_diagnostic(&error, given, &pointer).map(Box::new)
        })?;
        let inside = outer.resource_inside(&reference.resource).unwrap_or(&reference.resource).to_owned();
        let handed_on = outer.inputs.get(&inside).map(|input| input.given.clone());
        Ok(Input {
            reference,
            given: handed_on.unwrap_or_else(|| Given {
                name: inside,
                text: written.to_owned(),
                place: given.span,
                pointer,
                environment: outer.clone(),
            }),
        })
    }

    /// Gives a parameter of a subgraph its value in one use; returns `None` after a diagnostic.
    fn parameter(
        &mut self,
        parameter: &'a Entry,
        given: Option<&document::Value>,
        pointer: &str,
        outer: &Environment,
        inner: &mut Environment,
    ) -> Option<()> {
        let known = self.parameters.entry(parameter);
        let Some(declaration) = known.or_insert_with(|| parameter.value.decode().ok().map(Rc::new)).clone()
        else {
            return Some(());
        };
        // Where a number is wanted, a word lacks its sign.
        if let Some(unsigned) = given
            .filter(|_| declaration.parameter_type != ParameterType::Enum)
            .and_then(|given| Signs::Expression.check(given))
        {
            let declared = "the parameter is declared here";
            self.shared.diagnostics.push(unsigned.pointer(pointer).related(parameter.key_span, declared));
            return None;
        }
        let value = match given {
            Some(given) => to_document(&self.evaluate(given, pointer, outer)?, given.span),
            None => parameter.value.get("default")?.clone(),
        };
        let value = match setting::decode_parameter(&parameter.key, &declaration, &value) {
            Ok(value) => value,
            Err(errors) => {
                let declared = "the parameter is declared here";
                let errors = errors.into_iter().map(|one| one.related(parameter.key_span, declared));
                self.shared.diagnostics.extend(errors);
                return None;
            }
        };
        if !declaration.values.is_empty() {
            inner.words.insert(parameter.key.clone(), declaration.values.clone());
        }
        if let Some(given) = given
            && let Ok(expression) = Expr(given.to_json()).parse()
        {
            let expression = outer.close_live(&expression, &|_| false);
            let follows = (expression, Some((*declaration).clone()), given.span);
            self.follow(inner, &parameter.key, &value, follows);
        }
        inner.locals.insert(parameter.key.clone(), value);
        Some(())
    }

    /// Computes the derived values of a subgraph for one use of it. Returns `false` if one of them has an error.
    fn derive<'e>(
        &mut self,
        section: impl Fn(&str) -> &'e [Entry],
        pointer: &str,
        inner: &mut Environment,
    ) -> bool {
        let taken = [("parameters", "parameter"), ("inputs", "input"), ("resources", "resource")];
        let taken = taken.into_iter().flat_map(|(name, what)| {
            section(name).iter().map(move |entry| (entry.key.as_str(), (entry.key_span, what)))
        });
        let mut diagnostics = Diagnostics::new();
        let derived::Section { values, broken } = {
            let around = inner.seen(&self.shared.scope);
            let taken = taken.collect();
            derived::evaluate(section("derived"), pointer, &around, &taken, self.is_broken, &mut diagnostics)
        };
        self.shared.report_from(diagnostics, inner);
        let mut values: Vec<_> = values.into_iter().collect();
        values.sort_by_key(|(_, one)| one.rank);
        for (name, one) in values {
            let expression = inner.close_live(&one.expression, &|_| false);
            self.follow(inner, &name, &one.value, (expression, None, one.place));
            inner.words.extend(one.words.map(|words| (name.clone(), words)));
            inner.locals.insert(name, one.value);
        }
        broken.is_empty()
    }

    /// Records a local that depends on parameters of the pipeline, for evaluation when these parameters change.
    fn follow(
        &mut self,
        inner: &mut Environment,
        name: &str,
        value: &Value,
        (expression, declaration, place): (Expression, Option<ParameterDeclaration>, Span),
    ) {
        let outside = format!("{}${name}", inner.prefix);
        if self.shared.dependence.add(outside.clone(), expression, declaration, place) {
            self.shared.scope.set(&outside, value.clone());
            self.shared.given.insert(outside.clone(), value.clone());
            inner.following.insert(name.to_owned(), outside);
        }
    }
}

/// Converts the value of an expression to a document value.
fn to_document(value: &Value, span: Span) -> document::Value {
    let kind = match value {
        Value::Bool(value) => Kind::Bool(*value),
        Value::Number(number) => serde_json::Number::from_f64(*number).map_or(Kind::Null, Kind::Number),
        Value::Text(text) => Kind::Text(text.clone()),
        Value::Reference(reference) => Kind::Text(format!("&{reference}")),
        Value::List(list) => Kind::Array(list.iter().map(|value| to_document(value, span)).collect()),
    };
    document::Value { span, kind }
}
