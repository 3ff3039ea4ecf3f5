//! Shader modules that were made, or rejected, of one set of templates for one profile.
//!
//! Configurations of one pipeline mostly want the same shaders, and so do pipelines that are loaded one after the other.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use super::declares;
use crate::{ShaderModule, TargetProfile, TemplateSet, compile};
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

type Made = Result<Arc<ShaderModule>, Vec<Diagnostic>>;
/// Template, fixed values of axes, binding, member of it.
type Question = (String, AxisValues, String, Option<String>);

/// Shader modules by template and values of axes. Threads can share it.
#[derive(Debug)]
pub struct ShaderCache {
    templates: Arc<TemplateSet>,
    profile: TargetProfile,
    made: Mutex<BTreeMap<(String, AxisValues), Made>>,
    declared: Mutex<BTreeMap<Question, Option<AxisValues>>>,
}

impl ShaderCache {
    /// Nothing made yet.
    pub fn new(templates: &Arc<TemplateSet>, profile: &TargetProfile) -> Self {
        let (templates, profile) = (templates.clone(), profile.clone());
        Self { templates, profile, made: Mutex::default(), declared: Mutex::default() }
    }

    /// Nothing made yet but the modules of a cache before, of templates that have not changed. Rejections are made again:
    /// they may name any template.
    pub fn carrying(before: &Self, templates: &Arc<TemplateSet>, unchanged: &BTreeSet<&str>) -> Self {
        let new = Self::new(templates, &before.profile);
        let made = before.made.lock().unwrap_or_else(PoisonError::into_inner);
        let kept =
            made.iter().filter(|((name, _), module)| module.is_ok() && unchanged.contains(name.as_str()));
        let kept = kept.map(|(key, module)| (key.clone(), module.clone())).collect();
        let declared = before.declared.lock().unwrap_or_else(PoisonError::into_inner);
        let declared = declared.iter().filter(|((name, ..), _)| unchanged.contains(name.as_str()));
        let declared = declared.map(|(key, values)| (key.clone(), values.clone())).collect();
        Self { made: Mutex::new(kept), declared: Mutex::new(declared), ..new }
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
    /// As of [`compile`].
    pub fn module(&self, template: &str, values: AxisValues) -> Made {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (template.to_owned(), values);
        if let Some(known) = made.get(&key) {
            return known.clone();
        }
        let module = compile(&self.templates, template, &key.1, &self.profile).map(Arc::new);
        made.insert(key, module.clone());
        module
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
