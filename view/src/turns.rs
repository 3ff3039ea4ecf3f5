//! The choices of the inspector by key: each key goes to the next choice, and from the last to the first. Versions end
//! at the last.

use umbragraph::Plan;
use umbragraph::low_level::report::Report;

use crate::app::Viewer;
use crate::buffers::{layouts, size_of};
use crate::choices::{Look, Parts, Side, comparable};
use crate::graph::Selected;
use crate::inspector::versions;

/// A choice of the inspector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    Version,
    Side,
    Against,
    AgainstVersion,
    Mip,
    Layer,
    Sample,
    Aspect,
    Channel,
    Tile,
    Range,
    Declaration,
}

impl Viewer {
    /// Goes `by` steps further in a choice of the inspected resource; nothing happens if it has no such choice.
    pub(crate) fn turn(&mut self, turn: Turn, by: isize) {
        let (Some(plan), Some(report)) = (&self.stage.plan, &self.report) else { return };
        let Some(Selected::Resource(_)) = &self.inspector.selected else { return };
        let contents = &mut self.inspector.contents;
        let was_stencil = contents.look.is_stencil;
        match turn {
            Turn::Range => contents.turn_range(),
            Turn::Tile => contents.look.tile = cycled(contents.look.tile, contents.tiles.len(), by),
            turn => turned(&mut contents.look, turn, by, plan, report),
        }
        if contents.look.is_stencil != was_stencil {
            contents.forget();
        }
    }
}

fn turned(look: &mut Look, turn: Turn, by: isize, plan: &Plan, report: &Report) {
    let parts = Parts::of(plan, &look.name);
    let is_buffer = size_of(plan, &look.name).is_some();
    match turn {
        Turn::Version => {
            let versions = versions(report, &look.name);
            let at = versions.iter().position(|one| Some(one) == look.pass.as_ref());
            if let Some(version) = at.and_then(|at| versions.get(at.checked_add_signed(by)?)) {
                look.pass = Some(version.clone());
            }
        }
        Turn::Side => {
            let at = Side::ALL.iter().position(|one| one.0 == look.side).unwrap_or(0);
            look.side = Side::ALL[wrapped(at, Side::ALL.len(), by)].0;
            if look.side == Side::Before && look.other().is_none() {
                look.side = Side::ALL[wrapped(1, Side::ALL.len(), by)].0;
            }
        }
        Turn::Against => {
            let names: Vec<&String> = comparable(plan, report, is_buffer).collect();
            let at = look.against.as_ref().and_then(|(name, _)| names.iter().position(|one| *one == name));
            let name = cycled(at, names.len(), by).map(|at| names[at].clone());
            look.against = name.map(|name| (name.clone(), versions(report, &name).pop()));
        }
        Turn::AgainstVersion => {
            if let Some((name, pass)) = &mut look.against {
                let versions = versions(report, name);
                let at = versions.iter().position(|one| Some(one) == pass.as_ref()).unwrap_or(0);
                *pass = versions.get(wrapped(at, versions.len(), by)).cloned();
            }
        }
        Turn::Declaration if is_buffer => {
            look.layout = wrapped(look.layout, layouts(plan, &look.name).len(), by);
        }
        Turn::Mip => look.mip = wrapped(look.mip as usize, parts.mips as usize, by) as u32,
        Turn::Layer if parts.layers(look.mip) > 1 => {
            let at = look.layer.map(|layer| layer as usize);
            look.layer = cycled(at, parts.layers(look.mip) as usize, by).map(|layer| layer as u32);
        }
        Turn::Sample => look.sample = wrapped(look.sample as usize, parts.samples as usize, by) as u32,
        Turn::Aspect => look.is_stencil = parts.has_both_aspects && !look.is_stencil,
        Turn::Channel if !is_buffer => look.channel = cycled(look.channel, 4, by),
        Turn::Declaration | Turn::Layer | Turn::Channel | Turn::Tile | Turn::Range => {}
    }
}

/// The index `by` steps after another, around the end; 0 if there are none.
fn wrapped(at: usize, count: usize, by: isize) -> usize {
    (at as isize + by).rem_euclid(count.max(1) as isize) as usize
}

/// The choice `by` steps after another, where `None` (all of them) comes before the first.
fn cycled(at: Option<usize>, count: usize, by: isize) -> Option<usize> {
    wrapped(at.map_or(0, |at| at + 1), count + 1, by).checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_go_around_and_begin_with_all() {
        assert_eq!([None, Some(0), Some(1)].map(|at| cycled(at, 2, 1)), [Some(0), Some(1), None]);
        assert_eq!([None, Some(0)].map(|at| cycled(at, 2, -1)), [Some(1), None]);
        assert_eq!([wrapped(2, 3, 1), wrapped(0, 3, -1), wrapped(0, 0, 1)], [0, 2, 0]);
    }
}
