//! The templates that shaders are generated from, and the axes declared beside them.
//!
//! A [`TemplateSet`] is filled from anywhere (embedded, a folder, memory) with named texts: `forward.wgsl.jinja`,
//! `lib/noise.wgsl.jinja`, and their side files `forward.axes.json`. Names are how templates include one another; a
//! name is never looked up anywhere else, so a set is closed and the same everywhere.
//!
//! Diagnostics about a single text (its syntax, its declaration) are made when it is added. Diagnostics about how texts
//! fit together need the whole set: [`TemplateSet::check`] makes them, and compiling a template reports those that
//! concern it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use minijinja::Environment;

use super::fitting;
use super::markers::MarkedTemplates;
use super::placement::Placement;
use crate::axes;
use crate::axes::Space;
use crate::axes::{Axes, Constraint};
use crate::codes;
use crate::jinja::scan::{Scan, scan};
use crate::jinja::template::Template;
use crate::jinja::{comparisons, filters, guard, length, syntax_help, tree};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, Place, list_of};
use umbragraph_text::source::{FileId, Sources, Span};

/// The file-name endings of shader templates and of their axis declarations.
pub const TEMPLATE_ENDS: [&str; 2] = [".jinja", ".axes.json"];

/// A set of WGSL templates by name, with their axes: the options whose values select a variant.
#[derive(Debug)]
pub struct TemplateSet {
    pub(crate) environment: Environment<'static>,
    pub(crate) templates: BTreeMap<String, Arc<Template>>,
    declarations: BTreeMap<String, axes::Declaration>,
    /// The JSON source of the axis declarations, keyed by template name without its ending.
    declared: BTreeMap<String, Arc<str>>,
    /// The axes of each template, including inherited ones; computed on first use.
    resolved: OnceLock<BTreeMap<String, Resolved>>,
    /// The memory addresses of the template sources; computed on first use.
    placement: OnceLock<Placement>,
    /// Copies of the templates with position markers; created on first use.
    marked: OnceLock<MarkedTemplates>,
    longest_literal: usize,
    /// The files of the library's templates. Bindings in them get other binding numbers if they collide with bindings
    /// of other templates.
    pub(super) library: BTreeSet<FileId>,
}

#[derive(Debug, Default)]
struct Resolved {
    axes: Axes,
    diagnostics: Vec<Diagnostic>,
}

impl Default for TemplateSet {
    fn default() -> Self {
        Self::new()
    }
}

impl TemplateSet {
    /// Creates a set without templates.
    pub fn new() -> Self {
        Self {
            environment: filters::environment(),
            templates: BTreeMap::new(),
            declarations: BTreeMap::new(),
            declared: BTreeMap::new(),
            resolved: OnceLock::new(),
            placement: OnceLock::new(),
            marked: OnceLock::new(),
            longest_literal: 0,
            library: BTreeSet::new(),
        }
    }

    /// Adds a template from memory, or a declaration of axes if `name` ends in `.axes.json`. Diagnostics show the file
    /// as `name`. If the name exists already, reports an error and keeps the first.
    pub fn add(&mut self, sources: &mut Sources, name: &str, text: &str, diagnostics: &mut Diagnostics) {
        let file = sources.add(name, text);
        self.add_file(sources, file, name, diagnostics);
    }

    /// Adds a library template from a file in `sources`. Its bindings get other binding numbers if they collide with
    /// bindings of other templates.
    pub fn add_library_file(
        &mut self,
        sources: &Sources,
        file: FileId,
        name: &str,
        diagnostics: &mut Diagnostics,
    ) {
        self.library.insert(file);
        self.add_file(sources, file, name, diagnostics);
    }

    pub(crate) fn is_of_library(&self, file: FileId) -> bool {
        self.library.contains(&file)
    }

    /// Returns `true` if the set contains both library templates and other templates.
    pub(crate) fn has_own_templates(&self) -> bool {
        !self.library.is_empty() && self.templates.values().any(|one| !self.is_of_library(one.file))
    }

    /// Adds a template from a file in `sources`, or a declaration of axes if `name` ends in `.axes.json`. Diagnostics
    /// show the file's path, and templates refer to it as `name`. If the name exists already, reports an error and
    /// keeps the first.
    pub fn add_file(&mut self, sources: &Sources, file: FileId, name: &str, diagnostics: &mut Diagnostics) {
        let Some(text) = sources.get(file).map(|source| source.text().clone()) else { return };
        let twice = || {
            let message = format!("\"{name}\" is given twice");
            Diagnostic::error(codes::TEMPLATE_TWICE, Span::new(file, 0..0), message)
                .help("the first is used; remove this one, or give it another name")
        };
        if let Some(stem) = name.strip_suffix(".axes.json") {
            if self.declarations.contains_key(stem) {
                diagnostics.push(twice());
                return;
            }
            self.declarations.insert(stem.to_owned(), axes::parse(sources, file, diagnostics));
            self.declared.insert(stem.to_owned(), text);
        } else {
            if self.templates.contains_key(name) {
                diagnostics.push(twice());
                return;
            }
            let template = self.prepare(file, name, &text);
            diagnostics.extend(template.broken.clone());
            self.templates.insert(name.to_owned(), template.into());
        }
        self.changed();
    }

    /// Adds a template or a declaration of axes whose file cannot be read. Templates that refer to it report
    /// `diagnostic` instead of a missing template.
    pub fn add_unreadable(
        &mut self,
        sources: &mut Sources,
        name: &str,
        diagnostic: Diagnostic,
        diagnostics: &mut Diagnostics,
    ) {
        diagnostics.push(diagnostic.clone());
        let file = sources.add(name, "");
        if let Some(stem) = name.strip_suffix(".axes.json") {
            let unreadable = axes::Declaration::unreadable(file, [diagnostic]);
            self.declarations.entry(stem.to_owned()).or_insert(unreadable);
        } else if !self.templates.contains_key(name) {
            let (text, scan): (Arc<str>, _) = ("".into(), Scan::default());
            let prepared = tree::prepare(&text);
            let template = Template { file, text, scan, prepared, broken: Some(diagnostic) };
            self.templates.insert(name.to_owned(), template.into());
        }
        self.changed();
    }

    fn changed(&mut self) {
        (self.resolved, self.marked) = (OnceLock::new(), OnceLock::new());
        self.placement = OnceLock::new();
    }

    pub(crate) fn placement(&self) -> &Placement {
        self.placement.get_or_init(|| Placement::new(&self.environment, &self.templates))
    }

    pub(crate) fn marked(&self) -> &MarkedTemplates {
        self.marked.get_or_init(|| MarkedTemplates::new(&self.templates, self.environment.fuel()))
    }

    fn prepare(&mut self, file: FileId, name: &str, text: &Arc<str>) -> Template {
        let scan = scan(text);
        self.longest_literal = scan.literals.iter().map(Range::len).fold(self.longest_literal, usize::max);
        self.environment.set_fuel(Some(guard::fuel(self.longest_literal)));
        if let Some((range, what)) = length::too_long(text, &scan.tags) {
            let message = format!("the template exceeds a limit: {what}");
            let broken = Diagnostic::error(codes::TEMPLATE_LIMIT, Span::new(file, range), message)
                .help("put parts of it into variables, with {% set %}, or a table into a list");
            let prepared = tree::prepare("");
            return Template { file, text: text.clone(), scan, prepared, broken: Some(broken) };
        }
        let prepared = tree::prepare(text);
        let mut template = Template { file, text: text.clone(), scan, prepared, broken: None };
        if let Err(error) =
            self.environment.add_template_owned(name.to_owned(), template.prepared.text.clone())
        {
            template.broken = Some(syntax_help::syntax(&template, &error));
        }
        template
    }

    /// Iterates over the names of the templates in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.templates.keys().map(String::as_str)
    }

    /// The source file of a template; `None` if there is no such template.
    pub fn file(&self, template: &str) -> Option<FileId> {
        self.templates.get(template).map(|template| template.file)
    }

    /// The source file of a template's axis declaration; `None` for a template without one.
    pub fn axes_file(&self, template: &str) -> Option<FileId> {
        self.declarations.get(stem(template)).map(|declared| declared.file)
    }

    /// Returns the axes of a template, including inherited ones. Empty for a template without a declaration of axes;
    /// `None` if there is no such template.
    pub fn axes(&self, template: &str) -> Option<&Axes> {
        self.resolved().get(template).map(|found| &found.axes)
    }

    /// The source file of a template's axis declaration and its JSON. The JSON is `None` if the file is unreadable.
    pub(super) fn declared_text(&self, template: &str) -> Option<(FileId, Option<&Arc<str>>)> {
        Some((self.axes_file(template)?, self.declared.get(stem(template))))
    }

    /// Iterates over the names of the templates from which a template inherits axes directly; names without a template
    /// are left out.
    pub(super) fn inherited(&self, template: &str) -> impl Iterator<Item = &str> {
        let inherits = self.declarations.get(stem(template)).map(|declared| &declared.axes.inherits);
        let known =
            |(name, _): &(String, _)| self.templates.get_key_value(name).map(|(name, _)| name.as_str());
        inherits.into_iter().flatten().filter_map(known)
    }

    /// Returns the names of the axes of all templates whose name satisfies `wanted`.
    pub fn axes_of(&self, wanted: impl Fn(&str) -> bool) -> BTreeSet<&str> {
        let wanted = self.names().filter(|name| wanted(name));
        wanted.filter_map(|name| self.axes(name)).flat_map(Axes::names).collect()
    }

    /// Returns the errors in the axes of a template that prevent its rendering, such as conflicts with inherited axes
    /// and invalid declarations.
    pub(crate) fn axes_diagnostics(&self, template: &str) -> Vec<Diagnostic> {
        let Some(found) = self.resolved().get(template) else { return Vec::new() };
        let lost = found.axes.lost.diagnostics.iter().filter(|one| !found.diagnostics.contains(one));
        found.diagnostics.iter().chain(lost).cloned().collect()
    }

    /// Returns `true` if the declaration of at least one axis of the template is invalid.
    pub fn has_lost_axes(&self, template: &str) -> bool {
        self.axes(template).is_some_and(|axes| !axes.lost.diagnostics.is_empty())
    }

    /// Returns the diagnostic for a name that is no template of this set.
    pub fn unknown(&self, name: &str, place: impl Into<Place>) -> Diagnostic {
        let diagnostic =
            Diagnostic::error(codes::TEMPLATE_UNKNOWN, place, format!("there is no template \"{name}\""));
        let mut diagnostic = self.suggest(diagnostic, name, None);
        let help = diagnostic.help.take().unwrap_or_default();
        diagnostic.help(format!(
            "{help}; for templates of your own, give their folder (--templates FOLDER, Library::templates)"
        ))
    }

    /// Adds a suggestion for a misspelt template name to a diagnostic. The template `itself` is never suggested.
    fn suggest(&self, diagnostic: Diagnostic, name: &str, itself: Option<&str>) -> Diagnostic {
        let written = diagnostic.span();
        let names = self.names().filter(|name| Some(*name) != itself);
        diagnostic.suggest(name, names, written, |names| match names {
            [] => "there is no other template".to_owned(),
            names => format!("the templates are {}", list_of(names)),
        })
    }

    /// Adds diagnostics about the consistency of the set. It reports declarations of axes without a template, missing
    /// inherited templates, and conflicting declarations. It also reports contradictory constraints, defaults that
    /// violate constraints, comparisons of axes with impossible values, and parts that appear nowhere.
    pub fn check(&self, diagnostics: &mut Diagnostics) {
        let templates: BTreeSet<&str> = self.names().map(stem).collect();
        for (name, declared) in &self.declarations {
            if !templates.contains(name.as_str()) {
                let message = format!(
                    "\"{name}.axes.json\" declares axes, but there is no template \"{name}.wgsl.jinja\""
                );
                let start = Span::new(declared.file, 0..0);
                diagnostics.push(Diagnostic::error(codes::AXES_ORPHAN, start, message));
            }
        }
        for (name, resolved) in self.resolved() {
            diagnostics.extend(resolved.diagnostics.iter().cloned());
            let template = self.templates.get(name).filter(|_| self.axes_file(name).is_some());
            diagnostics.extend(
                template.into_iter().flat_map(|template| comparisons::check(template, &resolved.axes)),
            );
        }
        diagnostics.extend(self.templates.values().flat_map(|template| comparisons::lost(template)));
    }

    /// The way out of an axis that a template does not have: the template to inherit the axis from, or a declaration.
    pub fn way_to_axis(&self, template: &str, axis: &str) -> String {
        let declares = |name: &&str| {
            let declared = self.declarations.get(stem(name));
            declared.is_some_and(|declared| declared.axes.get(axis).is_some())
        };
        let declared = format!("declare it in {}.axes.json", stem(template));
        match self.names().find(declares) {
            None => declared,
            Some(one) => format!("it is an axis of {one}: write \"inherits\": [\"{one}\"], or {declared}"),
        }
    }

    fn resolved(&self) -> &BTreeMap<String, Resolved> {
        self.resolved.get_or_init(|| {
            let resolve = |name: &String| {
                let mut diagnostics = Vec::new();
                let axes = self.collect(name, &mut BTreeMap::new(), &mut diagnostics);
                diagnostics.extend(fitting::check(&self.templates, name));
                let clash = clash(name, &axes);
                let defaults = axes.defaults();
                for constraint in axes.violated(&defaults).filter(|_| clash.is_none()) {
                    let message = format!("the default values break a constraint: {constraint}");
                    diagnostics.push(
                        Diagnostic::error(codes::CONSTRAINT_VIOLATED, constraint.span, message)
                            .help("change a default, so that a pipeline that sets nothing is valid"),
                    );
                }
                diagnostics.extend(clash);
                (name.clone(), Resolved { axes, diagnostics })
            };
            self.templates.keys().map(resolve).collect()
        })
    }

    /// Collects the axes that a template declares and inherits. Results are cached in `done`. In a cycle of
    /// inheritance, the axes known so far are used.
    fn collect<'s>(
        &'s self,
        name: &'s str,
        done: &mut BTreeMap<&'s str, Axes>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Axes {
        if let Some(axes) = done.get(name) {
            return axes.clone();
        }
        done.insert(name, Axes::default());
        let Some(declaration) = self.declarations.get(stem(name)) else {
            // Without a declaration, a template has the axes of the one that it extends.
            let base = self
                .templates
                .get_key_value(name)
                .and_then(|(_, one)| one.prepared.structure.extends.as_ref());
            let axes = base.map(|base| self.collect(base, done, diagnostics)).unwrap_or_default();
            done.insert(name, axes.clone());
            return axes;
        };
        let mut own = declaration.axes.clone();
        let mut conflicts = Vec::new();
        for (other, span) in &declaration.axes.inherits {
            if self.templates.contains_key(other) {
                conflicts.extend(own.inherit(&self.collect(other, done, diagnostics)));
            } else {
                let message = format!("there is no template \"{other}\"");
                let diagnostic = Diagnostic::error(codes::AXES_ORPHAN, *span, message);
                let diagnostic = self.suggest(diagnostic, other, Some(name));
                own.lost.diagnostics.push(diagnostic.clone());
                diagnostics.push(diagnostic);
            }
        }
        declaration.resolve(&mut own, diagnostics);
        for (mine, theirs) in conflicts {
            let message = format!("the axis \"{}\" is declared in two ways", mine.name);
            diagnostics.push(
                Diagnostic::error(codes::AXES_CONFLICT, mine.span, message)
                    .related(theirs.span, format!("here with {}", theirs.kind.describe())),
            );
        }
        done.insert(name, own.clone());
        own
    }
}

/// The diagnostic for constraints that exclude every combination of axis values; `None` if a combination remains.
fn clash(template: &str, axes: &Axes) -> Option<Diagnostic> {
    let clash = Space::new(axes, &BTreeMap::new()).clash();
    let message = format!("the constraints of \"{template}\" leave no configuration");
    Some(contradiction(&clash, clash.first()?.span, message))
}

/// The diagnostic for a minimal set of constraints that excludes every combination of axis values.
pub(crate) fn contradiction(clash: &[Constraint], place: impl Into<Place>, message: String) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::CONSTRAINTS_CONTRADICT, place, message)
        .help("without any one of these constraints there would be a configuration");
    clash.iter().fold(diagnostic, |diagnostic, one| diagnostic.related(one.span, one.to_string()))
}

/// The name of a template without its ending: `lib/noise` for `lib/noise.wgsl.jinja`.
fn stem(name: &str) -> &str {
    name.strip_suffix(".jinja").unwrap_or(name).strip_suffix(".wgsl").unwrap_or(name)
}
