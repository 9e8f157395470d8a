//! Heat: a polystyrene strip between two supports softens in an oven, sags, and keeps its shape
//! when it has cooled.
//!
//! `cargo run -p sheetwork --example heat`

use sheetwork::prelude::*;
use sheetwork::scene::{OvenKey, OvenSpec};

pub fn main() -> Result<(), InputError> {
    let strip = SheetSpec { creep: true, ..SheetSpec::new("hips") }
        .named("strip")
        .size(0.15, 0.03)
        .grid(15, 4)
        .damping_ratio(0.5)
        .clamp(Region::Left)
        .probe("tip", 1.0, 0.5);
    // Temperatures of the oven (°C) at simulated times (s): linear in between, off at the end.
    let schedule = [(0.5, 20.0), (1.0, 130.0), (3.0, 130.0)];
    let mut schedule: Vec<OvenKey> =
        schedule.map(|(time, celsius)| OvenKey { time, temperature: Some(celsius) }).into();
    schedule.push(OvenKey { time: 3.0 + 1e-6, temperature: None });
    let mut scene = Scene::new().with_sheet(strip);
    scene.oven = Some(OvenSpec { convection: Some(40.0), schedule, ..OvenSpec::default() });
    // Heat runs 20 times as fast as motion: 1 s of the scene is 20 s of heating.
    scene.time_lapse = 20.0;
    let mut world = World::new(&scene)?;

    println!("{:>8} {:>10} {:>12} {:>10}", "time, s", "oven, °C", "sheet, °C", "tip, mm");
    let mut warmest: f64 = 0.0;
    for _ in 0..12 {
        world.advance(0.5);
        let sheet = &world.sheets()[0];
        let celsius = sheet.temperature().unwrap_or(world.room_temperature());
        warmest = warmest.max(celsius);
        let tip = sheet.probes[0].at(&sheet.x).y;
        println!("{:>8.1} {:>10.1} {celsius:>12.1} {:>10.1}", world.time(), world.room_temperature(), 1e3 * tip);
    }
    println!("warmest: {warmest:.0} °C");
    Ok(())
}
