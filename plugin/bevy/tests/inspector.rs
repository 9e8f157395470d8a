//! Edits of the inspector reach the running world and can be undone.

mod common;

use bevy::prelude::*;
use bevy_egui::egui;
use bevy_egui::egui::accesskit::Role;
use bevy_sheetwork::inspector::inspect;
use bevy_sheetwork::prelude::*;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// Draw the panels over a game like the plugin's own system.
fn draw(ui: &mut egui::Ui, app: &mut App) {
    app.world_mut().resource_scope(|all, mut world: Mut<SheetWorld>| {
        all.resource_scope(|all, mut clock: Mut<SheetClock>| {
            all.resource_scope(|_, mut inspector: Mut<SheetInspector>| {
                inspect(ui, &mut world, &mut clock, &mut inspector);
            });
        });
    });
}

/// A game with a strip that hangs from one end.
fn game() -> Harness<'static, App> {
    let mut app = common::app();
    app.init_resource::<SheetInspector>();
    let strip = Sheet::new("hips").named("strip").size(0.25, 0.1).clamp(Region::Left);
    app.world_mut().spawn((strip, Transform::default()));
    common::run(&mut app, 0.1);
    let mut harness = Harness::builder().with_size([420.0, 1600.0]).build_ui_state(draw, app);
    harness.run_steps(2);
    harness
}

/// Type `text` into the number beside the slider with this label.
fn type_into(harness: &mut Harness<'static, App>, label: &str, text: &str) {
    let row = harness.get_by_role_and_label(Role::Slider, label).rect();
    let beside = |r: egui::Rect| r.left() > row.left() && (r.center().y - row.center().y).abs() < 3.0;
    let mut numbers = harness.query_all_by_role(Role::SpinButton);
    numbers.find(|n| beside(n.rect())).expect("a number beside the slider").click();
    drop(numbers);
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.run_steps(1);
    harness.event(egui::Event::Text(text.to_owned()));
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
}

fn value(harness: &Harness<'static, App>, path: &str) -> f64 {
    let world = harness.state().world().resource::<SheetWorld>();
    let found = world.parameters().into_iter().find(|p| p.path == path);
    found.and_then(|p| p.value.parse().ok()).unwrap_or_else(|| panic!("{path}"))
}

/// Droop of the strip after one more second, m.
fn droop(harness: &mut Harness<'static, App>) -> f64 {
    common::run(harness.state_mut(), 1.0);
    let world = harness.state().world().resource::<SheetWorld>();
    world.sheets()[0].state.x.bounds().map_or(0.0, |(low, _)| -low.y)
}

#[test]
fn a_typed_value_reaches_the_running_world_and_undo_brings_it_back() {
    let mut harness = game();
    let stiff = value(&harness, "sheets.strip.material.young");
    let before = droop(&mut harness);
    type_into(&mut harness, "Young", "0.2 GPa");
    assert_eq!(value(&harness, "sheets.strip.material.young"), 2e8);
    let after = droop(&mut harness);
    assert!(after > 2.0 * before, "a soft strip hangs lower: {after} m after {before} m");
    harness.run_steps(1);
    harness.get_by_label("Undo sheets.0.material.young").click();
    harness.run_steps(2);
    assert_eq!(value(&harness, "sheets.strip.material.young"), stiff);
    assert!(harness.query_by_label("There are no changes.").is_some());
}

#[test]
fn a_rejected_edit_is_reported_and_changes_nothing() {
    let mut harness = game();
    let before = value(&harness, "sheets.strip.material.young");
    type_into(&mut harness, "Young", "12 kg");
    type_into(&mut harness, "Young", "-3 GPa");
    assert_eq!(value(&harness, "sheets.strip.material.young"), before);
    let told = harness.state().world().resource::<SheetInspector>().changes.messages.join("; ");
    assert!(told.contains("kg") && told.contains("outside"), "{told}");
    assert!(harness.query_all_by_label("✖").count() == 2);
}

#[test]
fn a_game_is_paused_and_stepped_by_its_buttons() {
    let mut harness = game();
    harness.get_by_label("⏭ Step").click();
    harness.run_steps(2);
    let steps = |harness: &Harness<'static, App>| harness.state().world().resource::<SheetWorld>().steps();
    let before = steps(&harness);
    common::run(harness.state_mut(), 0.2);
    assert_eq!(steps(&harness), before + 1, "one step, and it stands");
    harness.get_by_label("▶ Play").click();
    harness.run_steps(2);
    common::run(harness.state_mut(), 0.2);
    assert!(steps(&harness) > before + 5);
}
