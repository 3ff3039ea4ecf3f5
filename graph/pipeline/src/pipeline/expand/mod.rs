//! Loops and subgraphs: from the passes and resources of a document to their instances.
//!
//! ```jsonc
//! "subgraphs": { "blur": { "inputs": { "image": "what is blurred" }, "parameters": { … }, "resources": { … }, "passes": { … } } },
//! "passes": {
//!   "soften": { "use": "blur", "with": { "image": "&color", "radius": 6 } },
//!   "down":   { "for_each": { "level": "=levels" }, "fullscreen": { … "=&down@down[level - 1]" … } }
//! }
//! ```
//!
//! An instance shares the document's entry with all others and carries its own [`Environment`]; nothing of the text is
//! copied or decoded twice. Passes of a subgraph are named `soften.half`, rounds of a loop `down.0`, `down.1`, … A
//! loop over a number counts from 0; over a list it takes each element. A subgraph that is used in a loop is named
//! `soften.0.half`. What a use says of order, toggles and side effects holds for all passes of the instance.
//!
//! Limits: 4,096 rounds of a loop, 65,536 passes in all, subgraphs 16 levels deep.

mod subgraph;

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use crate::node::Registry;
use crate::pipeline::names::{Environment, Instance, expression_diagnostic, name_diagnostic};
use crate::pipeline::settings::live::Structural;
use crate::pipeline::state::shared::Shared;
use umbragraph_text::compose::is_path;
use umbragraph_text::diagnostic::{Code, Diagnostic, codes, list_of, way_of};
use umbragraph_text::document::{self, Document, Entry, Kind, pointer_join};
use umbragraph_text::expression::Value;
use umbragraph_text::language::{Expr, ParameterDeclaration};

const MAX_ROUNDS: usize = 4096;
const MAX_PASSES: usize = 65_536;
const MAX_DEPTH: usize = 16;

/// Expands the loops and subgraphs of a document to instances of passes and resources.
pub(super) struct Expander<'a, 's> {
    document: &'a Document,
    subgraphs: HashMap<&'a str, &'a Entry>,
    registry: &'s Registry,
    is_broken: &'s dyn Fn(&str) -> bool,
    shared: &'s mut Shared,
    pub(super) resources: Vec<Instance<'a>>,
    pub(super) instances: Vec<Instance<'a>>,
    /// The uses of subgraphs that have a passthrough.
    pub(super) passthroughs: Vec<Instance<'a>>,
    /// The uses of subgraphs, and the loops with zero iterations, that have an `after` setting.
    pub(super) waiting: Vec<Instance<'a>>,
    /// The passes that could not be expanded, by name.
    pub(super) gaps: Vec<(String, &'a Entry)>,
    full: bool,
    /// The number of uses of subgraphs so far.
    uses: usize,
    /// The decoded parameters of subgraphs, by the address of their entry in the document.
    parameters: HashMap<*const Entry, Option<Rc<ParameterDeclaration>>>,
    /// The subgraphs that are being expanded, the outermost first.
    open: Vec<String>,
    /// The names of uses of subgraphs that are switched off, and of loops with zero iterations.
    pub(super) absent: BTreeSet<String>,
}

impl<'a, 's> Expander<'a, 's> {
    pub(super) fn new(
        document: &'a Document,
        registry: &'s Registry,
        is_broken: &'s dyn Fn(&str) -> bool,
        shared: &'s mut Shared,
    ) -> Self {
        let subgraphs = document.root.entries_of("subgraphs").iter().map(|entry| (entry.key.as_str(), entry));
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
            full: false,
            uses: 0,
            parameters: HashMap::new(),
            open: Vec::new(),
            absent: BTreeSet::new(),
        }
    }

    /// Expands the resources and passes at the top level of the document.
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
        let above = [pointer, "/resources"].concat();
        for entry in owner.entries_of("resources") {
            if self.full || self.resources.len() >= MAX_PASSES {
                self.too_many(entry, pointer);
                return;
            }
            let name = environment.resource(&entry.key).into_owned();
            let resource = self.instance(entry, name, &above, environment);
            self.resources.push(resource);
        }
        let above = [pointer, "/passes"].concat();
        for entry in owner.entries_of("passes") {
            let name = environment.pass(&entry.key);
            let pass = self.instance(entry, name, &above, environment);
            self.looped(pass, depth);
        }
    }

    fn instance(
        &mut self,
        entry: &'a Entry,
        name: String,
        above: &str,
        environment: &Arc<Environment>,
    ) -> Instance<'a> {
        self.shared.diagnostics.extend(name_diagnostic(entry));
        let pointer = pointer_join(above, &entry.key);
        let is_broken = (self.is_broken)(&pointer);
        Instance { name, entry, pointer, environment: environment.clone(), is_broken }
    }

    fn looped(&mut self, pass: Instance<'a>, depth: usize) {
        if self.full {
            return;
        }
        let Some(rounds) = pass.entry.value.get("for_each").filter(|_| !pass.is_broken) else {
            self.single(pass, depth);
            return;
        };
        let (variable, values) = match self.rounds(rounds, &pass) {
            Ok(found) => found,
            Err(gap) => return self.leave_out(gap, &pass),
        };
        if values.is_empty() {
            self.switch_off(&pass, "for_each", false);
        }
        for (round, value) in values.into_iter().enumerate() {
            if self.full {
                return;
            }
            let mut inner = (*pass.environment).clone();
            // A variable stands before a parameter of its name.
            inner.following.remove(&variable.key);
            inner.words.remove(&variable.key);
            inner.locals.insert(variable.key.clone(), value);
            let name = format!("{}.{round}", pass.name);
            self.single(Instance { name, environment: Arc::new(inner), ..pass.clone() }, depth);
        }
    }

    /// Returns the variable of a loop, and its value in each iteration.
    fn rounds(
        &mut self,
        rounds: &'a document::Value,
        pass: &Instance<'a>,
    ) -> Result<(&'a Entry, Vec<Value>), Gap> {
        let at = format!("{}/for_each", pass.pointer);
        let variables = rounds.entries().unwrap_or_default();
        let [variable] = variables else {
            let message = format!("\"for_each\" has {} variables, a loop has one", variables.len());
            return Err(gap(codes::LOOP, rounds, &at, message, "write { \"level\": 4 }"));
        };
        let (at, value) = (pointer_join(&at, &variable.key), &variable.value);
        let wrong = |message: String, help: &str| Err(gap(codes::LOOP, value, &at, message, help));
        let too_many = |count: f64| {
            let message = format!("{count} rounds are more than the maximum of {MAX_ROUNDS}");
            wrong(message, "shorten the list, or lower the count")
        };
        let values = match self.structural(value, &at, &pass.environment).ok_or(None)? {
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

    fn single(&mut self, pass: Instance<'a>, depth: usize) {
        if self.instances.len() >= MAX_PASSES || self.uses >= MAX_PASSES {
            self.too_many(pass.entry, &pass.pointer);
            return;
        }
        match pass.entry.value.get("use") {
            Some(used) if !pass.is_broken => {
                if let Err(gap) = self.used(&pass, used, depth) {
                    self.leave_out(gap, &pass);
                }
            }
            _ => self.instances.push(pass),
        }
    }

    fn used(&mut self, pass: &Instance<'a>, used: &'a document::Value, depth: usize) -> Result<(), Gap> {
        let Instance { entry, pointer, environment, .. } = pass;
        let wanted = used.text().unwrap_or_default();
        let at = format!("{pointer}/use");
        // A file knows further files, whatever the pipeline declares.
        let is_seen = |name: &str| !environment.is_file || is_path(name);
        let Some(subgraph) = self.subgraphs.get(wanted).copied().filter(|_| is_seen(wanted)) else {
            let known = self.document.root.entries_of("subgraphs");
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
                    known => format!("the subgraphs are {}", list_of(known)),
                },
            ))));
        };
        if let Some(first) = self.open.iter().position(|open| open == wanted) {
            let way: Vec<&str> = self.open[first..].iter().map(String::as_str).chain([wanted]).collect();
            let message = format!("the subgraph \"{wanted}\" uses itself: {}", way_of(way));
            return Err(gap(codes::UNKNOWN_SUBGRAPH, used, &at, message, "a subgraph cannot use itself"));
        }
        if depth >= MAX_DEPTH {
            let message = format!("subgraphs are used {MAX_DEPTH} levels deep");
            return Err(gap(codes::UNKNOWN_SUBGRAPH, used, &at, message, "a subgraph cannot use itself"));
        }
        let mut members = entry.value.entries().unwrap_or_default().iter();
        if let Some(extra) = members.find(|member| self.registry.get(&member.key).is_some()) {
            let message = format!("\"use\" and \"{}\" exclude one another", extra.key);
            return Err(gap(codes::UNKNOWN_KEY, &extra.value, &at, message, "make it two passes"));
        }
        if let Some(when) = entry.value.get("when") {
            let at = format!("{pointer}/when");
            match self.structural(when, &at, environment).ok_or(None)? {
                Value::Bool(true) => {}
                Value::Bool(false) => {
                    self.switch_off(pass, "when", environment.is_top());
                    return Ok(());
                }
                other => {
                    let message = format!("a boolean is wanted here, this is {}", other.kind_name());
                    return Err(gap(codes::EXPRESSION_TYPE, when, &at, message, "make it a comparison"));
                }
            }
        }
        if let Some(survey) = &mut self.shared.programs.survey {
            survey.has(entry);
        }
        let mut inner = self.environment_of(pass, subgraph).ok_or(None)?;
        inner.toggles.clone_from(&environment.toggles);
        inner.toggles.extend(entry.value.get("toggle").and_then(document::Value::text).map(str::to_owned));
        if entry.value.get("passthrough").is_some() {
            self.passthroughs.push(pass.clone());
        }
        inner.side_effect = environment.side_effect
            || entry.value.get("side_effect").is_some_and(|value| matches!(value.kind, Kind::Bool(true)));
        self.wait(pass);
        self.uses += 1;
        self.open.push(wanted.to_owned());
        self.sections(&subgraph.value, &pointer_join("/subgraphs", wanted), &Arc::new(inner), depth + 1);
        self.open.pop();
        Ok(())
    }

    /// Records that a loop has zero iterations, or that a use of a subgraph is switched off. `key` is the deciding key,
    /// `for_each` or `when`.
    fn switch_off(&mut self, pass: &Instance<'a>, key: &str, is_top: bool) {
        self.wait(pass);
        self.absent.insert(pass.name.clone());
        if let Some(survey) = &mut self.shared.programs.survey {
            survey.lacks(pass.entry, &pass.pointer, key, is_top);
        }
    }

    /// Records a loop or a use of a subgraph whose `after` names passes that it must follow.
    fn wait(&mut self, pass: &Instance<'a>) {
        if pass.entry.value.get("after").is_some() {
            self.waiting.push(pass.clone());
        }
    }

    /// Stops the expansion at the maximum number of passes, resources or uses of subgraphs. Only the first call reports
    /// this.
    fn too_many(&mut self, entry: &Entry, pointer: &str) {
        if std::mem::replace(&mut self.full, true) {
            return;
        }
        let message =
            format!("the pipeline has more than {MAX_PASSES} passes, resources or uses of subgraphs");
        let diagnostic = Diagnostic::error(codes::LOOP, entry.key_span, message).pointer(pointer);
        self.shared.diagnostics.push(diagnostic.help("draw more in one pass, or split the pipeline"));
    }

    /// Leaves out an entry that cannot be expanded, and reports the reason.
    fn leave_out(&mut self, gap: Gap, pass: &Instance<'a>) {
        self.shared.diagnostics.extend(gap.map(|diagnostic| *diagnostic));
        self.gaps.push((pass.name.clone(), pass.entry));
    }

    /// Evaluates an expression that decides which passes exist. A change of the parameters that it uses then needs a
    /// new plan.
    fn structural(
        &mut self,
        value: &document::Value,
        pointer: &str,
        environment: &Environment,
    ) -> Option<Value> {
        self.settle(value, pointer, environment);
        self.evaluate(value, pointer, environment)
    }

    /// Marks the parameters on which an expression depends as structural: a change of them then needs a new plan.
    fn settle(&mut self, value: &document::Value, pointer: &str, environment: &Environment) {
        if let Ok(expression) = Expr(value.to_json()).parse() {
            let at = || Structural { place: value.span, pointer: pointer.to_owned() };
            self.shared.fix(&expression, environment, &at);
        }
    }

    fn evaluate(
        &mut self,
        value: &document::Value,
        pointer: &str,
        environment: &Environment,
    ) -> Option<Value> {
        let result = Expr(value.to_json())
            .parse()
            .and_then(|expression| environment.evaluate(&expression, &|_| false, &self.shared.scope));
        match result {
            Ok(value) => Some(value),
            Err(mut error) => {
                environment.widen(&mut error, std::iter::empty());
                let diagnostic = expression_diagnostic(&error, value, pointer);
                self.shared.report_from(diagnostic, environment);
                None
            }
        }
    }
}

/// The reason why an entry cannot be expanded; `None` if it was already reported.
type Gap = Option<Box<Diagnostic>>;

fn gap(
    code: Code,
    value: &document::Value,
    pointer: &str,
    message: impl Into<String>,
    help: impl Into<String>,
) -> Gap {
    Some(Box::new(Diagnostic::error(code, value.span, message).pointer(pointer).help(help)))
}
