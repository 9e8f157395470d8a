//! Factorisation and solution of a sheet's matrix with every vector instruction set of this
//! processor.
//!
//! `cargo bench -p sheetwork --bench factor [-- NAME]`. All factors of a case run in turn over many
//! rounds, and the minimum time of each counts, so that other load of the machine affects all
//! equally. Times are CPU times of the thread: factorisation and solution in one call, each alone,
//! and one half solution of a contact's load. `ratio` is the portable `both` over the row's.

use std::time::Instant;

use cpu_time::ThreadTime;
use sheetwork::linear::{Factor, HalfSolutions, InstructionSet, Pattern, SparseLoads, analyse_for};

/// Nodes in layers on a square grid, joined to those at the offsets `reach` (columns, rows).
struct BenchSheet {
    name: &'static str,
    side: i32,
    layers: i32,
    reach: &'static [(i32, i32)],
}

/// The staggered shell: a diamond of 13 points.
const SHELL: &[(i32, i32)] = &[(0, 1), (1, 0), (1, 1), (1, -1), (2, 0), (0, 2)];
/// Two layers, each node joined to all neighbours in both.
const LATTICE: &[(i32, i32)] = &[(0, 0), (0, 1), (1, 0), (1, 1), (1, -1)];

const SHEETS: [BenchSheet; 6] = [
    BenchSheet { name: "shell 11x11", side: 11, layers: 1, reach: SHELL },
    BenchSheet { name: "shell 21x21", side: 21, layers: 1, reach: SHELL },
    BenchSheet { name: "shell 41x41", side: 41, layers: 1, reach: SHELL },
    BenchSheet { name: "shell 81x81", side: 81, layers: 1, reach: SHELL },
    BenchSheet { name: "lattice 21x2x21", side: 21, layers: 2, reach: LATTICE },
    BenchSheet { name: "lattice 41x2x41", side: 41, layers: 2, reach: LATTICE },
];

impl BenchSheet {
    fn pattern(&self) -> (Pattern, Vec<[f64; 2]>) {
        let n = self.side;
        let masses = || (0..n * n * self.layers).map(|i| (i / self.layers / n, i / self.layers % n, i % self.layers));
        let places = masses().map(|(i, j, _)| [f64::from(i) * 0.01, f64::from(j) * 0.01]).collect();
        let inside = |i: i32| (0..n).contains(&i);
        let mut pairs = Vec::new();
        for (own, (i, j, _)) in masses().enumerate() {
            for &(di, dj) in self.reach {
                let (i, j) = (i + di, j + dj);
                if inside(i) && inside(j) {
                    pairs.extend((0..self.layers).map(|l| (own as u32, ((i * n + j) * self.layers + l) as u32)));
                }
            }
        }
        (Pattern::new((n * n * self.layers) as usize, pairs), places)
    }
}

/// Values of a positive definite, diagonally dominant matrix.
fn values(pattern: &Pattern) -> Vec<f64> {
    let mut values: Vec<f64> = (0..9 * pattern.blocks()).map(|i| ((i * 7919) % 1009) as f64 / 1009.0 - 0.5).collect();
    for column in 0..pattern.size() {
        let at = 9 * pattern.starts[column] as usize;
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            values[at + 3 * i + j] = values[at + 3 * j + i];
        }
        for i in 0..3 {
            values[at + 4 * i] = 60.0;
        }
    }
    values
}

/// Loads on four neighbouring nodes, as from contact constraints.
fn contacts(masses: u32, side: u32) -> SparseLoads {
    let mut loads = SparseLoads::default();
    for i in 0..64 {
        let at = |k| (i * 37 + [0, 1, side, side + 1][k]) % masses;
        loads.push((0..4).map(|k| (at(k), [0.1, 0.2, 0.25])));
    }
    loads
}

/// Minimum times, ms: factorisation and solution in one call, each alone, and one half solution.
#[derive(Clone, Copy)]
struct Times {
    both: f64,
    factorise: f64,
    solve: f64,
    half: f64,
}

impl Times {
    const NONE: Self = Self { both: f64::MAX, factorise: f64::MAX, solve: f64::MAX, half: f64::MAX };
}

/// Replaces `least` by the time of `work` (ms) if that is smaller.
fn clock(least: &mut f64, work: impl FnOnce()) {
    let start = ThreadTime::now();
    work();
    *least = least.min(start.elapsed().as_secs_f64() * 1e3);
}

fn round(factor: &mut Factor, values: &[f64], b: &mut [f64], loads: &SparseLoads, least: &mut Times) {
    let mut halves = HalfSolutions::default();
    // Several times, with warm caches as in a sheet's step.
    for _ in 0..4 {
        b.fill(1.0);
        clock(&mut least.both, || factor.factorize_and_solve(values, b).expect("positive definite"));
        clock(&mut least.factorise, || factor.factorize(values).expect("positive definite"));
        clock(&mut least.solve, || factor.solve(b));
        let mut all = f64::MAX;
        clock(&mut all, || factor.half_solve(loads, &mut halves));
        least.half = least.half.min(all / loads.len() as f64);
    }
}

fn main() {
    let chosen = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let head = ["both ms", "factor", "solve", "half us", "Mflop", "numbers", "GFLOP/s", "ratio"];
    println!("{:16} {:22}{}", "sheet", "instructions", head.map(|h| format!("{h:>10}")).concat());
    for sheet in SHEETS.iter().filter(|s| chosen.as_ref().is_none_or(|c| s.name.contains(c.as_str()))) {
        let (pattern, places) = sheet.pattern();
        let values = values(&pattern);
        let loads = contacts(pattern.size() as u32, sheet.side as u32);
        let mut factors: Vec<_> =
            InstructionSet::ALL.into_iter().filter_map(|path| analyse_for(&pattern, &places, path)).collect();
        let mut times = vec![Times::NONE; factors.len()];
        let mut b = vec![1.0; 3 * pattern.size()];
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < 4.0 {
            for (factor, least) in factors.iter_mut().zip(&mut times) {
                round(factor, &values, &mut b, &loads, least);
            }
        }
        for (factor, t) in factors.iter().zip(&times) {
            let mflop = factor.flops() / 1e6;
            println!(
                "{:16} {:22}{:10.4}{:10.4}{:10.4}{:10.2}{:10.2}{:10}{:10.1}{:10.2}",
                sheet.name,
                factor.name(),
                t.both,
                t.factorise,
                t.solve,
                t.half * 1e3,
                mflop,
                factor.nonzeros(),
                mflop / t.factorise,
                times[0].both / t.both
            );
        }
    }
}
