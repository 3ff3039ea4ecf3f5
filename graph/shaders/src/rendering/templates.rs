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

/// The endings of the names of template files.
pub const TEMPLATE_ENDS: [&str; 2] = [".jinja", ".axes.json"];

/// Templates by name, with their axes.
#[derive(Debug)]
pub struct TemplateSet {
    pub(crate) environment: Environment<'static>,
    pub(crate) templates: BTreeMap<String, Arc<Template>>,
    declarations: BTreeMap<String, axes::Declaration>,
    /// The texts of the declarations.
    declared: BTreeMap<String, Arc<str>>,
    /// The axes of each template with the inherited ones, resolved for all templates on first use.
    resolved: OnceLock<BTreeMap<String, Resolved>>,
    /// The addresses of the texts in memory, computed on first use.
    placement: OnceLock<Placement>,
    /// The templates with markers, made on first use.
    marked: OnceLock<MarkedTemplates>,
    longest_literal: usize,
    /// The library's templates: their bindings are renumbered when they collide with an author's.
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
    /// No templates yet.
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

    /// Adds a template, or the axes of one where the name ends in `.axes.json`. Diagnostics name the file as `name`.
    pub fn add(&mut self, sources: &mut Sources, name: &str, text: &str, diagnostics: &mut Diagnostics) {
        let file = sources.add(name, text);
        self.add_file(sources, file, name, diagnostics);
    }

    /// Adds a registered text of a library: its bindings give way to those of other templates that take the same
    /// numbers.
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

    /// Whether there is a library, and templates that are not of it.
    pub(crate) fn has_own_templates(&self) -> bool {
        !self.library.is_empty() && self.templates.values().any(|one| !self.is_of_library(one.file))
    }

    /// Adds a registered text under a name of its own: a file that diagnostics show by its path.
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

    /// Notes that a template, or the axes of one, cannot be read: whatever uses it gets this diagnostic, and not that
    /// there is no such template.
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

    /// The names of the templates in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.templates.keys().map(String::as_str)
    }

    /// The text of a template as a registered file.
    pub fn file(&self, template: &str) -> Option<FileId> {
        self.templates.get(template).map(|template| template.file)
    }

    /// The declaration beside a template as a registered file; `None` for a template without one.
    pub fn axes_file(&self, template: &str) -> Option<FileId> {
        self.declarations.get(stem(template)).map(|declared| declared.file)
    }

    /// The axes of a template, its own and the inherited ones; none for a template without a side file. `None` if there
    /// is no such template.
    pub fn axes(&self, template: &str) -> Option<&Axes> {
        self.resolved().get(template).map(|found| &found.axes)
    }

    /// The text of the declaration beside a template, and its file.
    pub(super) fn declared_text(&self, template: &str) -> Option<(FileId, Option<&Arc<str>>)> {
        Some((self.axes_file(template)?, self.declared.get(stem(template))))
    }

    /// The templates whose axes one inherits, as far as there are such.
    pub(super) fn inherited(&self, template: &str) -> impl Iterator<Item = &str> {
        let inherits = self.declarations.get(stem(template)).map(|declared| &declared.axes.inherits);
        let known =
            |(name, _): &(String, _)| self.templates.get_key_value(name).map(|(name, _)| name.as_str());
        inherits.into_iter().flatten().filter_map(known)
    }

    /// The names of the axes of some templates.
    pub fn axes_of(&self, wanted: impl Fn(&str) -> bool) -> BTreeSet<&str> {
        let wanted = self.names().filter(|name| wanted(name));
        wanted.filter_map(|name| self.axes(name)).flat_map(Axes::names).collect()
    }

    /// Errors in the axes of a template that prevent its rendering: errors that involve other files, and declarations
    /// that do not define their axis.
    pub(crate) fn axes_diagnostics(&self, template: &str) -> Vec<Diagnostic> {
        let found = self.resolved().get(template);
        found
            .into_iter()
            .flat_map(|found| found.diagnostics.iter().chain(&found.axes.lost.diagnostics))
            .cloned()
            .collect()
    }

    /// Whether a template has axes whose declaration does not define them.
    pub fn has_lost_axes(&self, template: &str) -> bool {
        self.axes(template).is_some_and(|axes| !axes.lost.diagnostics.is_empty())
    }

    /// The diagnostic for a name that is no template of this set.
    pub fn unknown(&self, name: &str, place: impl Into<Place>) -> Diagnostic {
        let diagnostic =
            Diagnostic::error(codes::TEMPLATE_UNKNOWN, place, format!("there is no template \"{name}\""));
        let mut diagnostic = self.suggest(diagnostic, name, None);
        let help = diagnostic.help.take().unwrap_or_default();
        diagnostic.help(format!(
            "{help}; for templates of your own, give their folder (--templates FOLDER, Library::templates)"
        ))
    }

    /// Adds the template that was meant by a name to a diagnostic at the name; nothing means the template `itself`.
    fn suggest(&self, diagnostic: Diagnostic, name: &str, itself: Option<&str>) -> Diagnostic {
        let written = diagnostic.span();
        let names = self.names().filter(|name| Some(*name) != itself);
        diagnostic.suggest(name, names, written, |names| match names {
            [] => "there is no other template".to_owned(),
            names => format!("the templates are {}", list_of(names)),
        })
    }

    /// Checks how the texts fit together: side files without a template, inherited templates that do not exist,
    /// declarations that disagree, defaults that break a constraint, comparisons of axes with what they never are.
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
    }

    fn resolved(&self) -> &BTreeMap<String, Resolved> {
        self.resolved.get_or_init(|| {
            let resolve = |name: &String| {
                let mut diagnostics = Vec::new();
                let axes = self.collect(name, &mut BTreeMap::new(), &mut diagnostics);
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

    /// The axes that a template declares and inherits. Every template is worked out once; a template that inherits
    /// itself in a cycle gets what is known so far.
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
        let Some(declaration) = self.declarations.get(stem(name)) else { return Axes::default() };
        let mut own = declaration.axes.clone();
        let mut conflicts = Vec::new();
        for (other, span) in &declaration.axes.inherits {
            if self.templates.contains_key(other) {
                conflicts.extend(own.inherit(&self.collect(other, done, diagnostics)));
            } else {
                let message = format!("there is no template \"{other}\"");
                let diagnostic = Diagnostic::error(codes::AXES_ORPHAN, *span, message);
                diagnostics.push(self.suggest(diagnostic, other, Some(name)));
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

/// The diagnostic for constraints that leave no configuration at all.
fn clash(template: &str, axes: &Axes) -> Option<Diagnostic> {
    let clash = Space::new(axes, &BTreeMap::new()).clash();
    let message = format!("the constraints of \"{template}\" leave no configuration");
    Some(contradiction(&clash, clash.first()?.span, message))
}

/// The diagnostic for a smallest set of constraints that leave no configuration.
pub(crate) fn contradiction(clash: &[Constraint], place: impl Into<Place>, message: String) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::CONSTRAINTS_CONTRADICT, place, message)
        .help("without any one of these constraints there would be a configuration");
    clash.iter().fold(diagnostic, |diagnostic, one| diagnostic.related(one.span, one.to_string()))
}

/// The name of a template without its ending: `lib/noise` for `lib/noise.wgsl.jinja`.
fn stem(name: &str) -> &str {
    name.strip_suffix(".jinja").unwrap_or(name).strip_suffix(".wgsl").unwrap_or(name)
}
