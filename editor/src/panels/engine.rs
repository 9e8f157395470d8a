//! Controls of the integrator, its step, gravity, air and wind, and default contact parameters.

use bevy_egui::egui::{Grid, Ui};
use bevy_sheetwork::inspector::controls::{ControlOptions, PLAIN, parameter_row};
use bevy_sheetwork::inspector::{cost, engine as rows};
use sheetwork::ParameterId;

use crate::session::Session;

/// Integrator, step, substeps, tolerance, gravity, air, wind, default friction and restitution.
pub fn engine(ui: &mut Ui, session: &mut Session) {
    Grid::new("engine").num_columns(2).show(ui, |ui| {
        // A scene opened with linear damping keeps the control.
        let factor = session.scene().air.factor < 1.0 || session.document().opened().air.factor < 1.0;
        rows(ui, session, factor);
        surfaces(ui, session);
    });
    cost(ui, session);
}

/// Default friction and restitution.
fn surfaces(ui: &mut Ui, session: &mut Session) {
    let (friction, restitution) = (session.scene().contact.friction, session.scene().contact.restitution);
    let about = "Coulomb friction coefficient of sheets and bodies without their own";
    let how = ControlOptions::usual(ParameterId::ContactFriction).on_release();
    parameter_row(ui, session, ("Default friction", about, "contact.friction"), friction, PLAIN, &how);
    let about = "Coefficient of restitution of sheets and bodies without their own";
    parameter_row(ui, session, ("Default restitution", about, "contact.restitution"), restitution, PLAIN, &how);
}
