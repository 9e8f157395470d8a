//! Samples of a run for plots and CSV: energies, step time, heights of probes, temperatures and
//! delivered stiffness.
//!
//! At most [`MAX_SAMPLES`] samples are stored. When they are full, every second one is dropped, so
//! that a long run is covered at a coarser interval.

use std::fmt::Write as _;

use sheetwork::World;
use sheetwork::profiler::Phase;

/// Maximum number of samples.
pub const MAX_SAMPLES: usize = 8192;

/// Sample of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Simulated time, s.
    pub time: f64,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Elastic energy, J.
    pub elastic: f64,
    /// Potential energy, J, zero at the origin.
    pub gravity: f64,
    /// Wall-clock time of a step, s; 0 before the first.
    pub step_s: f64,
    /// Wall-clock time of each phase of a step ([`Phase::ALL`]), s; `None` while not measured.
    pub stages: Option<[f64; Phase::ALL.len()]>,
    /// Height of each probe, or of the centre of mass of each sheet without probes, m.
    pub heights: Vec<f64>,
    /// Smallest ratio of delivered to requested stiffness; `None` where no sheet requests a
    /// stiffness.
    pub delivered: Option<f64>,
    /// Lowest, mean and highest temperature of all sheets, °C; `None` without heat sources.
    pub celsius: Option<[f64; 3]>,
}

impl Sample {
    /// Sum of the energies, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity
    }

    /// Sample of the present state of `world`.
    pub fn from_world(world: &World, step_s: f64) -> Self {
        let mut sample = Self { time: world.time(), step_s, heights: heights(world).collect(), ..Self::default() };
        let mut all = (f64::INFINITY, 0.0, f64::NEG_INFINITY, 0.0);
        for sheet in world.sheets() {
            let energy = sheet.energy(world.gravity());
            sample.kinetic += energy.kinetic;
            sample.elastic += energy.elastic;
            sample.gravity += energy.gravity;
            if let Some(found) = sheet.delivered_stiffness(world.dt()) {
                let part = found.bends_as_pa / found.asked_pa.max(1e-300);
                sample.delivered = Some(sample.delivered.map_or(part, |least| least.min(part)));
            }
            if let Some(heat) = sheet.heat() {
                let (low, high) = heat.range();
                let sum: f64 = heat.celsius().iter().sum();
                all = (all.0.min(low), all.1 + sum, all.2.max(high), all.3 + heat.celsius().len() as f64);
            }
        }
        sample.celsius = (all.3 > 0.0).then(|| [all.0, all.1 / all.3, all.2]);
        sample
    }
}

/// Heights of the probes of every sheet of `world`, or of its centre of mass where it has none, m.
pub fn heights(world: &World) -> impl Iterator<Item = f64> {
    world.sheets().iter().flat_map(|sheet| {
        let middle = sheet.probes.is_empty().then(|| sheet.centre_of_mass().y);
        middle.into_iter().chain(sheet.probes.iter().map(|p| p.at(&sheet.state.x).y))
    })
}

/// Names of [`Sample::heights`]: "sheet probe".
pub fn height_names(world: &World) -> Vec<String> {
    let of = |sheet: &sheetwork::sheet::Sheet| {
        let probes = sheet.probes.iter().map(|p| format!("{} {}", sheet.name, p.name));
        if sheet.probes.is_empty() { vec![format!("{} middle", sheet.name)] } else { probes.collect() }
    };
    world.sheets().iter().flat_map(of).collect()
}

/// Samples of a run.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    all: Vec<Sample>,
    /// Sampling interval, in calls of `push`.
    every: u32,
    waiting: u32,
}

impl Samples {
    /// Delete all samples.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Add a sample.
    pub fn push(&mut self, sample: Sample) {
        self.waiting += 1;
        if self.waiting < self.every {
            return;
        }
        self.waiting = 0;
        if self.all.len() >= MAX_SAMPLES {
            let mut index = 0;
            self.all.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.every = 2 * self.every.max(1);
        }
        self.all.push(sample);
    }

    /// Delete samples after `time` (s), which will be simulated again.
    pub fn discard_after(&mut self, time: f64) {
        let kept = self.all.partition_point(|s| s.time <= time + 1e-12);
        self.all.truncate(kept);
    }

    /// All samples, oldest first.
    pub fn all(&self) -> &[Sample] {
        &self.all
    }

    /// First height at `time` (s), interpolated linearly, m; `None` outside the samples.
    pub fn height_at(&self, time: f64) -> Option<f64> {
        let after = self.all.partition_point(|s| s.time < time);
        let (b, a) = (self.all.get(after)?, self.all.get(after.saturating_sub(1))?);
        let (from, to) = (*a.heights.first()?, *b.heights.first()?);
        let part = if b.time > a.time { (time - a.time) / (b.time - a.time) } else { 1.0 };
        (time >= a.time - 1e-12).then_some(from + (to - from) * part)
    }

    /// CSV table with a header of names and units; `heights` are the names of the heights.
    pub fn csv(&self, heights: &[String]) -> String {
        let mut text =
            String::from("time_s,kinetic_j,elastic_j,gravity_j,total_j,step_s,coldest_c,mean_c,hottest_c,delivered");
        let timed = self.all.iter().any(|s| s.stages.is_some());
        if timed {
            Phase::ALL.iter().for_each(|(_, name)| _ = write!(text, ",{name}_s"));
        }
        for name in heights {
            // Quotation marks in a user's name are doubled, as CSV requires.
            let _ = write!(text, ",\"height_m {}\"", name.replace('"', "\"\""));
        }
        text.push('\n');
        for s in &self.all {
            let _ = write!(text, "{},{},{},{},{},{}", s.time, s.kinetic, s.elastic, s.gravity, s.total(), s.step_s);
            match s.celsius {
                Some([low, mean, high]) => _ = write!(text, ",{low},{mean},{high}"),
                None => text.push_str(",,,"),
            }
            let _ = write!(text, ",{}", s.delivered.map_or_else(String::new, |part| part.to_string()));
            if timed {
                (0..Phase::ALL.len()).for_each(|i| {
                    let _ = write!(text, ",{}", s.stages.map_or_else(String::new, |all| all[i].to_string()));
                });
            }
            for height in &s.heights {
                let _ = write!(text, ",{height}");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{OvenSpec, Scene, SheetSpec};

    fn at(time: f64) -> Sample {
        Sample { time, heights: vec![1.0], ..Sample::default() }
    }

    #[test]
    fn a_long_run_is_covered_in_bounded_memory() {
        let mut samples = Samples::default();
        for i in 0..10 * MAX_SAMPLES {
            samples.push(at(i as f64));
        }
        assert!(samples.all().len() <= MAX_SAMPLES && samples.all().len() > MAX_SAMPLES / 4);
        assert_eq!(samples.all()[0].time, 0.0);
        assert!(samples.all().last().expect("some").time > 9.9 * MAX_SAMPLES as f64);
        assert!(samples.all().windows(2).all(|w| w[0].time < w[1].time));
        samples.discard_after(100.0);
        assert!(samples.all().iter().all(|s| s.time <= 100.0) && !samples.all().is_empty());
    }

    #[test]
    fn a_table_has_as_many_columns_in_every_line() {
        let spec = SheetSpec { name: "a \"b\"".into(), ..SheetSpec::thesis() };
        let scene = Scene { sheets: vec![spec], oven: Some(OvenSpec::default()), ..Scene::thesis() };
        let world = World::new(&scene).expect("valid");
        let mut samples = Samples::default();
        samples.push(Sample::from_world(&world, 1e-4));
        samples.push(at(1.0));
        let names = height_names(&world);
        assert_eq!(names.len(), samples.all()[0].heights.len());
        let csv = samples.csv(&names);
        let columns: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
        assert_eq!(columns, [11, 11, 11]);
        assert!(csv.contains("\"height_m a \"\"b\"\" middle\""), "{csv}");
        assert!(samples.all()[0].celsius.is_some_and(|[low, mean, high]| low <= mean && mean <= high));
    }
}
