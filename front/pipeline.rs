//! [`Pipeline`]: a pipeline as it was loaded, to be planned for sizes, parameters and features.

use std::fmt;
use std::sync::Arc;

use umbragraph_session::{Choice, Loaded};

use crate::Error;
use crate::Plan;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::front::Options;
use crate::front::options::Given;
use crate::low_level::compose::Composed;
use crate::low_level::document::{self, Document};
use crate::low_level::pipeline::{Override, Overrides, ParameterFile, of_preset};
use crate::low_level::shader::TargetProfile;
use crate::low_level::source::{Sources, Span};

/// A loaded pipeline, to be planned for sizes, parameters and features. Planning again parses nothing; if only sizes
/// differ from an earlier plan, the rest of that plan is reused. Clones share the loaded files and compare equal.
#[derive(Clone)]
pub struct Pipeline {
    loaded: Loaded,
    composed: Arc<Composed>,
    profile: TargetProfile,
    findings: Arc<Diagnostics>,
}

impl Pipeline {
    /// Creates a pipeline from loaded files; `None` if they form no valid document.
    pub(super) fn new(loaded: Loaded, profile: TargetProfile, findings: Diagnostics) -> Option<Self> {
        let composed = loaded.composed()?.clone();
        Some(Self { loaded, composed, profile, findings: Arc::new(findings) })
    }

    /// Plans a frame. Checks everything that can be known without a device: values, shaders, formats, and the layout of
    /// the host's meshes.
    ///
    /// # Errors
    /// All diagnostics, if at least one of them is an error.
    pub fn plan(&self, options: &Options) -> Result<Arc<Plan>, Error> {
        let planned = self.plan_over(options, &[]);
        planned.map(|(plan, _)| plan).map_err(|findings| Error::new(findings, self.sources()))
    }

    /// Plans a frame with the values of parameter files, which the options override. Returns the plan with the warnings
    /// and notes of loading, of the parameter files and of planning.
    pub(super) fn plan_over(
        &self,
        options: &Options,
        files: &[ParameterFile],
    ) -> Result<(Arc<Plan>, Diagnostics), Diagnostics> {
        let mut findings = Diagnostics::clone(&self.findings);
        let overrides = self.overrides(options, files, &mut findings);
        let choice = Choice::new(self.profile.clone(), options.plan.clone());
        let choice = choice.overrides(overrides).exposed(options.exposed.clone());
        let planned = self.loaded.plan(&choice);
        findings.extend(planned.diagnostics);
        findings.sort();
        let findings: Diagnostics = findings.into_iter().map(|one| in_code(one, options)).collect();
        match planned.report.plan {
            Some(plan) if !findings.has_errors() => Ok((plan, findings)),
            _ => Err(findings),
        }
    }

    /// Returns `true` if the pipeline was created from `loaded`, not from another load of the same files.
    #[cfg(feature = "watch")]
    pub(super) fn is_of(&self, loaded: &Loaded) -> bool {
        self.loaded == *loaded
    }

    /// The warnings and notes that loading the pipeline reported.
    pub fn findings(&self) -> &Diagnostics {
        &self.findings
    }

    /// The pipeline's document, composed of its file and the files that it extends, includes and uses.
    pub fn document(&self) -> &Document {
        &self.composed.document
    }

    /// The source texts of all documents and templates of the pipeline.
    pub fn sources(&self) -> &Sources {
        self.loaded.sources()
    }
}

impl PartialEq for Pipeline {
    /// Returns `true` if both pipelines come from the same load.
    fn eq(&self, other: &Self) -> bool {
        self.loaded == other.loaded
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.document().root.get("name").and_then(document::Value::text);
        f.debug_tuple("Pipeline").field(&name.unwrap_or_default()).finish()
    }
}

impl Pipeline {
    /// Returns the values of parameters and features from the preset, the parameter files and the options. Later
    /// sources in this order take priority.
    fn overrides(&self, options: &Options, files: &[ParameterFile], findings: &mut Diagnostics) -> Overrides {
        let mut numbers = 0..;
        let mut place = || Span::of_host(numbers.next().unwrap_or_default());
        let preset = options.preset.as_ref();
        let preset = preset.map(|preset| (preset.name.clone(), place()));
        let preset = preset.or_else(|| files.iter().rev().find_map(|file| file.preset.clone()));
        let preset = preset.map(|(name, place)| of_preset(self.document(), &name, place, findings));
        let below = preset.unwrap_or_default();
        let below = files.iter().fold(below, |below, file| below.under(file.overrides.clone()));
        let mut settings = |all: &[Given]| {
            let setting = |Given { name, value, .. }: &Given| {
                let place = place();
                let value = document::Value::from_json(value.clone(), place);
                Override { name: name.clone(), value, place }
            };
            all.iter().map(setting).collect()
        };
        let own =
            Overrides { parameters: settings(&options.parameters), features: settings(&options.features) };
        below.under(own)
    }
}

/// Moves a diagnostic about an option to the place in the host's code that sets the option.
fn in_code(mut diagnostic: Diagnostic, options: &Options) -> Diagnostic {
    let given = |span: Span| options.given().nth(span.host_number()? as usize);
    if let Some(Given { at, .. }) = diagnostic.span().and_then(given) {
        let (path, locator) = (at.file().to_owned(), format!("line {}", at.line()));
        diagnostic.place = Place::File { path, locator };
        diagnostic.fix = None;
    }
    diagnostic
}
