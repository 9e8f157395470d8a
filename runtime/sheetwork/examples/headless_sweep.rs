//! A parameter study without a window: droop of a strip against its thickness, computed by one
//! world per thickness on all cores, compared with beam theory; results as CSV.
//!
//! `cargo run -p sheetwork --example headless_sweep`

use std::thread;

use sheetwork::prelude::*;

/// Length and width of the strip, m.
const SIZE: (f64, f64) = (0.10, 0.02);

pub fn main() -> Result<(), InputError> {
    let thicknesses = [3e-4, 4e-4, 5e-4, 7e-4, 1e-3, 1.5e-3];
    // Worlds are independent, and each gives the same bits on every thread.
    let rows: Vec<Result<(f64, f64), InputError>> = thread::scope(|scope| {
        let work = thicknesses.map(|thickness| scope.spawn(move || droop(thickness)));
        work.map(|thread| thread.join().expect("a world does not panic")).into()
    });

    println!("thickness_mm,droop_mm,beam_theory_mm,ratio");
    for (thickness, row) in thicknesses.iter().zip(rows) {
        let (measured, theory) = row?;
        println!("{:.1},{:.4},{:.4},{:.4}", 1e3 * thickness, 1e3 * measured, 1e3 * theory, measured / theory);
    }
    Ok(())
}

/// Droop of the tip of a clamped strip (m): in equilibrium, and by beam theory,
/// w = ρ t g L⁴ / (8 D) with D = E t³/12 for ν = 0.
fn droop(thickness: f64) -> Result<(f64, f64), InputError> {
    let material = Material { young: 2e9, poisson: 0.0, density: 1045.0, thickness, ..Material::default() };
    let theory = material.areal_mass() * 9.81 * SIZE.0.powi(4) / (8.0 * material.plate_stiffness());
    let strip = SheetSpec::new("")
        .material(material)
        .size(SIZE.0, SIZE.1)
        .grid(21, 5)
        .clamp(Region::Left)
        .probe("tip", 1.0, 0.5);
    let mut world = World::new(&Scene::new().with_sheet(strip))?;
    let found = world.find_equilibrium(1e-9);
    assert!(found.iter().all(|equilibrium| equilibrium.converged && equilibrium.is_stable));
    let sheet = &world.sheets()[0];
    Ok((-sheet.probes[0].at(&sheet.x).y, theory))
}
