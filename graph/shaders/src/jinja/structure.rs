//! Parts of a template that other templates refer to: blocks, macros, and what it extends, includes and imports.

use std::ops::Range;

use minijinja::machinery::ast::{CallArg, Expr, Spanned, Stmt};

/// The parts of a template by which it fits to others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Structure {
    /// The template that this one extends; `None` without a tag `extends`, or if its template is computed.
    pub(crate) extends: Option<String>,
    /// Whether some `extends` is computed, or stands in another tag.
    pub(crate) extends_any: bool,
    /// The names of included templates that are written as literals.
    pub(crate) includes: Vec<String>,
    pub(crate) blocks: Vec<Block>,
    pub(crate) macros: Vec<Macro>,
    pub(crate) imports: Vec<Import>,
    pub(crate) calls: Vec<Call>,
    /// Text behind `extends` and outside of blocks, which is never written.
    pub(crate) dropped: Vec<Range<usize>>,
}

/// A `block` tag.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) name: String,
    /// The byte range of the name.
    pub(crate) range: Range<usize>,
    /// Whether the block stands in another block.
    pub(crate) is_nested: bool,
}

/// A `macro` tag.
#[derive(Clone, Debug)]
pub(crate) struct Macro {
    pub(crate) name: String,
    pub(crate) arguments: Vec<String>,
    /// The number of arguments without a default.
    pub(crate) required: usize,
    pub(crate) range: Range<usize>,
}

/// A name in a tag `{% from "FILE" import NAME %}`.
#[derive(Clone, Debug)]
pub(crate) struct Import {
    pub(crate) template: String,
    pub(crate) name: String,
    pub(crate) range: Range<usize>,
}

/// A call of a function or macro by its name, without `*` arguments.
#[derive(Clone, Debug)]
pub(crate) struct Call {
    pub(crate) name: String,
    pub(crate) positional: usize,
    pub(crate) named: Vec<String>,
    pub(crate) range: Range<usize>,
}

impl Structure {
    /// Reads the parts from the syntax tree of a template with the source `text`.
    pub(super) fn of(template: &Stmt<'_>, text: &str) -> Self {
        let mut reader = Reader { text, structure: Self::default(), depth: 0, blocks: 0 };
        if let Stmt::Template(template) = template {
            reader.statements(&template.children);
        }
        reader.structure
    }

    /// Records a call.
    pub(super) fn call(&mut self, call: &Spanned<minijinja::machinery::ast::Call<'_>>) {
        let Expr::Var(name) = &call.expr else { return };
        let is_spread = |one: &CallArg<'_>| matches!(one, CallArg::PosSplat(_) | CallArg::KwargSplat(_));
        if call.args.iter().any(is_spread) {
            return;
        }
        let named = call.args.iter().filter_map(|one| match one {
            CallArg::Kwarg(name, _) => Some((*name).to_owned()),
            _ => None,
        });
        let named: Vec<String> = named.collect();
        self.calls.push(Call {
            name: name.id.to_owned(),
            positional: call.args.len() - named.len(),
            named,
            range: name.span().start_offset as usize..name.span().end_offset as usize,
        });
    }
}

struct Reader<'t> {
    text: &'t str,
    structure: Structure,
    /// The number of tags around a statement.
    depth: usize,
    /// The number of blocks around a statement.
    blocks: usize,
}

impl Reader<'_> {
    fn statements(&mut self, list: &[Stmt<'_>]) {
        list.iter().for_each(|one| self.statement(one));
    }

    fn inside(&mut self, list: &[Stmt<'_>]) {
        self.depth += 1;
        self.statements(list);
        self.depth -= 1;
    }

    fn statement(&mut self, one: &Stmt<'_>) {
        match one {
            Stmt::Template(one) => self.statements(&one.children),
            Stmt::ForLoop(one) => {
                self.inside(&one.body);
                self.inside(&one.else_body);
            }
            Stmt::IfCond(one) => {
                self.inside(&one.true_body);
                self.inside(&one.false_body);
            }
            Stmt::WithBlock(one) => self.inside(&one.body),
            Stmt::AutoEscape(one) => self.inside(&one.body),
            Stmt::FilterBlock(one) => self.inside(&one.body),
            Stmt::Block(one) => {
                let range = range(one.span());
                self.structure.blocks.push(Block {
                    name: one.name.to_owned(),
                    range: self.name_in(range, "block", one.name),
                    is_nested: self.blocks > 0,
                });
                self.blocks += 1;
                self.inside(&one.body);
                self.blocks -= 1;
            }
            Stmt::Extends(one) => match literal(&one.name) {
                Some(name) if self.depth == 0 && self.structure.extends.is_none() => {
                    self.structure.extends = Some(name);
                }
                _ => self.structure.extends_any = true,
            },
            Stmt::Include(one) => self.structure.includes.extend(literal(&one.name)),
            Stmt::FromImport(one) => {
                let Some(template) = literal(&one.expr) else { return };
                for (name, _) in &one.names {
                    let Expr::Var(name) = name else { continue };
                    self.structure.imports.push(Import {
                        template: template.clone(),
                        name: name.id.to_owned(),
                        range: range(name.span()),
                    });
                }
            }
            Stmt::Macro(one) => {
                let names = one.args.iter().map(|argument| match argument {
                    Expr::Var(name) => name.id.to_owned(),
                    _ => String::new(),
                });
                self.structure.macros.push(Macro {
                    name: one.name.to_owned(),
                    arguments: names.collect(),
                    required: one.args.len().saturating_sub(one.defaults.len()),
                    range: range(one.span()),
                });
                // The text of a macro is written where it is called.
                self.blocks += 1;
                self.inside(&one.body);
                self.blocks -= 1;
            }
            Stmt::EmitRaw(one) if self.structure.extends.is_some() && self.blocks == 0 => {
                self.structure.dropped.push(range(one.span()));
            }
            _ => {}
        }
    }

    /// The byte range of the name behind a keyword in a tag; the range itself if the name is not found.
    fn name_in(&self, range: Range<usize>, keyword: &str, name: &str) -> Range<usize> {
        let found = self.text.get(range.start..).and_then(|text| {
            let behind = text.find(keyword)? + keyword.len();
            Some(range.start + behind + text[behind..].find(name)?)
        });
        found.map_or(range, |start| start..start + name.len())
    }
}

fn literal(one: &Expr<'_>) -> Option<String> {
    match one {
        Expr::Const(one) => one.value.as_str().map(str::to_owned),
        _ => None,
    }
}

fn range(span: minijinja::machinery::Span) -> Range<usize> {
    span.start_offset as usize..span.end_offset as usize
}
