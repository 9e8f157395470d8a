//! Measurements of the simulation in Bevy's `DiagnosticsStore`.

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

use crate::core::{SheetClock, SheetState, SheetWorld, SheetworkSet, SheetworkWritten};

/// Plugin that measures the simulation in every tick.
///
/// ```
/// # use bevy::{diagnostic::DiagnosticsStore, prelude::*};
/// # use bevy_sheetwork::prelude::*;
/// fn show(diagnostics: Res<DiagnosticsStore>) {
///     let time = diagnostics.get(&SheetworkDiagnosticsPlugin::STEP_TIME);
///     let time = time.and_then(|d| d.smoothed());
///     println!("the sheets take {time:?} ms a tick");
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkDiagnosticsPlugin;

impl SheetworkDiagnosticsPlugin {
    /// Wall-clock time of the world's steps in a tick, ms.
    pub const STEP_TIME: DiagnosticPath = DiagnosticPath::const_new("sheetwork/step_time");
    /// Number of nodes of all sheets.
    pub const NODES: DiagnosticPath = DiagnosticPath::const_new("sheetwork/masses");
    /// Number of nodes that touched a body in the last step.
    pub const CONTACTS: DiagnosticPath = DiagnosticPath::const_new("sheetwork/contacts");
    /// Number of sheets that do not sleep.
    pub const AWAKE: DiagnosticPath = DiagnosticPath::const_new("sheetwork/awake");
    /// Kinetic, elastic and potential energy of all sheets, J.
    pub const ENERGY: DiagnosticPath = DiagnosticPath::const_new("sheetwork/energy");
    /// Smallest delivered bending stiffness of a sheet, % of the requested one
    /// ([`Sheet::delivered_stiffness`](sheetwork::sheet::Sheet::delivered_stiffness)). Absent while
    /// no sheet requests a stiffness.
    pub const STIFFNESS: DiagnosticPath = DiagnosticPath::const_new("sheetwork/stiffness");
    /// Time since the start that was not simulated because frames took too long, s.
    pub const TIME_LOST: DiagnosticPath = DiagnosticPath::const_new("sheetwork/time_lost");
}

impl Plugin for SheetworkDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        app.register_diagnostic(Diagnostic::new(Self::STEP_TIME).with_suffix("ms"))
            .register_diagnostic(Diagnostic::new(Self::NODES).with_max_history_length(1))
            .register_diagnostic(Diagnostic::new(Self::CONTACTS))
            .register_diagnostic(Diagnostic::new(Self::AWAKE))
            .register_diagnostic(Diagnostic::new(Self::ENERGY).with_suffix("J"))
            .register_diagnostic(Diagnostic::new(Self::STIFFNESS).with_suffix("%"))
            .register_diagnostic(Diagnostic::new(Self::TIME_LOST).with_suffix("s").with_max_history_length(1))
            .add_systems(FixedUpdate, measure.in_set(SheetworkSet::Writeback).after(SheetworkWritten));
    }
}

fn measure(mut diagnostics: Diagnostics, world: Res<SheetWorld>, clock: Res<SheetClock>, states: Query<&SheetState>) {
    type Paths = SheetworkDiagnosticsPlugin;
    if clock.due() > 0.0 {
        diagnostics.add_measurement(&Paths::STEP_TIME, || world.step_time().as_secs_f64() * 1e3);
    }
    diagnostics.add_measurement(&Paths::NODES, || world.sheets().iter().map(|s| s.node_count()).sum::<usize>() as f64);
    diagnostics.add_measurement(&Paths::CONTACTS, || f64::from(states.iter().map(|s| s.contacts).sum::<u32>()));
    diagnostics.add_measurement(&Paths::AWAKE, || states.iter().filter(|s| !s.asleep).count() as f64);
    let gravity = world.gravity();
    diagnostics.add_measurement(&Paths::ENERGY, || world.sheets().iter().map(|s| s.energy(gravity).total).sum());
    let delivered = world.sheets().iter().filter_map(|s| s.delivered_stiffness(world.dt()));
    if let Some(least) = delivered.map(|d| d.bends_as_pa / d.asked_pa).min_by(f64::total_cmp) {
        diagnostics.add_measurement(&Paths::STIFFNESS, || 100.0 * least);
    }
    diagnostics.add_measurement(&Paths::TIME_LOST, || clock.time_lost());
}
