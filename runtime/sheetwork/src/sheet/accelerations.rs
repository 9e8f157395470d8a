//! Node accelerations for explicit integrators: springs, elements, gravity, air and applied forces.
//!
//! a_i = (Σ element and spring forces + applied force) / m_i + g - λ v_i (m/s²) for a dynamic node,
//! and 0 for a fixed or kinematic node.

use glam::DVec3;

use crate::elements::Element;
use crate::elements::spring::{SpringScratch, Springs};
use crate::integrators::{Advance, Forces};
use crate::math::Vectors;
use crate::sheet::air_drag::Drag;
use crate::sheet::{Pins, Sheet};

/// External field of a sheet, equal for all nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Field {
    /// Acceleration of gravity, m/s².
    pub gravity: DVec3,
    /// Linear damping λ of the velocities, 1/s.
    pub air: f64,
    /// Density of the air for drag, kg/m³; 0 without drag.
    pub air_density: f64,
    /// Velocity of the air, m/s.
    pub wind: DVec3,
}

struct SheetForces<'a> {
    field: Field,
    damped: bool,
    springs: &'a Springs,
    elements: &'a [Box<dyn Element>],
    drag: &'a mut Drag,
    pins: &'a Pins,
    inverse_mass: &'a [f64],
    applied: &'a Vectors,
    scratch: &'a mut SpringScratch,
    force: &'a mut Vectors,
}

impl Forces for SheetForces<'_> {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        self.force.copy_from(self.applied);
        self.springs.add_forces(x, v, self.damped, self.scratch, self.force);
        self.elements.iter().for_each(|e| e.add_forces(x, v, self.force));
        if self.drag.acts(&self.field) {
            self.drag.add_forces(&self.field, x, v, self.force);
        }
        let axes = a.axes_mut().into_iter().zip(self.force.axes()).zip(v.axes());
        for (((a, f), v), g) in axes.zip(self.field.gravity.to_array()) {
            let per_mass = a.iter_mut().zip(f).zip(v).zip(self.inverse_mass);
            for (((a, f), v), w) in per_mass {
                let free = if *w > 0.0 { 1.0 } else { 0.0 };
                *a = w * f + free * (g - self.field.air * v);
            }
        }
        self.pins.hold_rails(a);
    }
}

impl Sheet {
    /// Advance the sheet by its integrator from time `t` (s) by up to `dt` (s) under `field`,
    /// without contact and limits.
    pub(crate) fn advance(&mut self, field: Field, t: f64, dt: f64) -> Advance {
        let done = self.advance_open(field, t, dt);
        self.end_flow();
        done
    }

    /// Advance as [`Sheet::advance`] does, without storing the inelastic strain:
    /// [`Sheet::end_flow`] stores it once the step is accepted.
    pub(crate) fn advance_open(&mut self, field: Field, t: f64, dt: f64) -> Advance {
        if self.work.force.len() != self.x.len() {
            self.work.force = Vectors::zeros(self.x.len());
        }
        self.begin_flow(dt);
        let done = if self.engine_kind.info().implicit {
            self.advance_implicit(field, t, dt)
        } else {
            self.advance_explicit(field, t, dt)
        };
        self.counters.accepted += done.accepted;
        self.counters.rejected += done.rejected;
        self.counters.evaluations += done.evaluations;
        self.counters.guarded += done.guarded;
        done
    }

    fn advance_explicit(&mut self, field: Field, t: f64, dt: f64) -> Advance {
        let mut forces = SheetForces {
            field,
            damped: self.damped,
            springs: &self.springs,
            elements: &self.elements,
            drag: &mut self.drag,
            pins: &self.pins,
            inverse_mass: &self.inverse_mass,
            applied: &self.applied,
            scratch: &mut self.work.springs,
            force: &mut self.work.force,
        };
        self.engine.advance(&mut forces, t, dt, &mut self.x, &mut self.v)
    }

    /// Add the forces of springs and elements at the present positions and velocities to `force`
    /// (N).
    #[doc(hidden)]
    pub fn add_internal_forces(&self, force: &mut Vectors) {
        self.springs.add_forces(&self.x, &self.v, true, &mut SpringScratch::default(), force);
        self.elements.iter().for_each(|e| e.add_forces(&self.x, &self.v, force));
    }
}
