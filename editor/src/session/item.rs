//! Items of a scene that can be moved by hand.

use glam::DVec3;

/// Something that can be carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A sheet of the scene, by number.
    Sheet(usize),
    /// A body of the scene, by number.
    Body(usize),
    /// A heater of the scene, by number.
    Heater(usize),
    /// The nozzle of the heat gun.
    HeatGun,
}

/// What is on its way and has not arrived.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub(super) item: Item,
    /// Where it was shown when it was taken, and how far it is from there, m.
    pub(super) from: DVec3,
    pub(super) by: DVec3,
}
