//! The shader templates of umbragraph, embedded.
//!
//! Each `NAME.wgsl.jinja` of this folder is a template, and `NAME.axes.json` beside it declares what it varies in. They
//! are data: this crate has no code, so that a host which brings its own templates need not carry it.

/// Every file: its name below this folder, with `/`, and its text; sorted by name.
pub const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/files.rs"));

#[cfg(test)]
mod tests {
    use super::FILES;

    #[test]
    fn every_declaration_of_axes_has_its_template() {
        for (name, _) in FILES.iter().filter(|(name, _)| name.ends_with(".axes.json")) {
            let template = name.replace(".axes.json", ".wgsl.jinja");
            assert!(FILES.iter().any(|(other, _)| *other == template), "{name} has no {template}");
        }
    }

    #[test]
    fn names_are_sorted_and_use_forward_slashes() {
        assert!(FILES.iter().is_sorted());
        assert!(FILES.iter().all(|(name, _)| !name.contains('\\')));
    }
}
