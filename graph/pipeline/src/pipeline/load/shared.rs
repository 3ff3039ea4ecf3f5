//! The state that all passes of one pipeline share while they are declared.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use super::VIEWPORT;
use super::programs::Programs;
use crate::data::ValueType;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::{self, Pointer};
use crate::expression::{Expression, ExpressionError, ExpressionKind, Scope as _, Value, unknown_name};
use crate::language::{Expr, GeometryDeclaration};
use crate::pipeline::environment::Environment;
use crate::pipeline::instance::Instance;
use crate::pipeline::live::{Dependence, names};
use crate::pipeline::{Resource, ResourceKind, StaticScope, Structural};
use crate::source::{Sources, Span};
use crate::work::ResourceHandle;

/// Values that a CPU pass reads of blackboard data.
pub(in crate::pipeline) struct Expected {
    pub(in crate::pipeline) resource: ResourceHandle,
    pub(in crate::pipeline) values: Vec<(String, ValueType)>,
    pub(in crate::pipeline) place: Span,
    pub(in crate::pipeline) pointer: String,
}

/// The state that all passes of one pipeline share while they are declared.
pub(in crate::pipeline) struct Shared {
    pub(in crate::pipeline) scope: StaticScope,
    /// What follows from which parameters.
    pub(in crate::pipeline) dependence: Dependence,
    /// Values that subgraphs are given and that follow from parameters.
    pub(in crate::pipeline) given: BTreeMap<String, Value>,
    /// The names of the toggles, which expressions cannot see.
    pub(in crate::pipeline) toggles: Vec<String>,
    pub(in crate::pipeline) resources: Vec<Resource>,
    pub(super) resource_index: HashMap<String, ResourceHandle>,
    pub(in crate::pipeline) geometry: BTreeMap<String, GeometryDeclaration>,
    /// By geometry the filters that a host of it states.
    pub(in crate::pipeline) filters: BTreeMap<String, Vec<String>>,
    pub(in crate::pipeline) programs: Programs,
    pub(in crate::pipeline) diagnostics: Diagnostics,
    /// Diagnostics about what subgraphs are given; they stand where the subgraph is used.
    pub(in crate::pipeline) argument_errors: Diagnostics,
    /// Expressions by their text.
    expressions: HashMap<String, Rc<Expression>>,
    /// How often a pass had an error that only follows from a diagnostic elsewhere.
    pub(in crate::pipeline) withheld: usize,
    pub(super) sources: Sources,
    /// The values that CPU passes read of one another.
    pub(in crate::pipeline) expected: Vec<Expected>,
}

impl Shared {
    /// Before the first pass is declared.
    pub(super) fn new(
        scope: StaticScope,
        dependence: Dependence,
        toggles: Vec<String>,
        geometry: BTreeMap<String, GeometryDeclaration>,
        programs: Programs,
        sources: &Sources,
    ) -> Self {
        Self {
            scope,
            dependence,
            given: BTreeMap::new(),
            toggles,
            resources: Vec::new(),
            resource_index: HashMap::new(),
            geometry,
            filters: BTreeMap::new(),
            programs,
            diagnostics: Diagnostics::new(),
            argument_errors: Diagnostics::new(),
            expressions: HashMap::new(),
            withheld: 0,
            sources: sources.clone(),
            expected: Vec::new(),
        }
    }

    pub(in crate::pipeline) fn find(&self, name: &str) -> Option<ResourceHandle> {
        self.resource_index.get(name).copied()
    }

    pub(in crate::pipeline) fn add_resource(&mut self, resource: Resource) -> ResourceHandle {
        let handle = ResourceHandle(self.resources.len() as u32);
        self.resource_index.entry(resource.name.clone()).or_insert(handle);
        self.resources.push(resource);
        handle
    }

    pub(in crate::pipeline) fn intern_data(
        &mut self,
        name: &str,
        place: Span,
        pointer: &str,
    ) -> ResourceHandle {
        self.find(name).unwrap_or_else(|| {
            self.add_resource(Resource {
                name: name.to_owned(),
                place,
                pointer: pointer.to_owned(),
                value: document::Value { span: place, kind: document::Kind::Null },
                environment: Arc::default(),
                kind: ResourceKind::Data(None),
                history: None,
            })
        })
    }

    /// The parsed text of an expression; what stands in many places is parsed once.
    pub(in crate::pipeline) fn parse(&mut self, text: &str) -> Result<Rc<Expression>, ExpressionError> {
        if let Some(known) = self.expressions.get(text) {
            return Ok(known.clone());
        }
        let parsed = Rc::new(Expr::parse_text(text)?);
        self.expressions.insert(text.to_owned(), parsed.clone());
        Ok(parsed)
    }

    /// Makes structural what an expression follows from, because of what stands at a place.
    pub(in crate::pipeline) fn fix(
        &mut self,
        expression: &Expression,
        environment: &Environment,
        at: &dyn Fn() -> Structural,
    ) {
        if !self.dependence.is_settled() {
            names(expression).into_iter().for_each(|name| self.fix_name(name, environment, at));
        }
    }

    /// The same of a name.
    pub(in crate::pipeline) fn fix_name(
        &mut self,
        name: &str,
        environment: &Environment,
        at: &dyn Fn() -> Structural,
    ) {
        if !self.dependence.is_settled()
            && let Some(name) = environment.followed(name)
        {
            self.dependence.fix(name, at);
        }
    }

    /// Makes structural what the expressions in a value follow from.
    pub(in crate::pipeline) fn fix_all(
        &mut self,
        value: &document::Value,
        environment: &Environment,
        pointer: &Pointer<'_>,
    ) {
        if self.dependence.is_settled() {
            return;
        }
        match &value.kind {
            document::Kind::Text(text) => {
                let at = || Structural { place: value.span, pointer: pointer.into() };
                if let Ok(expression) = self.parse(text) {
                    self.fix(&expression, environment, &at);
                }
            }
            document::Kind::Array(list) => list.iter().enumerate().for_each(|(at, item)| {
                self.fix_all(item, environment, &pointer.element(at));
            }),
            document::Kind::Object(entries) => entries.iter().for_each(|entry| {
                self.fix_all(&entry.value, environment, &pointer.key(&entry.key));
            }),
            _ => {}
        }
    }

    /// Makes structural what the order and the fallbacks of a pass follow from.
    pub(in crate::pipeline) fn fix_order(&mut self, pass: &Instance<'_>) {
        for key in ["after", "passthrough"] {
            if let Some(value) = pass.entry.value.get(key) {
                self.fix_all(value, &pass.environment, &Pointer::Text(&pass.pointer).key(key));
            }
        }
    }

    /// Reports the diagnostics of one instance, each error of a subgraph once.
    pub(in crate::pipeline) fn report_from(
        &mut self,
        diagnostics: impl IntoIterator<Item = Diagnostic>,
        environment: &Environment,
    ) {
        for diagnostic in diagnostics {
            match environment.used_at.is_empty() {
                true => self.diagnostics.push(diagnostic),
                false => _ = self.diagnostics.push_new(environment.told(diagnostic)),
            }
        }
    }

    /// The first name of a deferred expression that nothing will ever define.
    pub(in crate::pipeline) fn unknown_name(&self, expression: &Expression) -> Option<ExpressionError> {
        match &expression.kind {
            ExpressionKind::Name(name) => {
                let head = name.rsplit_once('.').map_or(name.as_str(), |(head, _)| head);
                let known = self.scope.lookup(name).is_some()
                    || VIEWPORT.contains(&name.as_str())
                    || self.find(name).is_some()
                    || self.find(head).is_some()
                    || self.scope.is_broken(name);
                (!known).then(|| {
                    let mut error = unknown_name(name, expression.range.clone(), &self.scope);
                    if let Some(unknown) = &mut error.unknown {
                        unknown.known.extend(VIEWPORT.iter().map(|name| (*name).to_owned()));
                    }
                    error
                })
            }
            _ => expression.parts().find_map(|part| self.unknown_name(part)),
        }
    }
}
