//! The accelerations of a sheet's masses: springs, gravity, air, applied forces.
//!
//! a_i = (Σ spring forces + applied) / m_i + g - λ v_i for a free mass, 0 for a held or led one.

use glam::DVec3;

use super::{Sheet, Vectors};
use crate::element::spring::{SpringScratch, Springs};
use crate::engine::{Advance, Forces};

/// What acts on a sheet from outside, the same for all masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Acceleration of gravity, m/s².
    pub gravity: DVec3,
    /// Decay rate of velocities in the air, 1/s.
    pub air: f64,
}

struct SheetForces<'a> {
    field: Field,
    damped: bool,
    springs: &'a Springs,
    inverse_mass: &'a [f64],
    applied: &'a Vectors,
    scratch: &'a mut SpringScratch,
    force: &'a mut Vectors,
}

impl Forces for SheetForces<'_> {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        self.force.copy_from(self.applied);
        self.springs.add_forces(x, v, self.damped, self.scratch, self.force);
        let axes = a.axes_mut().into_iter().zip(self.force.axes()).zip(v.axes());
        for (((a, f), v), g) in axes.zip(self.field.gravity.to_array()) {
            let per_mass = a.iter_mut().zip(f).zip(v).zip(self.inverse_mass);
            for (((a, f), v), w) in per_mass {
                let free = if *w > 0.0 { 1.0 } else { 0.0 };
                *a = w * f + free * (g - self.field.air * v);
            }
        }
    }
}

impl Sheet {
    /// Lets the sheet's engine advance it from time `t` by up to `dt` (s) under `field`; no contact, no limits.
    pub(crate) fn advance(&mut self, field: Field, t: f64, dt: f64) -> Advance {
        if self.work.force.len() != self.x.len() {
            self.work.force = Vectors::zeros(self.x.len());
        }
        let mut forces = SheetForces {
            field,
            damped: self.damped,
            springs: &self.springs,
            inverse_mass: &self.inverse_mass,
            applied: &self.applied,
            scratch: &mut self.work.springs,
            force: &mut self.work.force,
        };
        let done = self.engine.advance(&mut forces, t, dt, &mut self.x, &mut self.v);
        self.counters.accepted += done.accepted;
        self.counters.rejected += done.rejected;
        self.counters.evaluations += done.evaluations;
        done
    }
}
