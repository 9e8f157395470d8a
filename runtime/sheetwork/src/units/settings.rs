//! Declaration of settings: constants of the numerics, each with unit, reason and value in one
//! place.

/// Declare structs of settings. Each field has its value; `DEFAULT` of a struct holds them all.
macro_rules! settings {
    ($($(#[$meta:meta])* pub struct $name:ident {
        $($(#[$field_meta:meta])* pub $field:ident: $type:ty = $value:expr,)+
    })+) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $type,)+
        }

        impl $name {
            /// Settings in use.
            pub const DEFAULT: Self = Self { $($field: $value,)+ };
        }
    )+};
}

pub(crate) use settings;
