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
/// Modules without warnings by template and values of axes, each with the capabilities that it is valid with.
type Shared = BTreeMap<(String, AxisValues), Vec<(Capabilities, Arc<ShaderModule>)>>;
/// Template, fixed values of axes, binding, member of it.
type Question = (String, AxisValues, String, Option<String>);

/// The texts of a survey.
#[derive(Debug, Default)]
struct Texts {
    /// By template and values of the axes that are no overrides.
    rendered: HashMap<(String, AxisValues), Arc<Rendered>>,
    /// By the hash of the text, with the capabilities that each module was validated with.
    modules: HashMap<[u8; 32], Vec<(Capabilities, Arc<ShaderModule>)>>,
}

/// Shader modules by template and values of axes. Threads can share it.
#[derive(Debug)]
pub struct ShaderCache {
    templates: Arc<TemplateSet>,
    profile: TargetProfile,
    made: Mutex<BTreeMap<(String, AxisValues), Made>>,
    /// The modules of all profiles.
    shared: Arc<Mutex<Shared>>,
    declared: Arc<Mutex<BTreeMap<Question, Option<AxisValues>>>>,
    /// The texts of all profiles, for a survey.
    texts: Option<Arc<Mutex<Texts>>>,
}

impl ShaderCache {
    /// An empty cache.
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

    /// An empty cache for a survey of configurations, whose variants are all proven afterwards.
    pub fn of_survey(templates: &Arc<TemplateSet>, profile: &TargetProfile) -> Self {
        Self { texts: Some(Arc::default()), ..Self::new(templates, profile) }
    }

    /// The modules of the same templates for another profile, which the two share as far as they can.
    pub fn beside(other: &Self, profile: &TargetProfile) -> Self {
        let (shared, declared, texts) = (other.shared.clone(), other.declared.clone(), other.texts.clone());
        Self { shared, declared, texts, ..Self::new(&other.templates, profile) }
    }

    /// A cache that keeps the modules of unchanged templates from an earlier one. Rejections are made again: they may
    /// name any template.
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

    /// The templates.
    pub fn templates(&self) -> &Arc<TemplateSet> {
        &self.templates
    }

    /// The profile.
    pub fn profile(&self) -> &TargetProfile {
        &self.profile
    }

    /// The number of variants that were rendered, rejected ones included.
    pub fn rendered(&self) -> usize {
        self.made.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The module of a template with values of its axes.
    ///
    /// # Errors
    /// As of [`compile`](crate::compile).
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

    /// A module of another profile that is valid for this one too, or else a new one.
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

    /// The module of a text that is proven later.
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

    /// The values with which some variant of a template in which these axes are fixed declares a binding, with a member
    /// where one is given.
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
