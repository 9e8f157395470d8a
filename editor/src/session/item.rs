//! Items of a scene that can be moved by hand.

use glam::DVec3;

/// Item that can be moved by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// Sheet of the scene, by index.
    Sheet(usize),
    /// Body of the scene, by index.
    Body(usize),
    /// Heater of the scene, by index.
    Heater(usize),
    /// Nozzle of the heat gun.
    HeatGun,
}

/// Item that is being moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovedItem {
    pub(super) item: Item,
    /// Displayed position at the grab, and displacement from there, m.
    pub(super) from: DVec3,
    pub(super) by: DVec3,
}
