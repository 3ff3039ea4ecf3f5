//! Declared offsets of a block's members, compared with those in the shader.
//!
//! A block of values is laid out by the struct of the shader. For who has a layout given from elsewhere (push constants
//! of an engine that is ported), the struct that has it is written out, with `@size` of the member before each gap.
//! Members without an offset follow those that have one.

use std::collections::BTreeMap;

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::program::{Program, ProgramBinding};
use crate::pipeline::settings::evaluate::Evaluate;
use umbragraph_shaders::{Member, TypeLayout};
use umbragraph_text::diagnostic::{codes, list_of, suggested_name};
use umbragraph_text::document;

impl PassBuilder<'_> {
    /// Checks that the members of a block lie at the declared byte offsets; returns `None` after a diagnostic.
    pub(super) fn block_offsets(
        &mut self,
        program: &Program,
        binding: &ProgramBinding,
        offsets: &BTreeMap<String, u32>,
        at: &str,
    ) -> Option<()> {
        let template = &program.template;
        let TypeLayout::Struct { name, members, .. } = binding.block.as_ref()? else { return Some(()) };
        let mut placed: Vec<(&Member, u32)> = Vec::new();
        let mut fine = true;
        for (name, offset) in offsets {
            let Some(member) = members.iter().find(|member| member.name == *name) else {
                let known = members.iter().map(|member| member.name.as_str());
                let help = match suggested_name(name, known.clone()) {
                    Some(suggested) => format!("did you mean \"{suggested}\"?"),
                    None => format!("it has {}", list_of(known)),
                };
                self.misplaced(at, name, format!("the block has no member \"{name}\""), help);
                fine = false;
                continue;
            };
            let align = member.layout.align();
            if !offset.is_multiple_of(align) {
                let spelling = member.layout.spelling();
                let message = format!(
                    "\"{name}\" cannot lie at byte {offset}: of {spelling} it is a multiple of {align}"
                );
                let below = offset / align * align;
                let help = format!("write {below} or {}", below.saturating_add(align));
                self.misplaced(at, name, message, help);
                fine = false;
                continue;
            }
            placed.push((member, *offset));
        }
        placed.sort_by_key(|(_, offset)| *offset);
        for pair in placed.windows(2) {
            let [(before, first), (member, offset)] = pair else { continue };
            let end = first.saturating_add(before.layout.size());
            if end > *offset {
                let message = format!(
                    "\"{}\" is to begin at byte {offset}, and \"{}\" ends at byte {end}",
                    member.name, before.name
                );
                self.misplaced(at, &member.name, message, format!("write {end} or more"));
                fine = false;
            }
        }
        if !fine {
            return None;
        }
        if let Some((member, wanted)) = placed.iter().find(|(member, wanted)| member.offset != *wanted) {
            let message = format!(
                "\"{}\" lies at byte {} in {template}, not at byte {wanted}",
                member.name, member.offset
            );
            let help = format!("write in {template}: {}", laid_out(name, members, &placed));
            self.misplaced(at, &member.name, message, help);
            // Those after it move with it.
            return None;
        }
        Some(())
    }

    fn misplaced(&mut self, at: &str, name: &str, message: String, help: String) {
        self.report(codes::BLOCK_MISMATCH, &document::pointer_join(at, name), message, help);
    }
}

/// The WGSL source of a struct whose members lie at given, ascending byte offsets, with padding between them.
fn laid_out(name: &str, members: &[Member], placed: &[(&Member, u32)]) -> String {
    let mut written = Vec::new();
    if let Some((_, first @ 1..)) = placed.first() {
        written.push(format!("@size({first}) reserved: u32"));
    }
    for (at, (member, offset)) in placed.iter().enumerate() {
        let gap = placed.get(at + 1).and_then(|(next, wanted)| {
            let natural = (offset + member.layout.size()).next_multiple_of(next.layout.align());
            (natural != *wanted).then(|| format!("@size({}) ", wanted - offset))
        });
        written.push(format!("{}{}: {}", gap.unwrap_or_default(), member.name, member.layout.spelling()));
    }
    let others = members.iter().filter(|member| placed.iter().all(|(other, _)| other.name != member.name));
    written.extend(others.map(|member| format!("{}: {}", member.name, member.layout.spelling())));
    format!("struct {name} {{ {} }}", written.join(", "))
}
