//! Factorisation and solution of a sheet's matrix: faer beside our own factor on every path this processor has.
//!
//! `cargo bench -p sheetwork --bench factor [-- NAME]`. Every factor of a case is run in turn, many rounds, and the least
//! time of each counts, so that other load on the machine falls on all alike. Times are CPU time of the thread, ms: of
//! factorisation with one solution, and of the solution alone; `ratio` is faer's over the row's.

use std::time::Instant;

use cpu_time::ThreadTime;
use sheetwork::engine::linear::{Backend, Factor, Path, Pattern, analyse, analyse_for};

/// Masses in layers on a square grid, joined to those at `reach` columns and rows.
struct Sheet {
    name: &'static str,
    side: i32,
    layers: i32,
    reach: &'static [(i32, i32)],
}

/// The staggered shell: a diamond of 13 points.
const SHELL: &[(i32, i32)] = &[(0, 1), (1, 0), (1, 1), (1, -1), (2, 0), (0, 2)];
/// Two layers, a mass joined to all around it in both.
const LATTICE: &[(i32, i32)] = &[(0, 0), (0, 1), (1, 0), (1, 1), (1, -1)];

const SHEETS: [Sheet; 6] = [
    Sheet { name: "shell 11x11", side: 11, layers: 1, reach: SHELL },
    Sheet { name: "shell 21x21", side: 21, layers: 1, reach: SHELL },
    Sheet { name: "shell 41x41", side: 41, layers: 1, reach: SHELL },
    Sheet { name: "shell 81x81", side: 81, layers: 1, reach: SHELL },
    Sheet { name: "lattice 21x2x21", side: 21, layers: 2, reach: LATTICE },
    Sheet { name: "lattice 41x2x41", side: 41, layers: 2, reach: LATTICE },
];

impl Sheet {
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

/// Values of a positive definite matrix: a diagonal that outweighs its row.
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

/// Least times of factorisation with solution and of solution, ms.
#[derive(Clone, Copy)]
struct Times {
    both: f64,
    solve: f64,
}

fn round(factor: &mut dyn Factor, values: &[f64], b: &mut [f64], least: &mut Times) {
    let start = ThreadTime::now();
    factor.factorize(values).expect("positive definite");
    let middle = start.elapsed();
    factor.solve(b);
    let both = start.elapsed();
    least.both = least.both.min(both.as_secs_f64() * 1e3);
    least.solve = least.solve.min((both - middle).as_secs_f64() * 1e3);
}

fn main() {
    let chosen = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    println!(
        "{:16} {:24} {:>9} {:>9} {:>7} {:>9} {:>9} {:>6}",
        "sheet", "factor", "ms", "solve", "Mflop", "numbers", "GFLOP/s", "ratio"
    );
    for sheet in SHEETS.iter().filter(|s| chosen.as_ref().is_none_or(|c| s.name.contains(c.as_str()))) {
        let (pattern, places) = sheet.pattern();
        let values = values(&pattern);
        let mut factors = vec![analyse(&pattern, &places, Backend::Faer)];
        factors.extend(Path::ALL.into_iter().rev().filter_map(|path| analyse_for(&pattern, &places, path)));
        let mut times = vec![Times { both: f64::MAX, solve: f64::MAX }; factors.len()];
        let mut b = vec![1.0; 3 * pattern.size()];
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < 2.0 {
            for (factor, least) in factors.iter_mut().zip(&mut times) {
                b.fill(1.0);
                round(&mut **factor, &values, &mut b, least);
            }
        }
        for (factor, t) in factors.iter().zip(&times) {
            let [mflop, numbers] = [factor.flops() / 1e6, factor.nonzeros() as f64];
            let rate = mflop / (t.both - t.solve);
            let ratio = times[0].both / t.both;
            println!(
                "{:16} {:24} {:9.4} {:9.4} {:7.2} {:9} {:9.1} {:6.2}",
                sheet.name,
                factor.name(),
                t.both,
                t.solve,
                mflop,
                numbers,
                rate,
                ratio
            );
        }
    }
}
