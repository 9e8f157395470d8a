//! Linear springs with dashpots along them, for the explicit integrators.
//!
//! For a spring from node a to node b with d = x_b - x_a, L = |d|, rest length s (m), stiffness k
//! (N/m) and dashpot c (N s/m):
//!
//! - force on a: [k (L - s) + c (v_b - v_a)·d/L] d/L, and the opposite force on b (thesis 3.3.2 and
//!   equation 3.32);
//! - energy ½ k (L - s)².
//!
//! A spring of zero length has no direction and exerts no force.
//!
//! For the kernel, springs are ordered into runs that join consecutive nodes. A regular grid has
//! few long runs, so that gathering differences and scattering forces are contiguous loops, and
//! square roots and divisions run over all springs at once. The order fixes the order of summation,
//! independent of the vector width: results have equal bits on every x86-64.

use multiversion::multiversion;

use crate::math::Vectors;
use crate::mesh::spring_class::SpringClass;

/// One spring, as input of [`Springs::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// First node.
    pub a: u32,
    /// Second node.
    pub b: u32,
    /// Role in the structure.
    pub class: SpringClass,
    /// Stiffness k, N/m, 0 or more.
    pub stiffness: f64,
    /// Rest length s, m, more than 0.
    pub rest: f64,
    /// Dashpot c, N s/m, 0 or more.
    pub damping: f64,
}

/// Consecutive slots that join consecutive nodes: slot `first + i` joins `a + i` to `b + i`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SpringRun {
    first: u32,
    a: u32,
    b: u32,
    len: u32,
}

/// Maximum number of empty slots between two springs of one run. Up to two empty slots cost less
/// than a new run.
const MAXIMUM_EMPTY_SLOTS: u32 = 2;

/// Springs in the order of the kernel: slots sorted by the distance b - a of their nodes and then
/// by a. An empty slot has zero stiffness and exerts no force.
#[derive(Clone, Debug, Default, PartialEq)]
struct SpringSlots {
    runs: Vec<SpringRun>,
    /// Slot of each spring.
    of: Vec<u32>,
    stiffness: Vec<f64>,
    rest: Vec<f64>,
    damping: Vec<f64>,
}

/// The springs of a sheet as arrays of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Springs {
    /// First node of each spring.
    pub a: Vec<u32>,
    /// Second node of each spring.
    pub b: Vec<u32>,
    /// Role of each spring.
    pub class: Vec<SpringClass>,
    /// Stiffness k, N/m.
    pub stiffness: Vec<f64>,
    /// Rest length s, m.
    pub rest: Vec<f64>,
    /// Dashpot c, N s/m.
    pub damping: Vec<f64>,
    slots: SpringSlots,
}

/// Buffers of [`Springs::add_forces`], reused so that a step does not allocate.
#[derive(Clone, Debug, Default)]
pub struct SpringWorkspace {
    d: Vectors,
    rate: Vectors,
    factor: Vec<f64>,
}

impl Springs {
    /// Springs from a list, in its order.
    pub fn new(list: &[Spring]) -> Self {
        let mut springs = Self::default();
        for s in list {
            springs.a.push(s.a);
            springs.b.push(s.b);
            springs.class.push(s.class);
            springs.stiffness.push(s.stiffness);
            springs.rest.push(s.rest);
            springs.damping.push(s.damping);
        }
        springs.slots = SpringSlots::new(list);
        springs
    }

    /// Sets stiffness (N/m) and dashpot (N s/m) of spring `i`.
    ///
    /// # Panics
    /// If `i` is out of range.
    pub fn set_law(&mut self, i: usize, stiffness: f64, damping: f64) {
        self.stiffness[i] = stiffness;
        self.damping[i] = damping;
        let slot = self.slots.of[i] as usize;
        self.slots.stiffness[slot] = stiffness;
        self.slots.damping[slot] = damping;
    }

    /// Sets the rest length (m) of spring `i`.
    ///
    /// # Panics
    /// If `i` is out of range.
    pub fn set_rest(&mut self, i: usize, rest: f64) {
        self.rest[i] = rest;
        self.slots.rest[self.slots.of[i] as usize] = rest;
    }

    /// Sets the stiffness (N/m) of spring `i`.
    ///
    /// # Panics
    /// If `i` is out of range.
    pub fn set_stiffness(&mut self, i: usize, stiffness: f64) {
        self.stiffness[i] = stiffness;
        self.slots.stiffness[self.slots.of[i] as usize] = stiffness;
    }

    /// Number of springs.
    pub fn len(&self) -> usize {
        self.a.len()
    }

    /// Whether the list is empty.
    pub fn is_empty(&self) -> bool {
        self.a.is_empty()
    }

    /// Whether any spring has a dashpot.
    pub fn is_damped(&self) -> bool {
        self.damping.iter().any(|c| *c != 0.0)
    }

    /// Energy stored at positions `x` (m), J.
    pub fn energy(&self, x: &Vectors) -> f64 {
        (0..self.len())
            .map(|i| {
                let stretch = x.get(self.b[i] as usize).distance(x.get(self.a[i] as usize)) - self.rest[i];
                0.5 * self.stiffness[i] * stretch * stretch
            })
            .sum()
    }

    /// Adds the forces (N) at positions `x` (m) and velocities `v` (m/s) to `force`; `damped`
    /// includes the dashpots.
    pub fn add_forces(
        &self,
        x: &Vectors,
        v: &Vectors,
        damped: bool,
        scratch: &mut SpringWorkspace,
        force: &mut Vectors,
    ) {
        let n = self.slots.rest.len();
        if scratch.factor.len() != n {
            *scratch = SpringWorkspace { d: Vectors::zeros(n), rate: Vectors::zeros(n), factor: vec![0.0; n] };
        }
        add_forces(&self.slots, x, v, damped, scratch, force);
    }
}

impl SpringSlots {
    fn new(list: &[Spring]) -> Self {
        let mut order: Vec<u32> = (0..list.len() as u32).collect();
        // The index makes the order total for springs between one pair of nodes.
        order.sort_by_key(|i| {
            let s = &list[*i as usize];
            (i64::from(s.b) - i64::from(s.a), s.a, *i)
        });
        let mut slots = Self { of: vec![0; list.len()], ..Self::default() };
        for i in order {
            let spring = &list[i as usize];
            slots.place(spring.a, spring.b);
            slots.of[i as usize] = slots.rest.len() as u32 - 1;
            if let (Some(k), Some(s), Some(c)) =
                (slots.stiffness.last_mut(), slots.rest.last_mut(), slots.damping.last_mut())
            {
                (*k, *s, *c) = (spring.stiffness, spring.rest, spring.damping);
            }
        }
        slots
    }

    /// Appends a slot that joins a to b: to the last run if a is at most [`MAXIMUM_EMPTY_SLOTS`]
    /// empty slots away, else to a new run.
    fn place(&mut self, a: u32, b: u32) {
        let first = self.rest.len() as u32;
        let mut open = 1;
        match self.runs.last_mut() {
            Some(run)
                if b.wrapping_sub(a) == run.b.wrapping_sub(run.a)
                    && (run.a + run.len..=run.a + run.len + MAXIMUM_EMPTY_SLOTS).contains(&a) =>
            {
                open = a - run.a - run.len + 1;
                run.len += open;
            }
            _ => self.runs.push(SpringRun { first, a, b, len: 1 }),
        }
        let end = (first + open) as usize;
        self.stiffness.resize(end, 0.0);
        self.rest.resize(end, 0.0);
        self.damping.resize(end, 0.0);
    }
}

impl SpringRun {
    fn ranges(&self) -> (usize, usize, usize, usize) {
        (self.first as usize, self.a as usize, self.b as usize, self.len as usize)
    }
}

/// Gathers, evaluates and scatters. The compiler builds one variant per vector width, chosen at run
/// time; no variant contracts or reorders operations, so all give equal bits.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn add_forces(
    slots: &SpringSlots,
    x: &Vectors,
    v: &Vectors,
    damped: bool,
    scratch: &mut SpringWorkspace,
    force: &mut Vectors,
) {
    let SpringWorkspace { d, rate, factor } = scratch;
    gather(&slots.runs, x, d);
    if damped {
        gather(&slots.runs, v, rate);
        damped_factors(slots, d, rate, factor);
    } else {
        elastic_factors(slots, d, factor);
    }
    scatter(&slots.runs, d, factor, force);
}

/// d = p_b - p_a for every slot.
#[inline(always)]
fn gather(runs: &[SpringRun], p: &Vectors, d: &mut Vectors) {
    for (d, p) in d.axes_mut().into_iter().zip(p.axes()) {
        for run in runs {
            let (first, a, b, len) = run.ranges();
            let (d, a, b) = (&mut d[first..first + len], &p[a..a + len], &p[b..b + len]);
            for i in 0..len {
                d[i] = b[i] - a[i];
            }
        }
    }
}

/// Adds factor · d to the first node of every slot and subtracts it from the second.
#[inline(always)]
fn scatter(runs: &[SpringRun], d: &mut Vectors, factor: &[f64], force: &mut Vectors) {
    for (d, force) in d.axes_mut().into_iter().zip(force.axes_mut()) {
        for (d, factor) in d.iter_mut().zip(factor) {
            *d *= factor;
        }
        for run in runs {
            let (first, a, b, len) = run.ranges();
            let d = &d[first..first + len];
            // Two loops, because a node may be first in one spring and second in another spring of
            // the run.
            let ends = &mut force[a..a + len];
            for i in 0..len {
                ends[i] += d[i];
            }
            let ends = &mut force[b..b + len];
            for i in 0..len {
                ends[i] -= d[i];
            }
        }
    }
}

/// factor = k (1 - s/L): the force on the first node is factor · d.
#[inline(always)]
fn elastic_factors(slots: &SpringSlots, d: &Vectors, factor: &mut [f64]) {
    let n = factor.len();
    let (x, y, z) = (&d.x[..n], &d.y[..n], &d.z[..n]);
    let (k, s) = (&slots.stiffness[..n], &slots.rest[..n]);
    for i in 0..n {
        let squared = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        factor[i] = k[i] * (1.0 - s[i] * inverse);
    }
}

/// factor = k (1 - s/L) + c (rate·d)/L².
#[inline(always)]
fn damped_factors(slots: &SpringSlots, d: &Vectors, rate: &Vectors, factor: &mut [f64]) {
    let n = factor.len();
    let (x, y, z) = (&d.x[..n], &d.y[..n], &d.z[..n]);
    let (u, v, w) = (&rate.x[..n], &rate.y[..n], &rate.z[..n]);
    let (k, s, c) = (&slots.stiffness[..n], &slots.rest[..n], &slots.damping[..n]);
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
        let spring = |a, b, stiffness, rest| Spring { a, b, class: SpringClass::X, stiffness, rest, damping: 0.0 };
        let springs = Springs::new(&[spring(0, 1, 3.0, 0.7), spring(1, 2, 5.0, 0.9), spring(0, 2, 2.0, 1.1)]);
        let points = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.0, -0.2, 0.1), DVec3::new(1.4, 0.9, -0.5)];
        let x = vectors(&points);
        let v = Vectors::zeros(3);
        let mut force = Vectors::zeros(3);
        springs.add_forces(&x, &v, false, &mut SpringWorkspace::default(), &mut force);
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
        let class = SpringClass::X;
        let springs = Springs::new(&[Spring { a: 0, b: 1, class, stiffness: 0.0, rest: 1.0, damping: 4.0 }]);
        let x = vectors(&[DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)]);
        let v = vectors(&[DVec3::ZERO, DVec3::new(0.5, 3.0, -1.0)]);
        let mut force = Vectors::zeros(2);
        springs.add_forces(&x, &v, true, &mut SpringWorkspace::default(), &mut force);
        assert_eq!(force.get(0), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(force.get(1), DVec3::new(-2.0, 0.0, 0.0));
    }

    #[test]
    fn a_spring_of_zero_length_exerts_no_force() {
        let class = SpringClass::X;
        let springs = Springs::new(&[Spring { a: 0, b: 1, class, stiffness: 1.0, rest: 1.0, damping: 1.0 }]);
        let x = vectors(&[DVec3::ONE, DVec3::ONE]);
        let v = vectors(&[DVec3::ZERO, DVec3::ONE]);
        let mut force = Vectors::zeros(2);
        springs.add_forces(&x, &v, true, &mut SpringWorkspace::default(), &mut force);
        assert_eq!(force, Vectors::zeros(2));
    }

    #[test]
    fn empty_slots_exert_no_force() {
        // Two rows of three nodes: springs 0-1, 1-2 and 3-4, 4-5; slot 2-3 between the rows stays
        // empty.
        let rows = [(0, 1), (1, 2), (3, 4), (4, 5)];
        let list = rows.map(|(a, b)| Spring { a, b, class: SpringClass::X, stiffness: 2.0, rest: 1.0, damping: 0.5 });
        let springs = Springs::new(&list);
        assert_eq!(springs.slots.runs.len(), 1);
        let mut x = Vectors::default();
        (0..6).for_each(|i| x.push(DVec3::new(f64::from(i % 3) * 1.5, f64::from(i / 3) * 9.0, 0.0)));
        let mut force = Vectors::zeros(6);
        springs.add_forces(&x, &Vectors::zeros(6), true, &mut SpringWorkspace::default(), &mut force);
        for (i, wanted) in [1.0, 0.0, -1.0, 1.0, 0.0, -1.0].into_iter().enumerate() {
            assert_eq!(force.get(i), DVec3::new(wanted, 0.0, 0.0));
        }
    }
}
