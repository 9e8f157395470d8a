//! Classes of the springs of a lattice: their role in the structure.

use serde::{Deserialize, Serialize};

/// Role of a spring in its structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SpringClass {
    /// Along x in a layer.
    X,
    /// Along z in a layer.
    Z,
    /// Diagonal in a layer, towards larger x with larger z.
    Diagonal,
    /// Diagonal in a layer, towards smaller x with larger z.
    AntiDiagonal,
    /// Between neighbouring layers.
    Inter,
    /// Provot's flexion spring: second neighbours along x or z, in a triangular layer along
    /// x and the slanting lines.
    Flexion,
    /// Second neighbours along a line of springs.
    CrossOver,
}

impl SpringClass {
    /// All classes.
    pub const ALL: [Self; 7] =
        [Self::X, Self::Z, Self::Diagonal, Self::AntiDiagonal, Self::Inter, Self::Flexion, Self::CrossOver];

    /// Name in files.
    pub fn name(self) -> &'static str {
        ["x", "z", "diagonal", "anti-diagonal", "inter", "flexion", "cross-over"][self as usize]
    }

    /// The class with this name in files.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }
}
