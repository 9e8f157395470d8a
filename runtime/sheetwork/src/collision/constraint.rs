//! Contact constraints, the interface between collision detection and the contact solver.
//!
//! A constraint joins a point of a sheet (a combination of nodes) to a point of a body or of a
//! sheet. With n the unit normal from b to a and o the contact offset, its gap is
//!
//!   g = n·(x_a - x_b) - o   (m)
//!
//! and the contact condition is g ≥ 0. Detection creates constraints independently of stiffness;
//! the solver is independent of shapes.

use glam::DVec3;

/// A point of a sheet: up to three nodes with weights that sum to 1. Unused entries have weight 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetPoint {
    /// Node indices.
    pub nodes: [u32; 3],
    /// Weights of the nodes.
    pub weights: [f64; 3],
}

impl SheetPoint {
    /// The point at node `i`.
    pub fn node(i: u32) -> Self {
        Self { nodes: [i; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// Nodes with nonzero weight, and their weights.
    pub fn terms(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.nodes.iter().copied().zip(self.weights).filter(|(_, w)| *w != 0.0)
    }

    /// Position of the point with the nodes at `x`, m.
    pub fn position(&self, x: &crate::math::Vectors) -> DVec3 {
        self.terms().map(|(i, w)| x.get(i as usize) * w).sum()
    }
}

/// One side of a contact constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactSide {
    /// A point of a sheet.
    Sheet {
        /// Index of the sheet in the detection input.
        sheet: u32,
        /// Point on the sheet.
        point: SheetPoint,
    },
    /// A point of a body.
    Body {
        /// Index of the body in the detection input.
        body: u32,
        /// Point in the frame of the body, m.
        local: DVec3,
    },
}

/// Key of a contact constraint, constant over iterations, stages and steps. The contact cache
/// stores forces by key, and constraints with equal violation are ordered by key. It consists of
/// the keys of two features, each unique in the detection input.
pub type ContactKey = [u64; 2];

/// A contact constraint that is active or may become active within the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactConstraint {
    /// Side to which the normal points.
    pub a: ContactSide,
    /// Side from which the normal points.
    pub b: ContactSide,
    /// Unit normal from b to a, world axes.
    pub normal: DVec3,
    /// Distance along the normal at which the two sides touch, m.
    pub offset: f64,
    /// Key of the constraint.
    pub key: ContactKey,
    /// Coulomb friction coefficient of the pair.
    pub friction: f64,
    /// Restitution coefficient of the pair.
    pub restitution: f64,
    /// Bond force f of an explicit integrator, N: the normal contact force is at least -f.
    pub bond: f64,
    /// Velocity of the middle between two bodies that compress a sheet relative to side b, m/s. The
    /// gap is then held at 0 without slip.
    pub compressed: Option<DVec3>,
}
