//! What all passes of one pipeline share while they are declared.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use super::{VIEWPORT, has_word};
use crate::data::ValueType;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::document;
use crate::expression::{Expression, ExpressionError, ExpressionKind, Scope as _, unknown_name};
use crate::language::GeometryDeclaration;
use crate::pipeline::environment::Environment;
use crate::pipeline::modules::{Chosen, Modules};
use crate::pipeline::{Program, ProgramBinding, ProgramVariant, Resource, ResourceKind, StaticScope};
use crate::shader::{AxisValue, AxisValues, ShaderModule, TargetProfile, TemplateSet, exceeded_by_layout};
use crate::source::{Sources, Span};
use crate::work::{ProgramHandle, ResourceHandle};

/// Values that a host pass reads of host data.
pub(in crate::pipeline) struct Expected {
    pub(in crate::pipeline) resource: ResourceHandle,
    pub(in crate::pipeline) values: Vec<(String, ValueType)>,
    pub(in crate::pipeline) place: Span,
    pub(in crate::pipeline) pointer: String,
}

/// What all passes of one pipeline share while they are declared.
pub(in crate::pipeline) struct Shared {
    pub(in crate::pipeline) scope: StaticScope,
    /// The names of the toggles, which expressions cannot see.
    pub(in crate::pipeline) toggles: Vec<String>,
    pub(in crate::pipeline) resources: Vec<Resource>,
    pub(super) resource_index: HashMap<String, ResourceHandle>,
    pub(in crate::pipeline) geometry: BTreeMap<String, GeometryDeclaration>,
    pub(in crate::pipeline) programs: Vec<Arc<Program>>,
    pub(super) program_keys: BTreeMap<Chosen, Option<ProgramHandle>>,
    pub(in crate::pipeline) modules: Modules,
    /// The variants whose findings are reported.
    pub(super) refused: BTreeSet<(String, AxisValues)>,
    pub(in crate::pipeline) templates: Arc<TemplateSet>,
    pub(in crate::pipeline) profile: TargetProfile,
    pub(in crate::pipeline) diagnostics: Diagnostics,
    /// Findings about what subgraphs are given; they stand where the subgraph is used.
    pub(in crate::pipeline) misgiven: Diagnostics,
    /// Expressions of subgraphs and loops, by their text.
    pub(in crate::pipeline) expressions: HashMap<String, Rc<Expression>>,
    /// How often a pass had a fault that only follows from a finding elsewhere.
    pub(in crate::pipeline) withheld: usize,
    pub(super) sources: Sources,
    /// What host passes read of one another.
    pub(in crate::pipeline) expected: Vec<Expected>,
}

impl Shared {
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

    /// Reports the findings of one instance: with the places where it is used, and each fault of a subgraph once.
    pub(in crate::pipeline) fn report_from(&mut self, findings: Diagnostics, environment: &Environment) {
        for mut finding in findings {
            if environment.used_at.is_empty() {
                self.diagnostics.push(finding);
                continue;
            }
            let known = self.diagnostics.iter().any(|known| {
                (known.code, &known.place, &known.message) == (finding.code, &finding.place, &finding.message)
            });
            if !known {
                for place in &environment.used_at {
                    finding = finding.related(*place, "used here");
                }
                self.diagnostics.push(finding);
            }
        }
    }

    /// Whether the text of a template, or of any that it could include, has the word: a binding that this variant does
    /// not have, another may.
    pub(in crate::pipeline) fn is_mentioned(&self, template: &str, word: &str) -> bool {
        let text_of = |name: &str| {
            let file = self.templates.file(name).and_then(|file| self.sources.get(file));
            file.map(|file| file.text().clone()).unwrap_or_else(|| "".into())
        };
        let mut reached = vec![template.to_owned()];
        let mut at = 0;
        while let Some(name) = reached.get(at) {
            let text = text_of(name);
            if has_word(&text, word) {
                return true;
            }
            let quoted =
                |name: &str| text.contains(&format!("\"{name}\"")) || text.contains(&format!("'{name}'"));
            let included: Vec<String> =
                self.templates.names().filter(|name| quoted(name)).map(str::to_owned).collect();
            reached.extend(included.into_iter().filter(|name| !reached.contains(name)).collect::<Vec<_>>());
            at += 1;
        }
        false
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
            ExpressionKind::Unary(_, a) => self.unknown_name(a),
            ExpressionKind::Binary(_, a, b) | ExpressionKind::Index(a, b) => {
                self.unknown_name(a).or_else(|| self.unknown_name(b))
            }
            ExpressionKind::Conditional(a, b, c) => {
                self.unknown_name(a).or_else(|| self.unknown_name(b)).or_else(|| self.unknown_name(c))
            }
            ExpressionKind::Call(_, list) | ExpressionKind::List(list) => {
                list.iter().find_map(|item| self.unknown_name(item))
            }
            ExpressionKind::Literal(_) => None,
        }
    }

    /// The program of a template with chosen axes, in every combination of the mesh properties.
    pub(in crate::pipeline) fn program(
        &mut self,
        chosen: Chosen,
        place: Span,
        pointer: &dyn Fn() -> String,
    ) -> Option<ProgramHandle> {
        if let Some(known) = self.program_keys.get(&chosen) {
            return *known;
        }
        let handle = self.new_program(&chosen, place, &pointer());
        self.program_keys.insert(chosen, handle);
        handle
    }

    fn new_program(&mut self, chosen: &Chosen, place: Span, pointer: &str) -> Option<ProgramHandle> {
        let Chosen { template, axes, properties } = chosen;
        let mut variants = Vec::new();
        for mask in 0..1u32 << properties.len().min(8) {
            let mut active: Vec<String> = Vec::new();
            let mut values = axes.clone();
            for (bit, name) in properties.iter().enumerate() {
                let on = mask & (1 << bit) != 0;
                values.insert(name.clone(), AxisValue::Bool(on));
                if on {
                    active.push(name.clone());
                }
            }
            active.sort();
            let module = self.module(template, values, place, pointer)?;
            variants.push(ProgramVariant { properties: active, module });
        }
        match Program::new(template.clone(), axes.clone(), variants, place) {
            Ok(program) if program.bindings.iter().any(|binding| self.is_beyond(binding)) => {
                let beyond: Vec<_> =
                    program.bindings.iter().filter(|binding| self.is_beyond(binding)).collect();
                for binding in beyond {
                    let message = format!(
                        "{template} declares \"{}\" at @group({}) @binding({})",
                        binding.name, binding.group, binding.entry.binding
                    );
                    let limits = &self.profile.limits;
                    let help = format!(
                        "groups are below {}, bindings below {}",
                        limits.max_bind_groups, limits.max_bindings_per_bind_group
                    );
                    self.diagnostics.push(
                        Diagnostic::error(codes::DEVICE_RULE, place, message).pointer(pointer).help(help),
                    );
                }
                None
            }
            Ok(program) => {
                for excess in self.excess(&program) {
                    let message = format!("the variants of {template} together bind {excess} in a stage");
                    self.diagnostics.push(
                        Diagnostic::error(codes::DEVICE_RULE, place, message)
                            .pointer(pointer)
                            .help("variants share one layout: let them share bindings, or draw them in passes of their own"),
                    );
                }
                self.programs.push(Arc::new(program));
                Some(ProgramHandle(self.programs.len() as u32 - 1))
            }
            Err(findings) => {
                self.diagnostics.extend(findings.into_iter().map(|finding| finding.pointer(pointer)));
                None
            }
        }
    }

    /// What the layout of a program has too much of, though each variant alone does not: that is its shader's finding.
    fn excess(&self, program: &Program) -> Vec<String> {
        let is_own = |variant: &ProgramVariant| {
            let bindings = variant.module.reflection.bindings.iter();
            !exceeded_by_layout(bindings.map(|binding| &binding.entry), &self.profile).is_empty()
        };
        if program.variants.len() < 2 || program.variants.iter().any(is_own) {
            return Vec::new();
        }
        exceeded_by_layout(program.bindings.iter().map(|binding| &binding.entry), &self.profile)
    }

    /// Whether a binding has a number that no device of the profile allows.
    fn is_beyond(&self, binding: &ProgramBinding) -> bool {
        let limits = &self.profile.limits;
        binding.group >= limits.max_bind_groups || binding.entry.binding >= limits.max_bindings_per_bind_group
    }

    fn module(
        &mut self,
        template: &str,
        values: AxisValues,
        place: Span,
        pointer: &str,
    ) -> Option<Arc<ShaderModule>> {
        let key = (template.to_owned(), values.clone());
        match self.modules.get(&self.templates, template, values, &self.profile) {
            Ok(module) => Some(module),
            Err(_) if !self.refused.insert(key) => None,
            Err(findings) => {
                for mut finding in findings {
                    if finding.place == crate::diagnostic::Place::Nowhere {
                        finding.place = place.into();
                        finding.pointer = pointer.to_owned();
                    } else {
                        finding = finding.related(place, "used by this pass");
                    }
                    // The same fault in a second variant, or a second pass, is the same fault.
                    let known = self.diagnostics.iter().any(|known| {
                        (known.code, &known.place, &known.message)
                            == (finding.code, &finding.place, &finding.message)
                    });
                    if !known {
                        self.diagnostics.push(finding);
                    }
                }
                None
            }
        }
    }
}
