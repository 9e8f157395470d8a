//! Random materials, sizes, poses and kicks: which go unstable or gain energy. Arguments: how many, structures by commas,
//! and anything more to print every run.

use sheetwork::lattice::StructureKind;
use sheetwork::measure::kicks::kick;

fn main() {
    let runs: u64 = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(50);
    let kinds: Vec<StructureKind> =
        std::env::args().nth(2).unwrap_or("shell".into()).split(',').map(|s| s.parse().unwrap()).collect();
    let (mut bad, mut gained) = (0, 0);
    for i in 0..runs {
        let k = kick(i, &kinds, 2.0).unwrap();
        if k.unstable.is_some() {
            bad += 1;
        }
        if k.energy_ratio > 1.001 {
            gained += 1;
        }
        if k.unstable.is_some() || k.energy_ratio > 1.001 || std::env::args().nth(3).is_some() {
            println!("{k:?}");
        }
    }
    println!("{runs} runs, {bad} unstable, {gained} gained energy");
}
