//! Expressions in settings: evaluated over parameters and features, or kept until sizes are known.

use std::rc::Rc;

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::names::expression_diagnostic::expression_diagnostic;
use crate::pipeline::settings::derived::NO_TOGGLES;
use crate::pipeline::settings::{Evaluate, LiveSetting, Structural, names};
use crate::work::{Deferred, Live, LiveValue};
use umbragraph_text::diagnostic::{Code, Diagnostic, codes};
use umbragraph_text::expression::{Expression, ExpressionError, ExpressionKind, UnknownName, Value};
use umbragraph_text::language::Expr;

impl Evaluate for PassBuilder<'_> {
    fn value(&mut self, expr: &Expr, pointer: &str) -> Option<Value> {
        let result = self.evaluate(expr, pointer);
        result.map_err(|error| self.expression_error(&error, pointer)).ok()
    }

    fn add(&mut self, diagnostic: Diagnostic, pointer: &str) {
        let mut diagnostic = diagnostic.at(self.place(pointer), self.absolute(pointer));
        // A literal is no expression.
        let is_literal = self.settings.nearest(pointer).text().is_none();
        if let Some(help) = diagnostic.help.as_mut().filter(|_| is_literal) {
            *help = help.replace("make the expression yield", "write");
        }
        self.shared.diagnostics.push(diagnostic);
    }

    fn warn(&mut self, code: Code, pointer: &str, message: impl Into<String>, help: impl Into<String>) {
        let diagnostic = Diagnostic::warning(code, self.place(pointer), message);
        self.shared.diagnostics.push(diagnostic.help(help).pointer(self.absolute(pointer)));
    }

    fn report_word(&mut self, word: &str, expr: &Expr, pointer: &str) {
        let message = format!("the expression yields \"{word}\", which is not known here");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_WORD, self.place(pointer), message)
            .pointer(self.absolute(pointer))
            .help("the schema lists the words known here");
        let name = match expr.parse() {
            Ok(Expression { kind: ExpressionKind::Name(name), .. }) => Some(name),
            _ => None,
        };
        let derived = name.and_then(|name| self.shared.scope.derived_at(&name));
        self.shared.diagnostics.push(match derived {
            Some(place) => diagnostic.related(place, "the word comes from here"),
            None => diagnostic,
        });
    }
}

impl PassBuilder<'_> {
    /// Evaluates settings of a CPU node as live settings, which can change from frame to frame. The node receives
    /// changed values in [`update`](crate::work::CpuNode::update).
    pub fn live<T>(&mut self, evaluate: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.is_live, true);
        let result = evaluate(self);
        self.is_live = outer;
        result
    }

    /// Evaluates an expression whose value can change from frame to frame; returns `None` after a diagnostic.
    pub fn live_value<T: LiveValue>(&mut self, expr: &Expr, pointer: &str) -> Option<Live<T>> {
        let evaluated = self.parse(expr).and_then(|expression| {
            let closed = self.closed(&expression);
            let is_live = self.shared.dependence.any(names(&closed));
            let setting = is_live.then(|| self.add_live(closed, pointer, |value| T::read(value).map(drop)));
            Ok((self.evaluate_closed(&expression)?, setting))
        });
        let (value, setting) = evaluated.map_err(|error| self.expression_error(&error, pointer)).ok()?;
        Some(Live { value: self.judged(&value, pointer)?, setting })
    }

    /// Parses an expression that may name resource sizes and can change from frame to frame; returns `None` after a
    /// diagnostic.
    pub fn live_deferred(&mut self, expr: &Expr, pointer: &str) -> Option<Live<Deferred>> {
        let value = self.live(|pass| pass.deferred(expr, pointer))?;
        let is_live = self.shared.dependence.any(names(&value.expression));
        let setting = is_live.then(|| self.add_live(value.expression.clone(), pointer, |_| Ok(())));
        Some(Live { value, setting })
    }

    /// Evaluates settings as structural, also within [`Self::live`]: a change of the parameters that they use then
    /// needs a new plan.
    pub fn structural<T>(&mut self, evaluate: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::take(&mut self.is_live);
        let result = evaluate(self);
        self.is_live = outer;
        result
    }

    /// Parses an expression that may name resource sizes, for evaluation once these are known; returns `None` after a
    /// diagnostic.
    pub fn deferred(&mut self, expr: &Expr, pointer: &str) -> Option<Deferred> {
        let parsed = self.parse(expr).and_then(|expression| {
            self.environment.check_words(&expression, &self.shared.scope)?;
            Ok(expression)
        });
        let expression = parsed.map_err(|error| self.expression_error(&error, pointer)).ok()?;
        if !self.is_live {
            self.fix(&expression, pointer);
        }
        let (place, absolute) = (self.place(pointer), self.absolute(pointer));
        let expression = if self.environment.is_top() {
            Rc::unwrap_or_clone(expression)
        } else {
            self.closed(&expression)
        };
        // Values of names that exist come later.
        if let Some(error) = self.shared.unknown_name(&expression) {
            self.expression_error(&error, pointer);
            return None;
        }
        Some(Deferred { expression, place, pointer: absolute })
    }

    fn evaluate(&mut self, expr: &Expr, pointer: &str) -> Result<Value, ExpressionError> {
        let expression = self.parse(expr)?;
        self.evaluate_parsed(&expression, pointer)
    }

    pub(super) fn evaluate_parsed(
        &mut self,
        expression: &Expression,
        pointer: &str,
    ) -> Result<Value, ExpressionError> {
        if self.is_live {
            // A node is given all of its settings.
            self.add_live(self.closed(expression), pointer, |_| Ok(()));
        } else {
            self.fix(expression, pointer);
        }
        self.evaluate_closed(expression)
    }

    fn evaluate_closed(&self, expression: &Expression) -> Result<Value, ExpressionError> {
        let shared = &*self.shared;
        self.environment.evaluate(expression, &|name| shared.find(name).is_some(), &shared.scope)
    }

    /// Rewrites an expression to names outside of subgraphs. Names whose values depend on parameters stay names.
    fn closed(&self, expression: &Expression) -> Expression {
        self.environment.close_live(expression, &|name| self.shared.find(name).is_some())
    }

    /// Adds a live setting unless it is already listed, and returns its index.
    fn add_live(
        &mut self,
        expression: Expression,
        pointer: &str,
        check: fn(&Value) -> Result<(), Diagnostic>,
    ) -> usize {
        if let Some(known) = self.live.iter().position(|setting| setting.pointer == pointer) {
            return known;
        }
        let (place, absolute) = (self.place(pointer), self.absolute(pointer));
        let value = Deferred { expression, place, pointer: absolute };
        self.live.push(LiveSetting { check, pointer: pointer.to_owned(), value });
        self.live.len() - 1
    }

    /// Marks the parameters that an expression depends on as structural, because of the setting at `pointer`. A change
    /// of them then needs a new plan.
    pub(super) fn fix(&mut self, expression: &Expression, pointer: &str) {
        let (settings, above) = (self.settings, &self.pointer);
        let at = || Structural { place: settings.nearest(pointer).span, pointer: [above, pointer].concat() };
        self.shared.fix(expression, self.environment, &at);
    }

    pub(super) fn parse(&mut self, expr: &Expr) -> Result<Rc<Expression>, ExpressionError> {
        match expr.0.as_str() {
            Some(text) => self.shared.parse(text),
            None => expr.parse().map(Rc::new),
        }
    }

    pub(super) fn expression_error(&mut self, error: &ExpressionError, pointer: &str) {
        if error
            .unknown
            .as_deref()
            .is_some_and(|unknown| !unknown.is_complete && self.report_argument_error(&unknown.name))
        {
            return;
        }
        let mut error = error.clone();
        self.environment
            .widen(&mut error, self.shared.resources.iter().map(|resource| resource.name.as_str()));
        let value = self.settings.nearest(pointer);
        let Some(mut diagnostic) = expression_diagnostic(&error, value, &self.absolute(pointer)) else {
            self.shared.withheld += 1;
            return;
        };
        let is_toggle =
            |unknown: &UnknownName| !unknown.is_complete && self.shared.toggles.contains(&unknown.name);
        if error.unknown.as_deref().is_some_and(is_toggle) {
            diagnostic.fix = None;
            diagnostic = diagnostic.help(NO_TOGGLES);
        }
        self.shared.diagnostics.push(diagnostic);
    }
}

impl PassBuilder<'_> {
    /// Reports an input of a subgraph whose argument names no resource. Returns `true` if `name` was reported.
    pub(super) fn report_argument_error(&mut self, name: &str) -> bool {
        let resources = self.shared.resources.iter().map(|resource| resource.name.as_str());
        let diagnostic = self.environment.argument_error(name, resources);
        let is_it = diagnostic.is_some();
        self.shared.withheld += usize::from(is_it);
        self.shared.argument_errors.extend(diagnostic);
        is_it
    }
}
