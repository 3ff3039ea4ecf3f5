//! Methods that set one field of a value.

/// Declares builder methods named after fields. Each method takes `self` and returns it with the field replaced.
///
/// ```
/// #[derive(Default)]
/// struct Sun { lux: f32, name: String }
///
/// impl Sun {
///     umbragraph_text::setters! {
///         /// Sets the illuminance in lux.
///         lux: f32,
///     }
///     umbragraph_text::setters! { into
///         /// Sets the name of the light.
///         name: String,
///     }
/// }
/// assert_eq!(Sun::default().lux(3.0).name("noon").name, "noon");
/// ```
#[macro_export]
macro_rules! setters {
    ($($(#[$of_field:meta])* $field:ident: $of:ty,)*) => {$(
        $(#[$of_field])*
        #[must_use]
        pub fn $field(self, $field: $of) -> Self {
            Self { $field, ..self }
        }
    )*};
    (into $($(#[$of_field:meta])* $field:ident: $of:ty,)*) => {$(
        $(#[$of_field])*
        #[must_use]
        pub fn $field(self, $field: impl Into<$of>) -> Self {
            Self { $field: $field.into(), ..self }
        }
    )*};
}
