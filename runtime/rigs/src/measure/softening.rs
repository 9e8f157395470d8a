//! Stiffness of a material at a temperature, and the droop of a sheet of it, clamped along one
//! edge. Thermal expansion is excluded, so that the droop depends on the stiffness alone.

use serde_json::json;

use crate::measure::{FreeEdge, RigResult, Runner, Setup};
use sheetwork::scene::{Material, MaterialChoice, Region};
use sheetwork::sheet::temperature::Softening;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let celsius = setup.thermal.celsius.unwrap_or(100.0);
    let mut scene = setup.scene();
    setup.clamp(&mut scene, Region::Left);
    let material = Material { expansion: 0.0, ..setup.material.clone() };
    let young = material.young * Softening::of(&material).fraction(celsius);
    scene.sheets[0].material = MaterialChoice::Inline(material);
    let mut world = setup.world(&scene)?;
    world.sheets_mut()[0].set_temperatures(|_| celsius)?;
    let mut runner = Runner::new(world);
    runner.bring_to_rest(setup);
    let sheet = &runner.world.sheets()[0];
    let edge = FreeEdge::new(sheet, &sheet.state.x);
    let drop = scene.sheets[0].placement.position.y - edge.middle.y;
    let keys = json!({
        "celsius": celsius,
        "young_pa": young,
        "young_cold_pa": setup.material.young,
        "droop_m": drop,
    });
    Ok(runner.outcome(keys))
}
