//! The graph of one function: its statements in order, with the control flow in which each runs.
//!
//! If no side of a branch leaves the block, invocations reconverge: the control flow after the branch is the one before
//! it. Otherwise it depends on the condition. A loop's flow depends on its own end. The walk keeps the node of each
//! variable's current value. Branches are merged where they meet; loops begin with nodes that get their edges at the
//! end.

use std::collections::HashMap;

use naga::{
    AddressSpace, Binding, Block, BuiltIn, Expression, Function, Handle, Module, ShaderStage, Span,
    Statement, SwitchCase,
};

use super::flow_graph::{FlowGraph, Node, Note};
use super::summary::{Finding, Need, Operation, Origin, Passed, Summary};
use crate::written::ir;

/// A bit set of the ways in which a statement can end.
type Ends = u8;

const NEXT: Ends = 1;
const BREAK: Ends = 2;
const CONTINUE: Ends = 4;
const RETURN: Ends = 8;

/// The state of a loop or switch while the graph of its statements is built.
struct Frame {
    is_loop: bool,
    /// The variables assigned inside: the index in `Walk::state`, and the nodes of the value at the exit and at the end
    /// of an iteration. A node is `None` until its place is reached.
    assigned: Vec<(usize, Option<Node>, Option<Node>)>,
}

pub(super) struct Walk<'a> {
    pub(super) module: &'a Module,
    pub(super) function: &'a Function,
    is_entry: bool,
    summaries: &'a HashMap<Handle<Function>, Summary>,
    pub(super) graph: FlowGraph,
    /// The graph node that stands for values that may differ between invocations.
    pub(super) differing: Node,
    /// The graph node that stands for values that are equal in all invocations.
    pub(super) uniform: Node,
    /// The graph node of the control flow at the function's start.
    start: Node,
    pub(super) values: Vec<Option<Node>>,
    pub(super) arguments: Vec<Node>,
    /// The nodes of the value that each pointer argument refers to, before and after the call; `None` for other
    /// arguments.
    contents: Vec<Option<(Node, Node)>>,
    /// The nodes of the current values: first of the local variables, then of the targets of all arguments.
    pub(super) state: Vec<Node>,
    result: Node,
    frames: Vec<Frame>,
    /// The uniformity requirements, each with the node that must be uniform.
    pub(super) needs: Vec<(Need, Node)>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        module: &'a Module,
        function: &'a Function,
        stage: Option<ShaderStage>,
        summaries: &'a HashMap<Handle<Function>, Summary>,
    ) -> Self {
        let mut graph = FlowGraph::default();
        let (differing, uniform, start, result) =
            (graph.node(&[]), graph.node(&[]), graph.node(&[]), graph.node(&[]));
        let mut state = vec![uniform; function.local_variables.len()];
        let (mut arguments, mut contents) = (Vec::new(), Vec::new());
        for argument in &function.arguments {
            let is_variable = module.types[argument.ty].inner.pointer_space() == Some(AddressSpace::Function);
            let value = match stage {
                Some(_) if is_same_everywhere(module, argument) => uniform,
                Some(_) => {
                    let name = argument.name.as_deref().unwrap_or_default();
                    let arguments = function.expressions.iter().find(|(_, expression)| {
                        **expression == Expression::FunctionArgument(arguments.len() as u32)
                    });
                    let span = arguments
                        .map_or(Span::UNDEFINED, |(handle, _)| function.expressions.get_span(handle));
                    graph.noted(&[differing], span, format!("\"{name}\" differs between invocations"))
                }
                None => graph.node(&[]),
            };
            arguments.push(value);
            let inner = is_variable.then(|| (graph.node(&[]), graph.node(&[])));
            state.push(inner.map_or(differing, |(before, _)| before));
            contents.push(inner);
        }
        Self {
            module,
            function,
            is_entry: stage.is_some(),
            summaries,
            graph,
            differing,
            uniform,
            start,
            values: vec![None; function.expressions.len()],
            arguments,
            contents,
            state,
            result,
            frames: Vec::new(),
            needs: Vec::new(),
        }
    }

    /// Builds the graph of the function. Returns its summary for callers, and the violations of uniformity requirements
    /// inside it.
    pub(super) fn summary(mut self) -> (Summary, Vec<Finding>) {
        let (_, ends) = self.block(&self.function.body, self.start);
        if ends & NEXT != 0 {
            self.returned();
        }
        let Self { graph, needs, .. } = &self;
        let differing = graph.depending_on(self.differing);
        let mut findings = Vec::new();
        for (need, node) in needs {
            if differing.has(*node) {
                findings.push(Finding { need: need.clone(), reasons: differing.reasons(*node) });
            }
        }
        let mut summary = Summary::default();
        if self.is_entry {
            return (summary, findings);
        }
        let start = graph.depending_on(self.start);
        // One of each severity is enough: what is said of the call is the same.
        for (need, _) in needs.iter().filter(|(_, node)| start.has(*node)) {
            if summary.flow.iter().all(|known| known.warning != need.warning) {
                summary.flow.push(need.clone());
            }
        }
        let origin = |node: Node| Origin {
            differs: differing.has(node).then(|| differing.reasons(node)),
            passed: Vec::new(),
        };
        summary.result = origin(self.result);
        summary.contents = self.contents.iter().map(|inner| inner.map(|(_, after)| origin(after))).collect();
        for (at, (argument, inner)) in self.arguments.iter().zip(&self.contents).enumerate() {
            let before = inner.map(|(before, _)| (Passed::Contents(at), before));
            for (passed, node) in [(Passed::Argument(at), *argument)].into_iter().chain(before) {
                let depending = graph.depending_on(node);
                for (need, _) in needs.iter().filter(|(_, node)| depending.has(*node)) {
                    let is_known =
                        |(known, other): &(Passed, Need)| *known == passed && other.warning == need.warning;
                    if !summary.values.iter().any(is_known) {
                        summary.values.push((passed, need.clone()));
                    }
                }
                if depending.has(self.result) {
                    summary.result.passed.push(passed);
                }
                for (inner, into) in self.contents.iter().zip(&mut summary.contents) {
                    if let (Some((_, after)), Some(into)) = (inner, into)
                        && depending.has(*after)
                    {
                        into.passed.push(passed);
                    }
                }
            }
        }
        (summary, findings)
    }

    fn returned(&mut self) {
        let locals = self.function.local_variables.len();
        for (at, inner) in self.contents.iter().enumerate() {
            if let Some((_, after)) = inner {
                self.graph.edge(*after, self.state[locals + at]);
            }
        }
    }

    fn block(&mut self, block: &Block, mut flow: Node) -> (Node, Ends) {
        let mut ends = NEXT;
        for (statement, span) in block.span_iter() {
            let (next, own) = self.statement(statement, *span, flow);
            flow = next;
            ends = (ends & !NEXT) | own;
            if own & NEXT == 0 {
                break;
            }
        }
        (flow, ends)
    }

    fn statement(&mut self, statement: &Statement, span: Span, flow: Node) -> (Node, Ends) {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    self.emit(handle, flow);
                }
            }
            Statement::Block(inner) => return self.block(inner, flow),
            Statement::If { condition, accept, reject } => {
                let decided = self.decided(*condition, flow);
                let before = self.state.clone();
                let (first, mut ends) = self.block(accept, decided);
                let accepted = std::mem::replace(&mut self.state, before);
                let (second, others) = self.block(reject, decided);
                if ends & NEXT != 0 {
                    self.meet(accepted, others & NEXT != 0);
                }
                ends |= others;
                return (if ends == NEXT { flow } else { self.graph.node(&[first, second]) }, ends);
            }
            Statement::Switch { selector, cases } => return self.switch(*selector, cases, flow),
            Statement::Loop { body, continuing, break_if } => {
                return self.repeated(body, continuing, *break_if, flow);
            }
            Statement::Break => {
                self.leave(false);
                return (flow, BREAK);
            }
            Statement::Continue => {
                self.leave(true);
                return (flow, CONTINUE);
            }
            Statement::Return { value } => {
                if let Some(value) = value {
                    let value = self.value(*value);
                    self.graph.edge(self.result, value);
                    self.graph.edge(self.result, flow);
                }
                self.returned();
                return (flow, RETURN);
            }
            Statement::Store { pointer, value } => {
                let value = self.value(*value);
                self.store(*pointer, &[value, flow], span);
            }
            Statement::ControlBarrier(_) => self.need(Operation::Barrier, span, &[flow], false),
            Statement::Atomic { result: Some(result), .. } => self.differs(*result, flow, span, "an atomic"),
            Statement::WorkGroupUniformLoad { pointer, result } => {
                let place = self.value(*pointer);
                self.need(Operation::WorkgroupUniformLoad, span, &[flow], false);
                self.need(Operation::WorkgroupUniformLoad, span, &[place, flow], true);
                self.values[result.index()] = Some(self.graph.node(&[flow]));
            }
            Statement::Call { function, arguments, result } => {
                self.call(*function, arguments, *result, span, flow);
            }
            Statement::SubgroupBallot { result, .. }
            | Statement::SubgroupGather { result, .. }
            | Statement::SubgroupCollectiveOperation { result, .. } => {
                self.subgroup(statement, span, flow);
                self.differs(*result, flow, span, "a subgroup operation");
            }
            _ => {}
        }
        (flow, NEXT)
    }

    fn switch(&mut self, selector: Handle<Expression>, cases: &[SwitchCase], flow: Node) -> (Node, Ends) {
        let decided = self.decided(selector, flow);
        let assigned = self.assigned(cases.iter().map(|case| &case.body));
        self.frames.push(Frame { is_loop: false, assigned });
        let before = self.state.clone();
        let (mut ends, mut flows) = (0, Vec::new());
        let mut met: Option<Vec<Node>> = None;
        // A case that falls through stands for one more selector of the next.
        for case in cases.iter().filter(|case| !(case.fall_through && case.body.is_empty())) {
            self.state.clone_from(&before);
            let (end, own) = self.block(&case.body, decided);
            if own & NEXT != 0 {
                if let Some(met) = met.take() {
                    self.meet(met, true);
                }
                met = Some(self.state.clone());
            }
            ends |= own;
            flows.push(end);
        }
        let is_left = ends & BREAK != 0;
        self.state = met.unwrap_or(before);
        self.join_exits(is_left && ends & NEXT != 0);
        if is_left {
            ends = (ends & !BREAK) | NEXT;
        }
        (if ends == NEXT { flow } else { self.graph.node(&flows) }, ends)
    }

    fn repeated(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
        flow: Node,
    ) -> (Node, Ends) {
        let round = self.graph.node(&[flow]);
        let assigned = self.assigned([body, continuing]);
        let mut begins = Vec::new();
        for (slot, ..) in &assigned {
            let value = self.graph.node(&[self.state[*slot]]);
            self.state[*slot] = value;
            begins.push((*slot, value));
        }
        self.frames.push(Frame { is_loop: true, assigned });
        let (mut end, mut ends) = self.block(body, round);
        self.join_rounds(ends & NEXT != 0);
        let (last, others) = self.block(continuing, end);
        end = last;
        ends |= others;
        if let Some(condition) = break_if {
            end = self.decided(condition, end);
            self.leave(false);
            ends |= BREAK;
        }
        self.graph.edge(round, end);
        for (slot, value) in begins {
            self.graph.edge(value, self.state[slot]);
        }
        self.join_exits(false);
        ends = (ends & RETURN) | if ends & BREAK != 0 { NEXT } else { 0 };
        (if ends == NEXT { flow } else { round }, ends)
    }

    fn decided(&mut self, condition: Handle<Expression>, flow: Node) -> Node {
        let value = self.value(condition);
        let span = self.function.expressions.get_span(condition);
        self.graph.noted(&[value, flow], span, "this decides which invocations go on")
    }

    /// Merges the variables' values where two control-flow paths join. If `both` is `false`, only the path with the
    /// values `other` reaches the join.
    fn meet(&mut self, other: Vec<Node>, both: bool) {
        if !both {
            self.state = other;
            return;
        }
        for (value, other) in self.state.iter_mut().zip(other) {
            if *value != other {
                *value = self.graph.node(&[*value, other]);
            }
        }
    }

    /// Adds the variables' current values to those at the exit of the innermost loop or switch. If `is_round`, adds
    /// them to those at the end of an iteration of the innermost loop instead.
    fn leave(&mut self, is_round: bool) {
        let mut frames = self.frames.iter_mut().rev();
        let Some(frame) = frames.find(|frame| frame.is_loop || !is_round) else { return };
        for (slot, exit, round) in &mut frame.assigned {
            let into = if is_round { round } else { exit };
            let node = *into.get_or_insert_with(|| self.graph.node(&[]));
            self.graph.edge(node, self.state[*slot]);
        }
    }

    /// Merges the variables' values at the end of a loop's body. `is_reached` is `true` if the end is reached without
    /// `continue`.
    fn join_rounds(&mut self, is_reached: bool) {
        let Some(frame) = self.frames.last() else { return };
        for (slot, _, round) in &frame.assigned {
            let Some(round) = round else { continue };
            if is_reached {
                self.graph.edge(*round, self.state[*slot]);
            }
            self.state[*slot] = *round;
        }
    }

    /// Merges the variables' values after a loop or switch. `also_end` is `true` if its end is also reached without
    /// `break`.
    fn join_exits(&mut self, also_end: bool) {
        let Some(frame) = self.frames.pop() else { return };
        for (slot, exit, _) in frame.assigned {
            let Some(exit) = exit else { continue };
            if also_end {
                self.graph.edge(exit, self.state[slot]);
            }
            self.state[slot] = exit;
        }
    }

    fn call(
        &mut self,
        callee: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
        span: Span,
        flow: Node,
    ) {
        let summaries = self.summaries;
        let values: Vec<Node> = arguments.iter().map(|one| self.value(*one)).collect();
        let contents: Vec<Node> = arguments.iter().map(|one| self.contents_of(*one)).collect();
        let Some(summary) = summaries.get(&callee) else {
            if let Some(result) = result {
                self.values[result.index()] = Some(self.differing);
            }
            return;
        };
        let name = self.module.functions[callee].name.as_deref().unwrap_or_default();
        let at = |passed: &Passed| match passed {
            Passed::Argument(at) => values.get(*at).copied(),
            Passed::Contents(at) => contents.get(*at).copied(),
        };
        for need in &summary.flow {
            self.needs.push((need.called_at(span, name, false), flow));
        }
        for (passed, need) in &summary.values {
            let depends_on = [at(passed).unwrap_or(self.differing), flow];
            let node = self.graph.node(&depends_on);
            self.needs.push((need.called_at(span, name, true), node));
        }
        let mut node_of = |origin: &Origin| {
            let mut depends_on = vec![flow];
            depends_on.extend(origin.passed.iter().filter_map(at));
            let Some(reasons) = &origin.differs else { return self.graph.node(&depends_on) };
            let mut before = self.differing;
            for Note { span, text } in reasons.iter().rev() {
                before = self.graph.noted(&[before], *span, text.clone());
            }
            depends_on.push(before);
            self.graph.noted(
                &depends_on,
                span,
                format!("what \"{name}\" gives may differ between invocations"),
            )
        };
        let own = result.map(|result| (result, node_of(&summary.result)));
        let after: Vec<Option<Node>> =
            summary.contents.iter().map(|origin| origin.as_ref().map(&mut node_of)).collect();
        if let Some((result, node)) = own {
            self.values[result.index()] = Some(node);
        }
        for (argument, after) in arguments.iter().zip(after) {
            if let Some(after) = after {
                self.store(*argument, &[after], span);
            }
        }
    }

    /// The variables that the blocks assign, as indices in `Walk::state`, with `None` for the nodes at exit and end of
    /// iteration.
    fn assigned<'b>(
        &self,
        blocks: impl IntoIterator<Item = &'b Block>,
    ) -> Vec<(usize, Option<Node>, Option<Node>)> {
        let mut slots = Vec::new();
        let mut blocks: Vec<&Block> = blocks.into_iter().collect();
        while let Some(block) = blocks.pop() {
            for statement in block {
                match statement {
                    Statement::Store { pointer, .. } => slots.extend(self.slot(*pointer)),
                    Statement::Call { arguments, .. } => {
                        slots.extend(arguments.iter().filter_map(|argument| self.slot(*argument)));
                    }
                    _ => blocks.extend(ir::blocks(statement)),
                }
            }
        }
        slots.sort_unstable();
        slots.dedup();
        slots.into_iter().map(|slot| (slot, None, None)).collect()
    }
}

/// Returns `true` if an argument of an entry point is the same in all invocations of a workgroup.
fn is_same_everywhere(module: &Module, argument: &naga::FunctionArgument) -> bool {
    let same = [Binding::BuiltIn(BuiltIn::WorkGroupId), Binding::BuiltIn(BuiltIn::NumWorkGroups)];
    ir::inputs_of(module, argument).iter().all(|input| same.contains(input.binding))
}
