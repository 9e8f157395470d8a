//! The flexion angle limit holds in contact, at the step of the scene, and lets the sheet rest.

use sheetwork::Status;
use sheetwork_tests::{shipped_scene, world};

#[test]
fn the_flexion_limit_holds_within_a_degree_on_a_wedge_and_the_sheet_rests() {
    for (structure, grid) in [("provot2d", "(11, 1, 11)"), ("provot3d", "(11, 2, 11)")] {
        for limit in [60.0, 40.0, 20.0, 10.0] {
            let text = limit.to_string();
            let engine = std::env::var("ENGINE").unwrap_or("euler-richardson".into());
            let scene = shipped_scene("wedge").with_overrides(&[
                ("engine", &engine),
                ("sheets.0.structure", structure),
                ("sheets.0.grid", grid),
                ("sheets.0.flexion_limit", &text),
            ]);
            let mut world = world(&scene.unwrap_or_else(|e| panic!("{e}")));
            let (mut peak, mut late, mut first, mut rests, mut slow) = (0.0_f64, 0.0_f64, None, None, None);
            let begun = std::time::Instant::now();
            let mut steps = 0;
            for step in 0..1600 {
                world.step();
                let sheet = &world.sheets()[0];
                let now = f64::from(step) * world.dt();
                let angle = sheet.largest_flexion_angle().expect("triples");
                if first.is_none() && sheet.touching().contains(&true) {
                    first = Some(now);
                }
                if let Some(first) = first {
                    peak = peak.max(angle);
                    if now > first + 0.3 { late = late.max(angle); }
                }
                if sheet.max_speed() > 1e-3 { slow = None; } else if slow.is_none() { slow = Some(now); }
                if sheet.state.status == Status::Asleep && rests.is_none() { rests = Some(now); }
                if rests.is_none() { steps += 1; }
                if std::env::var("V").is_ok() && step % 40 == 0 { println!("  {now:.2} {angle:.2} {:.2e} {}", sheet.max_speed(), sheet.touching().iter().filter(|t| **t).count()); }
            }
            let sheet = &world.sheets()[0];
            let end = sheet.largest_flexion_angle().expect("triples");
            let (low, high) = sheet.state.x.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x.y), h.max(x.y)));
            println!("{structure} {limit}: end {end:.2} peak {peak:.2} late {late:.2} first {first:?} asleep {rests:?} slow from {slow:?} speed {:.1e} y {low:.4} {high:.4} squeezed {:?} us/step {:.0}", sheet.max_speed(), sheet.squeezed_to(), begun.elapsed().as_secs_f64() / f64::from(steps) * 1e6);
        }
    }
}
