//! All texts of a template, with one rendering per path through it.
//!
//! The axes that a template reads are not known in advance: they depend on the values of others, on includes, on
//! macros. So the rendering itself finds them. It starts with no axis decided; at the first read of an axis the
//! exploration takes the first value that the constraints allow, and queues the others. A finished rendering is one
//! path, with the axes that decided it. All configurations that agree on these axes take the same path, so they are
//! counted without enumeration. A template with 30 axes that no path reads costs no more than one without them.
//!
//! A read without effect gives paths with the same text; the hash of the text identifies them, and each text is
//! validated once. Texts are passed on as they are found and not kept; rendering the path again reproduces them.
//!
//! Limits: 65,536 paths, 32,768 distinct texts, 512 MiB of text; eight times as much where texts are joined from parts.
//! An axis with more than 16,384 values that the text reads is explored at its first, default and last value only. Each
//! limit is an error, since an untried value may fail; the exploration lists the axes that are incomplete.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet, VecDeque};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use minijinja::value::{Object, Value};

use super::choices::Choices;
use crate::axes::AxisKind;
use crate::axes::Domain;
use crate::axes::Space;
use crate::rendering::context::to_template_value;
use crate::rendering::parts::{Decide, Parts};
use crate::rendering::render;
use crate::written::text_map::{Origin, Segment, Source};
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Diagnostic, Place};
use umbragraph_text::source::FileId;

use crate::codes;
use crate::jinja::guard;
use crate::rendering::templates::TemplateSet;

/// The maximum number of paths through one template. A path is one choice of values for the axes that a rendering
/// reads.
const MAX_PATHS: usize = 1 << 16;
/// The number of paths above which a template is divided into parts. Division costs as much as some dozens of
/// renderings.
const MANY_PATHS: usize = 64;
/// The maximum number of distinct WGSL modules of one template.
const MAX_TEXTS: usize = 1 << 15;
/// The maximum total size of a template's distinct modules in bytes.
const MAX_BYTES: usize = 512 << 20;
/// The factor by which the limits on paths, modules and bytes are higher if modules are joined from rendered parts,
/// which is much faster.
const JOINED: usize = 8;
/// The maximum number of values of an axis that are all explored. Of a larger axis, only the first, default and last
/// values are.
const MAX_VALUES: u64 = 1 << 14;

/// One path through a template's branches: the result of one rendering.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    /// The values of the axes that were read on the path.
    pub(crate) decided: Choices,
    /// The index of the generated module; `None` if rendering failed.
    pub(crate) text: Option<usize>,
}

/// A distinct WGSL module generated from a template.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    pub(crate) hash: [u8; 32],
    pub(crate) bytes: usize,
    /// The index of the first path that generates the module.
    pub(crate) leaf: usize,
    /// The indices of all paths that generate the module.
    pub(crate) leaves: Vec<usize>,
    /// The ids of the module's declarations; `None` if the module can only be validated as a whole.
    pub(crate) declarations: Option<Arc<[u32]>>,
}

/// All explored paths and distinct modules of one template.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exploration {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) texts: Vec<Text>,
    /// The failed renderings: index of the path and diagnostic.
    pub(crate) failures: Vec<(usize, Diagnostic)>,
    /// Diagnostics that concern the whole template.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Whether all paths and values were explored.
    pub(crate) complete: bool,
    /// The axes that are read, but whose values were not all explored.
    pub(crate) partial: BTreeSet<String>,
    /// The axes that at least one path reads.
    pub(crate) read: BTreeSet<String>,
    /// The total size of the distinct modules in bytes.
    bytes: usize,
    /// Whether modules are joined from rendered parts.
    pub(crate) is_joined: bool,
    /// The literal template text that paths write: file and byte offset of each piece. Empty if text is not tracked.
    pub(crate) literals: HashSet<(FileId, u32)>,
}

impl Exploration {
    /// The indices of the paths that generate a module.
    pub(crate) fn leaves_of(&self, text: usize) -> &[usize] {
        self.texts.get(text).map(|text| text.leaves.as_slice()).unwrap_or_default()
    }

    /// Renders the module with index `text` again, with its map to the templates; `None` on an error.
    pub(crate) fn source(&self, set: &TemplateSet, template: &str, text: usize) -> Option<Source> {
        let leaf = self.leaves.get(self.texts.get(text)?.leaf)?;
        render::render_fixed(set, template, &leaf.decided.values())
    }

    fn is_full(&self) -> bool {
        let times = if self.is_joined { JOINED } else { 1 };
        let [paths, texts, bytes] = [MAX_PATHS, MAX_TEXTS, MAX_BYTES].map(|limit| limit * times);
        self.leaves.len() >= paths || self.texts.len() >= texts || self.bytes >= bytes
    }
}

/// A branch of the exploration to continue later: the axis values decided before, the axis, and the index of its next
/// value.
struct Pending {
    decided: Choices,
    axis: String,
    next: u64,
}

/// The state of exploring the paths through one template.
pub(crate) struct Explorer<'a> {
    set: &'a TemplateSet,
    template: &'a str,
    space: Arc<Space>,
    /// Whether the literal template text that paths write is recorded.
    track: bool,
    /// The template divided into parts that are rendered separately, created once there are many paths. `None` if
    /// modules are always rendered as a whole.
    parts: Option<&'a OnceLock<Option<Parts>>>,
    unknown: BTreeSet<String>,
    /// Whether paths are visited by number of decisions that differ from the first path, instead of depth first.
    nearest_first: bool,
    by_hash: HashMap<[u8; 32], usize>,
    pending: VecDeque<Pending>,
    next: Option<Choices>,
    pub(crate) exploration: Exploration,
}

impl<'a> Explorer<'a> {
    pub(crate) fn new(set: &'a TemplateSet, template: &'a str, space: &Arc<Space>, track: bool) -> Self {
        Self {
            set,
            template,
            space: space.clone(),
            track,
            parts: None,
            unknown: BTreeSet::new(),
            nearest_first: false,
            by_hash: HashMap::new(),
            pending: VecDeque::new(),
            next: Some(Choices::default()),
            exploration: Exploration { complete: true, ..Exploration::default() },
        }
    }

    /// Makes the explorer join modules from rendered parts, unless it tracks literal text.
    pub(crate) fn of_parts(self, parts: Option<&'a OnceLock<Option<Parts>>>) -> Self {
        Self { parts: parts.filter(|_| !self.track), ..self }
    }

    /// Makes the explorer visit paths near the first path first, for a search that usually ends early.
    pub(crate) fn nearest_first(self) -> Self {
        Self { nearest_first: true, ..self }
    }

    /// Returns the next distinct module, which becomes the last of `exploration.texts`; `None` at the end or at a
    /// limit.
    pub(crate) fn next_text(&mut self) -> Option<String> {
        while let Some(start) = self.next.take() {
            if self.exploration.is_full() {
                self.exploration.complete = false;
                return None;
            }
            let found = self.take_path(start);
            self.next = self.take_pending();
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// Visits all paths and discards their WGSL. Returns `false` if there are more than `max` paths or a limit is
    /// exceeded.
    pub(crate) fn take_all(&mut self, max: usize) -> bool {
        while let Some(start) = self.next.take() {
            if self.exploration.leaves.len() >= max || self.exploration.is_full() {
                return false;
            }
            self.take_path(start);
            self.next = self.take_pending();
        }
        true
    }

    /// Renders the path that starts with these axis values. Returns the decisions on the path and the WGSL.
    fn text(&mut self, start: &Choices) -> (Arc<Fork>, Result<String, Box<Diagnostic>>) {
        let fork = || {
            let state = State { decided: start.values(), ..State::default() };
            Arc::new(Fork { space: self.space.clone(), state: Mutex::new(state) })
        };
        let is_worth_it = |parts: &&OnceLock<Option<Parts>>| {
            parts.get().is_some() || self.exploration.leaves.len() >= MANY_PATHS
        };
        let parts = self.parts.filter(is_worth_it);
        let parts = parts.and_then(|parts| parts.get_or_init(|| Parts::of(self.set, self.template)).as_ref());
        if let Some(parts) = parts {
            let fork = fork();
            let decide: Arc<dyn Decide> = fork.clone();
            if let Some(text) = parts.render(self.set, &decide) {
                self.exploration.is_joined = true;
                return (fork, Ok(text));
            }
        }
        let fork = fork();
        let source = render::render_with(self.set, self.template, Value::from_dyn_object(fork.clone()));
        if let Ok(source) = &source
            && self.track
        {
            let literal = |segment: &Segment| match segment.origin {
                Some(Origin::Literal(file, offset)) => Some((file, offset)),
                _ => None,
            };
            self.exploration.literals.extend(source.map.segments.iter().filter_map(literal));
        }
        (fork, source.map(|source| source.wgsl))
    }

    /// Renders the path that starts with these axis values. Returns the WGSL if it is new.
    fn take_path(&mut self, start: Choices) -> Option<String> {
        let (fork, result) = self.text(&start);
        let state = std::mem::take(&mut *fork.state.lock().unwrap_or_else(PoisonError::into_inner));
        self.unknown.extend(state.unknown);
        let exploration = &mut self.exploration;
        let leaf = exploration.leaves.len();
        let mut new = None;
        let text = match result {
            Ok(wgsl) => {
                let hash = *blake3::hash(wgsl.as_bytes()).as_bytes();
                let known = *self.by_hash.entry(hash).or_insert(exploration.texts.len());
                if known == exploration.texts.len() {
                    let bytes = wgsl.len();
                    exploration.bytes += bytes;
                    exploration.texts.push(Text {
                        hash,
                        bytes,
                        leaf,
                        leaves: Vec::new(),
                        declarations: None,
                    });
                    new = Some(wgsl);
                }
                if let Some(text) = exploration.texts.get_mut(known) {
                    text.leaves.push(leaf);
                }
                Some(known)
            }
            Err(diagnostic) => {
                exploration.failures.push((leaf, *diagnostic));
                None
            }
        };
        let mut decided = start;
        for (axis, taken) in state.forks {
            let value = state.decided.get(&axis).cloned();
            self.pending.push_back(Pending { decided: decided.clone(), axis: axis.clone(), next: taken + 1 });
            if !exploration.read.contains(&axis) {
                exploration.read.insert(axis.clone());
            }
            if let Some(value) = value {
                decided = decided.and(axis, value);
            }
        }
        exploration.leaves.push(Leaf { decided, text });
        new
    }

    /// Returns the axis values at which the next path starts; `None` if all paths are explored.
    fn take_pending(&mut self) -> Option<Choices> {
        let space = &self.space;
        loop {
            let next = if self.nearest_first { self.pending.pop_front() } else { self.pending.pop_back() };
            let mut branch = next?;
            let mut values = branch.decided.values();
            let found = space.variable(&branch.axis).and_then(|domain| {
                let domain = narrowed(space, &branch.axis, domain);
                first_possible(space, &domain, &branch.axis, &mut values, branch.next)
            });
            if let Some((taken, value)) = found.zip(values.remove(&branch.axis)) {
                let start = branch.decided.and(branch.axis.clone(), value);
                branch.next = taken + 1;
                if self.nearest_first {
                    self.pending.push_front(branch);
                } else {
                    self.pending.push_back(branch);
                }
                return Some(start);
            }
        }
    }

    /// Returns the exploration with diagnostics for undeclared names and exceeded limits.
    pub(crate) fn finish(self) -> Exploration {
        let Self { set, template, space, mut exploration, unknown, .. } = self;
        let undeclared = render::undeclared_names(set, template, &unknown);
        if !undeclared.is_empty() {
            // What the undefined value breaks further on is no diagnostic of its own.
            exploration.failures.retain(|(_, diagnostic)| {
                diagnostic.code != codes::UNDECLARED_NAME
                    && !diagnostic.message.contains("undefined")
                    && !render::calls_one_of(&undeclared, diagnostic)
            });
            exploration.diagnostics.extend(undeclared);
        }
        let axes = set.axes(template);
        for name in &exploration.read {
            let Some(axis) = axes.and_then(|axes| axes.get(name)) else { continue };
            let count = space.variable(name).map_or(0, Domain::count);
            if count > MAX_VALUES {
                exploration.complete = false;
                exploration.partial.insert(name.clone());
                let message = format!(
                    "the text of \"{template}\" depends on \"{name}\", and of its {count} values only the first, the default and the last are proven"
                );
                let help = match axis.kind {
                    AxisKind::Integer { .. } => {
                        "narrow its range, and that of a parameter that it follows; write \"prove\": \"ends\" if it is only a \
                         size, or \"as\": \"override\" if the WGSL can read it; --set proves one value"
                    }
                    _ => "declare fewer values; --set proves one of them",
                };
                let limit = format!("up to {MAX_VALUES} values of an axis are all proven");
                exploration.diagnostics.push(
                    Diagnostic::error(codes::PATHS_LIMIT, axis.span, message)
                        .related(Place::Nowhere, limit)
                        .help(help),
                );
            }
        }
        if exploration.is_full() && !exploration.complete {
            exploration.partial = exploration.read.clone();
            let (paths, texts) = (exploration.leaves.len(), exploration.texts.len());
            let message = format!(
                "\"{template}\" has more than {paths} paths with {texts} texts; the others are not proven"
            );
            if let Some(file) = set.file(template) {
                let place = umbragraph_text::source::Span::new(file, 0..0);
                exploration.diagnostics.push(Diagnostic::error(codes::PATHS_LIMIT, place, message).help(
                    "declare constraints between its axes, or make those that the WGSL can read overrides (\"as\": \"override\")",
                ));
            }
        }
        exploration
    }
}

/// Returns the index of the first value, from index `from`, that the constraints allow; `None` if there is none. Sets
/// the axis to this value in `decided`.
fn first_possible(
    space: &Space,
    domain: &Domain,
    axis: &str,
    decided: &mut AxisValues,
    from: u64,
) -> Option<u64> {
    for index in from..domain.count() {
        decided.insert(axis.to_owned(), domain.value(index)?);
        if space.possible(decided) {
            return Some(index);
        }
    }
    decided.remove(axis);
    None
}

/// Returns the values of an axis to explore: all, or only the first, default and last one if there are more than
/// [`MAX_VALUES`].
fn narrowed<'d>(space: &Space, axis: &str, domain: &'d Domain) -> Cow<'d, Domain> {
    if domain.count() <= MAX_VALUES {
        return Cow::Borrowed(domain);
    }
    let ends = [domain.value(0), space.default_of(axis).cloned(), domain.value(domain.count() - 1)];
    let chosen: BTreeSet<_> = ends.into_iter().flatten().collect();
    Cow::Owned(Domain::Values(chosen.into_iter().collect()))
}

/// The template context of one rendering: chooses a value for each axis when it is first read.
#[derive(Debug)]
struct Fork {
    space: Arc<Space>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    decided: AxisValues,
    /// The axes that were first read in this rendering, in order of reading, with the index of the chosen value.
    forks: Vec<(String, u64)>,
    unknown: BTreeSet<String>,
}

impl Object for Fork {
    fn get_value(self: &Arc<Self>, key: &Value) -> Option<Value> {
        self.get_value_by_str(key.as_str()?)
    }

    fn get_value_by_str(self: &Arc<Self>, key: &str) -> Option<Value> {
        self.decide(key).as_ref().map(to_template_value)
    }
}

impl Decide for Fork {
    fn decide(&self, key: &str) -> Option<AxisValue> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = state.decided.get(key) {
            return Some(value.clone());
        }
        if key == guard::FITS {
            return None;
        }
        let Some(domain) = self.space.variable(key) else {
            if !state.unknown.contains(key) {
                state.unknown.insert(key.to_owned());
            }
            return None;
        };
        let domain = narrowed(&self.space, key, domain);
        let taken = first_possible(&self.space, &domain, key, &mut state.decided, 0)?;
        state.forks.push((key.to_owned(), taken));
        state.decided.get(key).cloned()
    }
}
