//! Parameters by path: list them, change stiffness and gravity between steps, with units.
//!
//! `cargo run -p sheetwork --example change_parameters`

use sheetwork::prelude::*;

pub fn main() -> Result<(), InputError> {
    let strip = SheetSpec::new("hips")
        .named("strip")
        .size(0.2, 0.04)
        .grid(15, 4)
        .at(0.0, 0.3, 0.0)
        .clamp(Region::Left)
        .damping_ratio(0.5)
        .probe("tip", 1.0, 0.5);
    let mut world = World::new(&Scene::new().with_sheet(strip))?;

    println!("{:<36} {:>14} {:<12} range", "parameter", "value", "unit");
    for Parameter { path, value, unit, range, .. } in world.parameters() {
        let range = range.map_or_else(String::new, |(min, max)| format!("{min:e} to {max:e}"));
        println!("{path:<36} {value:>14} {unit:<12} {range}");
    }

    println!("\n{:<44} {:>10}", "after one second with", "droop, mm");
    println!("{:<44} {:>10.2}", "the constants of polystyrene", droop_after(&mut world, 1.0));
    // A change takes effect from the next step on. A number without unit is in SI.
    for (path, value) in [
        ("sheets.strip.material.young", "1 GPa"),
        ("sheets.strip.material.thickness", "0.8 mm"),
        ("gravity", "(0, -1.62, 0)"),
        ("engine", "backward-euler"),
    ] {
        let old = world.set(path, value)?;
        let droop = droop_after(&mut world, 1.0);
        println!("{:<44} {droop:>10.2}", format!("{path} = {value} (was {old})"));
    }
    Ok(())
}

/// Droop of the tip below the clamp, mm, after `seconds`.
fn droop_after(world: &mut World, seconds: f64) -> f64 {
    world.advance(seconds);
    let sheet = &world.sheets()[0];
    1e3 * (0.3 - sheet.probes[0].at(&sheet.x).y)
}
