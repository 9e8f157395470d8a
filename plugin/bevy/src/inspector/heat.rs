//! Controls of heat sources by the parameters of the running world: surroundings, oven, heaters,
//! heat gun, hot bodies; and the temperatures of the sheets.

use bevy_egui::egui::{Grid, RichText, Ui};
use sheetwork::Parameter;

use super::ParameterAccess;
use super::controls::{ControlOptions, PLAIN, name, parameter_row};
use super::style::quiet;
use super::units::{DisplayUnit, Quantity};

/// Prefixes of the parameter paths of heat sources.
const HEATS: [&str; 7] =
    ["oven.", "heaters.", "heat_gun.", "bodies.", "ambient_temperature", "convection", "time_lapse"];

/// Switches and numbers of all heat sources, and the temperatures of the sheets. Returns whether
/// there are any.
pub fn heat_sources(ui: &mut Ui, access: &mut dyn ParameterAccess) -> bool {
    let all = access.world().parameters();
    let of_heat = |path: &str| HEATS.iter().any(|h| path.starts_with(h));
    let all: Vec<_> = all.into_iter().filter(|p| of_heat(&p.path)).collect();
    Grid::new("warmth").num_columns(2).show(ui, |ui| {
        for parameter in &all {
            let title = parameter.path.replace(['_', '.'], " ");
            let about = format!("Parameter {}, {}", parameter.path, parameter.unit);
            match (parameter.value.parse::<f64>(), parameter.value.parse::<bool>()) {
                (Ok(now), _) => {
                    let (row, shown) = ((&*title, &*about, &*parameter.path), shown(parameter));
                    parameter_row(ui, access, row, now, shown, &ControlOptions::default());
                }
                (_, Ok(mut on)) => {
                    let label = name(ui, &title, &about);
                    if ui.checkbox(&mut on, "").labelled_by(label.id).changed() {
                        access.set(&parameter.path, if on { "1" } else { "0" });
                    }
                    ui.end_row();
                }
                _ => {}
            }
        }
    });
    let sheets = access.world().sheets().iter().filter_map(|s| Some((s.name.as_str(), s.heat()?.range())));
    let mut some = !all.is_empty();
    for (sheet, (low, high)) in sheets {
        some = true;
        ui.horizontal(|ui| {
            ui.label(RichText::new(sheet).color(quiet(ui)));
            ui.monospace(format!("{low:.1} to {high:.1} °C"));
        });
    }
    some
}

/// Display unit of a parameter.
fn shown(parameter: &Parameter) -> DisplayUnit {
    Quantity::from_unit(parameter.unit).map_or(PLAIN, |quantity| DisplayUnit::fixed(quantity, parameter.unit, 1.0))
}
