//! What touches what: the rows of a contact problem.
//!
//! A contact joins a point of a sheet (a combination of masses) to a point of a body or of a sheet. With n the unit normal
//! from b to a and o the distance at which the surfaces touch, its gap is
//!
//!   g = n·(x_a - x_b) - o   (m)
//!
//! and contact wants g ≥ 0. Detection makes rows and knows nothing of stiffness; the solver knows nothing of shapes.

use glam::DVec3;

/// A point of a sheet: up to three masses with weights that sum to 1; entries that are not used have weight 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetPoint {
    /// The masses.
    pub masses: [u32; 3],
    /// Their weights.
    pub weights: [f64; 3],
}

impl SheetPoint {
    /// Mass `i` itself.
    pub fn mass(i: u32) -> Self {
        Self { masses: [i; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// The masses that count, with their weights.
    pub fn terms(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.masses.iter().copied().zip(self.weights).filter(|(_, w)| *w != 0.0)
    }

    /// Its place when the masses are at `x`, m.
    pub fn of(&self, x: &crate::math::Vectors) -> DVec3 {
        self.terms().map(|(i, w)| x.get(i as usize) * w).sum()
    }
}

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// A point of sheet number `sheet` of the problem.
    Sheet {
        /// Which sheet.
        sheet: u32,
        /// Where on it.
        point: SheetPoint,
    },
    /// A point of body number `body` of the problem.
    Body {
        /// Which body.
        body: u32,
        /// Where on it, in the frame of the body, m.
        local: DVec3,
    },
}

/// What names a contact from one iteration, stage and step to the next: impulses are remembered by it, and equal violations
/// are put in order by it. Two features, each as a number unique among the features of the problem.
pub type Key = [u64; 2];

/// A contact that is there or may be within the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The side that the normal points to.
    pub a: Side,
    /// The side that the normal comes from.
    pub b: Side,
    /// Direction from b to a, unit, in the world.
    pub normal: DVec3,
    /// Distance along the normal at which the two touch, m.
    pub offset: f64,
    /// Its name.
    pub key: Key,
    /// Coulomb friction coefficient of the pair.
    pub friction: f64,
    /// Restitution coefficient of the pair.
    pub restitution: f64,
}
