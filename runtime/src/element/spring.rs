//! Linear springs with dashpots along them.
//!
//! For a spring from mass a to mass b with d = x_b - x_a, L = |d|, rest length s, stiffness k (N/m), dashpot c (N s/m):
//!
//! - force on a: [k (L - s) + c (v_b - v_a)·d/L] d/L, and the opposite on b (thesis 3.3.2 and equation 3.32);
//! - energy ½ k (L - s)².
//!
//! A spring of no length has no direction and pulls on nothing.
//!
//! Springs are stored as arrays, and grouped into runs: consecutive springs that join consecutive masses. A regular grid
//! is a handful of long runs, so that gathering differences and scattering forces are contiguous loops, and the square
//! root and division between them run over all springs at once. Order of summation is fixed by the order of the springs
//! and does not depend on the width of the vector unit: results are the same bits on every x86-64.

use serde::{Deserialize, Serialize};

use crate::sheet::Vectors;

/// What a spring does in its structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SpringClass {
    /// Along x in a layer.
    X,
    /// Along z in a layer.
    Z,
    /// Slanting in a layer, to larger x with larger z.
    Diagonal,
    /// Slanting in a layer, to smaller x with larger z.
    AntiDiagonal,
    /// From one layer to the next.
    Inter,
    /// Provot's flexion: second neighbours along x or z.
    Flexion,
    /// Second neighbours along a spring line.
    CrossOver,
}

impl SpringClass {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::X, Self::Z, Self::Diagonal, Self::AntiDiagonal, Self::Inter, Self::Flexion, Self::CrossOver];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Z => "z",
            Self::Diagonal => "diagonal",
            Self::AntiDiagonal => "anti-diagonal",
            Self::Inter => "inter",
            Self::Flexion => "flexion",
            Self::CrossOver => "cross-over",
        }
    }

    /// The class of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }
}

/// Consecutive springs that join consecutive masses: spring `first + i` joins `a + i` to `b + i`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    first: u32,
    a: u32,
    b: u32,
    len: u32,
}

/// The springs of a sheet, as arrays of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Springs {
    /// First mass of each.
    pub a: Vec<u32>,
    /// Second mass of each.
    pub b: Vec<u32>,
    /// What each does.
    pub class: Vec<SpringClass>,
    /// Stiffness k, N/m, 0 or more.
    pub stiffness: Vec<f64>,
    /// Rest length s, m, more than 0.
    pub rest: Vec<f64>,
    /// Dashpot c, N s/m, 0 or more.
    pub damping: Vec<f64>,
    runs: Vec<Run>,
}

/// Room for the intermediate values of [`Springs::add_forces`]; kept between calls so that a warm step allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct SpringScratch {
    d: Vectors,
    rate: Vectors,
    factor: Vec<f64>,
}

impl Springs {
    /// Appends a spring.
    pub fn push(&mut self, a: u32, b: u32, class: SpringClass, stiffness: f64, rest: f64, damping: f64) {
        let first = self.a.len() as u32;
        self.a.push(a);
        self.b.push(b);
        self.class.push(class);
        self.stiffness.push(stiffness);
        self.rest.push(rest);
        self.damping.push(damping);
        match self.runs.last_mut() {
            Some(run) if run.a + run.len == a && run.b + run.len == b => run.len += 1,
            _ => self.runs.push(Run { first, a, b, len: 1 }),
        }
    }

    /// How many springs there are.
    pub fn len(&self) -> usize {
        self.a.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.a.is_empty()
    }

    /// Whether any spring has a dashpot.
    pub fn damped(&self) -> bool {
        self.damping.iter().any(|c| *c != 0.0)
    }

    /// Energy stored at positions `x`, J.
    pub fn energy(&self, x: &Vectors) -> f64 {
        (0..self.len())
            .map(|i| {
                let stretch = x.get(self.b[i] as usize).distance(x.get(self.a[i] as usize)) - self.rest[i];
                0.5 * self.stiffness[i] * stretch * stretch
            })
            .sum()
    }

    /// Adds the forces (N) at positions `x` (m) and velocities `v` (m/s) to `force`.
    pub fn add_forces(&self, x: &Vectors, v: &Vectors, damped: bool, scratch: &mut SpringScratch, force: &mut Vectors) {
        let n = self.len();
        if scratch.factor.len() != n {
            *scratch = SpringScratch { d: Vectors::zeros(n), rate: Vectors::zeros(n), factor: vec![0.0; n] };
        }
        self.gather(x, &mut scratch.d);
        if damped {
            self.gather(v, &mut scratch.rate);
            damped_factors(self, &scratch.d, &scratch.rate, &mut scratch.factor);
        } else {
            elastic_factors(self, &scratch.d, &mut scratch.factor);
        }
        self.scatter(scratch, force);
    }

    /// d = p_b - p_a for every spring.
    fn gather(&self, p: &Vectors, d: &mut Vectors) {
        for (d, p) in d.axes_mut().into_iter().zip(p.axes()) {
            for run in &self.runs {
                let (first, a, b, len) = run.ranges();
                let d = &mut d[first..first + len];
                for ((d, a), b) in d.iter_mut().zip(&p[a..a + len]).zip(&p[b..b + len]) {
                    *d = b - a;
                }
            }
        }
    }

    /// Adds factor · d to the first mass of every spring and takes it from the second.
    fn scatter(&self, scratch: &mut SpringScratch, force: &mut Vectors) {
        for (d, force) in scratch.d.axes_mut().into_iter().zip(force.axes_mut()) {
            for (d, factor) in d.iter_mut().zip(&scratch.factor) {
                *d *= factor;
            }
            for run in &self.runs {
                let (first, a, b, len) = run.ranges();
                let d = &d[first..first + len];
                for (f, d) in force[a..a + len].iter_mut().zip(d) {
                    *f += d;
                }
                for (f, d) in force[b..b + len].iter_mut().zip(d) {
                    *f -= d;
                }
            }
        }
    }
}

impl Run {
    fn ranges(&self) -> (usize, usize, usize, usize) {
        (self.first as usize, self.a as usize, self.b as usize, self.len as usize)
    }
}

/// factor = k (1 - s/L): the force on the first mass is factor · d.
fn elastic_factors(springs: &Springs, d: &Vectors, factor: &mut [f64]) {
    let n = factor.len();
    let (x, y, z) = (&d.x[..n], &d.y[..n], &d.z[..n]);
    let (k, s) = (&springs.stiffness[..n], &springs.rest[..n]);
    for i in 0..n {
        let squared = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        factor[i] = k[i] * (1.0 - s[i] * inverse);
    }
}

/// factor = k (1 - s/L) + c (rate·d)/L².
fn damped_factors(springs: &Springs, d: &Vectors, rate: &Vectors, factor: &mut [f64]) {
    let n = factor.len();
    let (x, y, z) = (&d.x[..n], &d.y[..n], &d.z[..n]);
    let (u, v, w) = (&rate.x[..n], &rate.y[..n], &rate.z[..n]);
    let (k, s, c) = (&springs.stiffness[..n], &springs.rest[..n], &springs.damping[..n]);
    for i in 0..n {
        let squared = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        let along = u[i] * x[i] + v[i] * y[i] + w[i] * z[i];
        factor[i] = k[i] * (1.0 - s[i] * inverse) + c[i] * along * (inverse * inverse);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn vectors(points: &[DVec3]) -> Vectors {
        let mut v = Vectors::default();
        points.iter().for_each(|p| v.push(*p));
        v
    }

    #[test]
    fn force_is_minus_the_gradient_of_the_energy() {
        let mut springs = Springs::default();
        springs.push(0, 1, SpringClass::X, 3.0, 0.7, 0.0);
        springs.push(1, 2, SpringClass::X, 5.0, 0.9, 0.0);
        springs.push(0, 2, SpringClass::Flexion, 2.0, 1.1, 0.0);
        let points = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.0, -0.2, 0.1), DVec3::new(1.4, 0.9, -0.5)];
        let x = vectors(&points);
        let v = Vectors::zeros(3);
        let mut force = Vectors::zeros(3);
        springs.add_forces(&x, &v, false, &mut SpringScratch::default(), &mut force);
        let h = 1e-6;
        for i in 0..3 {
            for axis in 0..3 {
                let moved = |s: f64| {
                    let mut p = points;
                    p[i][axis] += s;
                    springs.energy(&vectors(&p))
                };
                let gradient = (moved(h) - moved(-h)) / (2.0 * h);
                assert!((force.get(i)[axis] + gradient).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn a_dashpot_opposes_the_rate_of_stretch_only() {
        let mut springs = Springs::default();
        springs.push(0, 1, SpringClass::X, 0.0, 1.0, 4.0);
        let x = vectors(&[DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)]);
        let v = vectors(&[DVec3::ZERO, DVec3::new(0.5, 3.0, -1.0)]);
        let mut force = Vectors::zeros(2);
        springs.add_forces(&x, &v, true, &mut SpringScratch::default(), &mut force);
        assert_eq!(force.get(0), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(force.get(1), DVec3::new(-2.0, 0.0, 0.0));
    }

    #[test]
    fn a_spring_of_no_length_pulls_on_nothing() {
        let mut springs = Springs::default();
        springs.push(0, 1, SpringClass::X, 1.0, 1.0, 1.0);
        let x = vectors(&[DVec3::ONE, DVec3::ONE]);
        let v = vectors(&[DVec3::ZERO, DVec3::ONE]);
        let mut force = Vectors::zeros(2);
        springs.add_forces(&x, &v, true, &mut SpringScratch::default(), &mut force);
        assert_eq!(force, Vectors::zeros(2));
    }
}
