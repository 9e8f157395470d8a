//! Rigid bodies: a static floor, a kinematic arm that carries a glued sheet, and a dynamic ball
//! that falls onto a second sheet.
//!
//! `cargo run -p sheetwork --example bodies`

use sheetwork::glam::DVec3;
use sheetwork::prelude::*;

/// Run the example. Public for `tests/examples.rs`, which runs all of them.
pub fn main() -> Result<(), InputError> {
    let floor = BodySpec { name: "floor".into(), ..BodySpec::new(Shape::HalfSpace) };
    // A path makes a body kinematic: it moves 0.1 m to the right and turns by 30 degrees.
    let turn = PathKey { time: 1.0, offset: DVec3::new(0.1, 0.0, 0.0), rotation: DVec3::new(0.0, 30.0, 0.0) };
    let arm = BodySpec {
        name: "arm".into(),
        placement: Placement { position: DVec3::new(-0.12, 0.4, 0.0), ..Placement::default() },
        path: vec![PathKey::default(), turn],
        ..BodySpec::new(Shape::Box(DVec3::new(0.04, 0.02, 0.1)))
    };
    // A mass makes a body dynamic.
    let ball = BodySpec {
        name: "ball".into(),
        mass: Some(0.02),
        placement: Placement { position: DVec3::new(0.6, 0.15, 0.0), ..Placement::default() },
        ..BodySpec::new(Shape::Ball(0.02))
    };
    let carried =
        SheetSpec::new("pet").named("carried").size(0.2, 0.1).grid(11, 6).at(0.0, 0.4, 0.0).glue(Region::Left, "arm");
    let lying = SheetSpec::new("rubber").named("lying").size(0.2, 0.2).grid(9, 9).at(0.6, 0.002, 0.0);
    let scene = Scene::new().with_body(floor).with_body(arm).with_body(ball).with_sheet(carried).with_sheet(lying);
    let mut world = World::new(&scene)?;

    println!("{:>8} {:>10} {:>14} {:>12} {:>14}", "time, s", "arm x, m", "carried x, m", "ball y, mm", "ball v, m/s");
    for _ in 0..10 {
        world.advance(0.1);
        let (arm, ball) = (body(&world, "arm"), body(&world, "ball"));
        let carried = world.sheet("carried").map_or(0.0, |s| s.centre_of_mass().x);
        println!(
            "{:>8.2} {:>10.3} {:>14.3} {:>12.1} {:>14.3}",
            world.time(),
            arm.origin().x,
            carried,
            1e3 * ball.origin().y,
            ball.velocity().y
        );
    }
    println!("deepest penetration: {:.1} µm", 1e6 * world.penetration());

    // Bodies may be added, pushed and removed while the world runs.
    let id = world.add_body(&BodySpec { name: "ball".into(), ..BodySpec::new(Shape::Ball(0.01)) })?;
    let name = world.body_name(id).unwrap_or_default().to_owned();
    println!("a second \"ball\" is called \"{name}\"; removed: {}", world.remove_body(id));
    Ok(())
}

fn body(world: &World, name: &str) -> BodyState {
    *world.body_state(name).expect("the scene has this body")
}
