//! Stable codes of diagnostics, each with the page that explains it.

/// A stable diagnostic code with its explanation. Codes of this project are `UG` and four digits; node kinds that other
/// projects add use other prefixes.
///
/// The title names the kind of diagnostic in a few words. The page explains in Markdown why the diagnostic is reported,
/// often with an example and a remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Code {
    /// The code, such as `UG0101`.
    pub id: &'static str,
    /// The kind of diagnostic in a few words, in lower case.
    pub title: &'static str,
    /// The explanation, in Markdown.
    pub page: &'static str,
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id)
    }
}

/// Declares diagnostic codes as constants, and `ALL`, a slice of them in the order of declaration.
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
        /// All codes of this table, in the order of declaration.
        pub const ALL: &[$crate::diagnostic::Code] = &[$($name),*];
    };
}
