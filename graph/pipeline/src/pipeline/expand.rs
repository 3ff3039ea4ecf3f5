//! Loops and subgraphs: from the passes and resources of a document to their instances.
//!
//! ```jsonc
//! "subgraphs": { "blur": { "inputs": { "image": "what is blurred" }, "parameters": { … }, "resources": { … }, "passes": { … } } },
//! "passes": {
//!   "soften": { "use": "blur", "with": { "image": "color", "radius": 6 } },
//!   "down":   { "for_each": { "level": "levels" }, "fullscreen": { … "down@down.{level - 1}" … } }
//! }
//! ```
//!
//! An instance shares the document's entry with all others and carries its own [`Environment`]; nothing of the text is
//! copied or decoded twice. Passes of a subgraph are named `soften.half`, rounds of a loop `down.0`, `down.1`, … A loop
//! over a number counts from 0; over a list it takes each element. A subgraph that is used in a loop is named
//! `soften.0.half`. What a use says of order, toggles and side effects holds for all passes of the instance.
//!
//! Limits: 4,096 rounds of a loop, 65,536 passes in all, subgraphs 16 levels deep.

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use super::environment::{Environment, Given, Input};
use super::expression_diagnostic::expression_diagnostic;
use super::instance::{Instance, Waiting};
use super::load::{RESERVED, Shared, bad_name, is_name};
use super::{derived, setting};
use crate::compose::is_path;
use crate::diagnostic::{Code, Diagnostic, Diagnostics, codes, suggested_name};
use crate::document::{self, Document, Entry, Kind, pointer_join};
use crate::expression::{Expression, ExpressionError, Value};
use crate::language::{Expr, ParameterDeclaration, ParameterType, Reference};
use crate::node::Registry;
use crate::source::Span;

const MAX_ROUNDS: usize = 4096;
const MAX_PASSES: usize = 65_536;
const MAX_DEPTH: usize = 16;

/// Expands a document.
pub(super) struct Expander<'a, 's> {
    document: &'a Document,
    subgraphs: HashMap<&'a str, &'a Entry>,
    registry: &'s Registry,
    is_broken: &'s dyn Fn(&str) -> bool,
    shared: &'s mut Shared,
    pub(super) resources: Vec<Instance<'a>>,
    pub(super) instances: Vec<Instance<'a>>,
    /// Uses of subgraphs with a passthrough: the name, the entry, its pointer, what names mean there.
    pub(super) passthroughs: Vec<(String, &'a Entry, String, Arc<Environment>)>,
    /// Uses of subgraphs that wait for passes.
    pub(super) waiting: Vec<Waiting<'a>>,
    /// Passes that could not be expanded.
    pub(super) gaps: Vec<(String, &'a Entry)>,
    pub(super) unreadable: bool,
    full: bool,
    /// Uses of subgraphs so far.
    uses: usize,
    /// The parameters of subgraphs, by the address of their entry in the document.
    parameters: HashMap<*const Entry, Option<Rc<ParameterDeclaration>>>,
    /// The subgraphs that are being expanded, the outermost first.
    open: Vec<String>,
    /// Names of what is switched off, or of loops without a round.
    pub(super) absent: BTreeSet<String>,
}

impl<'a, 's> Expander<'a, 's> {
    pub(super) fn new(
        document: &'a Document,
        registry: &'s Registry,
        is_broken: &'s dyn Fn(&str) -> bool,
        shared: &'s mut Shared,
    ) -> Self {
        let subgraphs = document.root.get("subgraphs").and_then(document::Value::entries);
        let subgraphs = subgraphs.unwrap_or_default().iter().map(|entry| (entry.key.as_str(), entry));
        Self {
            document,
            subgraphs: subgraphs.collect(),
            registry,
            is_broken,
            shared,
            resources: Vec::new(),
            instances: Vec::new(),
            passthroughs: Vec::new(),
            waiting: Vec::new(),
            gaps: Vec::new(),
            unreadable: false,
            full: false,
            uses: 0,
            parameters: HashMap::new(),
            open: Vec::new(),
            absent: BTreeSet::new(),
        }
    }

    /// Expands the pipeline's own sections.
    pub(super) fn top(&mut self) {
        let document = self.document;
        self.sections(&document.root, "", &Arc::new(Environment::default()), 0);
    }

    fn sections(
        &mut self,
        owner: &'a document::Value,
        pointer: &str,
        environment: &Arc<Environment>,
        depth: usize,
    ) {
        let entries = |name: &str| owner.get(name).and_then(document::Value::entries).unwrap_or_default();
        let above = [pointer, "/resources"].concat();
        for entry in entries("resources") {
            if self.full || self.resources.len() >= MAX_PASSES {
                self.too_many(entry, pointer);
                return;
            }
            self.check_name(entry);
            let pointer = pointer_join(&above, &entry.key);
            let is_broken = (self.is_broken)(&pointer);
            let name = environment.resource(&entry.key).into_owned();
            self.resources.push(Instance {
                name,
                entry,
                pointer,
                environment: environment.clone(),
                is_broken,
            });
        }
        let above = [pointer, "/passes"].concat();
        for entry in entries("passes") {
            self.check_name(entry);
            let pointer = pointer_join(&above, &entry.key);
            self.looped(entry, environment.pass(&entry.key), pointer, environment, depth);
        }
    }

    fn check_name(&mut self, entry: &Entry) {
        if !is_name(&entry.key) || RESERVED.contains(&entry.key.as_str()) {
            self.shared.diagnostics.push(bad_name(entry));
        }
    }

    fn looped(
        &mut self,
        entry: &'a Entry,
        name: String,
        pointer: String,
        environment: &Arc<Environment>,
        depth: usize,
    ) {
        if self.full {
            return;
        }
        let rounds = entry.value.get("for_each").filter(|_| !(self.is_broken)(&pointer));
        let Some(rounds) = rounds else {
            self.single(entry, name, pointer, environment, depth);
            return;
        };
        let (variable, values) = match self.rounds(rounds, &pointer, environment) {
            Ok(found) => found,
            Err(gap) => return self.leave_out(gap, entry, name),
        };
        if values.is_empty() {
            self.wait(entry, &name, &pointer, environment);
            self.absent.insert(name.clone());
            self.shared.programs.modules.lacks(entry, &pointer, "for_each", false);
        }
        for (round, value) in values.into_iter().enumerate() {
            if self.full {
                return;
            }
            let mut inner = (**environment).clone();
            // A variable stands before a parameter of its name.
            inner.following.remove(&variable.key);
            inner.words.remove(&variable.key);
            inner.locals.insert(variable.key.clone(), value);
            self.single(entry, format!("{name}.{round}"), pointer.clone(), &Arc::new(inner), depth);
        }
    }

    /// The variable of a loop, and its values.
    fn rounds(
        &mut self,
        rounds: &'a document::Value,
        pointer: &str,
        environment: &Environment,
    ) -> Result<(&'a Entry, Vec<Value>), Gap> {
        let at = format!("{pointer}/for_each");
        let [variable] = rounds.entries().unwrap_or_default() else {
            let help = "write { \"level\": 4 }";
            return Err(gap(codes::LOOP, rounds, &at, "a loop has one variable".to_owned(), help));
        };
        let (at, value) = (pointer_join(&at, &variable.key), &variable.value);
        let wrong = |message: String, help: &str| Err(gap(codes::LOOP, value, &at, message, help));
        let too_many = |count: f64| {
            wrong(format!("{count} rounds are too many"), &format!("a loop has at most {MAX_ROUNDS}"))
        };
        let values = match self.structural(value, &at, environment).ok_or(None)? {
            Value::List(list) if list.len() <= MAX_ROUNDS => list,
            Value::Number(count) if count.fract() == 0.0 && (0.0..=MAX_ROUNDS as f64).contains(&count) => {
                (0..count as u32).map(|round| Value::Number(f64::from(round))).collect()
            }
            Value::List(list) => return too_many(list.len() as f64),
            Value::Number(count) if count.fract() == 0.0 && count >= 0.0 => return too_many(count),
            other => {
                let found = match other {
                    Value::Number(number) => number.to_string(),
                    other => other.kind_name().to_owned(),
                };
                let message = format!("a loop goes over a list or a count (0, 1, 2, …), this is {found}");
                return wrong(message, "write a count such as \"len(far)\", or a list");
            }
        };
        Ok((variable, values))
    }

    fn single(
        &mut self,
        entry: &'a Entry,
        name: String,
        pointer: String,
        environment: &Arc<Environment>,
        depth: usize,
    ) {
        let is_broken = (self.is_broken)(&pointer);
        if self.instances.len() >= MAX_PASSES || self.uses >= MAX_PASSES {
            self.too_many(entry, &pointer);
            return;
        }
        match entry.value.get("use") {
            Some(used) if !is_broken => {
                if let Err(gap) = self.used(entry, used, &name, &pointer, environment, depth) {
                    self.leave_out(gap, entry, name);
                }
            }
            _ => self.instances.push(Instance {
                name,
                entry,
                pointer,
                environment: environment.clone(),
                is_broken,
            }),
        }
    }

    fn used(
        &mut self,
        entry: &'a Entry,
        used: &'a document::Value,
        name: &str,
        pointer: &str,
        environment: &Arc<Environment>,
        depth: usize,
    ) -> Result<(), Gap> {
        let wanted = used.text().unwrap_or_default();
        let at = format!("{pointer}/use");
        // A file knows further files, whatever the pipeline declares.
        let is_seen = |name: &str| !environment.is_file || is_path(name);
        let Some(subgraph) = self.subgraphs.get(wanted).copied().filter(|_| is_seen(wanted)) else {
            let known = self.document.root.get("subgraphs").and_then(document::Value::entries);
            let known = known.unwrap_or_default();
            let known = known.iter().map(|entry| entry.key.as_str()).filter(|_| !environment.is_file);
            let message = match self.subgraphs.contains_key(wanted) {
                true => format!("a subgraph file does not see the subgraph \"{wanted}\" of the pipeline"),
                false => format!("there is no subgraph \"{wanted}\""),
            };
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SUBGRAPH, used.span, message).pointer(at);
            return Err(Some(Box::new(diagnostic.suggest(
                wanted,
                known,
                Some(used.span),
                |known| match known {
                    _ if environment.is_file => "name a file, relative to this one".to_owned(),
                    [] => "declare it under \"subgraphs\", or name a file".to_owned(),
                    known => format!("the subgraphs are {}", known.join(", ")),
                },
            ))));
        };
        let inside = pointer_join("/subgraphs", wanted);
        if let Some(first) = self.open.iter().position(|open| open == wanted) {
            let way: Vec<&str> = self.open[first..].iter().map(String::as_str).chain([wanted]).collect();
            let message = format!("the subgraph \"{wanted}\" uses itself: {}", way.join(" → "));
            return Err(gap(codes::UNKNOWN_SUBGRAPH, used, &at, message, "a subgraph cannot use itself"));
        }
        if depth >= MAX_DEPTH {
            let message = format!("subgraphs are used {MAX_DEPTH} levels deep");
            return Err(gap(codes::UNKNOWN_SUBGRAPH, used, &at, message, "a subgraph cannot use itself"));
        }
        if let Some(extra) = entry
            .value
            .entries()
            .unwrap_or_default()
            .iter()
            .find(|member| self.registry.get(&member.key).is_some())
        {
            let message = format!("\"use\" and \"{}\" exclude one another", extra.key);
            return Err(gap(codes::UNKNOWN_KEY, &extra.value, &at, message, "make it two passes"));
        }
        if let Some(when) = entry.value.get("when") {
            let at = format!("{pointer}/when");
            match self.structural(when, &at, environment).ok_or(None)? {
                Value::Bool(true) => {}
                Value::Bool(false) => {
                    self.wait(entry, name, pointer, environment);
                    self.absent.insert(name.to_owned());
                    self.shared.programs.modules.lacks(entry, pointer, "when", environment.is_top());
                    return Ok(());
                }
                other => {
                    let message = format!("a boolean is wanted here, this is {}", other.kind_name());
                    return Err(gap(codes::EXPRESSION_TYPE, when, &at, message, "make it a comparison"));
                }
            }
        }
        self.shared.programs.modules.has(entry);
        let found = self.environment_of(entry, &subgraph.value, &inside, wanted, name, pointer, environment);
        let mut inner = found.ok_or(None)?;
        inner.toggles.clone_from(&environment.toggles);
        inner.toggles.extend(entry.value.get("toggle").and_then(document::Value::text).map(str::to_owned));
        if entry.value.get("passthrough").is_some() {
            self.passthroughs.push((name.to_owned(), entry, pointer.to_owned(), environment.clone()));
        }
        inner.side_effect = environment.side_effect
            || entry.value.get("side_effect").is_some_and(|value| matches!(value.kind, Kind::Bool(true)));
        self.wait(entry, name, pointer, environment);
        self.uses += 1;
        self.open.push(wanted.to_owned());
        self.sections(&subgraph.value, &inside, &Arc::new(inner), depth + 1);
        self.open.pop();
        Ok(())
    }

    /// Notes what a loop or a use of a subgraph has to follow.
    fn wait(&mut self, entry: &'a Entry, name: &str, pointer: &str, environment: &Arc<Environment>) {
        if entry.value.get("after").is_some() {
            self.waiting.push(Waiting {
                name: name.to_owned(),
                entry,
                pointer: pointer.to_owned(),
                environment: environment.clone(),
            });
        }
    }

    /// Stops the expansion, with one diagnostic.
    fn too_many(&mut self, entry: &Entry, pointer: &str) {
        if std::mem::replace(&mut self.full, true) {
            return;
        }
        let message =
            format!("the pipeline has more than {MAX_PASSES} passes, resources or uses of subgraphs");
        let diagnostic = Diagnostic::error(codes::LOOP, entry.key_span, message).pointer(pointer);
        self.shared.diagnostics.push(diagnostic.help("draw more in one pass, or split the pipeline"));
    }

    /// The scope of names in one use of a subgraph.
    #[allow(clippy::too_many_arguments)]
    fn environment_of(
        &mut self,
        entry: &'a Entry,
        subgraph: &'a document::Value,
        inside: &str,
        subgraph_name: &str,
        name: &str,
        pointer: &str,
        outer: &Arc<Environment>,
    ) -> Option<Environment> {
        let section = |name: &str| subgraph.get(name).and_then(document::Value::entries).unwrap_or_default();
        let with = entry.value.get("with");
        let at = format!("{pointer}/with");
        self.shared.fix_all(&entry.value, outer, pointer, false);
        let mut used_at = vec![entry.key_span];
        used_at.extend(&outer.used_at);
        let mut inner = Environment {
            prefix: format!("{name}."),
            is_file: is_path(subgraph_name),
            used_at,
            ..Environment::default()
        };
        let mut fine = true;
        let mut misspelt: Vec<&str> = Vec::new();
        for given in with.and_then(document::Value::entries).unwrap_or_default() {
            let mut known =
                section("inputs").iter().chain(section("parameters")).map(|entry| entry.key.as_str());
            if known.clone().all(|known| known != given.key) {
                let known: Vec<&str> = known.by_ref().collect();
                let beside = with.and_then(document::Value::entries).unwrap_or_default();
                let diagnostic = document::schema::unknown_key(given, &known, beside);
                self.shared.diagnostics.push(diagnostic.pointer(pointer_join(&at, &given.key)));
                misspelt.push(&given.key);
                fine = false;
            }
        }
        let is_misspelt = |name: &str| misspelt.iter().any(|given| suggested_name(given, [name]).is_some());
        for input in section("inputs") {
            match with.and_then(|with| with.get(&input.key)) {
                Some(given) => match given.text().map(|text| outer.interpolate(text, &self.shared.scope)) {
                    Some(Ok(text)) => match Reference::parse(&text) {
                        Ok(reference) => {
                            let version = reference.version.map(|pass| outer.pass(pass));
                            let version =
                                version.or_else(|| outer.version(reference.resource).map(str::to_owned));
                            let back = outer.back(reference.resource).saturating_add(reference.back);
                            let name = outer.resource(reference.resource).into_owned();
                            let handed_on =
                                outer.inputs.get(reference.resource).map(|input| input.given.clone());
                            let given = handed_on.unwrap_or_else(|| Given {
                                name: reference.resource.to_owned(),
                                text: given.text().unwrap_or_default().to_owned(),
                                place: given.span,
                                pointer: pointer_join(&at, &input.key),
                                environment: outer.clone(),
                            });
                            inner.inputs.insert(input.key.clone(), Input { name, version, back, given });
                        }
                        Err(error) => {
                            let message = format!("\"{text}\" is not a reference");
                            let diagnostic = Diagnostic::error(codes::BAD_REFERENCE, given.span, message);
                            self.shared.diagnostics.push(diagnostic.pointer(&at).help(error.to_string()));
                            fine = false;
                        }
                    },
                    Some(Err(mut error)) => {
                        outer.widen(&mut error, std::iter::empty());
                        let here = pointer_join(&at, &input.key);
                        self.shared.diagnostics.extend(expression_diagnostic(&error, given, &here));
                        fine = false;
                    }
                    None => {
                        let message = format!(
                            "the input \"{}\" is a resource, this is {}",
                            input.key,
                            given.kind_name()
                        );
                        let diagnostic = Diagnostic::error(codes::WRONG_TYPE, given.span, message);
                        self.shared.diagnostics.push(diagnostic.pointer(&at).help("name a resource"));
                        fine = false;
                    }
                },
                None if is_misspelt(&input.key) => {}
                None => {
                    let message = format!("the input \"{}\" of \"{subgraph_name}\" is not given", input.key);
                    let diagnostic = Diagnostic::error(codes::MISSING_KEY, entry.key_span, message)
                        .related(input.key_span, "declared here")
                        .help(format!("add \"{}\" to \"with\"", input.key));
                    self.shared.diagnostics.push(diagnostic.pointer(&at));
                    fine = false;
                }
            }
        }
        for parameter in section("parameters") {
            let here = pointer_join(&format!("{inside}/parameters"), &parameter.key);
            if (self.is_broken)(&here) {
                fine = false;
                continue;
            }
            let known = self.parameters.entry(parameter);
            let Some(declaration) =
                known.or_insert_with(|| parameter.value.decode().ok().map(Rc::new)).clone()
            else {
                continue;
            };
            let given = with.and_then(|with| with.get(&parameter.key));
            let value = match given {
                None => parameter.value.get("default").cloned(),
                // A word, or an expression after an equals sign, as wherever a word can stand.
                Some(given)
                    if declaration.parameter_type == crate::language::ParameterType::Enum
                        && given.text().is_none_or(|text| !text.starts_with('=')) =>
                {
                    Some(given.clone())
                }
                Some(given) => self
                    .evaluate(given, &pointer_join(&at, &parameter.key), outer)
                    .map(|value| to_document(&value, given.span)),
            };
            let Some(value) = value else {
                fine = false;
                continue;
            };
            match setting::decode_parameter(&parameter.key, &declaration, &value) {
                Ok(value) => {
                    if !declaration.values.is_empty() {
                        inner.words.insert(parameter.key.clone(), declaration.values.clone());
                    }
                    let is_word = declaration.parameter_type == ParameterType::Enum;
                    let is_expression = |given: &&document::Value| {
                        !is_word || given.text().is_some_and(|text| text.starts_with('='))
                    };
                    let expression = given.filter(is_expression).and_then(|given| expression_of(given).ok());
                    if let (Some(given), Some(expression)) = (given, expression) {
                        let expression = outer.close_live(&expression, &|_| false);
                        let follows = (expression, Some((*declaration).clone()), given.span);
                        self.follow(&mut inner, &parameter.key, &value, follows);
                    }
                    inner.locals.insert(parameter.key.clone(), value);
                }
                Err(errors) => {
                    let declared = "the parameter is declared here";
                    let errors = errors.into_iter().map(|one| one.related(parameter.key_span, declared));
                    self.shared.diagnostics.extend(errors);
                    fine = false;
                }
            }
        }
        if fine && !section("derived").is_empty() {
            fine = self.derive(section, &format!("{inside}/derived"), &mut inner);
        }
        fine.then_some(inner)
    }

    /// Gives the derived values of a subgraph to one use of it, beside its parameters.
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

    /// Notes a local that follows from parameters of the pipeline.
    fn follow(
        &mut self,
        inner: &mut Environment,
        name: &str,
        value: &Value,
        (expression, declaration, place): (Expression, Option<ParameterDeclaration>, Span),
    ) {
        let outside = format!("{}${name}", inner.prefix);
        if self.shared.dependence.add(outside.clone(), expression, declaration, place) {
            self.shared.scope.give(&outside, value);
            self.shared.given.insert(outside.clone(), value.clone());
            inner.following.insert(name.to_owned(), outside);
        }
    }

    /// The value of an expression that decides what there is.
    fn structural(
        &mut self,
        value: &document::Value,
        pointer: &str,
        environment: &Environment,
    ) -> Option<Value> {
        if let Ok(expression) = expression_of(value) {
            self.shared.fix(&expression, environment, value.span, pointer);
        }
        self.evaluate(value, pointer, environment)
    }

    fn evaluate(
        &mut self,
        value: &document::Value,
        pointer: &str,
        environment: &Environment,
    ) -> Option<Value> {
        let word = value.text().and_then(|text| text.strip_prefix('='));
        let result = expression_of(value)
            .and_then(|expression| environment.evaluate(&expression, &|_| false, &self.shared.scope));
        match result {
            Ok(value) => Some(value),
            Err(mut error) => {
                environment.widen(&mut error, std::iter::empty());
                let sign = usize::from(word.is_some());
                error.range = error.range.start + sign..error.range.end + sign;
                let diagnostic = expression_diagnostic(&error, value, pointer);
                self.shared.report_from(diagnostic.into_iter().collect(), environment);
                None
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    /// Leaves out what one entry stands for.
    fn leave_out(&mut self, gap: Gap, entry: &'a Entry, name: String) {
        self.shared.diagnostics.extend(gap.map(|diagnostic| *diagnostic));
        self.gaps.push((name, entry));
    }
}

/// An expression, or one behind the sign of equality where a word can stand.
fn expression_of(value: &document::Value) -> Result<Expression, ExpressionError> {
    let word = value.text().and_then(|text| text.strip_prefix('='));
    word.map_or_else(|| Expr(value.to_json()), |word| Expr(word.into())).parse()
}

/// Why an entry stands for nothing; `None` where that has its diagnostic already.
type Gap = Option<Box<Diagnostic>>;

fn gap(code: Code, value: &document::Value, pointer: &str, message: String, help: &str) -> Gap {
    Some(Box::new(Diagnostic::error(code, value.span, message).pointer(pointer).help(help)))
}

/// An expression's value as it would stand in a document.
fn to_document(value: &Value, span: crate::source::Span) -> document::Value {
    let kind = match value {
        Value::Bool(value) => Kind::Bool(*value),
        Value::Number(number) => serde_json::Number::from_f64(*number).map_or(Kind::Null, Kind::Number),
        Value::Text(text) => Kind::Text(text.clone()),
        Value::List(list) => Kind::Array(list.iter().map(|value| to_document(value, span)).collect()),
    };
    document::Value { span, kind }
}
