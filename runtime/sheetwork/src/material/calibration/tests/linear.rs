//! Small deflections of a calibrated lattice: K u = f and K u = ω² M u, by an envelope Cholesky
//! factorisation.
//!
//! K = Σ k n nᵀ over springs at rest (linearised: a straight spring at its rest length has no other
//! stiffness).

use glam::DVec3;

use crate::material::calibration::Calibration;

/// Linearised sheet; unknowns are three per node, without the fixed ones.
pub struct Linear {
    /// Unknown of each coordinate of each node; `None` for a fixed one.
    unknown: Vec<Option<usize>>,
    mass: Vec<f64>,
    rows: Vec<Vec<f64>>,
    first: Vec<usize>,
}

impl Linear {
    /// Linear system of a lattice; coordinate `axis` of node `i` is fixed where `held(i, axis)`, or
    /// by a clamp.
    pub fn new(sheet: &Calibration, held: impl Fn(usize, usize) -> bool) -> Self {
        let positions = &sheet.lattice.positions;
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|a, b| positions[*a].x.total_cmp(&positions[*b].x).then(a.cmp(b)));
        let mut unknown = vec![None; 3 * positions.len()];
        let mut mass = Vec::new();
        for i in order {
            for axis in 0..3 {
                if !held(i, axis) && !sheet.held.contains(&(i as u32)) {
                    unknown[3 * i + axis] = Some(mass.len());
                    mass.push(sheet.mass[i]);
                }
            }
        }
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        let mut add = |k: f64, ends: &[(usize, f64)], n: DVec3| {
            for (a, sa) in ends {
                for (b, sb) in ends {
                    for (c, nc) in n.to_array().iter().enumerate() {
                        for (d, nd) in n.to_array().iter().enumerate() {
                            if let (Some(row), Some(column)) = (unknown[3 * a + c], unknown[3 * b + d]) {
                                entries.push((row, column, k * sa * sb * nc * nd));
                            }
                        }
                    }
                }
            }
        };
        for (link, k) in sheet.lattice.links.iter().zip(&sheet.stiffness) {
            let (a, b) = (link.a as usize, link.b as usize);
            add(*k, &[(a, -1.0), (b, 1.0)], (positions[b] - positions[a]).normalize());
        }
        for (link, k) in &sheet.braces {
            let (a, b) = (link.a as usize, link.b as usize);
            add(*k, &[(a, -1.0), (b, 1.0)], (positions[b] - positions[a]).normalize());
        }
        for wall in &sheet.walls {
            let a = wall.mass as usize;
            add(wall.stiffness, &[(a, 1.0)], (wall.point - positions[a]).normalize());
        }
        let n = mass.len();
        let mut first: Vec<usize> = (0..n).collect();
        entries.iter().for_each(|(row, column, _)| first[*row] = first[*row].min(*column));
        let mut rows: Vec<Vec<f64>> = (0..n).map(|i| vec![0.0; i - first[i] + 1]).collect();
        for (row, column, value) in entries.into_iter().filter(|(row, column, _)| column <= row) {
            rows[row][column - first[row]] += value;
        }
        let mut linear = Self { unknown, mass, rows, first };
        linear.factor();
        linear
    }

    fn factor(&mut self) {
        for i in 0..self.rows.len() {
            let (done, rest) = self.rows.split_at_mut(i);
            let (row, fi) = (&mut rest[0], self.first[i]);
            for j in fi..i {
                let fj = self.first[j];
                let from = fi.max(fj);
                let known: f64 = row[from - fi..j - fi].iter().zip(&done[j][from - fj..]).map(|(a, b)| a * b).sum();
                row[j - fi] = (row[j - fi] - known) / done[j][j - fj];
            }
            let last = i - fi;
            let pivot = row[last] - row[..last].iter().map(|v| v * v).sum::<f64>();
            assert!(pivot > 0.0, "a mechanism at unknown {i}");
            row[last] = pivot.sqrt();
        }
    }

    fn solve(&self, load: &[f64]) -> Vec<f64> {
        let mut y = load.to_vec();
        for i in 0..y.len() {
            let (row, fi) = (&self.rows[i], self.first[i]);
            let known: f64 = (fi..i).map(|j| row[j - fi] * y[j]).sum();
            y[i] = (y[i] - known) / row[i - fi];
        }
        for i in (0..y.len()).rev() {
            let (row, fi) = (&self.rows[i], self.first[i]);
            y[i] /= row[i - fi];
            for j in fi..i {
                y[j] -= row[j - fi] * y[i];
            }
        }
        y
    }

    /// Downward displacement of every node under a downward acceleration `g` (m/s²), m; 0 where
    /// fixed.
    pub fn sag(&self, g: f64) -> Vec<f64> {
        let mut load = vec![0.0; self.mass.len()];
        for u in self.unknown.iter().skip(1).step_by(3).flatten() {
            load[*u] = g * self.mass[*u];
        }
        let found = self.solve(&load);
        self.unknown.iter().skip(1).step_by(3).map(|u| u.map_or(0.0, |u| found[u])).collect()
    }

    /// Lowest frequency, rad/s, by inverse iteration.
    pub fn frequency(&self) -> f64 {
        // The sag shape is close to the first mode, and so not orthogonal to it.
        let mut load = vec![0.0; self.mass.len()];
        self.unknown.iter().skip(1).step_by(3).flatten().for_each(|u| load[*u] = self.mass[*u]);
        let mut squared = 0.0;
        for _ in 0..60 {
            let u = self.solve(&load);
            let work: f64 = u.iter().zip(&load).map(|(u, f)| u * f).sum();
            let inertia: f64 = u.iter().zip(&self.mass).map(|(u, m)| m * u * u).sum();
            squared = work / inertia;
            let scale = inertia.sqrt();
            load = u.iter().zip(&self.mass).map(|(u, m)| m * u / scale).collect();
        }
        squared.sqrt()
    }
}
