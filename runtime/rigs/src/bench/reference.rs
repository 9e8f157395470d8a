//! Reference values of the benchmark.
//!
//! At Poisson's ratio 0 a square sheet clamped along one edge bends as a strip, and the references
//! are independent of this library:
//! - cantilever: the heavy elastica, B θ'' = -q (L - s) cos θ, θ(0) = 0, θ'(L) = 0 (Romero et al.,
//!   ACM TOG 40(4), 2021, sec. 3);
//! - frequency: the cantilever beam, ω = 1.8751041² √(B / μ) / L² (Euler-Bernoulli);
//! - release: the inextensible elastica in motion, as a chain of rigid links with hinges, of second
//!   order in their length and without code shared with the sheet.
//!
//! B = E t³ / 12 bending stiffness per width, N·m; μ = ρ t mass per area, kg/m²; q = μ g, Pa; L
//! length, m; s arc length from the clamp. For structures with Poisson's ratio 1/3 and for the
//! pedestal, the reference is this library's shell on the finest grid at the finest step. The error
//! is then a deviation from that solution.

use serde_json::Value;
use sheetwork::InputError;
use sheetwork::material::elastica;

use crate::measure::{Setup, measure};

use crate::bench::sweep::setup;
use crate::bench::verdict::{ReferenceTarget, number, quantities};

/// Computed references, by rig and Poisson's ratio.
pub struct References {
    quick: bool,
    known: Vec<(String, f64, Vec<ReferenceTarget>)>,
}

impl References {
    /// An empty set; `quick` uses a coarser finest grid for slow rigs.
    pub fn new(quick: bool) -> Self {
        Self { quick, known: Vec::new() }
    }

    /// Targets of a rig.
    ///
    /// # Errors
    /// Failure of the reference run on the finest grid.
    pub fn get(&mut self, case: &str, poisson: f64) -> Result<Vec<ReferenceTarget>, InputError> {
        if let Some((_, _, targets)) = self.known.iter().find(|(c, p, _)| c == case && *p == poisson) {
            return Ok(targets.clone());
        }
        let targets = match strip(case, poisson) {
            Some(targets) => targets,
            None => finest_shell_targets(case, poisson, self.quick)?,
        };
        self.known.push((case.into(), poisson, targets.clone()));
        Ok(targets)
    }
}

/// Targets of a strip, for a rig and Poisson's ratio with a strip solution.
fn strip(case: &str, poisson: f64) -> Option<Vec<ReferenceTarget>> {
    if poisson != 0.0 {
        return None;
    }
    let strip = Strip::new(&setup(poisson));
    match case {
        "cantilever" => {
            let gamma = strip.weight() * strip.length.powi(3) / strip.bending;
            Some(vec![ReferenceTarget::exact("drop_m", elastica::elastica(gamma).0 * strip.length)])
        }
        "frequency" => {
            let value = 1.875_104_068_7_f64.powi(2) * (strip.bending / strip.mass).sqrt() / strip.length.powi(2);
            Some(vec![ReferenceTarget::exact("omega_motion_rad_s", value)])
        }
        "release" => {
            let (coarse, fine) = (strip.first_extreme(48)?, strip.first_extreme(96)?);
            // The depth is of second order, so the remaining error is a third of the change under
            // halving of the links. The tip is nearly at rest at the extreme, and its high modes
            // shift the time by a thousandth at any number of links.
            let depth = fine.0 + (fine.0 - coarse.0) / 3.0;
            Some(vec![
                ReferenceTarget::exact("first_extreme_m", depth),
                ReferenceTarget { quantity: "first_extreme_s", value: fine.1, uncertain: 1e-3 },
            ])
        }
        _ => None,
    }
}

/// Targets from the shell on the finest grid.
fn finest_shell_targets(case: &str, poisson: f64, quick: bool) -> Result<Vec<ReferenceTarget>, InputError> {
    // Equilibria are independent of the step, and the frequency is that of the linearised sheet.
    let (side, dt) = match (case, quick) {
        ("release", false) => (61, 1.0 / 960.0),
        ("release", true) => (31, 1.0 / 480.0),
        ("frequency", _) => (61, 1.0 / 30.0),
        (_, _) => (81, 1.0 / 60.0),
    };
    let found: Value = measure(case, &Setup { grid: (side, side), dt: Some(dt), ..setup(poisson) })?;
    let target = |&quantity: &&'static str| {
        let key = if quantity == "omega_motion_rad_s" { "omega_rad_s" } else { quantity };
        number(&found[key]).map(|value| ReferenceTarget::exact(quantity, value))
    };
    Ok(quantities(case).iter().filter_map(target).collect())
}

/// A strip of unit width, clamped at one end.
struct Strip {
    length: f64,
    bending: f64,
    mass: f64,
    gravity: f64,
}

/// Angles (rad) and angular velocities (rad/s) of the links.
type Motion = [Vec<f64>; 2];

impl Strip {
    fn new(setup: &Setup) -> Self {
        let material = &setup.material;
        Self {
            length: setup.length,
            bending: material.young * material.thickness.powi(3) / 12.0,
            mass: material.density * material.thickness,
            gravity: setup.gravity,
        }
    }

    /// Weight per area, Pa.
    fn weight(&self) -> f64 {
        self.mass * self.gravity
    }

    /// Drop (m) and time (s) of the tip's first extreme after release from straight, for a chain of
    /// `links`.
    fn first_extreme(&self, links: usize) -> Option<(f64, f64)> {
        let chain = LinkChain::new(self, links);
        let mut motion: Motion = [vec![0.0; links], vec![0.0; links]];
        let (mut drop, mut speed) = chain.tip(&motion);
        // The slowest strip reaches its extreme within two of its periods.
        let period = std::f64::consts::TAU * (self.mass / self.bending).sqrt() * self.length.powi(2) / 3.516;
        let steps = (2.0 * period / chain.step) as u64;
        for step in 0..steps {
            motion = chain.advance(&motion);
            let (next_drop, next_speed) = chain.tip(&motion);
            if speed > 0.0 && next_speed <= 0.0 {
                let share = speed / (speed - next_speed);
                let at = drop + 0.5 * speed * share * chain.step;
                return Some((at, (step as f64 + share) * chain.step));
            }
            (drop, speed) = (next_drop, next_speed);
        }
        None
    }
}

/// Rigid links of equal length with point masses at their ends and hinges between them. The clamp
/// contributes half a link.
struct LinkChain {
    link: f64,
    hinge: f64,
    gravity: f64,
    /// Point mass at the far end of each link, kg/m.
    mass: Vec<f64>,
    step: f64,
}

impl LinkChain {
    fn new(strip: &Strip, links: usize) -> Self {
        let link = strip.length / links as f64;
        let mass = (0..links).map(|k| strip.mass * link * if k + 1 == links { 0.5 } else { 1.0 }).collect();
        // In the highest mode neighbours rotate in opposite directions: ω ≤ 4 √(B/μ) / l². RK4 is
        // stable up to 2.8 and accurate enough at 1.5.
        let step = 1.5 * link * link / (4.0 * (strip.bending / strip.mass).sqrt());
        Self { link, hinge: strip.bending / link, gravity: strip.gravity, mass, step }
    }

    /// Drop and downward speed of the tip.
    fn tip(&self, [angle, rate]: &Motion) -> (f64, f64) {
        let drop = angle.iter().map(|a| a.sin()).sum::<f64>();
        let speed = angle.iter().zip(rate).map(|(a, r)| a.cos() * r).sum::<f64>();
        (self.link * drop, self.link * speed)
    }

    /// One step of the classical Runge-Kutta method.
    fn advance(&self, motion: &Motion) -> Motion {
        let h = self.step;
        let moved = |k: &Motion, by: f64| -> Motion {
            [0, 1].map(|i| motion[i].iter().zip(&k[i]).map(|(m, k)| m + by * k).collect())
        };
        let k1 = self.rate(motion);
        let k2 = self.rate(&moved(&k1, 0.5 * h));
        let k3 = self.rate(&moved(&k2, 0.5 * h));
        let k4 = self.rate(&moved(&k3, h));
        let links = 0..self.mass.len();
        let mean = [0, 1]
            .map(|i| links.clone().map(|j| (k1[i][j] + 2.0 * k2[i][j] + 2.0 * k3[i][j] + k4[i][j]) / 6.0).collect());
        moved(&mean, h)
    }

    /// Rates and accelerations of the angles. The link forces T keep their length, u_j·(a_j -
    /// a_{j-1}) = -l θ_j'² with m_j a_j = f_j - T_j u_j + T_{j+1} u_{j+1}: a tridiagonal system,
    /// where f is the weight plus the couples of the hinges.
    fn rate(&self, [angle, rate]: &Motion) -> Motion {
        let links = angle.len();
        let along: Vec<[f64; 2]> = angle.iter().map(|a| [a.cos(), a.sin()]).collect();
        let force = self.forces(angle, &along);
        let own = |j: usize| [0, 1].map(|i| force[j][i] / self.mass[j]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        // Elimination from the clamp: pull[j] + upper[j] pull[j + 1] = right side.
        let (mut pull, mut upper) = (vec![0.0; links], vec![0.0; links]);
        for j in 0..links {
            let (mut pivot, mut right) = (1.0 / self.mass[j], self.link * rate[j] * rate[j] + dot(along[j], own(j)));
            if j > 0 {
                let lower = -dot(along[j - 1], along[j]) / self.mass[j - 1];
                pivot += 1.0 / self.mass[j - 1] - lower * upper[j - 1];
                right -= dot(along[j], own(j - 1)) + lower * pull[j - 1];
            }
            if j + 1 < links {
                upper[j] = -dot(along[j], along[j + 1]) / (self.mass[j] * pivot);
            }
            pull[j] = right / pivot;
        }
        for j in (0..links.saturating_sub(1)).rev() {
            pull[j] -= upper[j] * pull[j + 1];
        }
        let pulled = |j: usize, i: usize| {
            let next = if j + 1 < links { pull[j + 1] * along[j + 1][i] } else { 0.0 };
            (force[j][i] - pull[j] * along[j][i] + next) / self.mass[j]
        };
        let turn = |j: usize| {
            let from = |i: usize| if j > 0 { pulled(j - 1, i) } else { 0.0 };
            dot([-along[j][1], along[j][0]], [pulled(j, 0) - from(0), pulled(j, 1) - from(1)]) / self.link
        };
        [rate.clone(), (0..links).map(turn).collect()]
    }

    /// Weight, and hinge moments as couples on the ends of the links.
    fn forces(&self, angle: &[f64], along: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let links = angle.len();
        let mut force: Vec<[f64; 2]> = self.mass.iter().map(|m| [0.0, m * self.gravity]).collect();
        for j in 0..links {
            let before = if j == 0 { 2.0 * angle[0] } else { angle[j] - angle[j - 1] };
            let after = if j + 1 == links { 0.0 } else { angle[j + 1] - angle[j] };
            let couple = self.hinge * (after - before) / self.link;
            let across = [-couple * along[j][1], couple * along[j][0]];
            for i in 0..2 {
                force[j][i] += across[i];
                if j > 0 {
                    force[j - 1][i] -= across[i];
                }
            }
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_strip_swings_to_twice_its_droop_in_half_its_period() {
        // Gravity is small, so the beam is linear. The first mode has all but 1.5 % of the droop q
        // L⁴ / 8 B and a tip displacement of 1 - cos ω₁ t times it. The first extreme is near twice
        // the droop, at about π / ω₁.
        let strip = Strip { length: 0.25, bending: 0.03125, mass: 0.525, gravity: 1e-3 };
        let (drop, time) = strip.first_extreme(40).expect("it turns");
        let droop = strip.weight() * strip.length.powi(4) / (8.0 * strip.bending);
        let omega = 3.516_015 * (strip.bending / strip.mass).sqrt() / strip.length.powi(2);
        assert!((drop / (2.0 * droop) - 1.0).abs() < 0.02, "{drop} {droop}");
        assert!((time * omega / std::f64::consts::PI - 1.0).abs() < 0.05, "{time} {omega}");
    }

    #[test]
    fn the_chain_converges_with_the_square_of_its_links() {
        let strip = Strip { length: 0.25, bending: 0.03125, mass: 0.525, gravity: 9.81 };
        let [a, b, c] = [20, 40, 80].map(|n| strip.first_extreme(n).expect("it turns"));
        let order = ((a.0 - b.0) / (b.0 - c.0)).log2();
        assert!((1.8..2.2).contains(&order), "{order}");
    }
}
