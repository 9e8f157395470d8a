//! The sheet as a Rapier soft body: particles, springs for stretch, dihedral hinges for bending.
//!
//! Rapier's springs and hinges are given as natural frequencies of the mass they move, ω² = k w, w
//! = Σ |∇C|² / m. Here each is turned back into the stiffness k of the sheet: a hinge at a node on
//! a line of spacing h bends with k = D b / h for each of the lines that share the width b (½ k θ²
//! with θ = κ h is ½ D κ² over h b), D = E t³ / 12, and its w is 6 / (m h²). Springs along the
//! sides and both diagonals of a cell carry an isotropic membrane of Poisson ratio 1/3, ⅔ and ⅓ of
//! E t / (1 - ν²). SI units.

use std::f64::consts::TAU;

use rapier3d::prelude::*;

/// Side of the square, m.
pub const LENGTH: f64 = 0.25;
/// Thickness, m.
pub const THICKNESS: f64 = 5e-4;
/// Young's modulus, Pa.
pub const YOUNG: f64 = 3e9;
/// Density, kg/m³.
pub const DENSITY: f64 = 1050.0;
/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// Where the hinges sit.
#[derive(Clone, Copy, PartialEq)]
pub enum Hinges {
    /// On the edges of Rapier's own cloth triangulation, by its own `surface_dihedrals`.
    Surface,
    /// At every node, along and across, on the two triangles either side of it on its grid line,
    /// and on each cell's diagonal: a discretisation of ours in Rapier's terms, and the kindest
    /// found.
    Lines,
}

impl Hinges {
    /// Factor on the membrane stiffness of the sheet, which still stretches by less than a
    /// thousandth under its weight: the most favourable of 1, 0.1, 0.01 and 0.001 with which the
    /// soft body comes to rest; line hinges hardly depend on it.
    fn membrane(self) -> f64 {
        match self {
            Self::Surface => 0.1,
            Self::Lines => 0.01,
        }
    }
}

struct Springs {
    edges: Vec<[u32; 2]>,
    softness: Vec<(u32, SpringCoefficients<f64>)>,
}

/// A grid of n x n particles with two pinned rows; the clamp lies half a spacing beyond the last of
/// them, because hinges that touch pinned particles move less mass and are stiffer by just that.
pub struct Grid {
    n: usize,
    along: f64,
    across: f64,
}

impl Grid {
    /// `n` particles a side, 5 or more.
    pub fn new(n: usize) -> Self {
        Self { n, along: LENGTH / (n as f64 - 2.5), across: LENGTH / (n as f64 - 1.0) }
    }

    /// The particles of the free edge.
    pub fn free_edge(&self) -> std::ops::Range<usize> {
        (self.n - 1) * self.n..self.n * self.n
    }

    /// The soft body; `damping` gives a spring's damping ratio by its frequency, rad/s.
    pub fn body(&self, hinges: Hinges, damping: impl Fn(f64) -> f64) -> SoftBodyBuilder {
        let masses = self.masses();
        let Springs { edges, softness } =
            self.springs(&masses, hinges.membrane() * YOUNG * THICKNESS / (1.0 - 1.0 / 9.0), &damping);
        let bending = YOUNG * THICKNESS.powi(3) / 12.0;
        let hinge = bending * LENGTH / (self.n as f64 * self.along);
        let omega = (6.0 * hinge / (masses[0] * self.along * self.along)).sqrt();
        let mut body = SoftBodyBuilder::new(self.positions()).masses(masses).surface(self.surface()).edges(edges);
        body.edge_softness = softness;
        let dihedrals = match hinges {
            Hinges::Surface => body.surface_dihedrals(),
            Hinges::Lines => self.line_hinges(),
        };
        let bend_softness = SpringCoefficients::new(omega / TAU, damping(omega));
        body.dihedrals(dihedrals)
            .material(SoftBodyMaterial { bend_softness, ..Default::default() })
            .pinned_particles((0..2 * self.n as u32).collect::<Vec<_>>())
            .no_surface_collider()
            .can_sleep(false)
    }

    fn id(&self, row: usize, column: usize) -> u32 {
        (row * self.n + column) as u32
    }

    fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.n;
        (0..n * n).map(move |k| (k / n, k % n))
    }

    fn positions(&self) -> Vec<Vector> {
        let place = |(i, j): (usize, usize)| Vector::new((i as f64 - 1.5) * self.along, 0.0, j as f64 * self.across);
        self.nodes().map(place).collect()
    }

    /// Equal masses along a row, so that all hinges have one frequency; half of it in the free
    /// edge's row, so that the weight and its lever are right.
    fn masses(&self) -> Vec<f64> {
        let mass = DENSITY * THICKNESS * self.along * LENGTH / self.n as f64;
        self.nodes().map(|(i, _)| if i == self.n - 1 { 0.5 * mass } else { mass }).collect()
    }

    /// Springs of a membrane of `stretch` N/m, each with its own frequency and damping ratio.
    fn springs(&self, masses: &[f64], stretch: f64, damping: impl Fn(f64) -> f64) -> Springs {
        let last = self.n - 1;
        let (mut edges, mut softness) = (Vec::new(), Vec::new());
        let mut add = |a: u32, b: u32, stiffness: f64| {
            let omega = (stiffness * (1.0 / masses[a as usize] + 1.0 / masses[b as usize])).sqrt();
            softness.push((edges.len() as u32, SpringCoefficients::new(omega / TAU, damping(omega))));
            edges.push([a, b]);
        };
        let side = |line: usize| stretch * if line == 0 || line == last { 1.0 / 3.0 } else { 2.0 / 3.0 };
        for (i, j) in self.nodes() {
            if i < last {
                add(self.id(i, j), self.id(i + 1, j), side(j));
            }
            if j < last {
                add(self.id(i, j), self.id(i, j + 1), side(i));
            }
            if i < last && j < last {
                add(self.id(i, j), self.id(i + 1, j + 1), stretch / 3.0);
                add(self.id(i + 1, j), self.id(i, j + 1), stretch / 3.0);
            }
        }
        Springs { edges, softness }
    }

    /// The triangles of Rapier's `cloth`: diagonals alternate.
    fn surface(&self) -> Vec<[u32; 3]> {
        let cells = self.nodes().filter(|&(i, j)| i + 1 < self.n && j + 1 < self.n);
        cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [self.id(i, j), self.id(i + 1, j), self.id(i + 1, j + 1), self.id(i, j + 1)];
                if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
            })
            .collect()
    }

    fn line_hinges(&self) -> Vec<[u32; 4]> {
        let last = self.n - 1;
        let beside = |k: usize| if k < last { k + 1 } else { k - 1 };
        let mut hinges = Vec::new();
        for (i, j) in self.nodes() {
            if i > 0 && i < last {
                hinges.push([self.id(i, j), self.id(i, beside(j)), self.id(i - 1, j), self.id(i + 1, j)]);
            }
            if j > 0 && j < last {
                hinges.push([self.id(i, j), self.id(beside(i), j), self.id(i, j - 1), self.id(i, j + 1)]);
            }
            if i < last && j < last {
                hinges.push([self.id(i, j), self.id(i + 1, j + 1), self.id(i + 1, j), self.id(i, j + 1)]);
            }
        }
        hinges
    }
}
