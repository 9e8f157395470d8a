//! First swing of an undamped sheet, clamped along one edge and released flat: its depth and its
//! time.

use serde_json::json;

use crate::measure::{FreeEdge, RigResult, Runner, Setup, bisect};
use sheetwork::scene::Region;

/// Time limit of the swing, in periods of the slowest bending mode.
const PERIODS: f64 = 3.0;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = Setup { damping_ratio: 0.0, ..setup.clone() }.scene();
    setup.clamp(&mut scene, Region::Left);
    let mut runner = Runner::new(setup.world(&scene)?);
    let start = scene.sheets[0].placement.position.y;
    let mut last = (0.0, 0.0, 0.0);
    let mut extreme = None;
    runner.run(PERIODS * setup.period(), |world| {
        let sheet = &world.sheets()[0];
        let now = (
            world.time(),
            start - FreeEdge::new(sheet, &sheet.state.x).middle.y,
            -FreeEdge::new(sheet, &sheet.state.v).middle.y,
        );
        if last.2 > 0.0 && now.2 <= 0.0 {
            extreme = Some(turning_point(last, now));
        }
        last = now;
        extreme.is_none()
    });
    let keys = json!({
        "first_extreme_m": extreme.map(|e| e.1),
        "first_extreme_s": extreme.map(|e| e.0),
    });
    Ok(runner.outcome(keys))
}

/// Turning point (time, value) of the cubic through two times with values and slopes.
pub(crate) fn turning_point(a: (f64, f64, f64), b: (f64, f64, f64)) -> (f64, f64) {
    let h = b.0 - a.0;
    let slope = |s: f64| {
        let (p, q) = (6.0 * s * s - 6.0 * s, 3.0 * s * s - 4.0 * s + 1.0);
        p * (a.1 - b.1) + h * (q * a.2 + (3.0 * s * s - 2.0 * s) * b.2)
    };
    let turn = bisect((0.0, 1.0), 60, |s| slope(s) > 0.0).0;
    (a.0 + turn * h, cubic(a, b, turn))
}

/// Value at the fraction `s` of the cubic through two times with values and slopes.
pub(crate) fn cubic(a: (f64, f64, f64), b: (f64, f64, f64), s: f64) -> f64 {
    let (s2, s3) = (s * s, s * s * s);
    let (p, q) = (2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
    p * a.1 + q * b.1 + (b.0 - a.0) * ((s3 - 2.0 * s2 + s) * a.2 + (s3 - s2) * b.2)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_turning_point_of_a_cubic_is_exact() {
        // 1 + 2 t - t² turns at t = 1 with the value 2.
        let at = |t: f64| (t, 1.0 + 2.0 * t - t * t, 2.0 - 2.0 * t);
        let (t, value) = super::turning_point(at(0.7), at(1.6));
        assert!((t - 1.0).abs() < 1e-12 && (value - 2.0).abs() < 1e-12);
    }
}
