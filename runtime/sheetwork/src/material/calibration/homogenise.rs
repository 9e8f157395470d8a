//! Homogenisation: the plate equivalent to a lattice on scales much larger than its cells.
//!
//! A uniform strain ε and curvature κ is imposed on a periodic cell, u = ε x - y κ x and w = ½
//! xᵀκx, and the nodes of the cell relax (Cauchy-Born rule with internal relaxation; for plates see
//! Sab and Lebée, *Homogenization of Heterogeneous Thin and Thick Plates*, 2015, chapter 5). The
//! energy per area is ½ εᵀAε + εᵀBκ + ½ κᵀDκ. Heights y are from the middle of the sheet. A in N/m,
//! B in N, D in N m.
//!
//! Transverse shear: under a load cos(q·x) per area the plate deflects by 1/(D q⁴) without shear; a
//! Bloch wave of the cell gives the deflection with compliant inter-layer springs.

use glam::{DVec2, DVec3};

use crate::material::calibration::cell::{CellSpring, PeriodicCell};
use crate::material::calibration::dense::SymmetricMatrix;
use crate::material::calibration::target::Voigt;

/// Stiffness of a plate per area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PlateStiffness {
    /// A, N/m.
    pub membrane: Voigt,
    /// B, N.
    pub coupling: Voigt,
    /// D, N m, with an unstrained middle of the sheet.
    pub bending: Voigt,
}

impl PlateStiffness {
    /// Bending stiffness with a free membrane: D - Bᵀ A⁻¹ B, N m.
    pub fn free_bending(&self) -> Voigt {
        condensed(&self.bending, &self.membrane, &transpose(&self.coupling))
    }

    /// Membrane stiffness with free bending: A - B D⁻¹ Bᵀ, N/m.
    pub fn free_membrane(&self) -> Voigt {
        condensed(&self.membrane, &self.bending, &self.coupling)
    }
}

fn transpose(m: &Voigt) -> Voigt {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// `kept` - c `away`⁻¹ cᵀ.
fn condensed(kept: &Voigt, away: &Voigt, c: &Voigt) -> Voigt {
    let mut matrix = SymmetricMatrix::zeros(3);
    for i in 0..3 {
        for j in 0..3 {
            matrix.add(i, j, away[i][j]);
        }
    }
    let mut columns: Vec<Vec<f64>> = c.iter().map(|row| row.to_vec()).collect();
    matrix.solve(&mut columns);
    std::array::from_fn(|i| std::array::from_fn(|j| kept[i][j] - (0..3).map(|m| c[i][m] * columns[j][m]).sum::<f64>()))
}

/// Displacement of a point under a uniform strain or curvature, `(ε11, ε22, γ12, κ11, κ22, 2
/// κ12)[mode]` = 1.
pub(crate) fn uniform(mode: usize, p: DVec3) -> DVec3 {
    let (x, y, z) = (p.x, p.y, p.z);
    match mode {
        0 => DVec3::new(x, 0.0, 0.0),
        1 => DVec3::new(0.0, 0.0, z),
        2 => DVec3::new(0.5 * z, 0.0, 0.5 * x),
        3 => DVec3::new(-y * x, 0.5 * x * x, 0.0),
        4 => DVec3::new(0.0, 0.5 * z * z, -y * z),
        _ => DVec3::new(-0.5 * y * z, 0.5 * x * z, -0.5 * y * x),
    }
}

/// Elongation of a bond under each uniform mode, m. The origin lies under the bond, which only
/// changes a rigid motion.
fn stretches(bond: &CellSpring) -> [f64; 6] {
    let origin = bond.middle() * DVec3::new(1.0, 0.0, 1.0);
    let n = bond.direction();
    std::array::from_fn(|m| n.dot(uniform(m, bond.to - origin) - uniform(m, bond.from - origin)))
}

/// Energy matrix of the imposed modes with relaxed nodes, J per cell.
///
/// `stretch(bond)` is the elongation of a bond under each mode before relaxation.
pub(crate) fn relaxed<const M: usize>(
    cell: &PeriodicCell,
    k: &[f64],
    stretch: impl Fn(&CellSpring) -> [f64; M],
) -> [[f64; M]; M] {
    let mut matrix = SymmetricMatrix::zeros(3 * cell.masses);
    let mut energy = [[0.0; M]; M];
    let mut loads = vec![vec![0.0; 3 * cell.masses]; M];
    for (bond, k) in cell.springs.iter().zip(k).filter(|(_, k)| **k > 0.0) {
        let modes = stretch(bond);
        for i in 0..M {
            for j in 0..M {
                energy[i][j] += k * modes[i] * modes[j];
            }
        }
        if bond.a == bond.b {
            continue;
        }
        let n = bond.direction().to_array();
        let entries: [(usize, f64); 6] =
            std::array::from_fn(|e| if e < 3 { (3 * bond.a + e, -n[e]) } else { (3 * bond.b + e - 3, n[e - 3]) });
        matrix.add_outer(*k, &entries);
        for (load, mode) in loads.iter_mut().zip(modes) {
            for (at, value) in entries {
                load[at] += k * mode * value;
            }
        }
    }
    let pull = loads.clone();
    matrix.solve(&mut loads);
    for i in 0..M {
        for j in 0..M {
            energy[i][j] -= pull[i].iter().zip(&loads[j]).map(|(f, u)| f * u).sum::<f64>();
        }
    }
    energy
}

/// Plate equivalent to a cell with spring stiffnesses `k` (N/m, one per bond).
pub(crate) fn homogenise(cell: &PeriodicCell, k: &[f64]) -> PlateStiffness {
    let area = cell.extent.0 * cell.extent.1;
    let h = relaxed(cell, k, stretches);
    let block = |r: usize, c: usize| std::array::from_fn(|i| std::array::from_fn(|j| h[r + i][c + j] / area));
    PlateStiffness { membrane: block(0, 0), coupling: block(0, 3), bending: block(3, 3) }
}

/// Plate equivalent to springs of stiffness `share` (one per bond) without relaxation: linear in
/// the stiffnesses, and exact for springs between nodes of one kind.
pub(crate) fn affine(cell: &PeriodicCell, share: impl Fn(&CellSpring) -> f64) -> PlateStiffness {
    let area = cell.extent.0 * cell.extent.1;
    let mut plate = PlateStiffness::default();
    for bond in &cell.springs {
        let k = share(bond) / area;
        let s = stretches(bond);
        for i in 0..3 {
            for j in 0..3 {
                plate.membrane[i][j] += k * s[i] * s[j];
                plate.coupling[i][j] += k * s[i] * s[3 + j];
                plate.bending[i][j] += k * s[3 + i] * s[3 + j];
            }
        }
    }
    plate
}

/// Bending stiffness for a wave of load of the given length (m) at `angle` (rad) from x, N m.
///
/// `None` when the wave meets no stiffness.
pub(crate) fn wave_bending(cell: &PeriodicCell, k: &[f64], wavelength: f64, angle: f64) -> Option<f64> {
    let unknowns = 3 * cell.masses;
    let number = std::f64::consts::TAU / wavelength;
    let q = number * DVec2::from_angle(angle);
    let mut matrix = SymmetricMatrix::zeros(2 * unknowns);
    for (bond, k) in cell.springs.iter().zip(k).filter(|(_, k)| **k > 0.0) {
        let n = bond.direction().to_array();
        let span = bond.to - bond.from;
        let (sin, cos) = q.dot(DVec2::new(span.x, span.z)).sin_cos();
        // Amplitude of the elongation, real and imaginary, in the real and imaginary parts of the
        // displacements.
        let mut real = Vec::with_capacity(12);
        let mut imaginary = Vec::with_capacity(12);
        for (d, n) in n.iter().enumerate() {
            let (a, b) = (3 * bond.a + d, 3 * bond.b + d);
            real.extend([(a, -n), (b, n * cos), (unknowns + b, -n * sin)]);
            imaginary.extend([(unknowns + a, -n), (unknowns + b, n * cos), (b, n * sin)]);
        }
        matrix.add_outer(*k, &real);
        matrix.add_outer(*k, &imaginary);
    }
    let mut load = vec![0.0; 2 * unknowns];
    let share = cell.extent.0 * cell.extent.1 / cell.masses as f64;
    (0..cell.masses).for_each(|b| load[3 * b + 1] = share);
    let mut solution = [load];
    matrix.solve(&mut solution);
    let deflection = (0..cell.masses).map(|b| solution[0][3 * b + 1]).sum::<f64>() / cell.masses as f64;
    (deflection > 0.0).then(|| 1.0 / (deflection * number.powi(4)))
}
