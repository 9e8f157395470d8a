//! Sheets that come and go leave nothing behind.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, frame};

/// Numbers that grow if something of a despawned sheet stays: entities, sheets, bodies, meshes,
/// materials, bytes of a snapshot.
fn sizes(app: &App) -> [usize; 6] {
    let world = app.world().resource::<SheetWorld>();
    let meshes = app.world().resource::<Assets<Mesh>>().len();
    let materials = app.world().resource::<Assets<StandardMaterial>>().len();
    let bodies = world.rigid().map_or(0, |rigid| rigid.bodies().len());
    let entities = app.world().entities().count_spawned() as usize;
    [entities, world.sheets().len(), bodies, meshes, materials, world.serialise().len()]
}

#[test]
fn five_hundred_sheets_that_come_and_go_leave_nothing() {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let mut before = None;
    for round in 0..51 {
        let places = (0..10).map(|k| Transform::from_xyz(0.2 * k as f32, 0.05, 0.0));
        let spawned: Vec<Entity> = places
            .flat_map(|place| {
                let arm = app.world_mut().spawn((SheetBody::cuboid(0.01, 0.01, 0.01), place)).id();
                let sheet = Sheet::new("card").size(0.1, 0.1).grid(5, 5);
                let parts = (SheetAttachments::new(Region::Left, arm), SheetContacts::default(), SheetSides::default());
                let sheet =
                    app.world_mut().spawn((sheet, parts, place.with_translation(place.translation + Vec3::Y * 0.1)));
                let sheet = sheet.id();
                [sheet, arm]
            })
            .collect();
        (0..4).for_each(|_| frame(&mut app, 1.0 / 64.0));
        assert_eq!(app.world().resource::<SheetWorld>().sheets().len(), 10);
        spawned.into_iter().for_each(|entity| _ = app.world_mut().despawn(entity));
        (0..2).for_each(|_| frame(&mut app, 1.0 / 64.0));
        let after = sizes(&app);
        // The first round makes what is shared, as the default material.
        let first = *before.get_or_insert(after);
        assert_eq!(first[..5], after[..5], "round {round}");
        // A snapshot holds counters, as generations of handles, in numbers of variable length.
        assert!(after[5] <= first[5] + 8, "round {round}: {} and {} bytes", first[5], after[5]);
    }
}
