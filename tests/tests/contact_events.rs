//! Pairs in contact and their events.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use sheetwork::rapier3d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, Vector};
use sheetwork::rigid::RigidView;
use sheetwork::scene::Scene;
use sheetwork::{ContactEvent, ContactEventKind as Kind, ContactPartner, EventKind, SheetId, World};
use sheetwork_tests::{shipped_scene, state_hash};

/// A plate of polycarbonate of 3 mm, 11.5 cm square, above the floor, without restitution.
fn plate(height: f64) -> (World, SheetId) {
    let scene = format!(
        r#"(contact: (friction: 0.3, restitution: 0), dt: 0.002,
            sheets: [(name: "plate", structure: "shell", grid: (6, 1, 6), size: (0.115, 0.115), drag: (0, 0),
                material: (young: 2.4e9, poisson: 0.37, density: 1200, thickness: 3e-3, damping_ratio: 0.1),
                placement: (position: (0, {height}, 0)))],
            room: (x: (-1, 1), y: (0, 2), z: (-1, 1)))"#
    );
    let world = World::new(&Scene::parse(&scene).expect("a scene")).expect("a world");
    let id = world.sheet_id("plate").expect("there");
    (world, id)
}

fn of_kind(events: &[ContactEvent], kind: Kind) -> Vec<ContactEvent> {
    events.iter().copied().filter(|event| event.kind == kind).collect()
}

#[test]
fn a_falling_plate_begins_contact_at_its_speed_and_then_rests_on_its_weight() {
    let (mut world, id) = plate(0.2);
    let mass = world.sheets()[0].total_mass();
    let weight = mass * 9.81;
    world.record_contacts(id, Some(10.0 * weight)).expect("valid");
    world.advance(2.0);
    let events = world.drain_contact_events();
    let began = of_kind(&events, Kind::Began);
    assert_eq!(began.len(), 1, "{events:?}");
    let pair = began[0].pair;
    let speed = -world.gravity().y * began[0].time;
    assert!((pair.approach_speed - speed).abs() < 2.5 * 9.81 * world.dt(), "{} of {speed} m/s", pair.approach_speed);
    assert!((pair.normal - DVec3::Y).length() < 1e-6, "{}", pair.normal);
    assert!(pair.point.with_y(0.0).length() < 1e-3, "{}", pair.point);
    assert!(pair.impulse.y > 0.5 * mass * speed, "{} of {} N s", pair.impulse.y, mass * speed);
    assert_eq!(of_kind(&events, Kind::ForceExceeded).len(), 1, "{events:?}");
    assert!(of_kind(&events, Kind::Ended).is_empty());
    let [now] = world.contacts() else { panic!("{:?}", world.contacts()) };
    assert!((now.force - weight).abs() < 1e-3 * weight, "{} of {weight} N", now.force);
    assert_eq!((now.since, world.body_name(body(now.partner))), (began[0].time, Some("floor")));
    // Thrown up again.
    for node in 0..world.sheets()[0].node_count() {
        let sheet = world.get_sheet_mut(id).expect("there");
        let impulse = DVec3::Y * (2.0 * sheet.node_mass(node));
        sheet.apply_impulse(node, impulse).expect("valid");
    }
    let thrown = world.time();
    world.advance(0.2);
    let events = world.drain_contact_events();
    assert_eq!(events.len(), 1, "{events:?}");
    assert!(events[0].kind == Kind::Ended && (events[0].time - thrown).abs() < 2.0 * world.dt(), "{events:?}");
    assert!(world.contacts().is_empty());
}

fn body(partner: ContactPartner) -> sheetwork::BodyId {
    if let ContactPartner::Body(id) = partner { id } else { panic!("{partner:?}") }
}

#[test]
fn records_change_no_result_and_continue_from_a_snapshot() {
    let run = |records: bool| {
        let (mut world, id) = plate(0.05);
        if records {
            world.record_contacts(id, Some(0.0)).expect("valid");
        }
        world.advance(0.05);
        let saved = world.serialise();
        world.advance(0.5);
        let events = world.drain_contact_events();
        world.deserialise(&saved).expect("its own");
        world.advance(0.5);
        (state_hash(&world), events, world.drain_contact_events())
    };
    let (hash, events, again) = run(true);
    assert_eq!(hash, run(false).0);
    assert!(events.len() >= 2);
    assert_eq!(events, again);
}

#[test]
fn bad_thresholds_and_sheets_are_refused() {
    let (mut world, id) = plate(0.2);
    for threshold in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        let problem = world.record_contacts(id, Some(threshold)).expect_err("out of range");
        assert!(problem.to_string().contains("threshold"), "{problem}");
    }
    world.record_contacts(id, Some(f64::INFINITY)).expect("no threshold");
    world.advance(0.3);
    assert_eq!(world.contacts().len(), 1);
    world.remove_sheet(id);
    world.record_contacts(id, None).expect_err("removed");
    world.step();
    assert!(world.contacts().is_empty());
    let events = world.drain_contact_events();
    assert_eq!(events.iter().map(|event| event.kind).collect::<Vec<_>>(), [Kind::Began, Kind::Ended]);
}

#[test]
fn two_sheets_make_one_pair_and_a_folded_sheet_touches_itself() {
    let scene = r#"(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [
        (name: "low", structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "card",
            placement: (position: (0, 0.002, 0))),
        (name: "high", structure: "shell", grid: (7, 1, 7), size: (0.1, 0.1), material: "card",
            placement: (position: (0, 0.03, 0)))])"#;
    let mut world = World::new(&Scene::parse(scene).expect("a scene")).expect("a world");
    let ids: Vec<SheetId> = world.sheet_ids().collect();
    // Only the second of the two records.
    world.record_contacts(ids[1], Some(f64::INFINITY)).expect("valid");
    world.advance(0.5);
    let [pair] = world.contacts() else { panic!("{:?}", world.contacts()) };
    assert_eq!((pair.sheet, pair.partner), (ids[1], ContactPartner::Sheet(ids[0])));
    assert!(pair.normal.y > 0.99, "it lies on the other: {}", pair.normal);
    world.record_contacts(ids[0], Some(f64::INFINITY)).expect("valid");
    world.drain_contact_events();
    world.advance(0.5);
    let sheets = world.contacts().iter().filter(|pair| matches!(pair.partner, ContactPartner::Sheet(_)));
    assert_eq!(sheets.map(|pair| pair.sheet).collect::<Vec<_>>(), [ids[0]], "one pair if both record");
    // A strip that is folded and pressed.
    let mut world = World::new(&shipped_scene("pressed_fold")).expect("a world");
    let ids: Vec<SheetId> = world.sheet_ids().collect();
    ids.iter().for_each(|id| world.record_contacts(*id, Some(f64::INFINITY)).expect("valid"));
    world.advance(2.0);
    let events = world.drain_contact_events();
    assert!(events.iter().any(|event| event.pair.partner == ContactPartner::Itself), "{events:?}");
}

#[test]
fn contact_with_a_lent_body_carries_its_user_data() {
    let scene = Scene::parse(
        r#"(sheets: [(name: "leaf", structure: "shell", grid: (6, 1, 6), size: (0.1, 0.1), material: "paper",
            placement: (position: (0, 0.05, 0)))])"#,
    );
    let mut world = World::without_bodies(&scene.expect("a scene")).expect("a world");
    let id = world.sheet_id("leaf").expect("there");
    world.record_contacts(id, Some(f64::INFINITY)).expect("valid");
    let mut rigid = PhysicsWorld::new();
    let ground = rigid.insert_body(RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.1, 0.0)));
    rigid.insert_collider(ColliderBuilder::cuboid(1.0, 0.1, 1.0).user_data(1 << 70 | 42), Some(ground));
    for _ in 0..30 {
        rigid.step();
        let view = RigidView::new(&rigid.broad_phase, &rigid.narrow_phase, &rigid.bodies, &rigid.colliders);
        world.advance_with(&view, 1.0 / 60.0);
    }
    let data = |partner| if let ContactPartner::Collider { user_data, .. } = partner { user_data } else { 0 };
    assert_eq!(world.contacts().iter().map(|pair| data(pair.partner)).collect::<Vec<_>>(), [1 << 70 | 42]);
    let first = world.events().iter().find(|event| event.kind == EventKind::FirstContact).expect("touched");
    assert_eq!(first.user_data, Some(1 << 70 | 42));
}

#[test]
fn rest_and_waking_alternate() {
    let scene = r#"(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [
        (name: "a", structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "card",
            placement: (position: (0, 0.01, 0))),
        (name: "b", structure: "shell", grid: (7, 1, 7), size: (0.1, 0.1), material: "card",
            placement: (position: (0, 0.03, 0))),
        (name: "c", structure: "shell", grid: (7, 1, 7), size: (0.1, 0.1), material: "card",
            placement: (position: (0.4, 0.01, 0)))],
        bodies: [(name: "ball", shape: Ball(0.02), mass: 0.01, placement: (position: (0, 0.3, 0)))])"#;
    let mut world = World::new(&Scene::parse(scene).expect("a scene")).expect("a world");
    for k in 0..300 {
        world.advance(1.0 / 60.0);
        // A game may wake a sheet itself, several times.
        if k % 50 == 49 {
            world.sheets_mut().iter_mut().for_each(|sheet| sheet.wake());
            world.sheets_mut().iter_mut().for_each(|sheet| sheet.wake());
        }
    }
    let mut last: BTreeMap<String, EventKind> = BTreeMap::new();
    let mut count = 0;
    for event in world.events().iter().filter(|e| matches!(e.kind, EventKind::AtRest | EventKind::Woke)) {
        let before = last.insert(event.sheet.clone(), event.kind);
        assert!(before.unwrap_or(EventKind::Woke) != event.kind, "{event:?}");
        count += 1;
    }
    assert!(count >= 6, "{count}");
}

#[test]
fn a_stack_whose_solver_ends_early_reports_no_contact_that_was_not() {
    let card = |k: usize| {
        format!(
            r#"(name: "card {k}", structure: "shell", grid: (7, 1, 7), size: (0.06, 0.09), material: "card",
                placement: (position: (0, {}, 0)))"#,
            0.0004 + 0.0006 * k as f64
        )
    };
    let scene = format!(
        r#"(contact: (step_budget: 1000), room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [{}],
            bodies: [(name: "ball", shape: Ball(0.015), mass: 0.1, placement: (position: (0, 0.05, 0)))])"#,
        (0..6).map(card).collect::<Vec<_>>().join(", ")
    );
    let mut world = World::new(&Scene::parse(&scene).expect("a scene")).expect("a world");
    let ids: Vec<SheetId> = world.sheet_ids().collect();
    ids.iter().for_each(|id| world.record_contacts(*id, Some(f64::INFINITY)).expect("valid"));
    let mut barrier = 0;
    for _ in 0..60 {
        world.advance(1.0 / 120.0);
        barrier += world.step_report().barrier;
    }
    assert!(barrier > 0, "the fallback did not occur");
    let floor = world.body_id("floor").expect("there");
    let events = world.drain_contact_events();
    let on_floor = events.iter().filter(|event| event.pair.partner == ContactPartner::Body(floor));
    on_floor.for_each(|event| assert_eq!(event.pair.sheet, ids[0], "{event:?}"));
    let told = world.events().iter().filter(|event| event.body.as_deref() == Some("floor"));
    told.for_each(|event| assert_eq!(event.sheet, "card 0", "{event:?}"));
}

#[test]
fn a_sheet_that_rests_on_another_falls_when_that_is_removed_or_moved_away() {
    let scene = r#"(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [
        (name: "table", structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), material: "card",
            pins: [(region: Border)], placement: (position: (0, 0.3, 0))),
        (name: "leaf", structure: "shell", grid: (5, 1, 5), size: (0.05, 0.05), material: "card",
            placement: (position: (0, 0.301, 0)))])"#;
    for remove in [true, false] {
        let mut world = World::new(&Scene::parse(scene).expect("a scene")).expect("a world");
        let ids: Vec<SheetId> = world.sheet_ids().collect();
        world.advance(2.0);
        let leaf = |world: &World| world.get_sheet(ids[1]).expect("there").centre_of_mass().y;
        assert!(leaf(&world) > 0.299 && world.is_resting());
        if remove {
            world.remove_sheet(ids[0]);
        } else {
            world.move_sheet(ids[0], DVec3::X * 0.5, DQuat::IDENTITY).expect("valid");
        }
        world.advance(1.0);
        assert!(leaf(&world) < 0.01, "{} m, removed: {remove}", leaf(&world));
    }
}
