//! Grabs: springs between a hand and a material point of a sheet, see [`GrabSpring`].

use std::borrow::Cow;

use glam::DVec3;

use crate::elements::grab_spring::GrabSpring;
use crate::elements::{Element, NO_BLOCK};
use crate::error::{InputError, check_range, reject_if};
use crate::sheet::{Probe, Sheet};

/// Maximum number of grabs of one sheet.
pub const MAX_GRABS: usize = 8;
/// Maximum stiffness of a grab, N/m.
const MAX_GRAB_STIFFNESS: f64 = 1e9;
/// Maximum coordinate of a target, m.
const MAX_TARGET_COORDINATE: f64 = 1e6;

impl Sheet {
    /// Apply an impulse (N s) to node `node` and wake the sheet. A fixed node does not move.
    ///
    /// # Errors
    /// When there is no such node, or the impulse is not finite; nothing changes then.
    pub fn apply_impulse(&mut self, node: usize, impulse: DVec3) -> Result<(), InputError> {
        reject_if!(node >= self.node_count(), "node", "no node {node}; the sheet has {}", self.node_count());
        reject_if!(!impulse.is_finite(), "impulse", "not finite");
        self.state.v.add(node, impulse * self.inverse_mass[node]);
        self.wake();
        Ok(())
    }

    /// Grab the material point (u, v), each 0 to 1 over the bottom layer, by a spring of
    /// `stiffness` (N/m, above 0 to 1e9) to its present position; return the index of the grab. The
    /// spring limits the stable step of an explicit integrator like the springs of the sheet.
    ///
    /// # Errors
    /// When a value is out of range, or the sheet has eight grabs already.
    pub fn grab(&mut self, uv: (f64, f64), stiffness: f64) -> Result<usize, InputError> {
        check_range("u", uv.0, 0.0, 1.0, "")?;
        check_range("v", uv.1, 0.0, 1.0, "")?;
        check_range("stiffness", stiffness, 1e-9, MAX_GRAB_STIFFNESS, "N/m")?;
        reject_if!(self.grabs.len() >= MAX_GRABS, "grab", "{MAX_GRABS} pull at {} already", self.name);
        let (masses, weights) = material_point(self, uv).terms();
        let mut pull = GrabSpring::new(masses, weights, DVec3::ZERO, stiffness);
        pull.target = pull.point(&self.state.x);
        self.grabs.push(pull);
        add_pull(self);
        Ok(self.grabs.len() - 1)
    }

    /// Move the target of grab `index` to `target` (m, each coordinate within ±1e6), from the next
    /// step on.
    ///
    /// # Errors
    /// When there is no such grab, or the target is out of range; nothing is changed then.
    pub fn pull(&mut self, index: usize, target: DVec3) -> Result<(), InputError> {
        for (axis, value) in target.to_array().into_iter().enumerate() {
            check_range(&format!("target.{axis}"), value, -MAX_TARGET_COORDINATE, MAX_TARGET_COORDINATE, "m")?;
        }
        let Some(pull) = self.grabs.get_mut(index) else { return Err(InputError::new("pull", "nobody pulls there")) };
        if pull.target != target {
            pull.target = target;
            // The element keeps its place in the list, so the block indices of the others stay
            // valid.
            let at = self.elements.len() - self.grabs.len() + index;
            self.elements[at] = bound_element(self, index);
            self.wake();
        }
        Ok(())
    }

    /// Release grab `index`; later indices decrease by one. False when there is none.
    pub fn release_grab(&mut self, index: usize) -> bool {
        if index >= self.grabs.len() {
            return false;
        }
        let at = self.elements.len() - self.grabs.len() + index;
        self.elements.remove(at);
        self.grabs.remove(index);
        if let Some(system) = &mut self.system {
            system.forget_constant();
        }
        self.wake();
        true
    }

    /// Grabs of the sheet.
    pub fn pulls(&self) -> &[GrabSpring] {
        &self.grabs
    }
}

/// Triangles of the bottom layer.
pub(crate) fn bottom_triangles(sheet: &Sheet) -> Cow<'_, [[u32; 3]]> {
    match (&sheet.model.triangles, sheet.model.layers.first()) {
        (Some(triangles), _) => Cow::Borrowed(triangles),
        (None, Some(layer)) => Cow::Owned(layer.triangles()),
        (None, None) => Cow::Owned(Vec::new()),
    }
}

/// Material point (u, v), each 0 to 1, of the bottom layer.
pub(crate) fn material_point(sheet: &Sheet, uv: (f64, f64)) -> Probe {
    let first = sheet.model.layers.first().map_or(0, |l| l.first);
    Probe::new("", uv, first, &bottom_triangles(sheet), &sheet.model.uv)
}

/// Grab `index` as an element, bound to the blocks of the linear system if there is one.
fn bound_element(sheet: &Sheet, index: usize) -> Box<GrabSpring> {
    let mut pull = Box::new(sheet.grabs[index]);
    if let Some(system) = &sheet.system {
        pull.bind_blocks(&|a, b| system.block(a, b).unwrap_or(NO_BLOCK));
    }
    pull
}

/// Add the last grab to the elements.
pub(crate) fn add_pull(sheet: &mut Sheet) {
    let Some(pull) = sheet.grabs.last() else { return };
    if let Some(system) = &mut sheet.system {
        let mut missing = false;
        pull.visit_coupled_nodes(&mut |a, b| missing |= system.lacks_block(a, b));
        system.forget_constant();
        if missing {
            // No element couples these nodes of one triangle, so the linear system is rebuilt
            // and the integrator restarts.
            sheet.system = None;
            sheet.last_field = None;
        }
    }
    sheet.elements.push(bound_element(sheet, sheet.grabs.len() - 1));
    sheet.wake();
}
