//! Contact of single nodes with kinematic and static bodies, for explicit integrators. A node
//! responds alone, by impact and friction, without a contact solver.
//!
//! `detection` runs the steps, `clearance` skips distant nodes, `target` tests a node's path
//! against a collider, `response` computes impact and friction, `through_thickness` shares impacts
//! between layers, `flexion` holds the flexion limit of sheets that have one, `bonding` records the
//! contacts of adhesive sheets, `drawn_contact` adds those of the drawn surface.

pub(crate) mod bonding;
pub(crate) mod clearance;
pub mod detection;
pub(crate) mod drawn_contact;
pub(crate) mod flexion;
pub mod response;
pub(crate) mod target;
pub mod through_thickness;
