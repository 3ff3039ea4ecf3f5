//! Shader modules that were made, or rejected, of one set of templates for one profile.
//!
//! Configurations of one pipeline mostly want the same shaders, and so do pipelines that are loaded one after the
//! other. Profiles share modules: one that is valid with few capabilities, and about which nothing is to be said, is
//! the same for each profile that has these and more.
//!
//! A survey of all configurations asks for reflections alone, since a proof of all variants follows. For it a text is
//! rendered once for the axes that it is rendered from, and compiled once for all values of its overrides.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use naga::valid::Capabilities;

use super::declares;
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::targets::profile::TargetProfile;
use crate::variant::compile::{self, Rendered, ShaderModule};
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

type Made = Result<Arc<ShaderModule>, Vec<Diagnostic>>;
/// Shader modules without warnings, keyed by template and axis values. Each has the naga capabilities that it was
/// validated with.
type Shared = BTreeMap<(String, AxisValues), Vec<(Capabilities, Arc<ShaderModule>)>>;
/// The key of a cached [`declares`] query: template, fixed axis values, binding, and optionally a member of the
/// binding's block.
type Question = (String, AxisValues, String, Option<String>);

/// The WGSL modules of a survey. A survey visits many configurations before all variants are validated, and only needs
/// reflections.
#[derive(Debug, Default)]
struct Texts {
    /// Rendered WGSL, keyed by template and the values of its template axes.
    rendered: HashMap<(String, AxisValues), Arc<Rendered>>,
    /// Modules keyed by the BLAKE3 hash of their WGSL, with the naga capabilities that each was validated with.
    modules: HashMap<[u8; 32], Vec<(Capabilities, Arc<ShaderModule>)>>,
}

/// A thread-safe cache of shader modules, keyed by template and axis values, for one target profile.
#[derive(Debug)]
pub struct ShaderCache {
    templates: Arc<TemplateSet>,
    profile: TargetProfile,
    made: Mutex<BTreeMap<(String, AxisValues), Made>>,
    /// Modules that caches of several profiles share.
    shared: Arc<Mutex<Shared>>,
    declared: Arc<Mutex<BTreeMap<Question, Option<AxisValues>>>>,
    /// The WGSL modules that the caches of a survey share between profiles; `None` for a cache outside of a survey.
    texts: Option<Arc<Mutex<Texts>>>,
}

impl ShaderCache {
    /// Creates an empty cache for one target profile.
    pub fn new(templates: &Arc<TemplateSet>, profile: &TargetProfile) -> Self {
        let (templates, profile) = (templates.clone(), profile.clone());
        Self {
            templates,
            profile,
            made: Mutex::default(),
            shared: Arc::default(),
            declared: Arc::default(),
            texts: None,
        }
    }

    /// Creates an empty cache for a survey, which visits many configurations. Modules are compiled once for all
    /// override values, since all variants are validated later.
    pub fn of_survey(templates: &Arc<TemplateSet>, profile: &TargetProfile) -> Self {
        Self { texts: Some(Arc::default()), ..Self::new(templates, profile) }
    }

    /// Creates a cache for another profile. It shares the modules of `other` that need no capability beyond those of
    /// the profile.
    pub fn beside(other: &Self, profile: &TargetProfile) -> Self {
        let (shared, declared, texts) = (other.shared.clone(), other.declared.clone(), other.texts.clone());
        Self { shared, declared, texts, ..Self::new(&other.templates, profile) }
    }

    /// Creates a cache that keeps the modules of unchanged templates from an earlier cache. Rejections are not kept,
    /// since they may refer to any template.
    pub fn carrying(before: &Self, templates: &Arc<TemplateSet>, unchanged: &BTreeSet<&str>) -> Self {
        let new = Self::new(templates, &before.profile);
        let made = before.made.lock().unwrap_or_else(PoisonError::into_inner);
        let kept =
            made.iter().filter(|((name, _), module)| module.is_ok() && unchanged.contains(name.as_str()));
        let kept = kept.map(|(key, module)| (key.clone(), module.clone())).collect();
        let declared = before.declared.lock().unwrap_or_else(PoisonError::into_inner);
        let declared = declared.iter().filter(|((name, ..), _)| unchanged.contains(name.as_str()));
        let declared = declared.map(|(key, values)| (key.clone(), values.clone())).collect();
        Self { made: Mutex::new(kept), declared: Arc::new(Mutex::new(declared)), ..new }
    }

    /// The templates that modules are compiled from.
    pub fn templates(&self) -> &Arc<TemplateSet> {
        &self.templates
    }

    /// The target profile that modules are validated for.
    pub fn profile(&self) -> &TargetProfile {
        &self.profile
    }

    /// The number of cached variants, including rejected ones.
    pub fn rendered(&self) -> usize {
        self.made.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Returns the module of a template with these axis values; compiles the module if it is not cached.
    ///
    /// # Errors
    /// The errors of the template, the axis values or the generated WGSL.
    pub fn module(&self, template: &str, values: AxisValues) -> Made {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (template.to_owned(), values);
        if let Some(known) = made.get(&key) {
            return known.clone();
        }
        let module = match &self.texts {
            Some(texts) => self.surveyed(texts, template, &key.1),
            None => self.compiled(&key),
        };
        made.insert(key, module.clone());
        module
    }

    /// Returns a module compiled for another profile if it is valid for this profile too; otherwise compiles a new one.
    fn compiled(&self, key: &(String, AxisValues)) -> Made {
        let own = self.profile.capabilities;
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let of_others = shared.get(key).and_then(|all| all.iter().find(|(needed, _)| own.contains(*needed)));
        if let Some((_, module)) = of_others {
            return Ok(module.clone());
        }
        let new = Arc::new(compile::compile(&self.templates, &key.0, &key.1, &self.profile)?);
        if new.warnings.is_empty() {
            shared.entry(key.clone()).or_default().push((own, new.clone()));
        }
        Ok(new)
    }

    /// Compiles a module for a survey. Override values of a module that is already in the cache are not validated.
    fn surveyed(&self, texts: &Mutex<Texts>, template: &str, values: &AxisValues) -> Made {
        let (templates, own) = (&self.templates, self.profile.capabilities);
        let values = compile::complete(templates, template, values)?;
        let read = compile::template_values(templates, template, &values);
        let mut texts = texts.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (template.to_owned(), read);
        let rendered = match texts.rendered.get(&key) {
            Some(known) => known.clone(),
            None => {
                let new = Arc::new(render::render(templates, template, &key.1)?);
                texts.rendered.insert(key, new.clone());
                new
            }
        };
        let hash = *blake3::hash(rendered.0.wgsl.as_bytes()).as_bytes();
        let known = texts.modules.entry(hash).or_default();
        let of_text = known.iter().find(|(needed, one)| own.contains(*needed) && one.template == template);
        let with_values = |(_, one): &(_, Arc<ShaderModule>)| compile::with_values(one, &values, &rendered);
        if let Some(module) = of_text.and_then(with_values) {
            return Ok(Arc::new(module));
        }
        let new = compile::of_rendered(templates, template, &values, &rendered, &self.profile)?;
        let new = Arc::new(new);
        if new.warnings.is_empty() {
            known.push((own, new.clone()));
        }
        Ok(new)
    }

    /// Returns axis values of a variant that declares `binding` (and `member` in its block). `fixed` restricts the
    /// variants. `None` if no variant declares it; empty values if the search was incomplete.
    pub fn declares(
        &self,
        template: &str,
        fixed: &AxisValues,
        binding: &str,
        member: Option<&str>,
    ) -> Option<AxisValues> {
        let mut declared = self.declared.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (template.to_owned(), fixed.clone(), binding.to_owned(), member.map(str::to_owned));
        let search = || declares(&self.templates, template, fixed, binding, member);
        declared.entry(key).or_insert_with(search).clone()
    }
}
