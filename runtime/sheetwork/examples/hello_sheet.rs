//! A card clamped at one edge, released flat, swings and comes to rest: the smallest program.
//!
//! `cargo run -p sheetwork --example hello_sheet`

use sheetwork::prelude::*;

pub fn main() -> Result<(), InputError> {
    // A shell of 21 x 21 nodes, 0.3 m long and 0.2 m wide, with the constants of card of 300 g/m².
    let card = SheetSpec::new("card")
        .named("card")
        .size(0.3, 0.2)
        .at(0.0, 0.5, 0.0)
        .clamp(Region::Left)
        .damping_ratio(0.2)
        .probe("tip", 1.0, 0.5);
    // The scene: TR-BDF2 with a step of 1/60 s, gravity of 9.81 m/s², no air, no bodies.
    let mut world = World::new(&Scene::new().with_sheet(card))?;

    let sheet = &world.sheets()[0];
    let material = sheet.material();
    println!(
        "{} nodes, {:.1} g, D = {:.4} N m",
        sheet.node_count(),
        1e3 * sheet.total_mass(),
        material.plate_stiffness()
    );
    println!("{:>8} {:>12} {:>12} {:>12}", "time, s", "tip, mm", "elastic, mJ", "kinetic, mJ");
    for _ in 0..8 {
        world.advance(0.25);
        let sheet = &world.sheets()[0];
        let tip = sheet.probes[0].at(&sheet.x);
        let energy = sheet.energy(world.gravity());
        println!(
            "{:>8.2} {:>12.1} {:>12.3} {:>12.4}",
            world.time(),
            1e3 * (tip.y - 0.5),
            1e3 * energy.elastic,
            1e3 * energy.kinetic
        );
    }
    Ok(())
}
