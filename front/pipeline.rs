//! [`Pipeline`]: a pipeline as it was loaded, to be planned for sizes, parameters and features.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use crate::compiler::{Graph, Plan, PlanOptions};
use crate::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use crate::document::{self, Document};
use crate::front::Options;
use crate::node::Registry;
use crate::pipeline::{Modules, Overrides, Setting, of_preset};
use crate::shader::{TargetProfile, TemplateSet};
use crate::source::{Sources, Span};
use crate::{CheckOptions, Error};

/// A pipeline as it was loaded, to be planned for sizes, parameters and features. Planning again parses nothing; where
/// nothing but sizes differs from the plan before, the rest of that is taken over. Clones are the same pipeline.
#[derive(Clone)]
pub struct Pipeline(Arc<Loaded>);

/// Registry, profile, templates, and the modules of all loads.
pub(super) type With = (Registry, TargetProfile, Arc<TemplateSet>, Arc<Mutex<Modules>>);

struct Loaded {
    document: Document,
    with: With,
    sources: Sources,
    findings: Diagnostics,
    last: Mutex<Option<Last>>,
    /// What the schema says, once it was asked.
    schema: Mutex<Option<Diagnostics>>,
}

/// The plan before, and what it was made of.
struct Last {
    settings: Settings,
    graph: Graph,
    plan: Arc<Plan>,
}

type Settings = (Option<String>, Vec<(String, String)>, Vec<(String, String)>, BTreeSet<String>);

impl Pipeline {
    pub(super) fn new(document: Document, with: With, sources: Sources, findings: Diagnostics) -> Self {
        let (last, schema) = Default::default();
        Self(Arc::new(Loaded { document, with, sources, findings, last, schema }))
    }

    /// Plans a frame. Everything is checked that can be known without a device: values, shaders, formats, what the host
    /// stores.
    ///
    /// # Errors
    /// Every finding, if one of them is an error.
    pub fn plan(&self, options: &Options) -> Result<Arc<Plan>, Error> {
        let loaded = &*self.0;
        let Options { preset, parameters, features, exposed, .. } = options.clone();
        let settings: Settings = (preset, parameters, features, exposed);
        let mut last = loaded.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = last.as_mut().filter(|last| last.settings == settings) {
            let resized = last.plan.resized(&last.graph, &options.plan, &loaded.sources);
            last.plan = Arc::new(resized.map_err(|found| Error::new(found, &loaded.sources))?);
            return Ok(last.plan.clone());
        }
        let mut sources = loaded.sources.clone();
        let mut findings = loaded.findings.clone();
        let overrides = loaded.overrides(options, &mut sources, &mut findings);
        let document = loaded.exposing(&options.exposed, &mut findings);
        let checked = loaded.check(&document, (&overrides, &options.plan), &sources, &mut findings);
        findings.sort();
        match (checked.graph, checked.plan) {
            (Some(graph), Some(plan)) if !findings.has_errors() => {
                let plan = Arc::new(plan);
                *last = Some(Last { settings, graph, plan: plan.clone() });
                Ok(plan)
            }
            _ => Err(Error::new(findings, &sources)),
        }
    }

    /// Warnings and notes about what was loaded.
    pub fn findings(&self) -> &Diagnostics {
        &self.0.findings
    }

    /// The composed document.
    pub fn document(&self) -> &Document {
        &self.0.document
    }

    /// The texts that it was composed of, and those of templates.
    pub fn sources(&self) -> &Sources {
        &self.0.sources
    }
}

impl PartialEq for Pipeline {
    /// Whether both are of one load.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.0.document.root.get("name").and_then(document::Value::text);
        f.debug_tuple("Pipeline").field(&name.unwrap_or_default()).finish()
    }
}

impl Loaded {
    fn overrides(&self, options: &Options, sources: &mut Sources, findings: &mut Diagnostics) -> Overrides {
        let preset = options.preset.as_ref().map(|name| {
            let file = sources.add("<options>", name.as_str());
            of_preset(&self.document, name, Span::new(file, 0..name.len()), findings)
        });
        let mut settings = |all: &[(String, String)]| {
            let setting = |(name, json): &(String, String)| {
                let file = sources.add("<options>", json.as_str());
                match document::parse(sources, file).valid() {
                    Ok(value) => {
                        let place = value.root.span;
                        Some(Setting { name: name.clone(), value: value.root, place })
                    }
                    Err(found) => {
                        findings.extend(found);
                        None
                    }
                }
            };
            all.iter().filter_map(setting).collect()
        };
        let own =
            Overrides { parameters: settings(&options.parameters), features: settings(&options.features) };
        preset.unwrap_or_default().under(own)
    }

    /// The document with resources that are exposed.
    fn exposing(&self, exposed: &BTreeSet<String>, findings: &mut Diagnostics) -> Cow<'_, Document> {
        let mut document = Cow::Borrowed(&self.document);
        for name in exposed {
            let declared = self.document.root.get("resources").and_then(|all| all.entry(name));
            let Some(place) = declared.map(|entry| entry.key_span) else {
                let known = self.document.root.entries_of("resources");
                let known = known.iter().map(|entry| entry.key.as_str());
                let message = format!("there is no resource \"{name}\" to expose");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_RESOURCE, Place::Nowhere, message);
                findings.push(diagnostic.suggest(name, known, None, |known| {
                    format!("the resources are {}", list_of(known.iter().copied()))
                }));
                continue;
            };
            let resources = document.to_mut().root.entries_of_mut("resources");
            let resource = resources.and_then(|all| all.iter_mut().find(|entry| entry.key == *name));
            let kind = resource.map(|entry| &mut entry.value.kind);
            let Some(document::Kind::Object(kinds)) = kind else { continue };
            for document::Entry { value, .. } in kinds {
                let document::Kind::Object(keys) = &mut value.kind else { continue };
                keys.retain(|entry| entry.key != "exposed");
                let value = document::Value { span: place, kind: document::Kind::Bool(true) };
                keys.push(document::Entry { key: "exposed".to_owned(), key_span: place, value });
            }
        }
        document
    }

    fn check(
        &self,
        document: &Document,
        (overrides, plan): (&Overrides, &PlanOptions),
        sources: &Sources,
        findings: &mut Diagnostics,
    ) -> crate::CheckReport {
        let (registry, profile, templates, modules) = &self.with;
        let options = CheckOptions { registry, templates, profile, overrides, plan };
        let mut modules = modules.lock().unwrap_or_else(PoisonError::into_inner);
        let mut schema = self.schema.lock().unwrap_or_else(PoisonError::into_inner);
        modules.swap_schema(&mut schema);
        let checked = crate::check_sharing(document, &options, sources, findings, &mut modules);
        modules.swap_schema(&mut schema);
        checked
    }
}
