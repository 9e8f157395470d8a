//! Text typed into export, brush, comparison and study is applied, and invalid text is rejected.

use bevy_egui::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sheetwork_editor::export::{Job, Kind};
use sheetwork_editor::panels::{Section, Tool};
use sheetwork_editor::session::Variant;
use sheetwork_editor::study::{Stage, Study};

use super::common::{Both, folder, strip, type_number, type_over, whole};

fn told(harness: &Harness<'_, Both>, text: &str) {
    let messages = harness.state().0.messages();
    assert!(messages.iter().any(|m| m.text.contains(text)), "{text} is not in {messages:?}");
}

#[test]
fn an_export_accepts_its_settings_and_reports_its_files() {
    let (folder, mut harness) = (folder("dialogs"), whole(strip()));
    let file = folder.join("strip.glb");
    harness.state_mut().1.export = Some(Job::new(Kind::Gltf, &file, 0.5));
    harness.run_steps(2);
    type_number(&mut harness, "Per second", "20");
    type_number(&mut harness, "Duration", "soon");
    assert!(harness.query_by_label("11 moments").is_some(), "what is no number changes nothing");
    type_number(&mut harness, "Duration", "200 ms");
    assert!(harness.query_by_label("5 moments").is_some());
    type_number(&mut harness, "Per second", "9000");
    harness.get_by_label("Write").click();
    harness.run_steps(3);
    told(&harness, "1801 moments are more than the 1000");
    assert!(!file.exists());
    type_number(&mut harness, "Per second", "20");
    harness.get_by_label("Write").click();
    harness.run_steps(12);
    assert!(harness.state().1.export.is_none() && file.exists());
    told(&harness, "strip.glb");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn the_brush_accepts_units_and_rejects_other_text() {
    let mut harness = whole(strip());
    harness.state_mut().1.tool = Tool::Heat;
    harness.run_steps(2);
    type_number(&mut harness, "to", "212 °F");
    assert!((harness.state().1.brush.celsius - 100.0).abs() < 1e-9);
    type_number(&mut harness, "to", "hot");
    type_number(&mut harness, "radius", "3 GPa");
    told(&harness, "\"hot\" does not begin with a number");
    told(&harness, "GPa is a unit of pressure");
    type_number(&mut harness, "radius", "0.5 cm");
    assert_eq!((harness.state().1.brush.celsius.round(), harness.state().1.brush.radius), (100.0, Some(0.005)));
    harness.state_mut().1.tool = Tool::Crease;
    harness.run_steps(2);
    type_number(&mut harness, "by", "1 rad");
    assert!((harness.state().1.brush.angle - 57.2957795).abs() < 1e-6);
}

#[test]
fn a_variant_accepts_typed_values_and_reports_invalid_ones() {
    let mut session = strip();
    session.compare_with(vec![Variant { path: "sheets.0.material.thickness".into(), value: "0.001".into() }]);
    let mut harness = whole(session);
    harness.state_mut().1.open_sections = [Section::Compare].into();
    harness.run_steps(3);
    let thickness = |h: &Harness<'_, Both>| h.state().0.shown(1).map(|s| s.world().sheets()[0].material().thickness);
    assert_eq!(thickness(&harness), Some(0.001));
    harness.get_by_role(Role::TextInput).focus();
    harness.run_steps(2);
    type_over(&mut harness, "0.002");
    assert_eq!(thickness(&harness), Some(0.002));
    harness.get_by_role(Role::TextInput).focus();
    harness.run_steps(2);
    type_over(&mut harness, "thick");
    assert_eq!(thickness(&harness), None);
    assert!(harness.query_by_label_contains("thickness thick:").is_some(), "and says why");
    assert!(!harness.state().0.document().is_unsaved(), "variants are no edits of the scene");
}

#[test]
fn a_study_without_a_subject_does_not_begin() {
    let mut harness = whole(strip());
    let mut study = Study::new(1);
    study.subject = " ".into();
    harness.state_mut().1.study = Some(study);
    harness.run_steps(2);
    harness.get_by_label("Begin").click();
    harness.run_steps(3);
    assert!(harness.state().1.study.as_ref().is_some_and(|s| s.stage() == Stage::Welcome));
    assert!(!harness.state().0.messages().is_empty() && harness.state().0.scene().name == "strip");
}
