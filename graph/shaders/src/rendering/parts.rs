//! Templates in parts, each rendered once for the values that it reads.
//!
//! A template with many axes has many texts, of which most parts are the same: an include depends on a few axes, a
//! branch on one or two more. So a template is taken apart, through its includes, blocks and branches, into literal
//! text and parts that the engine renders one by one. A part remembers, as a tree of what it has read in order, the
//! text that it wrote; a further text of the template is looked up part by part and joined.
//!
//! Variables that tags bind (`set`, `macro`, `import`) are seen by the parts behind them. A part is rendered behind all
//! tags before it that bind a name which it mentions, itself or through what these mention or include; these tags run
//! once more, and what they read the part has read. What a tag that also writes text binds is bound by its text
//! captured.
//!
//! Limits: a template that calls `super` or `self`, that extends another by a name that is computed, or that nests
//! blocks in those that it overrides, is not taken apart. Fuel, and the sizes that rendering is limited to, are added
//! up over the parts; a text above a limit, or with an error, is rendered as a whole, which says what is wrong.

mod divide;

use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};

use minijinja::value::{Object, Value};

use super::context::to_template_value;
use super::templates::TemplateSet;
use crate::jinja::guard;
use crate::written::complexity;
use umbragraph_text::diagnostic::AxisValue;

/// A source of axis values, queried when a template reads an axis. `decide` returns `None` for a name that is no axis.
pub(crate) trait Decide: Debug + Send + Sync {
    fn decide(&self, name: &str) -> Option<AxisValue>;
}

/// A template divided into parts. The output of each part is cached by the axis values that the part reads.
/// Thread-safe.
#[derive(Debug, Default)]
pub(crate) struct Parts {
    steps: Vec<Step>,
    parts: Vec<Part>,
}

/// One step of generating WGSL from a divided template, in source order.
#[derive(Debug)]
enum Step {
    Literal(String),
    /// The index in `Parts::parts` of a part to render.
    Part(usize),
    /// A branch: continues with `then` if the part with index `condition` writes anything, otherwise with `otherwise`.
    Branch {
        condition: usize,
        then: Vec<Step>,
        otherwise: Vec<Step>,
    },
}

#[derive(Debug)]
struct Part {
    template: String,
    source: String,
    known: Mutex<Vec<Node>>,
}

/// A node of a decision tree that maps the axis values that a part reads to the part's output.
#[derive(Debug, Default)]
enum Node {
    /// A node that no rendering has reached yet.
    #[default]
    Open,
    /// A read of a name, with the index of the next node for each value; the value is `None` if the name is no axis.
    Reads(Arc<str>, Vec<(Option<AxisValue>, usize)>),
    Writes(Arc<str>, Cost),
}

/// The resources that a rendering consumes: minijinja's execution steps (`fuel`), bytes that expressions write, and
/// work as counted by `guard`.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    fuel: u64,
    written: usize,
    work: usize,
}

impl Parts {
    /// Divides a template into parts; `None` if the template cannot be divided.
    pub(crate) fn of(set: &TemplateSet, template: &str) -> Option<Self> {
        divide::divide(set, template)
    }

    /// Renders the template part by part with the axis values from `decide`. `None` on an error or an exceeded limit;
    /// the caller then renders the undivided template, which reports the cause.
    pub(crate) fn render(&self, set: &TemplateSet, decide: &Arc<dyn Decide>) -> Option<String> {
        let mut text = String::with_capacity(1 << 15);
        let mut cost = Cost::default();
        self.walk(&self.steps, set, decide, (&mut text, &mut cost))?;
        Some(text)
    }

    fn walk(
        &self,
        steps: &[Step],
        set: &TemplateSet,
        decide: &Arc<dyn Decide>,
        (text, cost): (&mut String, &mut Cost),
    ) -> Option<()> {
        for step in steps {
            match step {
                Step::Literal(literal) => text.push_str(literal),
                Step::Part(part) => text.push_str(&self.parts[*part].text(set, decide, cost)?),
                Step::Branch { condition, then, otherwise } => {
                    let is_taken = !self.parts[*condition].text(set, decide, cost)?.is_empty();
                    self.walk(if is_taken { then } else { otherwise }, set, decide, (text, cost))?;
                }
            }
        }
        (text.len() <= complexity::MAX_BYTES).then_some(())
    }
}

impl Part {
    fn text(&self, set: &TemplateSet, decide: &Arc<dyn Decide>, cost: &mut Cost) -> Option<Arc<str>> {
        let known = {
            let nodes = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            let mut at = 0;
            loop {
                match nodes.get(at) {
                    Some(Node::Reads(name, next)) => {
                        let value = decide.decide(name);
                        match next.iter().find(|(known, _)| *known == value) {
                            Some((_, next)) => at = *next,
                            None => break None,
                        }
                    }
                    Some(Node::Writes(text, cost)) => break Some((text.clone(), *cost)),
                    Some(Node::Open) | None => break None,
                }
            }
        };
        let (text, own) = match known {
            Some(known) => known,
            None => self.render(set, decide)?,
        };
        cost.fuel += own.fuel;
        cost.written += own.written;
        cost.work += own.work;
        let is_within = set.environment.fuel().is_none_or(|fuel| cost.fuel <= fuel)
            && guard::is_within(cost.written, cost.work);
        is_within.then_some(text)
    }

    /// Renders the part, and caches the axis values that it reads together with its output. `None` on an error.
    fn render(&self, set: &TemplateSet, decide: &Arc<dyn Decide>) -> Option<(Arc<str>, Cost)> {
        let reads = Arc::new(Recorder { decide: decide.clone(), reads: Mutex::default() });
        let template = set.environment.template_from_named_str(&self.template, &self.source).ok()?;
        guard::begin();
        let mut text = Vec::new();
        let done = template.render_captured_to(Value::from_dyn_object(reads.clone()), &mut text).ok()?;
        let fuel = done.state().fuel_levels().map_or(0, |(consumed, _)| consumed);
        let (written, work) = guard::spent();
        let (text, cost): (Arc<str>, _) =
            (String::from_utf8(text).ok()?.into(), Cost { fuel, written, work });
        let reads = std::mem::take(&mut *reads.reads.lock().unwrap_or_else(PoisonError::into_inner));
        let mut nodes = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if nodes.is_empty() {
            nodes.push(Node::Open);
        }
        let mut at = 0;
        for (name, value) in reads {
            let new = nodes.len();
            let Some(node) = nodes.get_mut(at) else { break };
            if matches!(node, Node::Open) {
                *node = Node::Reads(name.clone(), Vec::new());
            }
            // The same values lead to the same reads, so this is the name.
            let Node::Reads(_, next) = node else { break };
            at = match next.iter().find(|(known, _)| *known == value) {
                Some((_, at)) => *at,
                None => {
                    next.push((value, new));
                    nodes.push(Node::Open);
                    new
                }
            };
        }
        if let Some(node @ Node::Open) = nodes.get_mut(at) {
            *node = Node::Writes(text.clone(), cost);
        }
        Some((text, cost))
    }
}

/// A minijinja context that records each name, with its value, when a template first reads it.
#[derive(Debug)]
struct Recorder {
    decide: Arc<dyn Decide>,
    reads: Mutex<Vec<(Arc<str>, Option<AxisValue>)>>,
}

impl Object for Recorder {
    fn get_value(self: &Arc<Self>, key: &Value) -> Option<Value> {
        self.get_value_by_str(key.as_str()?)
    }

    fn get_value_by_str(self: &Arc<Self>, key: &str) -> Option<Value> {
        let mut reads = self.reads.lock().unwrap_or_else(PoisonError::into_inner);
        let known = reads.iter().find(|(name, _)| **name == *key).map(|(_, value)| value.clone());
        let value = known.unwrap_or_else(|| {
            let value = self.decide.decide(key);
            reads.push((key.into(), value.clone()));
            value
        });
        value.as_ref().map(to_template_value)
    }
}
