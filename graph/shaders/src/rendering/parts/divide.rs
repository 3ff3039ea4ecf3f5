//! The places at which a template is taken apart.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, Mutex};

use minijinja::machinery::ast::{Expr, Stmt};
use minijinja::machinery::{Span, parse};

use super::{Part, Parts, Step};
use crate::jinja::scan::{Scan, TagKind, WordKind, scan, syntax};
use crate::rendering::templates::TemplateSet;

/// The maximum depth of nested includes that are divided.
const MAX_DEPTH: usize = 16;

/// Divides a template into parts; `None` if it cannot be divided.
pub(super) fn divide(set: &TemplateSet, template: &str) -> Option<Parts> {
    let mut division =
        Division { set, parts: Parts::default(), definitions: Vec::new(), depth: 0, known: BTreeMap::new() };
    let steps = division.template(template, &BTreeMap::new())?;
    Some(Parts { steps, ..division.parts })
}

/// A template tag that assigns variables, such as `set`. Its source is repeated before each part that uses one of these
/// variables.
struct Definition {
    source: String,
    binds: BTreeSet<String>,
    mentions: BTreeSet<String>,
}

struct Division<'s> {
    set: &'s TemplateSet,
    parts: Parts,
    definitions: Vec<Definition>,
    depth: usize,
    known: BTreeMap<String, Arc<Words>>,
}

/// The variable names in a template, without those of included templates.
#[derive(Default)]
struct Words {
    binds: BTreeSet<String>,
    mentions: BTreeSet<String>,
    /// The names of the templates that are included, imported or extended.
    reaches: BTreeSet<String>,
}

/// Overriding blocks by block name: the overriding template, and the block's byte range there.
type Overrides = BTreeMap<String, (String, Range<usize>)>;

/// A template that is being divided.
struct Open<'t> {
    name: &'t str,
    text: &'t str,
    scan: &'t Scan,
}

impl Open<'_> {
    /// The byte range of the template tag at byte `offset`, or else of the last tag before it; `None` without such a
    /// tag.
    fn tag_at(&self, offset: usize) -> Option<&Range<usize>> {
        let behind = self.scan.tags.partition_point(|tag| tag.range.start <= offset);
        Some(&self.scan.tags.get(behind.checked_sub(1)?)?.range)
    }

    /// The byte range of a template statement, including its start and end tags.
    fn range(&self, span: Span) -> Option<Range<usize>> {
        let (start, end) = (span.start_offset as usize, span.end_offset as usize);
        Some(self.tag_at(start)?.start..self.tag_at(end.saturating_sub(1))?.end)
    }
}

impl Division<'_> {
    fn template(&mut self, name: &str, overrides: &Overrides) -> Option<Vec<Step>> {
        let template = self.set.templates.get(name).filter(|template| template.broken.is_none())?;
        let text = &template.prepared.text;
        let scan = scan(text);
        let open = Open { name, text, scan: &scan };
        let Ok(Stmt::Template(root)) = parse(text, name, syntax()) else { return None };
        // Blocks by another way than their place, and variables that are changed from elsewhere.
        let mentions = self.mentions(text);
        if ["super", "self", "namespace"].into_iter().any(|word| mentions.contains(word)) {
            return None;
        }
        let extended = root.children.iter().find_map(|child| match child {
            Stmt::Extends(extends) => Some(&extends.name),
            _ => None,
        });
        let Some(extended) = extended else { return self.body(&root.children, &open, overrides) };
        let base = constant(extended)?;
        let (mut steps, mut overrides) = (Vec::new(), overrides.clone());
        for child in &root.children {
            match child {
                Stmt::Extends(_) => {}
                Stmt::Block(block) => {
                    let range = open.range(block.span())?;
                    let is_nested = open.tags(range.clone(), "block") > 1;
                    if is_nested {
                        return None;
                    }
                    let here = || (name.to_owned(), range);
                    overrides.entry(block.name.to_owned()).or_insert_with(here);
                }
                // Its text goes nowhere.
                _ => {
                    let mut quiet = Vec::new();
                    self.statement(child, &open, &Overrides::new(), &mut quiet)?;
                    steps.extend(quiet.into_iter().filter_map(silent));
                }
            }
        }
        self.deeper(|division| division.template(base, &overrides)).map(|rest| {
            steps.extend(rest);
            steps
        })
    }

    fn deeper<T>(&mut self, work: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let done = work(self);
        self.depth -= 1;
        done
    }

    fn body(&mut self, all: &[Stmt<'_>], open: &Open<'_>, overrides: &Overrides) -> Option<Vec<Step>> {
        let mut steps = Vec::new();
        for one in all {
            self.statement(one, open, overrides, &mut steps)?;
        }
        Some(steps)
    }

    fn statement(
        &mut self,
        one: &Stmt<'_>,
        open: &Open<'_>,
        overrides: &Overrides,
        steps: &mut Vec<Step>,
    ) -> Option<()> {
        let span = match one {
            Stmt::EmitRaw(raw) => {
                match steps.last_mut() {
                    Some(Step::Literal(literal)) => literal.push_str(raw.raw),
                    _ => steps.push(Step::Literal(raw.raw.to_owned())),
                }
                return Some(());
            }
            Stmt::Include(include) if !include.ignore_missing => {
                let known = constant(&include.name).filter(|name| self.can_include(name));
                if let Some(name) = known {
                    let included = self.deeper(|division| division.template(name, &Overrides::new()))?;
                    steps.extend(included);
                    return Some(());
                }
                include.span()
            }
            Stmt::Block(block) => {
                let outer = self.definitions.len();
                match overrides.get(block.name) {
                    Some((template, range)) => steps.extend(self.overriding(template, range.clone())?),
                    None => steps.extend(self.body(&block.body, open, overrides)?),
                }
                // A block is a scope.
                self.definitions.truncate(outer);
                return Some(());
            }
            Stmt::IfCond(branch) => {
                let range = open.range(branch.span())?;
                if self.binds(&open.text[range.clone()]).is_empty() {
                    let tag = open.tag_at(range.start)?.clone();
                    let tag = &open.text[tag];
                    let keyword = tag.find(|each: char| each.is_ascii_alphabetic())?;
                    let (before, condition) = tag.split_at(keyword);
                    // `elif` begins a branch of its own.
                    let condition = condition.strip_prefix("el").unwrap_or(condition);
                    let condition = self.part(open, &format!("{before}{condition}1{{% endif %}}"));
                    let then = self.body(&branch.true_body, open, overrides)?;
                    let otherwise = self.body(&branch.false_body, open, overrides)?;
                    steps.push(Step::Branch { condition, then, otherwise });
                    return Some(());
                }
                branch.span()
            }
            Stmt::Include(include) => include.span(),
            Stmt::EmitExpr(one) => one.span(),
            Stmt::ForLoop(one) => one.span(),
            Stmt::WithBlock(one) => one.span(),
            Stmt::Set(one) => one.span(),
            Stmt::SetBlock(one) => one.span(),
            Stmt::AutoEscape(one) => one.span(),
            Stmt::FilterBlock(one) => one.span(),
            Stmt::Import(one) => one.span(),
            Stmt::FromImport(one) => one.span(),
            Stmt::Macro(one) => one.span(),
            Stmt::CallBlock(one) => one.span(),
            Stmt::Do(one) => one.span(),
            Stmt::Extends(_) | Stmt::Template(_) => return None,
        };
        let range = open.range(span)?;
        if !overrides.is_empty() && open.tags(range.clone(), "block") > 0 {
            return None;
        }
        let source = &open.text[range];
        let binds = self.binds(source);
        steps.push(Step::Part(self.part(open, source)));
        if !binds.is_empty() {
            let mentions = self.mentions(source);
            let is_silent = matches!(
                one,
                Stmt::Set(_) | Stmt::SetBlock(_) | Stmt::Import(_) | Stmt::FromImport(_) | Stmt::Macro(_)
            );
            let source = if is_silent {
                source.to_owned()
            } else {
                format!("{{% set __written %}}{source}{{% endset %}}")
            };
            self.definitions.push(Definition { source, binds, mentions });
        }
        Some(())
    }

    /// Divides the content of a block that overrides one of an extended template. `range` is the byte range of the
    /// block.
    fn overriding(&mut self, template: &str, range: Range<usize>) -> Option<Vec<Step>> {
        let text = &self.set.templates.get(template)?.prepared.text;
        let scan = scan(text);
        let Ok(Stmt::Template(root)) = parse(text, template, syntax()) else { return None };
        let open = Open { name: template, text, scan: &scan };
        let block = root.children.iter().find_map(|child| match child {
            Stmt::Block(block) if open.range(block.span()) == Some(range.clone()) => Some(block),
            _ => None,
        })?;
        self.body(&block.body, &open, &Overrides::new())
    }

    fn can_include(&self, name: &str) -> bool {
        let template = self.set.templates.get(name);
        template.is_some_and(|template| {
            let text = &template.prepared.text;
            let scan = scan(text);
            let open = Open { name, text, scan: &scan };
            template.broken.is_none() && open.tags(0..text.len(), "extends") == 0
        })
    }

    /// Adds a part: a piece of the template, preceded by the definitions of the variables that it uses. Returns the
    /// index of the part.
    fn part(&mut self, open: &Open<'_>, source: &str) -> usize {
        let mut mentions = self.mentions(source);
        let mut before = Vec::new();
        for each in self.definitions.iter().rev() {
            if !each.binds.is_disjoint(&mentions) {
                mentions.extend(each.mentions.iter().cloned());
                before.push(each.source.as_str());
            }
        }
        let source = before.into_iter().rev().chain([source]).collect();
        self.parts.parts.push(Part { template: open.name.to_owned(), source, known: Mutex::default() });
        self.parts.parts.len() - 1
    }

    /// The names of the variables that a piece of a template assigns for later pieces, itself or in templates that it
    /// includes.
    fn binds(&mut self, source: &str) -> BTreeSet<String> {
        self.all(source).iter().flat_map(|words| words.binds.iter().cloned()).collect()
    }

    /// The identifiers that occur in a piece of a template or in templates that it includes.
    fn mentions(&mut self, source: &str) -> BTreeSet<String> {
        self.all(source).iter().flat_map(|words| words.mentions.iter().cloned()).collect()
    }

    /// The names in a piece of a template, and separately those in each template that it includes, imports or extends,
    /// directly or indirectly.
    fn all(&mut self, source: &str) -> Vec<Arc<Words>> {
        let first = self.words(source);
        let mut open: Vec<String> = first.reaches.iter().cloned().collect();
        let mut seen = BTreeSet::new();
        let mut all = vec![Arc::new(first)];
        while let Some(name) = open.pop() {
            if !seen.insert(name.clone()) {
                continue;
            }
            let words = match self.known.get(&name) {
                Some(known) => known.clone(),
                None => {
                    let template = self.set.templates.get(&name);
                    let words = template.map(|template| self.words(&template.prepared.text));
                    let words = Arc::new(words.unwrap_or_default());
                    self.known.insert(name, words.clone());
                    words
                }
            };
            open.extend(words.reaches.iter().cloned());
            all.push(words);
        }
        all
    }

    fn words(&self, text: &str) -> Words {
        let scan = scan(text);
        let open = Open { name: "", text, scan: &scan };
        let mut words = Words::default();
        bound(text, &mut words.binds);
        words.mentions = open.words().map(str::to_owned).collect();
        for tag in &scan.tags {
            if !matches!(tag.keyword(text), Some("include" | "import" | "from" | "extends")) {
                continue;
            }
            let texts = tag.words.iter().filter(|word| word.kind == WordKind::Text);
            let written = texts.filter_map(|word| text.get(word.range.clone()));
            let mut known = written
                .map(|written| written.trim_matches(['"', '\'']))
                .filter(|name| self.set.templates.contains_key(*name))
                .peekable();
            // A name that is computed can be any.
            if known.peek().is_none() {
                words.reaches.extend(self.set.templates.keys().cloned());
            }
            words.reaches.extend(known.map(str::to_owned));
        }
        words
    }
}

impl Open<'_> {
    /// Iterates over the identifiers in all tags of the template.
    fn words(&self) -> impl Iterator<Item = &str> {
        let words = self.scan.tags.iter().flat_map(|tag| &tag.words);
        let words = words.filter(|word| word.kind == WordKind::Identifier);
        words.filter_map(|word| self.text.get(word.range.clone()))
    }

    /// The number of block tags with this keyword in a byte range.
    fn tags(&self, range: Range<usize>, keyword: &str) -> usize {
        let inside = self.scan.tags.iter().filter(|tag| {
            range.start <= tag.range.start && tag.range.end <= range.end && tag.kind == TagKind::Block
        });
        inside.filter(|tag| tag.keyword(self.text) == Some(keyword)).count()
    }
}

/// Collects the names that a template assigns in its outermost scope. Loops, `with`, blocks and macros have their own
/// scopes.
fn bound(text: &str, names: &mut BTreeSet<String>) {
    fn of(all: &[Stmt<'_>], names: &mut BTreeSet<String>) {
        for one in all {
            match one {
                Stmt::Set(set) => target(&set.target, names),
                Stmt::SetBlock(set) => {
                    target(&set.target, names);
                    of(&set.body, names);
                }
                Stmt::Macro(one) => drop(names.insert(one.name.to_owned())),
                Stmt::Import(import) => target(&import.name, names),
                Stmt::FromImport(import) => {
                    import
                        .names
                        .iter()
                        .for_each(|(name, alias)| target(alias.as_ref().unwrap_or(name), names));
                }
                Stmt::IfCond(branch) => {
                    of(&branch.true_body, names);
                    of(&branch.false_body, names);
                }
                Stmt::AutoEscape(one) => of(&one.body, names),
                Stmt::FilterBlock(one) => of(&one.body, names),
                _ => {}
            }
        }
    }
    fn target(one: &Expr<'_>, names: &mut BTreeSet<String>) {
        match one {
            Expr::Var(variable) => drop(names.insert(variable.id.to_owned())),
            Expr::GetAttr(attribute) => target(&attribute.expr, names),
            Expr::List(list) => list.items.iter().for_each(|item| target(item, names)),
            Expr::Tuple(list) => list.items.iter().for_each(|item| target(item, names)),
            _ => {}
        }
    }
    if let Ok(Stmt::Template(root)) = parse(text, "", syntax()) {
        of(&root.children, names);
    }
}

/// Converts a step so that its parts are still rendered, but write nothing. `None` for literal text, which needs no
/// rendering.
fn silent(step: Step) -> Option<Step> {
    match step {
        Step::Part(part) => Some(Step::Branch { condition: part, then: Vec::new(), otherwise: Vec::new() }),
        Step::Branch { condition, then, otherwise } => {
            let silence = |steps: Vec<Step>| steps.into_iter().filter_map(silent).collect();
            Some(Step::Branch { condition, then: silence(then), otherwise: silence(otherwise) })
        }
        Step::Literal(_) => None,
    }
}

/// The value of a string literal; `None` for any other expression.
fn constant<'e>(one: &'e Expr<'_>) -> Option<&'e str> {
    match one {
        Expr::Const(constant) => constant.value.as_str(),
        _ => None,
    }
}
