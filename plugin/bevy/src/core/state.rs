//! Component that reports the state of a sheet.

use bevy::prelude::*;
use sheetwork::sheet::{Sheet as SheetInWorld, Status};

/// State of a sheet after the last tick.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetState {
    /// Centre of mass in world space, m.
    pub centre: Vec3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Number of nodes that touched a body in the last step.
    pub contacts: u32,
    /// Whether the sheet sleeps.
    pub asleep: bool,
    /// Whether the sheet is unstable and stopped, or frozen by the recovery policy.
    pub unstable: bool,
    /// Lowest and highest temperature, °C; `None` without heat sources.
    pub temperature: Option<(f32, f32)>,
}

impl SheetState {
    pub(super) fn from_sheet(sheet: &SheetInWorld) -> Self {
        Self {
            centre: sheet.centre_of_mass().as_vec3(),
            velocity: (sheet.momentum() / sheet.total_mass()).as_vec3(),
            contacts: sheet.touching().iter().filter(|t| **t).count() as u32,
            asleep: sheet.state.status == Status::Asleep,
            unstable: matches!(sheet.state.status, Status::Unstable { .. } | Status::Frozen { .. }),
            temperature: sheet.heat().map(|h| h.range()).map(|(low, high)| (low as f32, high as f32)),
        }
    }
}
