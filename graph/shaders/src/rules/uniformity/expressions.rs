//! Dependencies of values, and the variables behind pointers.

use naga::diagnostic_filter::{FilterableTriggeringRule, Severity, StandardFilterableTriggeringRule};
use naga::{
    AddressSpace, Expression, GatherMode, Handle, ImageClass, SampleLevel, Span, Statement, StorageAccess,
    TypeInner,
};

use super::flow_graph::Node;
use super::summary::{Need, Operation};
use super::walk::Walk;
use crate::written::ir;

/// The variable or memory that a pointer is derived from.
enum Root {
    /// A local variable, or the target of a pointer argument: its index in `Walk::state`.
    Variable(usize),
    /// Memory in an address space, with the name of the variable.
    Memory(AddressSpace, String),
}

impl Walk<'_> {
    /// The graph node of an expression. An expression that no statement has evaluated counts as differing between
    /// invocations, unless it is constant, a variable or an argument.
    pub(super) fn value(&self, handle: Handle<Expression>) -> Node {
        let made = self.values.get(handle.index()).copied().flatten();
        made.unwrap_or_else(|| match &self.function.expressions[handle] {
            Expression::FunctionArgument(at) => {
                self.arguments.get(*at as usize).copied().unwrap_or(self.differing)
            }
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_)
            | Expression::GlobalVariable(_)
            | Expression::LocalVariable(_) => self.uniform,
            _ => self.differing,
        })
    }

    /// Creates the graph node of an expression at the statement that evaluates it. `flow` is the node of the control
    /// flow.
    pub(super) fn emit(&mut self, handle: Handle<Expression>, flow: Node) {
        let function = self.function;
        let span = function.expressions.get_span(handle);
        let expression = &function.expressions[handle];
        let mut depends_on = vec![flow];
        match ir::operands(expression) {
            Some(operands) => depends_on.extend(operands.map(|one| self.value(one))),
            None => depends_on.push(self.differing),
        }
        let source = match expression {
            Expression::Load { pointer } => match self.root(*pointer) {
                Some(Root::Memory(space, name)) if !is_read_only(space) => {
                    Some(format!("what \"{name}\" holds may differ between invocations"))
                }
                _ => {
                    depends_on.push(self.contents_of(*pointer));
                    None
                }
            },
            Expression::Derivative { .. } => {
                self.need(Operation::Derivative, span, &[flow], false);
                Some("a derivative may differ between invocations".to_owned())
            }
            Expression::ImageSample {
                level: SampleLevel::Auto | SampleLevel::Bias(_), depth_ref, ..
            } => {
                self.need(Operation::Sample { compares: depth_ref.is_some() }, span, &[flow], false);
                Some("what is sampled may differ between invocations".to_owned())
            }
            Expression::ImageLoad { image, .. } if self.is_written_image(*image) => {
                Some("what a texture that is written holds may differ between invocations".to_owned())
            }
            _ => None,
        };
        let node = match source {
            Some(text) => {
                depends_on.push(self.differing);
                self.graph.noted(&depends_on, span, text)
            }
            None => self.graph.node(&depends_on),
        };
        self.values[handle.index()] = Some(node);
    }

    /// Creates the node of a result that may differ between invocations, such as that of an atomic.
    pub(super) fn differs(&mut self, result: Handle<Expression>, flow: Node, span: Span, what: &str) {
        let text = format!("what {what} gives may differ between invocations");
        self.values[result.index()] = Some(self.graph.noted(&[flow, self.differing], span, text));
    }

    /// Requires uniform control flow for a subgroup operation, and a uniform distance for shuffles.
    pub(super) fn subgroup(&mut self, statement: &Statement, span: Span, flow: Node) {
        self.need(Operation::Subgroup, span, &[flow], false);
        if let Statement::SubgroupGather {
            mode: GatherMode::ShuffleDown(by) | GatherMode::ShuffleUp(by) | GatherMode::ShuffleXor(by),
            ..
        } = statement
        {
            let by = self.value(*by);
            self.need(Operation::Subgroup, span, &[by, flow], true);
        }
    }

    /// Adds the requirement that all of `nodes` are uniform. The module's diagnostic filters decide whether a violation
    /// is an error or a warning, or is ignored.
    pub(super) fn need(&mut self, operation: Operation, place: Span, nodes: &[Node], is_value: bool) {
        let warning = match self.severity(operation) {
            Severity::Off => return,
            Severity::Info | Severity::Warning => true,
            Severity::Error => false,
        };
        let node = match nodes {
            [one] => *one,
            several => self.graph.node(several),
        };
        self.needs.push((Need { operation, warning, place, called: None, is_value, way: Vec::new() }, node));
    }

    fn severity(&self, operation: Operation) -> Severity {
        let is_meant = |rule: &FilterableTriggeringRule| match operation {
            Operation::Derivative | Operation::Sample { .. } => {
                let derivative = StandardFilterableTriggeringRule::DerivativeUniformity;
                *rule == FilterableTriggeringRule::Standard(derivative)
            }
            Operation::Subgroup => {
                matches!(rule, FilterableTriggeringRule::Unknown(name) if &**name == "subgroup_uniformity")
            }
            Operation::Barrier | Operation::WorkgroupUniformLoad => false,
        };
        let mut next = self.function.diagnostic_filter_leaf;
        while let Some(handle) = next {
            let node = &self.module.diagnostic_filters[handle];
            if is_meant(&node.inner.triggering_rule) {
                return node.inner.new_severity;
            }
            next = node.parent;
        }
        Severity::Error
    }

    /// The node of the value that a pointer refers to. An expression that is no pointer counts as uniform.
    pub(super) fn contents_of(&self, pointer: Handle<Expression>) -> Node {
        match self.root(pointer) {
            Some(Root::Variable(slot)) => self.state[slot],
            Some(Root::Memory(space, _)) if !is_read_only(space) => self.differing,
            _ => self.uniform,
        }
    }

    /// Assigns a new value to the variable that a pointer refers to. A write to a member or an element keeps the
    /// variable's old dependencies.
    pub(super) fn store(&mut self, pointer: Handle<Expression>, depends_on: &[Node], span: Span) {
        let Some(slot) = self.slot(pointer) else { return };
        let mut depends_on = depends_on.to_vec();
        let variable = ir::base(self.function, pointer);
        if variable != pointer {
            depends_on.extend([self.value(pointer), self.state[slot]]);
        }
        let name = match &self.function.expressions[variable] {
            Expression::LocalVariable(variable) => self.function.local_variables[*variable].name.as_deref(),
            _ => None,
        };
        self.state[slot] = match name {
            Some(name) => self.graph.noted(&depends_on, span, format!("\"{name}\" gets its value here")),
            None => self.graph.node(&depends_on),
        };
    }

    /// The index in `Walk::state` of the variable that a pointer refers to; `None` for other memory.
    pub(super) fn slot(&self, pointer: Handle<Expression>) -> Option<usize> {
        match self.root(pointer)? {
            Root::Variable(slot) => Some(slot),
            Root::Memory(..) => None,
        }
    }

    fn root(&self, pointer: Handle<Expression>) -> Option<Root> {
        match self.function.expressions[ir::base(self.function, pointer)] {
            Expression::LocalVariable(variable) => Some(Root::Variable(variable.index())),
            Expression::GlobalVariable(variable) => {
                let variable = &self.module.global_variables[variable];
                Some(Root::Memory(variable.space, variable.name.clone().unwrap_or_default()))
            }
            Expression::FunctionArgument(at) => {
                let argument = self.function.arguments.get(at as usize)?;
                Some(match self.module.types[argument.ty].inner.pointer_space()? {
                    AddressSpace::Function => {
                        Root::Variable(self.function.local_variables.len() + at as usize)
                    }
                    space => Root::Memory(space, argument.name.clone().unwrap_or_default()),
                })
            }
            _ => None,
        }
    }

    fn is_written_image(&self, image: Handle<Expression>) -> bool {
        match ir::image(self.module, self.function, image) {
            Some(TypeInner::Image { class: ImageClass::Storage { access, .. }, .. }) => {
                access.contains(StorageAccess::STORE)
            }
            Some(TypeInner::Image { .. }) => false,
            _ => true,
        }
    }
}

fn is_read_only(space: AddressSpace) -> bool {
    match space {
        AddressSpace::Storage { access } => !access.contains(StorageAccess::STORE),
        AddressSpace::Uniform | AddressSpace::Handle | AddressSpace::Immediate => true,
        _ => false,
    }
}
