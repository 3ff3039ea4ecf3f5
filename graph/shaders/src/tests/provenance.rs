//! The assumption about the template engine on which the map rests.

use std::io::Write;

use minijinja::Environment;

/// A sink that records for every write whether the bytes are part of `source` in memory.
struct Notes {
    source: std::ops::Range<usize>,
    parts: Vec<(bool, String)>,
}

impl Write for Notes {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let address = bytes.as_ptr() as usize;
        let inside = self.source.contains(&address) && address + bytes.len() <= self.source.end;
        self.parts.push((inside, String::from_utf8_lossy(bytes).into_owned()));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn the_engine_writes_literal_text_as_parts_of_the_template() {
    let mut environment = Environment::new();
    environment
        .add_template_owned("main", "one {{ two }} three\n{% if true %}\nfour {{ two ~ '!' }}{% endif %}\n{% raw %}{{ five }}{% endraw %}")
        .unwrap();
    let template = environment.get_template("main").unwrap();
    let start = template.source().as_ptr() as usize;
    let mut notes = Notes { source: start..start + template.source().len(), parts: Vec::new() };
    template.render_captured_to(minijinja::context! { two => "2" }, &mut notes).unwrap();
    let literal: Vec<&str> =
        notes.parts.iter().filter(|(inside, _)| *inside).map(|(_, text)| text.as_str()).collect();
    let computed: Vec<&str> =
        notes.parts.iter().filter(|(inside, _)| !*inside).map(|(_, text)| text.as_str()).collect();
    assert_eq!(
        literal,
        ["one ", " three\n", "\nfour ", "\n", "{{ five }}"],
        "minijinja no longer writes literal text as sub-slices of the template: text_map.rs has lost its ground"
    );
    assert_eq!(computed, ["2", "2!"]);
}
