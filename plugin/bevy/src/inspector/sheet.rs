//! Controls of a sheet's behaviour: damping, drag, friction, restitution, pressure, stiffness
//! between layers, bending limit.

use bevy_egui::egui::Ui;
use sheetwork::ParameterId as Id;
use sheetwork::sheet::inter_layer;

use super::ParameterAccess;
use super::controls::{ControlOptions, DEGREES, PLAIN, parameter_control, parameter_row, usual_row};
use super::units::{DisplayUnit, Quantity};

/// Rows of the parameters of sheet `index` that can change at run time, material aside, in a grid
/// of two columns.
pub fn behaviour(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    damping(ui, access, index);
    contact(ui, access, index);
    inter_layer_stiffness(ui, access, index);
    flexion_limit(ui, access, index);
}

fn damping(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    let Some(sheet) = access.world().sheets().get(index) else { return };
    let (follows, ratio, damping, drag) =
        (sheet.follows_material(), sheet.damping_ratio(), sheet.damping(), sheet.drag());
    let path = |name: &str| format!("sheets.{index}.{name}");
    if follows {
        let about = "Damping ratio of the slowest bending mode; faster modes are damped more";
        usual_row(ui, access, ("Damping", about, &path("damping_ratio")), ratio, PLAIN, Id::DampingRatio);
    } else {
        let about = "Dashpots along the springs, as a fraction of critical damping";
        usual_row(ui, access, ("Damping", about, &path("damping")), damping, PLAIN, Id::Damping);
    }
    if access.world().air().density > 0.0 {
        let about = "Drag coefficient for air across the sheet";
        usual_row(ui, access, ("Drag", about, &path("drag.0")), drag.0, PLAIN, Id::DragAcross);
        let about = "Drag coefficient for air along the sheet";
        usual_row(ui, access, ("… along", about, &path("drag.1")), drag.1, PLAIN, Id::DragAlong);
    }
}

fn contact(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    let Some(sheet) = access.world().sheets().get(index) else { return };
    let (friction, restitution, pressure) = (sheet.parameters.friction, sheet.parameters.restitution, sheet.pressure());
    let path = |name: &str| format!("sheets.{index}.{name}");
    let about = "Coulomb friction coefficient of the sheet; a contact uses the mean of both surfaces";
    usual_row(ui, access, ("Friction", about, &path("friction")), friction, PLAIN, Id::Friction);
    let about = "Ratio of separation to approach speed";
    usual_row(ui, access, ("Restitution", about, &path("restitution")), restitution, PLAIN, Id::Restitution);
    let about = "Pressure difference from the upper to the lower side, Pa; positive for a vacuum below";
    let shown = DisplayUnit::fixed(Quantity::Pressure, "Pa", 1.0);
    parameter_row(ui, access, ("Pressure", about, &path("pressure")), pressure, shown, &ControlOptions::speed(0.2));
}

/// Stiffness of the springs between layers, for lattices whose springs are not calibrated.
fn inter_layer_stiffness(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    let Some(sheet) = access.world().sheets().get(index) else { return };
    let Some(now) = inter_layer::stiffness(sheet) else { return };
    let path = format!("sheets.{index}.inter_layer_stiffness");
    let about = "Stiffness of the springs between layers, N/m: it resists bending and holds the layers apart";
    let shown = DisplayUnit::fixed(Quantity::Stiffness, "N/m", 1.0);
    usual_row(ui, access, ("Between layers", about, &path), now, shown, Id::InterLayerStiffness);
}

/// Bending angle limit, for structures with flexion springs.
fn flexion_limit(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    let Some(sheet) = access.world().sheets().get(index) else { return };
    let Some(largest) = sheet.largest_flexion_angle() else { return };
    let (limit, path) = (sheet.flexion_angle_limit(), format!("sheets.{index}.flexion_limit"));
    let mut limited = limit.is_some();
    let check = ui.checkbox(&mut limited, "Bend limit").on_hover_text("Largest bending angle of a flexion spring");
    if check.changed() {
        let value = if limited { largest.clamp(30.0, 180.0).to_string() } else { "none".to_owned() };
        access.set(&path, &value);
    }
    match limit {
        Some(now) => {
            ui.horizontal(|ui| {
                let label = ui.weak("at");
                parameter_control(ui, access, &label, &path, now, DEGREES, &ControlOptions::usual(Id::FlexionLimit));
            });
        }
        None => {
            ui.weak(format!("bends to {largest:.1}° now"));
        }
    }
    ui.end_row();
}
