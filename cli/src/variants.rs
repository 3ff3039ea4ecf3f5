//! The outcome of proving variants: for people, as JSON, as annotations of a pull request, and as files.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use serde::Serialize;
use umbragraph::diagnostic::{Diagnostic, counted};
use umbragraph::low_level::shader::TemplateSet;
use umbragraph::low_level::shader::permutations::{Count, Permutations, TemplateReport};

use umbragraph::low_level::source::Span;

use crate::lock::{Lock, LockFile, PassPlaces, Pipeline, Reaching, worst};
use crate::measured::Measured;
use crate::permutations::Shard;
use crate::replace::{replace, unwritable};

/// The result of a `permutations` run.
#[derive(Default)]
pub(crate) struct Outcome {
    /// The hash of everything that determines the result, except the shard: files, options and version.
    pub(crate) run: String,
    /// The validated part of the work; `None` for all of it.
    pub(crate) shard: Option<Shard>,
    /// Set if options made the validated set differ from the reachable set of variants.
    pub(crate) is_partial: bool,
    pub(crate) reached: Vec<ReachedConfigurations>,
    pub(crate) permutations: Permutations,
    /// Measurements of an offline compiler.
    pub(crate) measured: Option<Measured>,
}

/// The reachable configurations of one pipeline.
#[derive(Serialize)]
pub(crate) struct ReachedConfigurations {
    pub(crate) pipeline: String,
    pub(crate) configurations: Count,
    /// The number of loaded configurations, which together contain every pass in all its states.
    pub(crate) loaded: usize,
    /// The number of loaded configurations with incompatible parameter values.
    pub(crate) rejected: usize,
    /// The indices of the validation requests for these configurations.
    #[serde(skip)]
    pub(crate) requests: Range<usize>,
    /// The passes that each validation request belongs to.
    #[serde(skip)]
    pub(crate) reaching: Vec<Reaching>,
    /// The source place of each pass.
    #[serde(skip)]
    pub(crate) places: BTreeMap<String, Span>,
}

/// The JSON output. `templates` has one entry for each pass and product of axis values.
#[derive(Serialize)]
struct Document<'a> {
    /// The hash of everything that determines the result, except the shard: files, options and version.
    run: &'a str,
    diagnostics: Vec<serde_json::Value>,
    /// The part of the work in this report; `None` for all of it.
    shard: Option<Shard>,
    /// Set if options made the validated set differ from the reachable set of variants.
    partial: bool,
    pipelines: Vec<ReachedPipeline<'a>>,
    templates: &'a [TemplateReport],
    combinations: Count,
    texts: usize,
    /// The number of shader sources that naga validated directly; the verdicts of the others follow from them.
    proven: usize,
    /// The number of distinct declarations, each counted together with the declarations that it refers to.
    declarations: usize,
    /// Measurements of an offline compiler, by the hashes of variants.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<&'a Measured>,
}

/// A pipeline in the JSON output.
#[derive(Serialize)]
struct ReachedPipeline<'a> {
    #[serde(flatten)]
    counts: &'a ReachedConfigurations,
    /// The shader sources of passes and profiles, as in a lock file.
    reached: Pipeline,
}

/// The combined reports of one pass.
struct Summary<'a> {
    template: &'a str,
    covered: Count,
    texts: BTreeMap<&'a str, usize>,
    dead: BTreeSet<&'a str>,
    profiles: &'a [String],
    cost: u64,
}

impl Outcome {
    fn combinations(&self) -> Count {
        self.permutations.templates.iter().fold(Count::ZERO, |sum, report| sum.plus(report.covered))
    }

    /// Describes the coverage for people, with a line for each pipeline. With `in_full`, adds a line for each pass, and
    /// the total that [`proven_now`] completes.
    pub(crate) fn human(&self, in_full: bool) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        for reached in &self.reached {
            let ReachedConfigurations { pipeline, configurations, loaded, rejected, requests, .. } = reached;
            let _ = write!(text, "{pipeline}: {}", plural(*configurations, "configuration"));
            if configurations.number != *loaded as u128 {
                let states = if configurations.exact { "every pass in all its states in " } else { "" };
                let verb = if configurations.exact { "" } else { " loaded" };
                let _ = write!(text, ", {states}{loaded} of them{verb}");
            }
            if *rejected > 0 {
                let _ = write!(text, ", {rejected} with values that do not go together");
            }
            self.sum(&mut text, requests);
            text.push('\n');
        }
        let mut passes: Vec<((&str, &str), Summary<'_>)> = Vec::new();
        for report in &self.permutations.templates {
            let own = (report.name.as_str(), report.group.as_str());
            let at =
                passes.iter().position(|(name, known)| *name == own && known.template == report.template);
            let at = at.unwrap_or_else(|| {
                let summary = Summary {
                    template: &report.template,
                    covered: Count::ZERO,
                    texts: BTreeMap::new(),
                    dead: report.dead_axes.iter().map(String::as_str).collect(),
                    profiles: &report.profiles,
                    cost: 0,
                };
                passes.push((own, summary));
                passes.len() - 1
            });
            let Some((_, summary)) = passes.get_mut(at) else { continue };
            summary.covered = summary.covered.plus(report.covered);
            summary
                .texts
                .extend(report.variants.iter().map(|variant| (variant.hash.as_str(), variant.bytes)));
            let costs = report.variants.iter().filter_map(|variant| Some(variant.worst()?.1.total));
            summary.cost = costs.fold(summary.cost, u64::max);
            summary.dead.retain(|name| report.dead_axes.iter().any(|dead| dead == name));
        }
        for ((name, group), summary) in passes.iter().filter(|_| in_full) {
            let bytes: usize = summary.texts.values().sum();
            let max = summary.texts.values().max().copied().unwrap_or_default();
            let of =
                if *name == summary.template { String::new() } else { format!(" ({})", summary.template) };
            let on = if group.is_empty() { String::new() } else { format!(" on {group}") };
            let _ = write!(
                text,
                "{name}{on}{of}: {}, {}, {bytes} bytes, largest {max}, cost up to {}, for {}",
                plural(summary.covered, "combination"),
                counted(summary.texts.len(), "distinct text"),
                summary.cost,
                summary.profiles.join(", "),
            );
            if !summary.dead.is_empty() {
                let dead: Vec<&str> = summary.dead.iter().copied().collect();
                let _ = write!(text, "; without effect: {}", dead.join(", "));
            }
            text.push('\n');
        }
        if in_full {
            let texts = counted(self.permutations.texts, "distinct text");
            let _ = write!(text, "{} covered by {texts}", plural(self.combinations(), "combination"));
        }
        text
    }

    /// Returns the reachable shaders for the lock file, and the source places of passes.
    pub(crate) fn lock(&self, file: &LockFile<'_>) -> (Lock, PassPlaces) {
        let (mut lock, mut places) = (Lock::default(), PassPlaces::new());
        for reached in &self.reached {
            let name = file.name_of(Path::new(&reached.pipeline));
            let pipeline = Pipeline::new(&reached.reaching, &self.permutations.templates);
            places.extend(reached.places.iter().map(|(pass, at)| ((name.clone(), pass.clone()), *at)));
            lock.pipelines.insert(name, pipeline);
        }
        (lock, places)
    }

    /// Returns the most expensive template lines in the most expensive variant of a pass, the most expensive first.
    pub(crate) fn expensive(
        &self,
        templates: &TemplateSet,
        file: &LockFile<'_>,
        pipeline: &str,
        pass: &str,
    ) -> Vec<(Span, u64)> {
        const MAX: usize = 3;
        let of_pass = |reached: &ReachedConfigurations| {
            let all = reached.reaching.iter().filter(|one| one.passes.iter().any(|own| own == pass));
            all.map(|one| one.request).collect::<Vec<usize>>()
        };
        let reached = self.reached.iter().find(|one| file.name_of(Path::new(&one.pipeline)) == pipeline);
        let requests = reached.map(of_pass).unwrap_or_default();
        let reports = self.permutations.templates.iter().filter(|one| requests.contains(&one.request));
        let reports: Vec<&TemplateReport> = reports.collect();
        let Some(variant) = worst(&reports) else { return Vec::new() };
        let of = reports.iter().find(|report| report.variants.iter().any(|one| std::ptr::eq(one, variant)));
        of.map(|report| report.expensive(templates, variant, MAX)).unwrap_or_default()
    }

    /// Appends a summary of all passes of a pipeline, whose validation requests have the indices `requests`.
    fn sum(&self, text: &mut String, requests: &Range<usize>) {
        let is_of = |report: &&TemplateReport| requests.contains(&report.request);
        let reports = || self.permutations.templates.iter().filter(is_of);
        // A program that a profile draws otherwise is one all the same.
        let passes: BTreeSet<&str> = reports().map(|report| report.name.as_str()).collect();
        let hashes = reports().flat_map(|report| report.variants.iter().map(|variant| variant.hash.as_str()));
        let texts: BTreeSet<&str> = hashes.collect();
        let combinations = reports().fold(Count::ZERO, |sum, report| sum.plus(report.covered));
        let mut profiles: Vec<&str> = Vec::new();
        for profile in reports().flat_map(|report| &report.profiles) {
            if !profiles.contains(&profile.as_str()) {
                profiles.push(profile);
            }
        }
        let profiles = profiles.join(", ");
        if !passes.is_empty() {
            let programs = counted(passes.len(), "program");
            let texts = counted(texts.len(), "distinct text");
            let _ = write!(
                text,
                "; {programs}, {}, {texts}, for {profiles}",
                plural(combinations, "combination")
            );
        }
    }

    /// Returns the complete report as JSON.
    pub(crate) fn json(&self, diagnostics: Vec<serde_json::Value>) -> String {
        let pipeline = |counts| ReachedPipeline {
            counts,
            reached: Pipeline::new(&counts.reaching, &self.permutations.templates),
        };
        let document = Document {
            run: &self.run,
            diagnostics,
            shard: self.shard,
            partial: self.is_partial,
            pipelines: self.reached.iter().map(pipeline).collect(),
            templates: &self.permutations.templates,
            combinations: self.combinations(),
            texts: self.permutations.texts,
            proven: self.permutations.proven,
            declarations: self.permutations.declarations,
            measured: self.measured.as_ref(),
        };
        serde_json::to_string_pretty(&document).unwrap_or_default()
    }
}

/// Returns the end of the summary's last line: the number of shader sources that this run had to validate.
pub(crate) fn proven_now(proven: usize, texts: usize) -> String {
    match proven {
        0 => "; nothing had to be proven again\n".to_owned(),
        all if all == texts => "; all of them proven now\n".to_owned(),
        some => format!("; {some} of them proven now, from which the others follow\n"),
    }
}

fn plural(count: Count, what: &str) -> String {
    format!("{count} {what}{}", if count.number == 1 { "" } else { "s" })
}

/// Writes every distinct shader source to a folder.
pub(crate) fn write(
    folder: &Path,
    templates: &TemplateSet,
    reports: &[TemplateReport],
) -> Result<(), Diagnostic> {
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    let mut written = BTreeSet::new();
    for report in reports {
        for variant in &report.variants {
            let name = variant.file_name(&report.name);
            if !written.insert(name.clone()) {
                continue;
            }
            let Some(text) = report.text(templates, variant) else { continue };
            let path = folder.join(&name);
            replace(&path, text)?;
        }
    }
    Ok(())
}
