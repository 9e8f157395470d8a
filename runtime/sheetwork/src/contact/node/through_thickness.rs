//! An impact on one layer is felt by the layers behind it at once.
//!
//! Through the thickness of a real sheet a shock takes under a microsecond; between the layers of a lattice it would take
//! many steps, and a dropped lattice would bounce off its own inter-layer springs instead of by its restitution. So a mass
//! that is joined across to masses which were struck takes the impact too, in the share s of its neighbours on that side
//! that were struck: its approach velocity vₙ becomes vₙ (1 - (1 + e) s), with friction in proportion. Since s is at most 1
//! this never adds energy, and a sheet that lands flat rebounds as one with e² of its energy, which the layers alone would not
//! give. Resting contact is left to the springs, which carry the weight of the upper layers.

use glam::DVec3;

use crate::contact::node::response::slowed;
use crate::elements::spring::{SpringClass, Springs};
use crate::sheet::Sheet;

/// An impact that a mass took in this step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strike {
    /// Share of the impact, 0 (none) to 1.
    pub share: f64,
    /// Direction out of the body, unit.
    pub normal: DVec3,
    /// Velocity of the body there, m/s.
    pub body: DVec3,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// How much of the step was left after the impact, s.
    pub rest: f64,
}

/// For every mass, the masses it is joined to in the layer below and in the layer above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stack {
    layers: u32,
    layer_of: Vec<u32>,
    below: Neighbours,
    above: Neighbours,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Neighbours {
    first: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn new(lists: &[Vec<u32>]) -> Self {
        let mut all = Self { first: vec![0], list: Vec::new() };
        for list in lists {
            all.list.extend_from_slice(list);
            all.first.push(all.list.len() as u32);
        }
        all
    }

    fn of(&self, i: usize) -> &[u32] {
        &self.list[self.first[i] as usize..self.first[i + 1] as usize]
    }
}

impl Stack {
    /// From the inter-layer springs of a sheet.
    pub fn new(springs: &Springs, layer_of: &[u32]) -> Self {
        let mut below = vec![Vec::new(); layer_of.len()];
        let mut above = vec![Vec::new(); layer_of.len()];
        for i in (0..springs.len()).filter(|i| springs.class[*i] == SpringClass::Inter) {
            let (a, b) = (springs.a[i], springs.b[i]);
            let (low, high) = if layer_of[a as usize] < layer_of[b as usize] { (a, b) } else { (b, a) };
            below[high as usize].push(low);
            above[low as usize].push(high);
        }
        Self {
            layers: layer_of.iter().max().map_or(0, |l| l + 1),
            layer_of: layer_of.to_vec(),
            below: Neighbours::new(&below),
            above: Neighbours::new(&above),
        }
    }

    /// For every mass of a smaller layer, the masses it is joined to in the layer below and, apart, in the layer above.
    pub fn cells(&self) -> impl Iterator<Item = (u32, &[u32])> {
        let small = |i: &usize| self.layer_of[*i] % 2 == 1;
        let masses = (0..self.layer_of.len()).filter(small);
        masses.flat_map(|i| [(i as u32, self.below.of(i)), (i as u32, self.above.of(i))])
    }

    /// Whether there is more than one layer to share between.
    pub fn is_layered(&self) -> bool {
        self.layers > 1
    }
}

/// Passes the impacts in `sheet.work.struck` on from layer to layer, upwards and then downwards, after a step of `dt` s.
pub(crate) fn share_impacts(sheet: &mut Sheet, dt: f64) {
    for layer in 1..sheet.stack.layers {
        pass(sheet, layer, dt, |stack| &stack.below);
    }
    for layer in (0..sheet.stack.layers.saturating_sub(1)).rev() {
        pass(sheet, layer, dt, |stack| &stack.above);
    }
}

fn pass(sheet: &mut Sheet, layer: u32, dt: f64, side: impl Fn(&Stack) -> &Neighbours) {
    let drift = sheet.engine_kind.info().drift - 0.5;
    let Sheet { stack, work, x, v, inverse_mass, .. } = sheet;
    let from = side(stack);
    for i in 0..stack.layer_of.len() {
        if stack.layer_of[i] != layer || work.struck[i].share > 0.0 || inverse_mass[i] == 0.0 {
            continue;
        }
        let Some(strike) = felt(from.of(i), &work.struck) else { continue };
        work.struck[i] = strike;
        // As in `response`: back to the instant of the impact, then on with the new velocity and the same acceleration.
        let ended = v.get(i);
        let change = ended - work.v_before.get(i);
        let gained = change * (strike.rest / dt);
        let shift = change * drift;
        let arriving = ended - gained + shift;
        let leaving = strike.body + rebound(arriving - strike.body, &strike);
        v.set(i, leaving + gained - shift);
        x.set(i, x.get(i) + (leaving - arriving) * strike.rest);
    }
}

/// The mean of what the neighbours took; `None` if none was struck.
fn felt(neighbours: &[u32], struck: &[Strike]) -> Option<Strike> {
    let mut sum = Strike::default();
    for strike in neighbours.iter().map(|j| struck[*j as usize]).filter(|s| s.share > 0.0) {
        sum.share += strike.share;
        sum.normal += strike.normal * strike.share;
        sum.body += strike.body * strike.share;
        sum.restitution += strike.restitution * strike.share;
        sum.friction += strike.friction * strike.share;
        sum.rest += strike.rest * strike.share;
    }
    let total = sum.share;
    if total <= 0.0 {
        return None;
    }
    Some(Strike {
        share: total / neighbours.len() as f64,
        normal: sum.normal.normalize_or_zero(),
        body: sum.body / total,
        restitution: sum.restitution / total,
        friction: sum.friction / total,
        rest: sum.rest / total,
    })
}

/// Velocity relative to the body after the shared impact.
fn rebound(v: DVec3, strike: &Strike) -> DVec3 {
    let approach = v.dot(strike.normal);
    if approach >= 0.0 {
        return v;
    }
    let impulse = -(1.0 + strike.restitution) * approach * strike.share;
    let along = v - strike.normal * approach;
    slowed(along, strike.friction * impulse) + strike.normal * (approach + impulse)
}
