//! A clamped card, the scene of the tests of creases, plasticity and creep.

use glam::DVec3;
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{IntegratorKind, MaterialChoice, PinSpec, Region, Scene, SheetSpec};

/// A card of 0.2 m by 0.1 m, clamped at its left edge.
pub fn card(grid: (u32, u32)) -> Scene {
    let sheet = SheetSpec {
        name: "card".into(),
        structure: StructureKind::Shell,
        grid: (grid.0, 1, grid.1),
        size: (0.2, 0.1),
        material: MaterialChoice::Named("card".into()),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    };
    let dt = 1.0 / 60.0;
    Scene { gravity: DVec3::ZERO, engine: IntegratorKind::TrBdf2, dt, sheets: vec![sheet], ..Scene::default() }
}

/// Field and problem with which a card is rejected after `change`.
///
/// # Panics
/// A card that is accepted.
pub fn rejection(change: &dyn Fn(&mut SheetSpec)) -> (String, String) {
    let mut scene = card((11, 7));
    change(&mut scene.sheets[0]);
    match World::new(&scene) {
        Ok(_) => panic!("the card was accepted"),
        Err(error) => (error.field.clone(), error.problem.clone()),
    }
}
