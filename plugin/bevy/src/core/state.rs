//! The component that reports the state of a sheet.

use bevy::prelude::*;
use sheetwork::sheet::{Sheet as SheetInWorld, Status};

/// How a sheet fares, brought up to date every tick.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetState {
    /// Centre of mass in world space, m.
    pub centre: Vec3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Masses that touched a body in the last step.
    pub contacts: u32,
    /// Whether it has come to rest and is not stepped until something wakes it.
    pub asleep: bool,
    /// Whether it went unstable and was stopped, or frozen before it did.
    pub unstable: bool,
    /// Coldest and hottest temperature, °C; none of a sheet that nothing heats.
    pub temperature: Option<(f32, f32)>,
}

impl SheetState {
    pub(super) fn of(sheet: &SheetInWorld) -> Self {
        Self {
            centre: sheet.centre_of_mass().as_vec3(),
            velocity: (sheet.momentum() / sheet.total_mass()).as_vec3(),
            contacts: sheet.touching().iter().filter(|t| **t).count() as u32,
            asleep: sheet.status == Status::Asleep,
            unstable: matches!(sheet.status, Status::Unstable { .. } | Status::Frozen { .. }),
            temperature: sheet.heat().map(|h| h.range()).map(|(low, high)| (low as f32, high as f32)),
        }
    }
}
