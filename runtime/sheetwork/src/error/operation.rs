//! Errors of the operations of scenes and worlds, by kind.
//!
//! Each variant carries the [`InputError`] with field, file, line and problem. The errors
//! dereference to it, display as it does, and convert to it.

use std::fmt;
use std::ops::Deref;

use crate::error::InputError;

/// Error of reading or overriding a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    File(InputError),
    /// The text is not RON, or has an unknown field or a value of another type.
    Syntax(InputError),
    /// An override is of a field that does not exist.
    UnknownField(InputError),
    /// A value is out of range, of another unit or type, or contradicts another value.
    Value(InputError),
}

/// Error of building a world or one of its objects.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// A file that the description names cannot be read or is invalid.
    File(InputError),
    /// The description is invalid.
    Description(InputError),
    /// The world has no bodies of its own to add to.
    Refused(InputError),
}

/// Error of reading or setting a parameter of a running world.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterError {
    /// The world has no parameter of this path.
    UnknownPath(InputError),
    /// The unit is unknown or of another quantity.
    WrongUnit(InputError),
    /// The text is no value of the parameter's kind.
    WrongKind(InputError),
    /// The number is out of range.
    OutOfRange(InputError),
    /// The object does not accept the value in its present state.
    Refused(InputError),
}

/// Error of restoring a snapshot.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The bytes are no snapshot, or are cut off or damaged.
    Damaged(InputError),
    /// The snapshot is of another version of the format.
    Version(InputError),
    /// The snapshot is of other sheets or bodies than those of the world.
    OtherWorld(InputError),
}

/// Implement the traits of an error whose variants all carry an [`InputError`].
macro_rules! carries_input_error {
    ($($name:ident: $($variant:ident)|+;)+) => {$(
        impl Deref for $name {
            type Target = InputError;

            fn deref(&self) -> &InputError {
                match self {
                    $(Self::$variant(error))|+ => error,
                }
            }
        }

        impl From<$name> for InputError {
            fn from(error: $name) -> Self {
                match error {
                    $($name::$variant(error))|+ => error,
                }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&**self, f)
            }
        }

        impl std::error::Error for $name {}

        impl $name {
            /// Change the carried error and keep the kind.
            #[allow(dead_code)]
            pub(crate) fn map(self, change: impl FnOnce(InputError) -> InputError) -> Self {
                match self {
                    $(Self::$variant(error) => Self::$variant(change(error)),)+
                }
            }
        }
    )+};
}

carries_input_error! {
    SceneError: File | Syntax | UnknownField | Value;
    BuildError: File | Description | Refused;
    ParameterError: UnknownPath | WrongUnit | WrongKind | OutOfRange | Refused;
    SnapshotError: Damaged | Version | OtherWorld;
}

impl From<InputError> for BuildError {
    fn from(error: InputError) -> Self {
        if error.file.is_some() { Self::File(error) } else { Self::Description(error) }
    }
}
