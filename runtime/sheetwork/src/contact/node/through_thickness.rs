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

use crate::contact::node::response::reduce_speed;
use crate::sheet::layer_stack::{LayerImpact, LayerStack, NeighbourLists};
use crate::sheet::{Sheet, SheetState};

/// Propagate the impacts in `sheet.work.layer_impacts` from layer to layer, upwards and then
/// downwards, after a step of `dt` (s).
pub(crate) fn propagate_impacts(sheet: &mut Sheet, dt: f64) {
    for layer in 1..sheet.stack.layers {
        propagate_to_layer(sheet, layer, dt, |stack| &stack.below);
    }
    for layer in (0..sheet.stack.layers.saturating_sub(1)).rev() {
        propagate_to_layer(sheet, layer, dt, |stack| &stack.above);
    }
}

/// Propagate the impacts to the nodes of one layer from the layer on the given `side`.
fn propagate_to_layer(sheet: &mut Sheet, layer: u32, dt: f64, side: impl Fn(&LayerStack) -> &NeighbourLists) {
    let drift = sheet.engine_kind.info().drift - 0.5;
    let Sheet { stack, work, state: SheetState { x, v, .. }, inverse_mass, .. } = sheet;
    let from = side(stack);
    for i in 0..stack.layer_of.len() {
        if stack.layer_of[i] != layer || work.layer_impacts[i].share > 0.0 || inverse_mass[i] == 0.0 {
            continue;
        }
        let Some(strike) = mean_impact(from.of(i), &work.layer_impacts) else { continue };
        work.layer_impacts[i] = strike;
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
fn mean_impact(neighbours: &[u32], struck: &[LayerImpact]) -> Option<LayerImpact> {
    let mut sum = LayerImpact::default();
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
    Some(LayerImpact {
        share: total / neighbours.len() as f64,
        normal: sum.normal.normalize_or_zero(),
        body: sum.body / total,
        restitution: sum.restitution / total,
        friction: sum.friction / total,
        rest: sum.rest / total,
    })
}

/// Velocity relative to the body after the shared impact, m/s.
fn rebound(v: DVec3, strike: &LayerImpact) -> DVec3 {
    let approach = v.dot(strike.normal);
    if approach >= 0.0 {
        return v;
    }
    let impulse = -(1.0 + strike.restitution) * approach * strike.share;
    let along = v - strike.normal * approach;
    reduce_speed(along, strike.friction * impulse) + strike.normal * (approach + impulse)
}
