//! Where members of a block have to lie, as a user says, held to where the shader has them.
//!
//! A block of values is laid out by the struct of the shader. Who has a layout given from elsewhere moves members by
//! `@size` of the member before; what is said here finds the one that is not where it should be.

use std::collections::BTreeMap;

use super::{Evaluate, PassBuilder};
use crate::diagnostic::{codes, suggested_name};
use crate::document;
use crate::shader::{Member, TypeLayout};

impl PassBuilder<'_> {
    /// Holds the members of a block to offsets; `None` after a diagnostic.
    pub(super) fn block_offsets(
        &mut self,
        layout: &TypeLayout,
        offsets: &BTreeMap<String, u32>,
        at: &str,
        template: &str,
    ) -> Option<()> {
        let TypeLayout::Struct { members, .. } = layout else { return Some(()) };
        let mut placed: Vec<(&Member, u32)> = Vec::new();
        let mut fine = true;
        for (name, offset) in offsets {
            let Some(member) = members.iter().find(|member| member.name == *name) else {
                let known = members.iter().map(|member| member.name.as_str());
                let help = match suggested_name(name, known.clone()) {
                    Some(suggested) => format!("did you mean \"{suggested}\"?"),
                    None => format!("it has {}", known.collect::<Vec<_>>().join(", ")),
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
                self.misplaced(
                    at,
                    name,
                    message,
                    format!("write {below} or {}", below.saturating_add(align)),
                );
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
            let before =
                members.iter().filter(|other| other.offset < member.offset).max_by_key(|other| other.offset);
            let room = before.map(|before| (before, wanted.saturating_sub(before.offset)));
            let help = match room {
                Some((before, room)) if room >= before.layout.size() => {
                    format!("write @size({room}) before \"{}\" in the template", before.name)
                }
                _ => "change the order of the members in the template".to_owned(),
            };
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
