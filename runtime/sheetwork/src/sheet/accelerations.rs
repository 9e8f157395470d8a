//! Node accelerations for explicit integrators: springs, elements, gravity, air and applied forces.
//!
//! a_i = (Σ element and spring forces + applied force) / m_i + g - λ v_i (m/s²) for a dynamic node,
//! and 0 for a fixed or kinematic node.

use glam::DVec3;

use crate::elements::Element;
use crate::elements::spring::{SpringWorkspace, Springs};
use crate::integrators::{AdvanceReport, Forces};
use crate::math::Vectors;
use crate::sheet::air_drag::AirDrag;
use crate::sheet::{Pins, Sheet, creep, implicit_system};

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
    has_dashpots: bool,
    springs: &'a Springs,
    elements: &'a [Box<dyn Element>],
    drag: &'a mut AirDrag,
    pins: &'a Pins,
    inverse_mass: &'a [f64],
    applied: &'a Vectors,
    scratch: &'a mut SpringWorkspace,
    force: &'a mut Vectors,
}

impl Forces for SheetForces<'_> {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        self.force.copy_from(self.applied);
        self.springs.add_forces(x, v, self.has_dashpots, self.scratch, self.force);
        self.elements.iter().for_each(|e| e.add_forces(x, v, self.force));
        if self.drag.is_active(&self.field) {
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
        self.pins.zero_fixed_axes(a);
    }
}

/// Advance the sheet by its integrator from time `t` (s) by up to `dt` (s) under `field`,
/// without contact and limits.
pub(crate) fn advance(sheet: &mut Sheet, field: Field, t: f64, dt: f64) -> AdvanceReport {
    let done = advance_uncommitted(sheet, field, t, dt);
    creep::end_inelastic_step(sheet);
    done
}

/// Advance as [`advance`] does, without storing the inelastic strain:
/// [`end_inelastic_step`](crate::sheet::creep::end_inelastic_step) stores it once the step is
/// accepted.
pub(crate) fn advance_uncommitted(sheet: &mut Sheet, field: Field, t: f64, dt: f64) -> AdvanceReport {
    if sheet.work.force.len() != sheet.state.x.len() {
        sheet.work.force = Vectors::zeros(sheet.state.x.len());
    }
    creep::begin_inelastic_step(sheet, dt);
    let done = if sheet.engine_kind.info().implicit {
        implicit_system::advance_implicit(sheet, field, t, dt)
    } else {
        advance_explicit(sheet, field, t, dt)
    };
    sheet.state.counters.accepted += done.accepted;
    sheet.state.counters.rejected += done.rejected;
    sheet.state.counters.evaluations += done.evaluations;
    sheet.state.counters.guarded += done.globalised;
    done
}

fn advance_explicit(sheet: &mut Sheet, field: Field, t: f64, dt: f64) -> AdvanceReport {
    let mut forces = SheetForces {
        field,
        has_dashpots: sheet.parameters.springs.has_dashpots,
        springs: &sheet.springs,
        elements: &sheet.elements,
        drag: &mut sheet.parameters.drag,
        pins: &sheet.pins,
        inverse_mass: &sheet.inverse_mass,
        applied: &sheet.parameters.applied,
        scratch: &mut sheet.work.springs,
        force: &mut sheet.work.force,
    };
    sheet.engine.advance(&mut forces, t, dt, &mut sheet.state.x, &mut sheet.state.v)
}

/// Add the forces of springs and elements at the present positions and velocities to `force`
/// (N).
#[doc(hidden)]
pub fn add_internal_forces(sheet: &Sheet, force: &mut Vectors) {
    sheet.springs.add_forces(&sheet.state.x, &sheet.state.v, true, &mut SpringWorkspace::default(), force);
    sheet.elements.iter().for_each(|e| e.add_forces(&sheet.state.x, &sheet.state.v, force));
}
