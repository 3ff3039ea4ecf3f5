//! The syntax tree of a template: the size checks that it needs, the names that it reads and binds, and the literals
//! that it compares them with.
//!
//! The engine's fuel bounds steps, and the sink bounds the text. Neither notices a value that doubles (`s ~ s`), nor
//! how long `in`, a slice or an index takes on a long value; and the parser evaluates operations on literals. So every
//! expression that can grow a value is wrapped in a function that checks the result ([`guard`](super::guard)). Every
//! value that is searched is wrapped in one that counts its size: operators that grow, results of macros, captured
//! blocks, and list elements (`[l, l]` needs no memory, but a comparison visits all of it). In a chain of one operator
//! every [`LINKS`]th link is checked, so that calls nest less deeply than the parser.
//!
//! Limits: an expression is as long as the engine's own recursion allows ([`length`](super::length)); between two
//! checks there are [`LINKS`] values of 1 MiB, or one of the 100 MB that the engine allows for `"x" * n`. Of a template
//! that the engine cannot parse nothing is known.

use std::collections::BTreeSet;
use std::ops::Range;

use minijinja::machinery::ast::{BinOpKind, Call, CallArg, CompareOpKind, Expr, Spanned, Stmt};
use minijinja::machinery::{Span, parse};

use super::guard::{FACTOR, FITS, INDEXED, PLAIN_FUNCTIONS, SEEN};
use super::scan::syntax;
use super::structure::Structure;

/// The maximum number of operands in a chain of one operator between two size checks.
const LINKS: usize = 16;

/// The variables that a template reads and assigns, and its comparisons of variables with literals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    /// The variables that are read, each with its byte range.
    pub(crate) uses: Vec<(String, Range<usize>)>,
    /// The variables that a tag of the template assigns.
    pub(crate) bound: BTreeSet<String>,
    pub(crate) compared: Vec<Compared>,
    /// The variables that a tag in a loop assigns, and that text behind the loop reads.
    pub(crate) lost: Vec<(String, Range<usize>)>,
}

/// A comparison of a variable with a literal string or number.
#[derive(Clone, Debug)]
pub(crate) struct Compared {
    pub(crate) variable: String,
    /// The value of the literal; `range` is its byte range in the template.
    pub(crate) literal: minijinja::Value,
    pub(crate) range: Range<usize>,
}

/// A template with inserted size checks, ready for minijinja.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub(crate) text: String,
    /// The insertions in order: byte offset in the original template and length in bytes.
    insertions: Vec<(usize, usize)>,
    pub(crate) names: Names,
    pub(crate) structure: Structure,
}

impl Prepared {
    /// Maps a byte offset in the prepared template to the original one. An offset inside an insertion maps to the
    /// position of the insertion.
    pub(crate) fn original(&self, offset: usize) -> usize {
        let mut inserted = 0;
        for (at, length) in &self.insertions {
            if *at + inserted >= offset {
                break;
            }
            if offset < *at + inserted + length {
                return *at;
            }
            inserted += length;
        }
        offset - inserted
    }
}

/// Inserts checks of value sizes into a template, so that rendering cannot exhaust memory.
pub(crate) fn prepare(text: &str) -> Prepared {
    let (inserted, names, structure) = read(text);
    let prepared = String::with_capacity(text.len() + 256);
    let mut prepared = Prepared { text: prepared, insertions: Vec::new(), names, structure };
    let mut copied = 0;
    for (at, insertion) in inserted {
        prepared.text.push_str(&text[copied..at]);
        copied = at;
        prepared.insertions.push((at, insertion.len()));
        prepared.text.push_str(&insertion);
    }
    prepared.text.push_str(&text[copied..]);
    prepared
}

/// Returns the size checks to insert, each with its byte offset, and the names and parts of the template. All are empty
/// if minijinja cannot parse the template.
fn read(text: &str) -> (Vec<(usize, String)>, Names, Structure) {
    let Ok(template) = parse(text, "", syntax()) else { return Default::default() };
    let mut found = Found { structure: Structure::of(&template, text), ..Found::default() };
    found.statement(&template);
    let Found { starts, mut ends, mut names, structure, binds, in_loops, .. } = found;
    names.lost = in_loops
        .into_iter()
        .filter(|(name, _, end)| {
            let mut reads = names.uses.iter().filter(|(used, range)| used == name && range.start >= *end);
            let is_bound_again =
                |read: usize| binds.iter().any(|(bound, at)| bound == name && (*end..read).contains(at));
            reads.any(|(_, range)| !is_bound_again(range.start))
        })
        .map(|(name, range, _)| (name, range))
        .collect();
    // What begins further out was found first, and what ends further out has to end last.
    ends.reverse();
    ends.extend(starts);
    ends.sort_by_key(|(at, _)| *at);
    names.uses.sort_by_key(|(_, range)| range.start);
    names.compared.sort_by_key(|compared| compared.range.start);
    (ends, names, structure)
}

#[derive(Default)]
struct Found {
    starts: Vec<(usize, String)>,
    ends: Vec<(usize, String)>,
    names: Names,
    structure: Structure,
    /// The places where variables are bound.
    binds: Vec<(String, usize)>,
    /// The ends of the loops around a statement.
    loops: Vec<usize>,
    /// The variables that `set` binds in a loop, each with its place and the end of the loop.
    in_loops: Vec<(String, Range<usize>, usize)>,
}

impl Found {
    fn wrap(&mut self, one: &Expr<'_>, function: &str) {
        self.starts.push((start(one), format!("{function}(")));
        self.ends.push((one.span().end_offset as usize, ")".to_owned()));
    }

    /// Records the variables that assignment targets bind.
    fn bind<'e, 'a: 'e>(&mut self, targets: impl IntoIterator<Item = &'e Expr<'a>>) {
        for target in targets {
            match target {
                Expr::Var(variable) => {
                    self.binds.push((variable.id.to_owned(), start(target)));
                    self.names.bound.insert(variable.id.to_owned());
                }
                Expr::GetAttr(attribute) => self.bind([&attribute.expr]),
                Expr::List(list) => self.bind(&list.items),
                _ => {}
            }
        }
    }

    /// Records the comparison of a variable with the values `with`, if all of them are literals.
    fn compared(&mut self, variable: &Expr<'_>, with: &[Expr<'_>]) {
        let Expr::Var(variable) = variable else { return };
        let literal = |one: &Expr<'_>| match one {
            Expr::Const(literal) if literal.value.as_str().is_some() || literal.value.is_number() => {
                let (literal, range) = (literal.value.clone(), range(one.span()));
                Some(Compared { variable: variable.id.to_owned(), literal, range })
            }
            _ => None,
        };
        let literals: Option<Vec<Compared>> = with.iter().map(literal).collect();
        self.names.compared.extend(literals.into_iter().flatten());
    }

    fn comparison(&mut self, left: &Expr<'_>, operator: BinOpKind, right: &Expr<'_>) {
        match (operator, right) {
            (BinOpKind::Eq | BinOpKind::Ne, _) => {
                self.compared(left, std::slice::from_ref(right));
                self.compared(right, std::slice::from_ref(left));
            }
            (BinOpKind::In, Expr::List(list)) => self.compared(left, &list.items),
            (BinOpKind::In, Expr::Tuple(list)) => self.compared(left, &list.items),
            _ => {}
        }
    }

    fn statements(&mut self, list: &[Stmt<'_>]) {
        list.iter().for_each(|one| self.statement(one));
    }

    fn statement(&mut self, one: &Stmt<'_>) {
        match one {
            Stmt::Template(one) => self.statements(&one.children),
            // What a macro returns here is written, and counted as such.
            Stmt::EmitExpr(one) => match &one.expr {
                Expr::Call(call) => self.call(call),
                other => self.expression(other),
            },
            Stmt::ForLoop(one) => {
                self.bind([&one.target]);
                self.names.bound.insert("loop".to_owned());
                self.expression(&one.iter);
                self.expressions(&one.filter_expr);
                self.loops.push(one.span().end_offset as usize);
                self.statements(&one.body);
                self.loops.pop();
                self.statements(&one.else_body);
            }
            Stmt::IfCond(one) => {
                self.expression(&one.expr);
                self.statements(&one.true_body);
                self.statements(&one.false_body);
            }
            Stmt::WithBlock(one) => {
                self.bind(one.assignments.iter().map(|(target, _)| target));
                one.assignments.iter().for_each(|(_, value)| self.expression(value));
                self.statements(&one.body);
            }
            Stmt::Set(one) => {
                if let (Expr::Var(variable), Some(end)) = (&one.target, self.loops.last()) {
                    self.in_loops.push((variable.id.to_owned(), range(one.target.span()), *end));
                }
                self.bind([&one.target]);
                self.expression(&one.expr);
            }
            Stmt::SetBlock(one) => {
                self.bind([&one.target]);
                self.ends.push((one.target.span().end_offset as usize, format!("|{FITS}")));
                self.expressions(&one.filter);
                self.statements(&one.body);
            }
            Stmt::AutoEscape(one) => {
                self.expression(&one.enabled);
                self.statements(&one.body);
            }
            Stmt::FilterBlock(one) => {
                self.expression(&one.filter);
                self.statements(&one.body);
            }
            Stmt::Block(one) => self.statements(&one.body),
            Stmt::Import(one) => {
                self.bind([&one.name]);
                self.expression(&one.expr);
            }
            Stmt::FromImport(one) => {
                self.bind(one.names.iter().map(|(name, alias)| alias.as_ref().unwrap_or(name)));
                self.expression(&one.expr);
            }
            Stmt::Extends(one) => self.expression(&one.name),
            Stmt::Include(one) => self.expression(&one.name),
            Stmt::Macro(one) => {
                self.names.bound.insert(one.name.to_owned());
                self.bind(&one.args);
                self.expressions(&one.defaults);
                self.statements(&one.body);
            }
            Stmt::CallBlock(one) => {
                self.bind(&one.macro_decl.args);
                self.arguments(&one.call.args);
                self.expressions(&one.macro_decl.defaults);
                self.statements(&one.macro_decl.body);
            }
            Stmt::Do(one) => self.arguments(&one.call.args),
            Stmt::EmitRaw(_) => {}
        }
    }

    fn expressions<'e, 'a: 'e>(&mut self, list: impl IntoIterator<Item = &'e Expr<'a>>) {
        list.into_iter().for_each(|one| self.expression(one));
    }

    fn arguments(&mut self, list: &[CallArg<'_>]) {
        for one in list {
            let (CallArg::Pos(one)
            | CallArg::Kwarg(_, one)
            | CallArg::PosSplat(one)
            | CallArg::KwargSplat(one)) = one;
            self.expression(one);
        }
    }

    fn call(&mut self, one: &Spanned<Call<'_>>) {
        self.structure.call(one);
        self.expression(&one.expr);
        self.arguments(&one.args);
    }

    /// Adds size checks to the elements of a container, since its size is the sum of all of them.
    fn elements(&mut self, list: &[Expr<'_>]) {
        for one in list {
            if matches!(one, Expr::Var(_) | Expr::GetAttr(_) | Expr::GetItem(_)) {
                self.wrap(one, FITS);
            }
            self.expression(one);
        }
    }

    fn expression(&mut self, one: &Expr<'_>) {
        self.link(one, 0);
    }

    /// Adds size checks to an expression. `unchecked` is the number of operators since the last check in its chain.
    fn link(&mut self, one: &Expr<'_>, unchecked: usize) {
        match one {
            Expr::Const(_) => {}
            Expr::Var(variable) => self.names.uses.push((variable.id.to_owned(), range(one.span()))),
            Expr::UnaryOp(one) => self.expression(&one.expr),
            Expr::BinOp(operation) => {
                let mut links = 0;
                if grows(one) {
                    let checked = unchecked.is_multiple_of(LINKS);
                    if checked {
                        self.wrap(one, FITS);
                    }
                    links = unchecked + 1;
                }
                if matches!(operation.op, BinOpKind::Mul) {
                    for side in [&operation.left, &operation.right] {
                        if !is_number(side) {
                            self.wrap(side, FACTOR);
                        }
                    }
                    links = 0;
                }
                if matches!(operation.op, BinOpKind::In) {
                    self.wrap(&operation.right, SEEN);
                }
                self.comparison(&operation.left, operation.op, &operation.right);
                self.link(&operation.left, links);
                self.expression(&operation.right);
            }
            Expr::Compare(one) => {
                self.expression(&one.expr);
                let mut left = &one.expr;
                for each in &one.ops {
                    let operator = match each.op {
                        CompareOpKind::Eq => Some(BinOpKind::Eq),
                        CompareOpKind::Ne => Some(BinOpKind::Ne),
                        CompareOpKind::In | CompareOpKind::NotIn => Some(BinOpKind::In),
                        _ => None,
                    };
                    operator.into_iter().for_each(|one| self.comparison(left, one, &each.expr));
                    left = &each.expr;
                    if matches!(each.op, CompareOpKind::In | CompareOpKind::NotIn) {
                        self.wrap(&each.expr, SEEN);
                    }
                    self.expression(&each.expr);
                }
            }
            Expr::Slice(one) => {
                self.wrap(&one.expr, SEEN);
                self.expression(&one.expr);
                self.expressions(one.start.iter().chain(&one.stop).chain(&one.step));
            }
            Expr::IfExpr(one) => {
                self.expressions([&one.test_expr, &one.true_expr]);
                self.expressions(&one.false_expr);
            }
            Expr::Filter(one) => {
                self.expressions(&one.expr);
                self.arguments(&one.args);
            }
            Expr::Test(one) => {
                if one.name == "in"
                    && let Some(CallArg::Pos(container)) = one.args.first()
                {
                    self.wrap(container, SEEN);
                }
                self.expression(&one.expr);
                self.arguments(&one.args);
            }
            Expr::GetAttr(one) => self.expression(&one.expr),
            Expr::GetItem(one) => {
                self.wrap(&one.expr, INDEXED);
                self.expressions([&one.expr, &one.subscript_expr]);
            }
            Expr::Call(call) => {
                if !matches!(&call.expr, Expr::Var(name) if PLAIN_FUNCTIONS.contains(&name.id)) {
                    self.wrap(one, FITS);
                }
                self.call(call);
            }
            Expr::List(one) => self.elements(&one.items),
            Expr::Tuple(one) => self.elements(&one.items),
            Expr::Map(one) => {
                self.elements(&one.keys);
                self.elements(&one.values);
            }
        }
    }
}

fn range(span: Span) -> Range<usize> {
    span.start_offset as usize..span.end_offset as usize
}

/// The byte offset of the start of an expression. The span that minijinja records covers only the last link of a chain
/// such as `a.b.c`.
fn start(one: &Expr<'_>) -> usize {
    match one {
        Expr::Filter(filter) => filter.expr.as_ref().map_or(one.span().start_offset as usize, start),
        Expr::Test(one) => start(&one.expr),
        Expr::GetAttr(one) => start(&one.expr),
        Expr::GetItem(one) => start(&one.expr),
        Expr::Slice(one) => start(&one.expr),
        Expr::Call(one) => start(&one.expr),
        Expr::IfExpr(one) => start(&one.true_expr),
        _ => one.span().start_offset as usize,
    }
}

/// Returns `true` if an operation can create a string or list larger than its operands.
fn grows(one: &Expr<'_>) -> bool {
    let Expr::BinOp(one) = one else { return false };
    match one.op {
        BinOpKind::Concat => true,
        BinOpKind::Add => !is_number(&one.left) && !is_number(&one.right),
        BinOpKind::Mul => !is_number(&one.left) || !is_number(&one.right),
        _ => false,
    }
}

/// Returns `true` if the expression can only have a numeric value.
fn is_number(one: &Expr<'_>) -> bool {
    use BinOpKind::{Div, FloorDiv, Pow, Rem, Sub};
    match one {
        Expr::Const(one) => one.value.is_number(),
        Expr::BinOp(one) => matches!(one.op, Div | FloorDiv | Pow | Rem | Sub),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::FITS;
    use crate::jinja::{filters, guard};

    #[test]
    fn what_makes_larger_values_is_checked() {
        for (text, checked) in [
            ("{% set a = b ~ c %}", "{% set a = __fits(b ~ c) %}"),
            ("{%- set a -%}x{% endset %}", "{%- set a|__fits -%}x{% endset %}"),
            ("{% set ns.a | upper %}x{% endset %}", "{% set ns.a|__fits | upper %}x{% endset %}"),
            ("{% set a = [b, [c.d], 1] %}", "{% set a = [__fits(b), [__fits(c.d)], 1] %}"),
            ("{% set a, b = c, d %}", "{% set a, b = __fits(c), __fits(d) %}"),
            ("{% for k in m(x) %}{% endfor %}", "{% for k in __fits(m(x)) %}{% endfor %}"),
            (
                "{% for k in range(4) %}{{ m(k) }}{% endfor %}",
                "{% for k in range(4) %}{{ m(k) }}{% endfor %}",
            ),
            ("{% macro m(a, b=c ~ d) %}{% endmacro %}", "{% macro m(a, b=__fits(c ~ d)) %}{% endmacro %}"),
            ("{% with a = b * 2 %}{% endwith %}", "{% with a = __fits(__factor(b) * 2) %}{% endwith %}"),
            ("{% if a in b %}{% endif %}", "{% if a in __seen(b) %}{% endif %}"),
            ("{% for %}{% for in %}{% for k %}", "{% for %}{% for in %}{% for k %}"),
        ] {
            assert_eq!(super::prepare(text).text, checked);
        }
    }

    #[test]
    fn offsets_map_back_across_insertions() {
        let text = "A{% set x = 1 + y %}B{%- for i in r + r -%}C{% endfor %}";
        let prepared = super::prepare(text);
        assert!(prepared.text.len() > text.len());
        for (at, character) in prepared.text.char_indices().filter(|(_, one)| one.is_ascii_uppercase()) {
            assert_eq!(text.as_bytes()[prepared.original(at)] as char, character, "at {at}");
        }
        assert_eq!(prepared.original(prepared.text.len()), text.len());
    }

    /// Renders a template with and without the size checks.
    fn both(text: &str) -> [Result<String, minijinja::ErrorKind>; 2] {
        let guarded = super::prepare(text).text;
        [guarded.as_str(), text].map(|text| {
            guard::begin();
            filters::environment().render_str(text, ()).map_err(|error| error.kind())
        })
    }

    #[test]
    fn guarded_expressions_have_the_values_that_they_had() {
        let operands = [
            "a",
            "(a)",
            "b.c",
            "b['c']",
            "(a ~ a)",
            "l[0]",
            "(l + l)[1]",
            "l[1:][0]",
            "n|abs",
            "(n + 1)|abs",
            "-n",
            "2",
            "(n if n is odd else 4)",
            "'x' 'y'",
            "m(n)",
            "(l|length)",
            "n is odd",
            "l|join('-')",
            "[n, n * 2]",
            "(n, n)",
        ];
        let operators =
            ["~", "+", "*", "in", "not in", "-", "==", "and", "~ a ~", "+ n +", "* n *", "~ 2 * n ~"];
        let before = "{% set a = 'x' %}{% set n = 3 %}{% set l = [1, 2] %}{% set b = {'c': 'd'} %}\
                      {% macro m(x) %}{{ x * 2 }}{% endmacro %}";
        let mut written = 0;
        for left in operands {
            for right in operands {
                for operator in operators {
                    let text = format!(
                        "{before}{{{{ ({left} {operator} {right})|join(',') if ({left} {operator} {right}) is not string else {left} {operator} {right} }}}}"
                    );
                    let [guarded, plain] = both(&text);
                    assert_eq!(guarded, plain, "{left} {operator} {right}");
                    written += usize::from(plain.is_ok());
                }
            }
        }
        assert!(written > 500, "{written}");
    }

    #[test]
    fn a_chain_is_checked_every_few_links() {
        let text = format!("{{{{ {} }}}}", vec!["a"; 100].join(" ~ "));
        let guarded = super::prepare(&text).text;
        assert_eq!(guarded.matches(FITS).count(), 7);
    }
}
