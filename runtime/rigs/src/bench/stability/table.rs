//! Markdown tables of the map.

use std::fmt::Write;

use crate::bench::stability::point::StabilityPoint;

/// Tolerance between measured and predicted value.
const RATIO_TOLERANCE: f64 = 0.05;

/// All tables.
pub fn markdown(points: &[StabilityPoint]) -> String {
    let mut text = String::new();
    // Writing to a string is infallible.
    let _ = writeln!(text, "## The map: found over predicted\n");
    let _ = writeln!(text, "| engine | points | median | lowest | highest | within 5 % |\n|---|---|---|---|---|---|");
    let map: Vec<&StabilityPoint> = points.iter().filter(|p| p.sweep == "map").collect();
    for engine in each(&map, |p| &p.engine) {
        let _ = writeln!(text, "{}", row(engine, &map, |p| p.engine == engine));
    }
    let _ =
        writeln!(text, "\n| structure | points | median | lowest | highest | within 5 % |\n|---|---|---|---|---|---|");
    for structure in each(&map, |p| &p.structure) {
        let _ = writeln!(text, "{}", row(structure, &map, |p| p.structure == structure && p.predicted.is_some()));
    }
    for (sweep, unit, value) in [
        ("aspect", "length over width", (|p| p.aspect) as fn(&StabilityPoint) -> f64),
        ("thickness", "mm", |p| 1e3 * p.thickness_m),
        ("jump", "K", |p| p.jump_k),
        ("speed", "m/s", |p| p.speed_m_s),
    ] {
        let of: Vec<&StabilityPoint> = points.iter().filter(|p| p.sweep == sweep).collect();
        sweep_table(&mut text, sweep, unit, &of, value);
    }
    thesis(&mut text, points);
    text
}

/// Distinct values of a field, in the order of occurrence.
fn each<'a>(points: &[&'a StabilityPoint], field: impl Fn(&'a StabilityPoint) -> &'a String) -> Vec<&'a str> {
    let mut all: Vec<&str> = Vec::new();
    for point in points {
        let value = field(point).as_str();
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}

fn row(name: &str, map: &[&StabilityPoint], of: impl Fn(&StabilityPoint) -> bool) -> String {
    let mine: Vec<&&StabilityPoint> = map.iter().filter(|p| of(p)).collect();
    let mut ratios: Vec<f64> = mine.iter().filter_map(|p| p.ratio()).collect();
    if ratios.is_empty() {
        let broken = mine.iter().filter(|p| p.found.is_some()).count();
        return format!("| {name} | {} | no limit: {broken} broken by steps of up to 1 s | | | |", mine.len());
    }
    ratios.sort_by(f64::total_cmp);
    let near = ratios.iter().filter(|r| (*r - 1.0).abs() <= RATIO_TOLERANCE).count();
    let (low, high) = (ratios[0], ratios[ratios.len() - 1]);
    format!(
        "| {name} | {} | {:.3} | {low:.3} | {high:.3} | {near} of {} |",
        mine.len(),
        ratios[ratios.len() / 2],
        ratios.len()
    )
}

fn sweep_table(
    text: &mut String,
    sweep: &str,
    unit: &str,
    points: &[&StabilityPoint],
    value: impl Fn(&StabilityPoint) -> f64,
) {
    let mut values: Vec<f64> = points.iter().map(|p| value(p)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.is_empty() {
        return;
    }
    let _ = writeln!(text, "\n## {sweep}, {unit}: longest step found, ms (over predicted)\n");
    let head: Vec<String> = values.iter().map(|v| format!("{v}")).collect();
    let _ = writeln!(text, "| structure | engine | {} |\n|---|---|{}", head.join(" | "), "---|".repeat(values.len()));
    for structure in each(points, |p| &p.structure) {
        for engine in each(points, |p| &p.engine) {
            let cell = |v: &f64| {
                let at = points.iter().find(|p| p.structure == structure && p.engine == engine && value(p) == *v);
                at.map_or_else(String::new, |p| cell(p))
            };
            let cells: Vec<String> = values.iter().map(cell).collect();
            let _ = writeln!(text, "| {structure} | {engine} | {} |", cells.join(" | "));
        }
    }
}

fn cell(point: &StabilityPoint) -> String {
    let found = point.found.map_or_else(|| "any".to_owned(), |f| format!("{:.2}", 1e3 * f));
    point.ratio().map_or_else(|| found.clone(), |r| format!("{found} ({r:.2})"))
}

/// Largest stable factors on the thesis's settings.
fn thesis(text: &mut String, points: &[StabilityPoint]) {
    for (sweep, title) in [
        ("thesis", "The thesis's engines, each at its own setting: how much harder until it breaks"),
        ("thesis-common", "The same, all at the second-order setting and one step"),
    ] {
        let of: Vec<&StabilityPoint> = points.iter().filter(|p| p.sweep == sweep).collect();
        if of.is_empty() {
            continue;
        }
        let _ = writeln!(text, "\n## {title}\n");
        let _ = writeln!(
            text,
            "| engine | stiffness, N/m | damping | step, ms | longer step | stiffer | lighter | less damping |\n\
             |---|---|---|---|---|---|---|---|"
        );
        for engine in each(&of, |p| &p.engine) {
            let at = |varied: &str| of.iter().find(|p| p.engine == engine && p.varied == varied);
            let Some(first) = at("step") else { continue };
            let more = |varied: &str| {
                let Some(point) = at(varied) else { return String::new() };
                let percent = |by: f64| format!("{:+.0} %", 100.0 * (by - 1.0));
                let found = point.found.map_or_else(|| "any".to_owned(), percent);
                point.predicted.map_or_else(|| found.clone(), |p| format!("{found} ({})", percent(p)))
            };
            let less = |varied: &str| match at(varied).map(|p| p.found) {
                Some(Some(by)) => format!("{:.0} % of it", 100.0 / by),
                Some(None) => "none".to_owned(),
                None => String::new(),
            };
            let _ = writeln!(
                text,
                "| {engine} | {} | {:.0} % | {:.1} | {} | {} | {} | {} |",
                first.stiffness_n_m,
                100.0 * first.damping,
                1e3 * first.dt_s.unwrap_or(0.0),
                more("step"),
                more("stiffness"),
                less("mass"),
                less("damping")
            );
        }
    }
}
