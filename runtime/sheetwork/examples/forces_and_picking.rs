//! Forces from outside: pick the node under a ray, push it by an impulse, pull a point by a spring
//! as a mouse does, and read the force of the hand.
//!
//! `cargo run -p sheetwork --example forces_and_picking`

use sheetwork::glam::DVec3;
use sheetwork::prelude::*;

pub fn main() -> Result<(), InputError> {
    let card = SheetSpec::new("card")
        .named("card")
        .size(0.2, 0.1)
        .grid(15, 8)
        .at(0.0, 0.3, 0.0)
        .clamp(Region::Left)
        .damping_ratio(0.3);
    let mut world = World::new(&Scene::new().with_sheet(card))?;
    world.advance(1.0);

    // Picking: the node nearest to a vertical ray through x = 0.08 m, z = 0.
    let node = pick(&world.sheets()[0], DVec3::new(0.08, 1.0, 0.0), DVec3::NEG_Y).expect("the sheet has nodes");
    let (u, v) = world.sheets()[0].uv[node];
    println!("picked node {node} at (u, v) = ({u:.2}, {v:.2}), height {:.1} mm", height(&world, node));

    // Impulse: 0.2 mN s upwards, at once.
    let sheet = &mut world.sheets_mut()[0];
    sheet.apply_impulse(node, DVec3::new(0.0, 2e-4, 0.0))?;
    println!("an impulse of 0.2 mN s gives this node {:.2} m/s", sheet.v.get(node).length());
    world.advance(1.0);

    // Grab: a spring of 20 N/m between a material point and a hand that rises by 60 mm in a second.
    let start = world.sheets()[0].x.get(node);
    let grab = world.sheets_mut()[0].grab((u, v), 20.0)?;
    println!("{:>12} {:>12} {:>12}", "hand, mm", "node, mm", "force, mN");
    for step in 1..=60 {
        let hand = start + DVec3::Y * (0.06 * f64::from(step) / 60.0);
        world.sheets_mut()[0].pull(grab, hand)?;
        world.step();
        if step % 12 == 0 {
            let force = 20.0 * (hand - world.sheets()[0].x.get(node)).length();
            println!("{:>12.1} {:>12.1} {:>12.2}", 1e3 * hand.y, height(&world, node), 1e3 * force);
        }
    }
    world.sheets_mut()[0].release_grab(grab);
    world.advance(2.0);
    println!("released: back at {:.1} mm", height(&world, node));
    Ok(())
}

/// Node nearest to the ray from `eye` along the unit vector `direction`.
fn pick(sheet: &Sheet, eye: DVec3, direction: DVec3) -> Option<usize> {
    let distance = |i: usize| (sheet.x.get(i) - eye).cross(direction).length();
    (0..sheet.node_count()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}

/// Height of a node, mm.
fn height(world: &World, node: usize) -> f64 {
    1e3 * world.sheets()[0].x.get(node).y
}
