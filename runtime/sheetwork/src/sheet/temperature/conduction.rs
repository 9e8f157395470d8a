//! Time integration of temperatures: conduction, and exchange of every thermal node with its
//! surroundings.
//!
//!   C dT/dt = -K T + S - H T - R (T + 273.15)⁴,
//!
//! T in °C; K is the matrix of the [`ThermalNetwork`], the other terms are an [`Exchange`],
//! constant over the step. TR-BDF2 with γ = 2 - √2: a trapezoidal stage of γ h, then BDF2 over the
//! whole step,
//!
//!   C (T₁ - T₀) = d h (F₀ + F₁), C (T₂ - T₀) = h (w (F₀ + F₁) + d F₂), d = 1 - √½, w = √2/4.
//!
//! The scheme is of second order and L-stable. Both stages have the matrix C/(d h) + K + J, J the
//! slope of the exchange, which is factorised when h or J has changed. Newton's iteration ends when
//! the remaining change is below `NEWTON_TOLERANCE`. The residual of the heat balance, from
//! iteration and rounding, is distributed over all nodes, so that heat is conserved to the rounding
//! of a sum. Steps in which the surroundings would change a temperature by more than
//! `MAX_TEMPERATURE_CHANGE` are divided.

use crate::linear::{Factor, Pattern, analyse};
use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::Sheet;
use crate::sheet::temperature::network::ThermalNetwork;
use crate::units::temperature::ZERO_CELSIUS;

/// Tolerance of Newton's iteration, K.
const NEWTON_TOLERANCE: f64 = 1e-6;
/// Maximum number of iterations of a stage, and number of iterations after which the matrix must be
/// exact.
const MAX_ITERATIONS: u32 = 40;
const STALE_ITERATIONS: u32 = 8;
/// Error of a slope, as a fraction of the diagonal, above which the matrix is factorised again.
const SLOPE_TOLERANCE: f64 = 0.05;
/// Maximum change of a temperature by the surroundings in a step, K, and maximum number of
/// bisections to achieve it.
const MAX_TEMPERATURE_CHANGE: f64 = 5.0;
const MAX_BISECTIONS: f64 = 8.0;

const D: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
const W: f64 = 0.5 * std::f64::consts::FRAC_1_SQRT_2;

/// Exchange of each thermal node with its surroundings: S - H T - R (T + 273.15)⁴.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    /// S, W.
    pub supply: Vec<f64>,
    /// H, W/K.
    pub convection: Vec<f64>,
    /// R, W/K⁴.
    pub radiation: Vec<f64>,
}

impl Exchange {
    /// Reset to zero, for `nodes` thermal nodes.
    pub fn clear(&mut self, nodes: usize) {
        for part in [&mut self.supply, &mut self.convection, &mut self.radiation] {
            part.clear();
            part.resize(nodes, 0.0);
        }
    }

    /// Heat flow into node `i` at `celsius` (°C), W.
    #[inline]
    fn flow(&self, i: usize, celsius: f64) -> f64 {
        let kelvin = celsius + ZERO_CELSIUS;
        // The radiation term is odd in T, so that an iterate below absolute zero is pulled back.
        self.supply[i] - self.convection[i] * celsius - self.radiation[i] * kelvin * kelvin.abs() * kelvin * kelvin
    }

    /// Negative slope of the heat flow, W/K.
    #[inline]
    fn slope(&self, i: usize, celsius: f64) -> f64 {
        let kelvin = (celsius + ZERO_CELSIUS).abs();
        self.convection[i] + 4.0 * self.radiation[i] * kelvin * kelvin * kelvin
    }
}

/// Linear system of conduction, with three thermal nodes per block row.
struct ConductionSystem {
    factor: Factor,
    /// Indices in `values` of the entries of K, and of the diagonal of every node.
    conduction: Vec<(u32, f64)>,
    diagonal: Vec<u32>,
    values: Vec<f64>,
    /// J of the factorised matrix, and its d h.
    slope: Vec<f64>,
    length: f64,
    right: Vec<f64>,
}

impl ConductionSystem {
    fn new(network: &ThermalNetwork, sheet: &Sheet) -> Self {
        let n = network.capacity.len();
        let rows = n.div_ceil(3);
        let mut pairs = Vec::new();
        network.for_each_entry(|a, b, _| pairs.push((a / 3, b / 3)));
        let pattern = Pattern::new(rows, pairs);
        let place = |row: usize| {
            let mass = (3 * row + 1).min(n - 1) % sheet.node_count();
            let (u, v) = sheet.model.uv[mass];
            [u * f64::from(sheet.model.grid.0) / 3.0, v * f64::from(sheet.model.grid.2)]
        };
        let places: Vec<[f64; 2]> = (0..rows).map(place).collect();
        let entry = |a: u32, b: u32| {
            let slot = pattern.slot(a / 3, b / 3).unwrap_or_default();
            9 * slot + 3 * (a % 3) + b % 3
        };
        let mut conduction = Vec::new();
        network.for_each_entry(|a, b, g| conduction.push((entry(a, b), g)));
        let padded = 3 * rows as u32;
        Self {
            factor: analyse(&pattern, &places),
            conduction,
            diagonal: (0..padded).map(|i| entry(i, i)).collect(),
            values: vec![0.0; 9 * pattern.blocks()],
            slope: vec![f64::NAN; n],
            length: f64::NAN,
            right: vec![0.0; padded as usize],
        }
    }

    /// Factorise the matrix for stages of d h = `length` (s) with the slopes at `celsius` (°C),
    /// unless the present factor is accurate enough. Returns the largest error of a slope and the
    /// largest slope, as fractions of the diagonal. The former, and the latter times its change
    /// during the iteration, bound the contraction of Newton's iteration.
    fn prepare(
        &mut self,
        network: &ThermalNetwork,
        exchange: &Exchange,
        celsius: &[f64],
        length: f64,
        stale: f64,
    ) -> (f64, f64) {
        let (mut near, mut wrong, mut largest) = (self.length == length, 0.0_f64, 0.0_f64);
        for (i, t) in celsius.iter().enumerate() {
            let slope = exchange.slope(i, *t);
            let diagonal = network.capacity[i] / length + slope;
            // Written with `<=`: NaN marks a slope before the first factorisation.
            near &= (slope - self.slope[i]).abs() <= stale * diagonal;
            wrong = wrong.max((slope - self.slope[i]).abs() / diagonal);
            largest = largest.max(slope / diagonal);
        }
        if near {
            return (wrong, largest);
        }
        self.length = length;
        for (i, t) in celsius.iter().enumerate() {
            self.slope[i] = exchange.slope(i, *t);
        }
        self.factorise(network);
        (0.0, largest)
    }

    /// Factorise the matrix of the present length and slopes.
    fn factorise(&mut self, network: &ThermalNetwork) {
        self.values.fill(0.0);
        for (i, slope) in self.slope.iter().enumerate() {
            self.values[self.diagonal[i] as usize] = network.capacity[i] / self.length + slope;
        }
        for i in self.slope.len()..self.diagonal.len() {
            self.values[self.diagonal[i] as usize] = 1.0;
        }
        for (entry, g) in &self.conduction {
            self.values[*entry as usize] += g;
        }
        // The matrix is diagonally dominant apart from bridges, which are positive semidefinite: it
        // has a factor.
        let _ = self.factor.factorize(&self.values);
    }
}

/// Time integrator of the temperatures of a sheet.
pub struct ConductionStepper {
    network: ThermalNetwork,
    system: ConductionSystem,
    /// Total heat capacity, J/K.
    whole: f64,
    before: Vec<f64>,
    flow: [Vec<f64>; 2],
    base: Vec<f64>,
}

impl ConductionStepper {
    /// Integrator of `sheet`, with `points` temperatures through the thickness at each node.
    pub fn new(sheet: &Sheet, points: usize) -> Self {
        let network = ThermalNetwork::new(sheet, points);
        let n = network.capacity.len();
        Self {
            system: ConductionSystem::new(&network, sheet),
            whole: network.capacity.iter().sum(),
            before: vec![0.0; n],
            flow: [vec![0.0; n], vec![0.0; n]],
            base: vec![0.0; n],
            network,
        }
    }

    /// Serialise the length and slopes of the present factor: another factor gives other rounding.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        to.number(self.system.length);
        to.numbers(&self.system.slope);
    }

    /// Deserialise length and slopes, and factorise.
    pub(crate) fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        let length = from.number()?;
        let mut slope = vec![0.0; self.system.slope.len()];
        from.numbers(&mut slope)?;
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        if length.to_bits() != self.system.length.to_bits() || !slope.iter().zip(&self.system.slope).all(same) {
            (self.system.length, self.system.slope) = (length, slope);
            self.system.factorise(&self.network);
        }
        Ok(())
    }

    /// Thermal network.
    pub fn network(&self) -> &ThermalNetwork {
        &self.network
    }

    /// Heat content above 0 °C, J.
    pub fn heat(&self, celsius: &[f64]) -> f64 {
        celsius.iter().zip(&self.network.capacity).map(|(t, c)| t * c).sum()
    }

    /// Advance temperatures (°C) by `dt` (s) of `exchange`.
    pub fn advance(&mut self, celsius: &mut [f64], exchange: &Exchange, dt: f64) {
        let mut left = dt;
        while left > dt * 1e-12 {
            let rate = |i: usize| exchange.flow(i, celsius[i]).abs() / self.network.capacity[i];
            let fastest = (0..celsius.len()).map(rate).fold(0.0, f64::max);
            // Powers of a half, so that one matrix serves many steps.
            let halvings = (fastest * dt / MAX_TEMPERATURE_CHANGE).max(1.0).log2().ceil().min(MAX_BISECTIONS);
            let part = (dt * (-halvings).exp2()).min(left);
            self.step(celsius, exchange, part);
            left -= part;
        }
    }

    /// One step of `h` (s).
    fn step(&mut self, celsius: &mut [f64], exchange: &Exchange, h: f64) {
        self.before.copy_from_slice(celsius);
        let length = D * h;
        let first = self.flow_at(celsius, exchange, 0);
        for i in 0..celsius.len() {
            self.base[i] = celsius[i] + length * self.flow[0][i] / self.network.capacity[i];
        }
        let middle = self.solve(celsius, exchange, length, 1);
        for i in 0..celsius.len() {
            let mean = W * (self.flow[0][i] + self.flow[1][i]);
            self.base[i] = self.before[i] + h * mean / self.network.capacity[i];
        }
        let last = self.solve(celsius, exchange, length, 1);
        // Conduction conserves heat: the difference is due to rounding and the tolerance of
        // Newton's iteration.
        let mut lost = h * (W * (first + middle) + D * last);
        for i in 0..celsius.len() {
            lost += self.network.capacity[i] * (self.before[i] - celsius[i]);
        }
        let shift = lost / self.whole;
        if !shift.is_finite() {
            // Only extreme exchanges have no solution; temperatures are then unchanged.
            celsius.copy_from_slice(&self.before);
            return;
        }
        celsius.iter_mut().for_each(|t| *t += shift);
    }

    /// Compute the heat flow into nodes at `celsius` (°C), W, as flow `k`. Returns the total from
    /// the surroundings, W.
    fn flow_at(&mut self, celsius: &[f64], exchange: &Exchange, k: usize) -> f64 {
        let flow = &mut self.flow[k];
        let mut given = 0.0;
        for (i, t) in celsius.iter().enumerate() {
            flow[i] = exchange.flow(i, *t);
            given += flow[i];
        }
        self.network.conduct(celsius, flow);
        given
    }

    /// Solve C (T - base) = `length` F(T), from `celsius`, and store F as flow `k`. Returns the
    /// total heat flow from the surroundings, W.
    fn solve(&mut self, celsius: &mut [f64], exchange: &Exchange, length: f64, k: usize) -> f64 {
        for round in 0..MAX_ITERATIONS {
            self.flow_at(celsius, exchange, k);
            let stale = if round < STALE_ITERATIONS { SLOPE_TOLERANCE } else { 0.0 };
            let (wrong, slope) = self.system.prepare(&self.network, exchange, celsius, length, stale);
            let right = &mut self.system.right;
            for i in 0..celsius.len() {
                right[i] = self.flow[k][i] - self.network.capacity[i] * (celsius[i] - self.base[i]) / length;
            }
            self.system.factor.solve(right);
            let (mut furthest, mut coldest) = (0.0_f64, f64::INFINITY);
            for (t, d) in celsius.iter_mut().zip(&*right) {
                *t += d;
                furthest = furthest.max(d.abs());
                coldest = coldest.min(*t);
            }
            // A slope is proportional to the third power of the absolute temperature.
            let turned = 3.0 * furthest / (coldest + ZERO_CELSIUS).max(1.0);
            if furthest * (wrong + slope * turned.min(1.0)) <= NEWTON_TOLERANCE {
                break;
            }
        }
        self.flow_at(celsius, exchange, k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::OutlineSpec;
    use crate::mesh::structure::StructureKind;
    use crate::scene::{Material, MaterialChoice, Scene, SheetSpec, SpringLaw};

    fn sheet(structure: StructureKind, grid: (u32, u32, u32), outline: Option<OutlineSpec>) -> Sheet {
        let material = Material { conductivity: 0.2, ..crate::scene::material::by_name("hips").expect("there") };
        let spec = SheetSpec {
            structure,
            grid,
            size: (0.1, 0.08),
            material: MaterialChoice::Inline(material),
            springs: SpringLaw::Length,
            outline,
            ..SheetSpec::default()
        };
        Sheet::build(&Scene { sheets: vec![spec], ..Scene::thesis() }, 0).expect("valid")
    }

    fn every() -> Vec<(Sheet, usize)> {
        use StructureKind::{Provot2d, Provot3d, Samm, Shell, Trimm};
        let disc = Some(OutlineSpec::Disc { radius: 0.05 });
        vec![
            (sheet(Shell, (11, 1, 9), None), 1),
            (sheet(Shell, (11, 1, 9), None), 2),
            (sheet(Shell, (11, 1, 9), disc), 2),
            (sheet(Samm, (8, 2, 7), None), 1),
            (sheet(Trimm, (8, 3, 7), None), 1),
            (sheet(Provot2d, (8, 1, 7), None), 1),
            (sheet(Provot3d, (8, 2, 7), None), 1),
        ]
    }

    #[test]
    fn nodes_hold_the_heat_of_the_sheet() {
        for (sheet, points) in every() {
            let network = ThermalNetwork::new(&sheet, points);
            let m = sheet.material();
            let wanted = match &sheet.model.triangles {
                Some(_) => sheet.total_mass() * m.specific_heat,
                None => m.areal_mass() * 0.1 * 0.08 * m.specific_heat,
            };
            let held: f64 = network.capacity.iter().sum();
            assert!((held / wanted - 1.0).abs() < 1e-12, "{}: {held}, not {wanted}", sheet.model.structure);
        }
    }

    #[test]
    fn heat_is_conserved_and_evens_out_at_any_step() {
        for (sheet, points) in every() {
            let mut stepper = ConductionStepper::new(&sheet, points);
            let mut exchange = Exchange::default();
            let n = stepper.network().capacity.len();
            exchange.clear(n);
            for dt in [1e-3, 1.0 / 60.0, 1.7, 1e3, 1e7] {
                let mut celsius: Vec<f64> = (0..n).map(|i| 20.0 + 100.0 * ((i * i) as f64).sin()).collect();
                let before = stepper.heat(&celsius);
                let mean = before / stepper.whole;
                let capacity = stepper.network().capacity.clone();
                let uneven = |celsius: &[f64]| {
                    celsius.iter().zip(&capacity).map(|(t, c)| c * (t - mean) * (t - mean)).sum::<f64>()
                };
                let first = uneven(&celsius);
                for _ in 0..200 {
                    stepper.advance(&mut celsius, &exchange, dt);
                }
                let change = stepper.heat(&celsius) / before - 1.0;
                assert!(change.abs() < 1e-12, "{} at {dt}: {change}", sheet.model.structure);
                // Bridges take the mean of nodes, so that node-to-node noise may change places,
                // while its total does not grow.
                assert!(
                    uneven(&celsius) <= first,
                    "{} at {dt}: {} of {first}",
                    sheet.model.structure,
                    uneven(&celsius)
                );
                if dt >= 1e3 {
                    let furthest = celsius.iter().map(|t| (t - mean).abs()).fold(0.0, f64::max);
                    assert!(furthest < 1e-6, "{} at {dt}: {furthest}", sheet.model.structure);
                }
            }
        }
    }

    #[test]
    fn a_steady_slope_along_the_sheet_drives_nothing_across_it() {
        for (sheet, points) in every() {
            let network = ThermalNetwork::new(&sheet, points);
            let n = network.capacity.len();
            let celsius: Vec<f64> = (0..n).map(|i| 40.0 + 30.0 * sheet.model.uv[i % sheet.node_count()].0).collect();
            let mut flow = vec![0.0; n];
            network.conduct(&celsius, &mut flow);
            // Inner nodes have no net flow; the border supplies it.
            let m = sheet.material();
            let through = m.conductivity * m.thickness * 30.0;
            for (i, q) in flow.iter().enumerate() {
                let inner = !sheet.model.border[i % sheet.node_count()];
                assert!(!inner || q.abs() < 1e-12 * through, "{}: {q} at {i}", sheet.model.structure);
            }
        }
    }

    #[test]
    fn radiation_is_followed_in_long_steps_too() {
        // 0.5 mm polystyrene from 120 °C in 20 °C: 60 °C after 43.79 s, by quadrature of dt = -C
        // dT/(2 ε σ (T⁴ - T₀⁴)).
        let sheet = sheet(StructureKind::Shell, (5, 1, 5), None);
        for dt in [1.0 / 60.0, 1.0, 43.79] {
            let mut stepper = ConductionStepper::new(&sheet, 1);
            let n = sheet.node_count();
            let mut exchange = Exchange::default();
            exchange.clear(n);
            for i in 0..n {
                exchange.radiation[i] =
                    2.0 * 0.9 * crate::units::temperature::STEFAN_BOLTZMANN * stepper.network().area[i];
                exchange.supply[i] = exchange.radiation[i] * (20.0 + ZERO_CELSIUS).powi(4);
            }
            let mut celsius = vec![120.0; n];
            let steps = (43.79_f64 / dt).round() as usize;
            (0..steps).for_each(|_| stepper.advance(&mut celsius, &exchange, 43.79 / steps as f64));
            assert!(celsius.iter().all(|t| (t - 60.0).abs() < 0.02), "{dt}: {}", celsius[0]);
        }
    }
}
