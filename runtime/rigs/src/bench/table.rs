//! Markdown table of the benchmark: the Pareto front of every rig, every peer, and every lattice of
//! equal springs.

use std::fmt::Write;

use crate::bench::front::front;
use crate::bench::point::ParetoPoint;
use crate::bench::sweep::{CASES, EQUAL_SPRINGS};

/// Tables of all rigs.
pub fn markdown(points: &[ParetoPoint]) -> String {
    let mut text = String::new();
    for case in CASES {
        let of_case: Vec<&ParetoPoint> = points.iter().filter(|p| p.case == *case).collect();
        if of_case.is_empty() {
            continue;
        }
        let best = front(&of_case);
        let stands = |i: &usize| of_case[*i].peer || of_case[*i].structure.ends_with(EQUAL_SPRINGS) || best.contains(i);
        let mut rows: Vec<usize> = (0..of_case.len()).filter(stands).collect();
        rows.sort_by(|&a, &b| of_case[a].cpu_ms_per_simulated_s.total_cmp(&of_case[b].cpu_ms_per_simulated_s));
        // Writing to a string is infallible.
        let _ = write!(
            text,
            "## {case}\n\n{} configurations; on the front: {}.\n\n\
             | structure | engine | grid | step | CPU ms per simulated second | error | at rest |\n|---|---|---|---|---|---|---|\n",
            of_case.len(),
            best.len(),
        );
        for i in rows {
            let _ = writeln!(text, "{}", row(of_case[i], best.contains(&i)));
        }
        text.push('\n');
    }
    text
}

fn row(point: &ParetoPoint, best: bool) -> String {
    let mark = if best { "**" } else { "" };
    let error = point.error.map_or_else(|| "-".into(), percent);
    let rest = match point.settled {
        Some(true) => "yes",
        Some(false) => "no",
        None => "",
    };
    format!(
        "| {mark}{}{mark} | {} | {} | {} | {} | {mark}{error}{mark} | {rest} |",
        point.structure,
        point.engine,
        point.grid,
        step(point.dt_s),
        significant(point.cpu_ms_per_simulated_s),
    )
}

/// A fraction in percent, two significant digits.
pub fn percent(fraction: f64) -> String {
    format!("{} %", significant(100.0 * fraction))
}

/// A step as a fraction of a second for an integer rate, else in milliseconds.
fn step(dt: f64) -> String {
    let rate = 1.0 / dt;
    let whole = (rate - rate.round()).abs() < 1e-6 * rate && rate < 2000.0;
    if whole { format!("1/{rate:.0} s") } else { format!("{} ms", significant(1e3 * dt)) }
}

/// Two significant digits, or all digits before the decimal point.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = (1 - value.abs().log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::front::tests::point;

    #[test]
    fn the_table_has_the_front_in_bold_and_all_peers() {
        let mut peer = point(40.0, 0.08);
        (peer.peer, peer.structure) = (true, "MuJoCo shell 4.0.0".into());
        let text = markdown(&[point(20.0, 0.0021), point(30.0, 0.003), peer]);
        assert!(text.contains("| **shell** | tr-bdf2 | 21x21 | 1/60 s | 20 | **0.21 %** | yes |"), "{text}");
        assert!(text.contains("| MuJoCo shell 4.0.0 | tr-bdf2 | 21x21 | 1/60 s | 40 | 8.0 % | yes |"), "{text}");
        assert!(!text.contains("0.30"), "{text}");
    }
}
