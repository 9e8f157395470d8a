//! Plots of the run: energies, step time, heights of probes, temperature.

use bevy_egui::egui::{Color32, Ui, vec2};

use super::chart::{Line, chart};
use super::dialog::Purpose;
use super::style::{ELASTIC, GRAVITY, KINETIC, QUIET, TOTAL};
use super::{EditorState, Plots};
use crate::samples::{Sample, height_names};
use crate::session::Session;
use sheetwork::profiler::Phase;

/// Colours of heights and of compared worlds, in turn.
pub(super) const COLOURS: [Color32; 6] = [
    Color32::from_rgb(240, 150, 70),
    Color32::from_rgb(95, 170, 235),
    Color32::from_rgb(140, 200, 120),
    Color32::from_rgb(230, 110, 160),
    Color32::from_rgb(170, 140, 230),
    Color32::from_rgb(210, 200, 90),
];

/// Plots side by side, and their options.
pub fn plots(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let mut export = false;
    ui.horizontal(|ui| {
        let plots = &mut state.plots;
        ui.checkbox(&mut plots.energy, "Energy");
        ui.checkbox(&mut plots.step, "Step time");
        ui.checkbox(&mut plots.stages, "Stages").on_hover_text(
            "Wall-clock time of a step's phases: motion, collision detection, contact solver, heat, bodies; measured only while this is on",
        );
        ui.checkbox(&mut plots.height, "Height");
        ui.checkbox(&mut plots.temperature, "Temperature");
        ui.checkbox(&mut plots.stiffness, "Delivered").on_hover_text(
            "Delivered bending stiffness relative to the requested one, after structure, grid and time step",
        );
        export = ui.button("Export CSV…").on_hover_text("All samples of the run as a table").clicked();
    });
    if export {
        state.browse(session, Purpose::Csv);
    }
    let charts = charts(session, state.plots);
    let count = charts.len().max(1) as f32;
    let width = (ui.available_width() - 8.0 * (count - 1.0)) / count;
    let size = vec2(width, (ui.available_height() - 2.0).max(80.0));
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (title, unit, lines) in &charts {
            chart(ui, size, (title, unit), session.history(), lines);
        }
    });
}

/// Title, unit and lines of a chart.
type Chart<'a> = (&'static str, &'static str, Vec<Line<'a>>);

/// Requested charts that have data.
fn charts(session: &Session, plots: Plots) -> Vec<Chart<'_>> {
    let last = session.history().last();
    let heated = last.is_some_and(|s| s.celsius.is_some());
    let aims = last.is_some_and(|s| s.delivered.is_some());
    let compared = session.shown(1).is_some();
    let mut all = Vec::new();
    if plots.energy {
        all.push(("Energy", "J", energies(session)));
    }
    if plots.step {
        let dt = session.world().dt();
        let took = |s: &Sample| (s.step_s > 0.0).then_some(s.step_s);
        let lines = vec![Line::new("step", KINETIC, took), Line::new("real time", QUIET, move |_| Some(dt))];
        all.push(("Step time", "s", lines));
    }
    if plots.stages {
        all.push(("Stages of a step", "s", stages(session)));
    }
    if plots.height && !compared {
        all.push(("Height", "m", heights(session)));
    }
    if plots.temperature && heated {
        let lines = vec![
            Line::new("highest", Color32::from_rgb(240, 90, 60), |s| Some(s.celsius?[2])),
            Line::new("mean", KINETIC, |s| Some(s.celsius?[1])),
            Line::new("lowest", ELASTIC, |s| Some(s.celsius?[0])),
        ];
        all.push(("Temperature", "°C", lines));
    }
    if plots.stiffness && aims {
        let part = |s: &Sample| Some(100.0 * s.delivered?);
        let lines = vec![Line::new("requested", QUIET, |_| Some(100.0)), Line::new("delivered", ELASTIC, part)];
        all.push(("Stiffness", "%", lines));
    }
    if compared {
        all.push(("Heights", "m", beside(session)));
        all.push(("Differences of height", "m", differences(session)));
    }
    all
}

/// Energies; potential and total energy relative to their minimum, because the zero of the height
/// is arbitrary.
fn energies(session: &Session) -> Vec<Line<'_>> {
    let lowest = session.history().iter().map(|s| s.gravity).fold(f64::INFINITY, f64::min);
    vec![
        Line::new("total", TOTAL, move |s| Some(s.total() - lowest)),
        Line::new("potential", GRAVITY, move |s| Some(s.gravity - lowest)),
        Line::new("elastic", ELASTIC, |s| Some(s.elastic)),
        Line::new("kinetic", KINETIC, |s| Some(s.kinetic)),
    ]
}

/// Heights of probes. The name of a single sheet is omitted.
fn heights(session: &Session) -> Vec<Line<'_>> {
    let alone = session.world().sheets().first().filter(|_| session.world().sheets().len() == 1);
    let short = |name: String| match alone.and_then(|sheet| name.strip_prefix(&format!("{} ", sheet.name))) {
        Some(rest) => rest.to_owned(),
        None => name,
    };
    let names = height_names(session.world()).into_iter().map(short);
    let line = |(i, name): (usize, String)| Line::new(name, COLOURS[i], move |s: &Sample| s.heights.get(i).copied());
    names.take(COLOURS.len()).enumerate().map(line).collect()
}

/// Wall-clock times of the phases of a step, without those below 1 % of the run.
fn stages(session: &Session) -> Vec<Line<'_>> {
    let mut spent = [0.0; Phase::ALL.len()];
    let timed = session.history().iter().filter_map(|s| s.stages);
    timed.for_each(|all| spent.iter_mut().zip(all).for_each(|(sum, part)| *sum += part));
    let worth = |i: usize| spent[i] > 0.01 * spent.iter().sum::<f64>();
    let line = |(i, (_, name)): (usize, &(Phase, &'static str))| {
        Line::new(*name, COLOURS[i], move |s: &Sample| s.stages.map(|all| all[i]))
    };
    Phase::ALL.iter().enumerate().filter(|(i, _)| worth(*i)).map(line).collect()
}

/// First height of every variant, minus that of this scene at the same time.
fn differences(session: &Session) -> Vec<Line<'_>> {
    of_variants(session, |s| Some(s.heights.first()? - height_at(session.history(), s.time)?)).collect()
}

/// Line of every variant.
fn of_variants<'a>(
    session: &'a Session,
    value: impl Fn(&Sample) -> Option<f64> + Copy + 'a,
) -> impl Iterator<Item = Line<'a>> {
    session.variants().enumerate().filter_map(move |(index, (variant, found))| {
        let colour = COLOURS[(index + 1) % COLOURS.len()];
        Some(Line::new(variant.value.clone(), colour, value).with_history(found.ok()?.history()))
    })
}

/// First height of a run at `time`, interpolated between samples.
fn height_at(history: &[Sample], time: f64) -> Option<f64> {
    let after = history.partition_point(|s| s.time < time);
    let high = history.get(after.min(history.len().checked_sub(1)?))?;
    let low = history.get(after.saturating_sub(1))?;
    let (a, b) = (*low.heights.first()?, *high.heights.first()?);
    let span = high.time - low.time;
    let s = if span > 0.0 { ((time - low.time) / span).clamp(0.0, 1.0) } else { 0.0 };
    Some(a + s * (b - a))
}

/// First height of every compared world.
fn beside(session: &Session) -> Vec<Line<'_>> {
    let height = |s: &Sample| s.heights.first().copied();
    std::iter::once(Line::new("scene", COLOURS[0], height)).chain(of_variants(session, height)).collect()
}
