//! Numbers of masses and springs of the structures (thesis 4.4.2, table 5.2).

use sheetwork::InputError;
use sheetwork::mesh::structure::{LatticeSpec, StructureKind, generate};

use crate::bench::thesis::{Finding, Row, Verdict};

/// Masses and springs of a structure.
fn counts(structure: StructureKind, grid: (u32, u32, u32)) -> Result<(usize, usize), InputError> {
    let spec = LatticeSpec { structure, grid, size: (0.025, 0.025), gap: 1e-3, cross_over: false };
    let lattice = generate(&spec)?;
    Ok((lattice.positions.len(), lattice.links.len()))
}

pub(crate) const STRUCTURES: Row = Row {
    name: "figures-4.11-4.13",
    title: "Figures 4.11 to 4.13: SaMM, SLaMM and TRiMM",
    says: "Masses of a layer lie over the middles of the cells below; SaMM 11x2x11 has 221 masses and 800 springs, \
           SLaMM one more spring a cell (981), TRiMM three springs between the layers a mass (881); a SaMM of 5x3x4 \
           has 52 and 175.",
    here: "`sheetwork generate --structure samm --grid 11x2x11`.",
    run: || {
        let wanted = [
            (StructureKind::Samm, (11, 2, 11), (221, 800)),
            (StructureKind::Slamm, (11, 2, 11), (221, 981)),
            (StructureKind::Trimm, (11, 2, 11), (221, 881)),
            (StructureKind::Samm, (5, 3, 4), (52, 175)),
        ];
        let mut lines = Vec::new();
        let mut all = true;
        for (structure, grid, wanted) in wanted {
            let found = counts(structure, grid)?;
            all &= found == wanted;
            let (x, y, z) = grid;
            lines.push(format!("{structure} {x}x{y}x{z}: {} masses, {} springs", found.0, found.1));
        }
        Ok(Finding::new(lines.join("; "), Verdict::of(all, "the counts differ")))
    },
};

pub(crate) const TABLE_5_2: Row = Row {
    name: "table-5.2",
    title: "Table 5.2: sizes of the TRiMM sheets",
    says: "8x2x8: 113 masses, 428 springs; 11x2x11: 221, 881; 14x2x14: 366, 1496; 17x2x17: 546, 2273.",
    here: "`sheetwork generate --structure trimm --grid 14x2x14`.",
    run: || {
        let printed = [(8, 113, 428), (11, 221, 881), (14, 366, 1496), (17, 546, 2273)];
        let mut lines = Vec::new();
        let mut springs_agree = true;
        let mut extra = 0;
        for (n, masses, springs) in printed {
            let found = counts(StructureKind::Trimm, (n, 2, n))?;
            springs_agree &= found.1 == springs;
            extra += masses - found.0;
            lines.push(format!("{n}x2x{n}: {} masses, {} springs", found.0, found.1));
        }
        let verdict = if springs_agree && extra == 2 {
            Verdict::Misprint(
                "a layer of n x n and one of (n-1) x (n-1): 14² + 13² = 365, 17² + 16² = 545; the springs of the same \
                 lines fit these counts"
                    .to_owned(),
            )
        } else {
            Verdict::of(springs_agree && extra == 0, "the counts differ")
        };
        Ok(Finding::new(lines.join("; "), verdict))
    },
};
