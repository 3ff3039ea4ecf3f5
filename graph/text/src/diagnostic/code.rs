//! Stable codes of diagnostics, each with the page that explains it.

/// A stable code: `UG` and four digits for the project's own, any other prefix for an integrator's node kinds.
///
/// The title says in a few words what kind of diagnostic it is; the page, in Markdown, says why it is one, shows an
/// example and the way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Code {
    /// `UG0101`.
    pub id: &'static str,
    /// A few words, lower case.
    pub title: &'static str,
    /// The explanation, in Markdown.
    pub page: &'static str,
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id)
    }
}

/// Declares a table of codes: one constant each, and `ALL` with every one of them in the order of declaration.
///
/// ```
/// umbragraph_text::codes! {
///     /// A noise texture of a size that is no power of two.
///     NOISE_SIZE = "NOISE1", "noise size", "Noise textures tile only at powers of two.";
/// }
/// assert_eq!(ALL, &[NOISE_SIZE]);
/// ```
#[macro_export]
macro_rules! codes {
    ($($(#[$meta:meta])* $name:ident = $id:literal, $title:literal, $page:expr;)*) => {
        $($(#[$meta])* pub const $name: $crate::diagnostic::Code =
            $crate::diagnostic::Code { id: $id, title: $title, page: $page };)*
        /// Every code of this table.
        pub const ALL: &[$crate::diagnostic::Code] = &[$($name),*];
    };
}
