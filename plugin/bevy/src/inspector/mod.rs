//! Inspector (feature `inspector`): egui panels that display and change the sheets of a running
//! game.
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_sheetwork::prelude::*;
//! App::new().add_plugins((DefaultPlugins, SheetworkPlugins, SheetInspectorPlugin)).run();
//! ```
//!
//! An edit sets a parameter of the [`SheetWorld`] by [`World::set`](sheetwork::World::set) and acts
//! from the next step on; the components of the sheets are unchanged. The panels are functions of
//! [`ParameterAccess`] for use in other windows: the Sheetwork editor uses the same panels.

pub mod controls;
mod engine;
pub mod hang;
mod heat;
mod material;
mod parameter_access;
mod sheet;
pub mod style;

use bevy::prelude::*;
use bevy_egui::egui::{self, Grid, RichText, ScrollArea, Ui};
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass};

use crate::core::{SheetClock, SheetWorld};

pub use engine::engine;
pub use heat::heat_sources;
pub use material::{Previews, constants, cost, delivered, droop, strip_shape};
pub use parameter_access::{Changes, InspectedGame, ParameterAccess};
pub use sheet::behaviour;
pub use sheetwork::units;

use style::{ACCENT, quiet, readable};

/// Plugin with a window of the inspector's panels; adds [`EguiPlugin`] where it is missing. F10
/// shows and hides the window.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetInspectorPlugin;

impl Plugin for SheetInspectorPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        app.init_resource::<SheetInspector>();
        app.add_systems(EguiPrimaryContextPass, show.run_if(resource_exists::<SheetWorld>));
    }
}

/// State of the inspector.
#[derive(Resource, Clone, Debug)]
pub struct SheetInspector {
    /// Whether its window is open.
    pub shown: bool,
    /// Key that shows and hides the window; `None` for no key.
    pub key: Option<egui::Key>,
    /// Index of the displayed sheet.
    pub sheet: usize,
    /// Changes and messages.
    pub changes: Changes,
    previews: Previews,
    /// Generation of the world that the changes belong to.
    generation: u32,
}

impl Default for SheetInspector {
    fn default() -> Self {
        let (changes, previews) = (Changes::default(), Previews::default());
        Self { shown: true, key: Some(egui::Key::F10), sheet: 0, changes, previews, generation: 0 }
    }
}

fn show(
    mut contexts: EguiContexts,
    mut world: ResMut<SheetWorld>,
    mut clock: ResMut<SheetClock>,
    mut inspector: ResMut<SheetInspector>,
) -> Result {
    // A game may have no window, or none yet.
    let Ok(ctx) = contexts.ctx_mut() else { return Ok(()) };
    let inspector = inspector.bypass_change_detection();
    if inspector.key.is_some_and(|key| ctx.input(|i| i.key_pressed(key))) && !ctx.text_edit_focused() {
        inspector.shown = !inspector.shown;
    }
    if !inspector.shown {
        return Ok(());
    }
    // Reading the world is not a change; edits mark what they change.
    let (world, clock) = (world.bypass_change_detection(), clock.bypass_change_detection());
    let window = egui::Window::new("Sheets").default_size([330.0, 640.0]).default_pos([8.0, 8.0]);
    window.show(ctx, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            inspect(ui, world, clock, inspector);
        });
    });
    Ok(())
}

/// All panels of the inspector, for windows and docks of the caller.
pub fn inspect(ui: &mut Ui, world: &mut SheetWorld, clock: &mut SheetClock, inspector: &mut SheetInspector) {
    if inspector.generation != world.generation() {
        inspector.generation = world.generation();
        inspector.changes.forget();
    }
    if !ui.input(|i| i.pointer.any_down()) {
        inspector.changes.seal();
    }
    time(ui, world, clock);
    let SheetInspector { sheet, changes, previews, .. } = inspector;
    let count = world.sheets().len();
    *sheet = (*sheet).min(count.saturating_sub(1));
    let mut game = InspectedGame { world, speed: clock.speed, changes };
    if count > 0 {
        choose(ui, &game, sheet);
        section(ui, "Material", |ui| of_material(ui, &mut game, previews, *sheet));
        section(ui, "Sheet", |ui| {
            Grid::new("behaviour").num_columns(2).show(ui, |ui| behaviour(ui, &mut game, *sheet));
        });
    } else {
        ui.weak("There is no sheet.");
    }
    section(ui, "Integrator", |ui| {
        let factor = game.world.air().factor < 1.0;
        Grid::new("engine").num_columns(2).show(ui, |ui| engine(ui, &mut game, factor));
        cost(ui, &game);
    });
    section(ui, "Heat", |ui| {
        if !heat_sources(ui, &mut game) {
            ui.weak("There are no heat sources.");
        }
    });
    section(ui, "Changed", |ui| changed(ui, &mut game));
    messages(ui, &mut inspector.changes.messages);
}

fn section(ui: &mut Ui, title: &'static str, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong())
        .default_open(title != "Heat")
        .show_unindented(ui, |ui| ui.push_id(title, contents));
}

/// Pause, single steps and speed.
fn time(ui: &mut Ui, world: &SheetWorld, clock: &mut SheetClock) {
    ui.horizontal(|ui| {
        let title = if clock.paused { "▶ Play" } else { "⏸ Pause" };
        if ui.button(title).on_hover_text("Simulated time is paused").clicked() {
            clock.paused = !clock.paused;
        }
        if ui.button("⏭ Step").on_hover_text("One time step").clicked() {
            clock.paused = true;
            clock.step_once();
        }
        let label = ui.label("Speed");
        let number = egui::DragValue::new(&mut clock.speed).range(0.0..=100.0).speed(0.01).suffix("×");
        ui.add(number).labelled_by(label.id).on_hover_text("Simulated seconds per second of the game");
        ui.monospace(format!("{:.3} s", world.time()));
    });
}

/// Choice of the sheet, where there are several.
fn choose(ui: &mut Ui, game: &InspectedGame<'_>, sheet: &mut usize) {
    let sheets = game.world.sheets();
    let Some(now) = sheets.get(*sheet) else { return };
    if sheets.len() > 1 {
        egui::ComboBox::from_label("sheet").selected_text(now.name.as_str()).show_ui(ui, |ui| {
            for (index, one) in sheets.iter().enumerate() {
                ui.selectable_value(sheet, index, one.name.as_str());
            }
        });
    }
    let text = format!("{}: {} nodes, {} springs", now.name, now.node_count(), now.springs().len());
    ui.label(RichText::new(text).color(quiet(ui)));
}

fn of_material(ui: &mut Ui, game: &mut InspectedGame<'_>, previews: &mut Previews, index: usize) {
    let Some(sheet) = game.world.sheets().get(index) else { return };
    let (material, size) = (sheet.material().clone(), sheet.rest_size());
    let length = previews.length.unwrap_or(size.0.max(size.1));
    droop(ui, game, previews, &material, length);
    Grid::new("constants").num_columns(2).show(ui, |ui| constants(ui, game, index));
    delivered(ui, game, index);
}

/// List of changes, and undo.
fn changed(ui: &mut Ui, game: &mut InspectedGame<'_>) {
    ui.horizontal(|ui| {
        let what = game.changes.undoes().map_or_else(|| "Undo".to_owned(), |path| format!("Undo {path}"));
        let undo = ui.add_enabled(game.changes.undoes().is_some(), egui::Button::new(what));
        if undo.on_hover_text("Undo the last change").clicked() {
            game.undo();
        }
    });
    let now = game.world.parameters();
    let value = |path: &str| now.iter().find(|p| p.path == path).map(|p| p.value.clone());
    let differs = |(path, first): &(String, String)| Some((path.clone(), value(path).filter(|v| v != first)?));
    let list: Vec<(String, String)> = game.changes.all().iter().filter_map(differs).collect();
    for (path, now) in &list {
        ui.label(RichText::new(format!("{path} = {now}")).monospace().size(11.0).color(readable(ui, ACCENT)));
    }
    if list.is_empty() {
        ui.weak("There are no changes.");
    } else if ui.button("Copy").on_hover_text("Paths and values as text, for the code of the game").clicked() {
        let text: Vec<String> = list.iter().map(|(path, now)| format!("{path} = {now}")).collect();
        ui.ctx().copy_text(text.join("\n"));
    }
}

/// Messages about rejected values, until dismissed.
fn messages(ui: &mut Ui, all: &mut Vec<String>) {
    let colour = ui.visuals().error_fg_color;
    if let Some(index) = dismissible(ui, all.iter().map(|text| (text.as_str(), colour))) {
        all.remove(index);
    }
}

/// Texts in their colours, each with a button that dismisses it. Returns the index of a dismissed
/// one.
pub fn dismissible<'a>(ui: &mut Ui, all: impl Iterator<Item = (&'a str, egui::Color32)>) -> Option<usize> {
    let mut dismissed = None;
    for (index, (text, colour)) in all.enumerate() {
        ui.horizontal_wrapped(|ui| {
            if ui.small_button("✖").on_hover_text("Dismiss").clicked() {
                dismissed = Some(index);
            }
            ui.label(RichText::new(text).color(colour));
        });
    }
    dismissed
}
