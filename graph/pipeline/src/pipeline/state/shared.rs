//! The state that all passes of one pipeline share while they are declared.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use crate::data::ValueType;
use crate::pipeline::names::{Environment, Instance, VIEWPORT};
use crate::pipeline::resource::{Resource, ResourceKind};
use crate::pipeline::settings::{Dependence, StaticScope, Structural, names};
use crate::pipeline::state::programs::Programs;
use crate::work::ResourceHandle;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics};
use umbragraph_text::document::{self, Pointer};
use umbragraph_text::expression::{
    Expression, ExpressionError, ExpressionKind, Scope as _, Value, unknown_name,
};
use umbragraph_text::language::{Expr, GeometryDeclaration};
use umbragraph_text::source::{Sources, Span};

/// The values that a CPU pass expects a blackboard data resource to publish.
pub(crate) struct Expected {
    pub(crate) resource: ResourceHandle,
    pub(crate) values: Vec<(String, ValueType)>,
    pub(crate) place: Span,
    pub(crate) pointer: String,
}

/// The state that all passes of one pipeline share while they are declared.
pub(crate) struct Shared {
    pub(crate) scope: StaticScope,
    /// The parameters on which each value depends.
    pub(crate) dependence: Dependence,
    /// The values of arguments and derived values of subgraphs that depend on parameters, by internal names.
    pub(crate) given: BTreeMap<String, Value>,
    /// The names of the toggles, which expressions cannot use.
    pub(crate) toggles: Vec<String>,
    pub(crate) resources: Vec<Resource>,
    pub(crate) resource_index: HashMap<String, ResourceHandle>,
    pub(crate) geometry: BTreeMap<String, GeometryDeclaration>,
    /// The draw filters that the host of each geometry lists, by geometry contract.
    pub(crate) filters: BTreeMap<String, Vec<String>>,
    pub(crate) programs: Programs,
    pub(crate) diagnostics: Diagnostics,
    /// Diagnostics about arguments of subgraphs, placed where the subgraph is used.
    pub(crate) argument_errors: Diagnostics,
    /// The parsed expressions, by their source text.
    expressions: HashMap<String, Rc<Expression>>,
    /// The number of errors in passes that only follow from another diagnostic.
    pub(crate) withheld: usize,
    pub(crate) sources: Sources,
    /// The values that CPU passes expect other passes to publish.
    pub(crate) expected: Vec<Expected>,
}

impl Shared {
    /// Creates the state before any pass is declared.
    pub(crate) fn new(
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

    pub(crate) fn find(&self, name: &str) -> Option<ResourceHandle> {
        self.resource_index.get(name).copied()
    }

    pub(crate) fn add_resource(&mut self, resource: Resource) -> ResourceHandle {
        let handle = ResourceHandle(self.resources.len() as u32);
        self.resource_index.entry(resource.name.clone()).or_insert(handle);
        self.resources.push(resource);
        handle
    }

    pub(crate) fn intern_data(&mut self, name: &str, place: Span, pointer: &str) -> ResourceHandle {
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

    /// Parses an expression, or returns the result of an earlier parse of the same text.
    pub(crate) fn parse(&mut self, text: &str) -> Result<Rc<Expression>, ExpressionError> {
        if let Some(known) = self.expressions.get(text) {
            return Ok(known.clone());
        }
        let parsed = Rc::new(Expr::parse_text(text)?);
        self.expressions.insert(text.to_owned(), parsed.clone());
        Ok(parsed)
    }

    /// Marks the parameters on which an expression depends as structural: a change of them then needs a new plan. `at`
    /// returns the use that is the reason.
    pub(crate) fn fix(
        &mut self,
        expression: &Expression,
        environment: &Environment,
        at: &dyn Fn() -> Structural,
    ) {
        if !self.dependence.is_settled() {
            names(expression).into_iter().for_each(|name| self.fix_name(name, environment, at));
        }
    }

    /// Marks the parameters on which a name depends as structural: a change of them then needs a new plan. `at` returns
    /// the use that is the reason.
    pub(crate) fn fix_name(&mut self, name: &str, environment: &Environment, at: &dyn Fn() -> Structural) {
        if !self.dependence.is_settled()
            && let Some(name) = environment.followed(name)
        {
            self.dependence.fix(name, at);
        }
    }

    /// Marks the parameters on which the expressions in a document value depend as structural: a change of them then
    /// needs a new plan.
    pub(crate) fn fix_all(
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

    /// Marks the parameters on which the order and the fallbacks of a pass depend as structural: a change of them then
    /// needs a new plan.
    pub(crate) fn fix_order(&mut self, pass: &Instance<'_>) {
        for key in ["after", "passthrough"] {
            if let Some(value) = pass.entry.value.get(key) {
                self.fix_all(value, &pass.environment, &Pointer::Text(&pass.pointer).key(key));
            }
        }
    }

    /// Reports the diagnostics of one instance. An error in a subgraph is reported once for all its uses.
    pub(crate) fn report_from(
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

    /// The error for the first name in a deferred expression that is not declared anywhere; `None` if all names are
    /// known.
    pub(crate) fn unknown_name(&self, expression: &Expression) -> Option<ExpressionError> {
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
