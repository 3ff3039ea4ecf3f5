//! The text of a random graph: its passes under shuffled keys, with what orders every two accesses of one subresource
//! range of which one writes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::*;

impl Graph {
    /// The text, with what is seen in the end.
    pub(super) fn written(&mut self, random: &mut Random) -> String {
        let mut observed: Vec<Unit> =
            (0..self.resources.len()).flat_map(|at| self.resources[at].units(at)).collect();
        let written = |unit: &Unit| {
            let states = self.passes.iter().filter(|pass| pass.writes.contains(unit)).map(Pass::states);
            states.fold(0, |all, states| all | states) == ALL_STATES
                || self.resources[unit.resource].lifetime == Lifetime::Persistent
        };
        observed.retain(written);
        while observed.len() > OBSERVED || observed.len() > 2 && random.one_in(4) {
            observed.remove(random.below(observed.len()));
        }
        let first_observer = self.passes.len();
        for (layer, unit) in observed.iter().enumerate() {
            let read = Read { unit: *unit, when: When::Now };
            let picture = Unit { resource: usize::MAX, mip: 0, at: layer };
            self.add(None, vec![picture], Deed::Copy(vec![read]));
        }
        let mut entries: Vec<String> =
            (0..self.passes.len()).map(|at| self.entry(random, at, at >= first_observer)).collect();
        random.shuffle(&mut entries);
        let mut resources = String::new();
        for resource in &self.resources {
            let lifetime = match resource.lifetime {
                Lifetime::Transient => "",
                Lifetime::Persistent => r#", "lifetime": "persistent""#,
                Lifetime::History => r#", "lifetime": "history", "initial": [0, 0, 0, 1]"#,
            };
            let _ = match resource.is_buffer {
                true => write!(
                    resources,
                    r#""{}": {{ "buffer": {{ "size": {} {lifetime} }} }},"#,
                    resource.name,
                    4 * QUARTER
                ),
                false => write!(
                    resources,
                    r#""{}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "mips": {}, "layers": {} {lifetime} }} }},"#,
                    resource.name, resource.mips, resource.layers
                ),
            };
        }
        let toggles: Vec<String> = (0..TOGGLES)
            .filter(|toggle| {
                self.passes.iter().any(|pass| pass.toggle.is_some_and(|(other, _)| other == *toggle))
            })
            .map(|toggle| format!(r#""s{toggle}": {{ "default": true }}"#))
            .collect();
        format!(
            "{{ \"format\": 1, \"name\": \"test\", \"toggles\": {{ {} }},\n\"resources\": {{ {resources}\n\"target\": {{ \
             \"texture\": {{ \"format\": \"rgba8unorm\", \"size\": \"=viewport\", \"layers\": {OBSERVED}, \
             \"lifetime\": \"imported\" }} }} }},\n\"passes\": {{\n{}\n}} }}",
            toggles.join(", "),
            entries.join(",\n")
        )
    }

    /// The passes before one that write a unit, the last one last.
    pub(super) fn writers(&self, unit: &Unit, before: usize) -> Vec<usize> {
        (0..before).filter(|at| self.passes[*at].writes.contains(unit)).collect()
    }

    /// One pass, with what orders it.
    fn entry(&self, random: &mut Random, at: usize, is_observer: bool) -> String {
        let pass = &self.passes[at];
        let mut after: BTreeSet<usize> = BTreeSet::new();
        let mut names: Vec<String> = Vec::new();
        // Several units of one reference have one version.
        let last = |read: &Read| self.writers(&read.unit, at).last().copied();
        let reads = pass.reads();
        let mut named = random.one_in(2);
        let is_one =
            matches!(pass.deed, Deed::Sum(_)) || reads.windows(2).all(|two| last(&two[0]) == last(&two[1]));
        for read in reads {
            if matches!(pass.deed, Deed::Sum(_)) {
                named = random.one_in(2);
            }
            let name = &self.resources[read.unit.resource].name;
            let writers = self.writers(&read.unit, at);
            let is_last =
                !(at + 1..self.passes.len()).any(|later| self.passes[later].writes.contains(&read.unit));
            names.push(match (read.when, writers.last()) {
                (When::Before, _) => format!("{name}@0"),
                (When::Back, _) => format!("{name}@-1"),
                (When::Now, Some(writer)) if !pass.loads() && is_one && named => {
                    format!("{name}@{}", self.passes[*writer].name)
                }
                (When::Now, _) if is_last && !pass.loads() && !named => name.clone(),
                (When::Now, None) => name.clone(),
                (When::Now, Some(_)) => {
                    after.extend(writers);
                    name.clone()
                }
            });
        }
        // What was written, or read, before it is written over.
        for unit in &pass.writes {
            after.extend(self.writers(unit, at));
            let reads = |earlier: &Pass| {
                earlier.reads().iter().any(|read| read.unit == *unit && read.when != When::Back)
            };
            after.extend((0..at).filter(|earlier| reads(&self.passes[*earlier])));
        }
        after.remove(&at);
        let mut text = format!("\"{}\": {{ ", pass.name);
        if !after.is_empty() {
            let list: Vec<String> = after.iter().map(|at| format!("\"{}\"", self.passes[*at].name)).collect();
            let _ = write!(text, "\"after\": [{}], ", list.join(", "));
        }
        if let Some((toggle, on)) = pass.toggle {
            let _ = write!(text, "\"toggle\": \"{}s{toggle}\", ", if on { "" } else { "!" });
        }
        let work = match is_observer {
            true => self.observer(pass, &names[0]),
            false => self.work(pass, &names),
        };
        text + &work + " }"
    }

    fn work(&self, pass: &Pass, names: &[String]) -> String {
        let to = pass.writes[0];
        let name = &self.resources[to.resource].name;
        let texel = |number: u32| format!("[\"={number} / 255\", 0, 0, 0]");
        let attached = |more: &str| {
            format!(r#""color": [{{ "to": "&{name}", "mip": {}, "layer": {} {more} }}]"#, to.mip, to.at)
        };
        let fill = |shader: &str, number: u32, more: &str| {
            format!(
                r#""fullscreen": {{ "shader": "{shader}.wgsl.jinja",
                "bind": {{ "settings": {{ "values": {{ "color": {} }} }} }}, {} }}"#,
                texel(number),
                attached(more)
            )
        };
        let bytes = |unit: &Unit, count: usize| {
            format!(r#""offset": {}, "size": {}"#, unit.at as u32 * QUARTER, count as u32 * QUARTER)
        };
        match &pass.deed {
            Deed::Fill(number) => fill("fill", *number, ""),
            Deed::FillLeft(number) => fill("left", *number, ""),
            Deed::Add(number) => fill("fill", *number, r#", "blend": "add""#),
            Deed::Sum(reads) => {
                let bound = |at: usize| {
                    let Unit { mip, at: layer, .. } = reads[at].unit;
                    format!(
                        r#"{{ "texture": {{ "name": "&{}", "mip": {mip}, "layer": {layer} }} }}"#,
                        names[at]
                    )
                };
                format!(
                    r#""fullscreen": {{ "shader": "add.wgsl.jinja", "bind": {{ "one": {}, "other": {} }}, {} }}"#,
                    bound(0),
                    bound(1),
                    attached("")
                )
            }
            Deed::Copy(reads) => {
                let end = |name: &str, unit: &Unit| match self.resources[unit.resource].is_buffer {
                    true => format!(r#"{{ "name": "&{name}", {} }}"#, bytes(unit, 1)),
                    false => format!(
                        r#"{{ "name": "&{name}", "mip": {}, "layer": {}, "layers": {} }}"#,
                        unit.mip,
                        unit.at,
                        reads.len()
                    ),
                };
                format!(
                    r#""copy": {{ "from": {}, "to": {} }}"#,
                    end(&names[0], &reads[0].unit),
                    end(name, &to)
                )
            }
            Deed::Zero => format!(r#""clear": {{ "buffer": "&{name}", {} }}"#, bytes(&to, pass.writes.len())),
            Deed::Bump(number) => format!(
                r#""compute": {{ "shader": "bump.wgsl.jinja", "workgroups": [1, 1, 1], "bind": {{
                "settings": {{ "values": {{ "number": {number} }} }},
                "words": {{ "buffer": {{ "name": "&{name}", {} }} }} }} }}"#,
                bytes(&to, 1)
            ),
        }
    }

    /// A pass that shows a unit in a layer of the picture.
    fn observer(&self, pass: &Pass, name: &str) -> String {
        let Deed::Copy(reads) = &pass.deed else { return String::new() };
        let Unit { resource, mip, at } = reads[0].unit;
        let to = format!(r#""color": [{{ "to": "&target", "layer": {} }}]"#, pass.writes[0].at);
        match self.resources[resource].is_buffer {
            true => format!(
                r#""fullscreen": {{ "shader": "word.wgsl.jinja", "bind": {{ "words": {{ "buffer": {{
                "name": "&{name}", "offset": {}, "size": {QUARTER} }} }} }}, {to} }}"#,
                at as u32 * QUARTER
            ),
            false => format!(
                r#""fullscreen": {{ "shader": "enlarge.wgsl.jinja", "bind": {{ "picture": {{ "texture": {{
                "name": "&{name}", "mip": {mip}, "layer": {at} }} }} }}, {to} }}"#
            ),
        }
    }
}
