//! Events of a run, and the errors of input: messages that name field, value, unit and range.
//!
//! `cargo run -p sheetwork --example events_and_errors`

use sheetwork::glam::DVec3;
use sheetwork::prelude::*;

/// Run the example. Public for `tests/examples.rs`, which runs all of them.
pub fn main() -> Result<(), InputError> {
    // Errors: nothing changes when input is rejected.
    let scene = Scene::new().with_sheet(SheetSpec::new("crad"));
    report_error("a material that does not exist", World::new(&scene).err());
    report_error("a scene file with a wrong type", Scene::parse("(dt: \"fast\")").err());

    let floor = BodySpec { name: "floor".into(), ..BodySpec::new(Shape::HalfSpace) };
    let placement = Placement { position: DVec3::new(0.0, 0.1, 0.0), rotation: DVec3::new(0.0, 0.0, 20.0) };
    let card = SheetSpec::new("playing-card").named("card").size(0.09, 0.06).grid(9, 7).placement(placement);
    let mut world = World::new(&Scene::new().with_body(floor).with_sheet(card))?;
    report_error("a value out of range", world.set("sheets.card.material.poisson", "0.7").err());
    report_error("a unit of another quantity", world.set("sheets.card.material.young", "3 mm").err());
    report_error("a misspelt path", world.set("sheets.card.material.yuong", "1e9").err());

    // Events: taken out of the world, so that the list does not grow.
    println!("\n{:>8} {:<16} {:<10} body", "time, s", "event", "sheet");
    while !world.is_resting() && world.time() < 10.0 {
        world.advance(0.1);
        for event in world.drain_events() {
            let kind = format!("{:?}", event.kind);
            println!("{:>8.3} {kind:<16} {:<10} {}", event.time_s, event.sheet, event.body.unwrap_or_default());
        }
    }

    // An explicit integrator with a step far above its stability limit stops the sheet.
    world.set_engine(IntegratorKind::Rk4);
    world.sheets_mut()[0].apply_impulse(0, DVec3::new(0.0, 1e-3, 0.0))?;
    world.advance(1.0);
    for event in world.drain_events().iter().filter(|e| e.kind == EventKind::Unstable) {
        let alarm = event.alarm.as_ref().expect("an unstable sheet has a report");
        println!(
            "{:>8.3} Unstable: {:.1e} m/s after a step of {:.1} ms",
            event.time_s,
            alarm.speed_m_s,
            1e3 * alarm.step_s
        );
    }
    Ok(())
}

fn report_error(what: &str, error: Option<impl std::error::Error>) {
    let error = error.expect("this input is rejected");
    println!("{what}:\n    {error}");
}
