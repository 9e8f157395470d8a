//! Sharing of an impact between the layers of a lattice.
//!
//! In a real sheet a shock crosses the thickness in less than a microsecond. Between the layers of
//! a lattice it takes many steps, so that a dropped lattice would rebound from its inter-layer
//! springs and not by its restitution coefficient. A node that is connected to struck nodes of the
//! next layer therefore takes the impact too. With s the struck fraction of its connected nodes in
//! that layer, its approach velocity v_n becomes v_n (1 - (1 + e) s), with proportional friction.
//! Since s ≤ 1, energy never grows, and a sheet that lands flat rebounds with e² of its energy.
//! Resting contact is left to the springs, which carry the weight of the upper layers.

use glam::DVec3;

use crate::contact::node::response::slowed;
use crate::elements::spring::Springs;
use crate::mesh::spring_class::SpringClass;
use crate::sheet::Sheet;

/// Impact on a node in this step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strike {
    /// Share of the impact, 0 (none) to 1.
    pub share: f64,
    /// Outward unit normal of the body.
    pub normal: DVec3,
    /// Velocity of the body at the contact, m/s.
    pub body: DVec3,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Remaining time of the step after the impact, s.
    pub rest: f64,
}

/// Connections of every node to the layers below and above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stack {
    layers: u32,
    layer_of: Vec<u32>,
    below: Neighbours,
    above: Neighbours,
}

/// Lists of connected nodes, one per node, stored in one array.
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
    /// Build the connections from the inter-layer springs of a lattice and the layer of every node.
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

    /// Nodes of the smaller (odd) layers, each with its connected nodes in the layer below and,
    /// separately, in the layer above.
    pub fn cells(&self) -> impl Iterator<Item = (u32, &[u32])> {
        let small = |i: &usize| self.layer_of[*i] % 2 == 1;
        let masses = (0..self.layer_of.len()).filter(small);
        masses.flat_map(|i| [(i as u32, self.below.of(i)), (i as u32, self.above.of(i))])
    }

    /// Whether the sheet has more than one layer.
    pub fn is_layered(&self) -> bool {
        self.layers > 1
    }
}

/// Propagate the impacts in `sheet.work.struck` from layer to layer, upwards and then downwards,
/// after a step of `dt` (s).
pub(crate) fn share_impacts(sheet: &mut Sheet, dt: f64) {
    for layer in 1..sheet.stack.layers {
        pass(sheet, layer, dt, |stack| &stack.below);
    }
    for layer in (0..sheet.stack.layers.saturating_sub(1)).rev() {
        pass(sheet, layer, dt, |stack| &stack.above);
    }
}

/// Propagate the impacts to the nodes of one layer from the layer on the given `side`.
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
        // As in `response`: back to the time of impact, then forward with the new velocity and the
        // same acceleration.
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

/// Mean impact of the connected nodes, with their share; `None` if none was struck.
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

/// Velocity relative to the body after the shared impact, m/s.
fn rebound(v: DVec3, strike: &Strike) -> DVec3 {
    let approach = v.dot(strike.normal);
    if approach >= 0.0 {
        return v;
    }
    let impulse = -(1.0 + strike.restitution) * approach * strike.share;
    let along = v - strike.normal * approach;
    slowed(along, strike.friction * impulse) + strike.normal * (approach + impulse)
}
