//! Grabs: springs between a hand and a material point of a sheet, see [`Pull`].

use glam::DVec3;

use crate::elements::grab_spring::Pull;
use crate::elements::{Element, NO_BLOCK};
use crate::error::{InputError, check_range};
use crate::sheet::{Probe, Sheet};

/// Maximum number of grabs of one sheet.
pub const MOST_PULLS: usize = 8;
/// Maximum stiffness of a grab, N/m.
const STIFFEST: f64 = 1e9;
/// Maximum coordinate of a target, m.
const FURTHEST: f64 = 1e6;

impl Sheet {
    /// Grab the material point (u, v), each 0 to 1 over the bottom layer, by a spring of
    /// `stiffness` (N/m, above 0 to 1e9) to its present position; return the index of the grab. The
    /// spring limits the stable step of an explicit integrator like the springs of the sheet.
    ///
    /// # Errors
    /// When a value is out of range, or the sheet has eight grabs already.
    pub fn grab(&mut self, uv: (f64, f64), stiffness: f64) -> Result<usize, InputError> {
        check_range("u", uv.0, 0.0, 1.0, "")?;
        check_range("v", uv.1, 0.0, 1.0, "")?;
        check_range("stiffness", stiffness, 1e-9, STIFFEST, "N/m")?;
        if self.pulls.len() >= MOST_PULLS {
            return Err(InputError::new("grab", format!("{MOST_PULLS} pull at {} already", self.name)));
        }
        let triangles = match (&self.triangles, self.layers.first()) {
            (Some(triangles), _) => triangles.clone(),
            (None, Some(layer)) => layer.triangles(),
            (None, None) => Vec::new(),
        };
        let first = self.layers.first().map_or(0, |l| l.first);
        let (masses, weights) = Probe::new("", uv, first, &triangles, &self.uv).terms();
        let mut pull = Pull::new(masses, weights, DVec3::ZERO, stiffness);
        pull.target = pull.point(&self.x);
        self.pulls.push(pull);
        self.add_pull();
        Ok(self.pulls.len() - 1)
    }

    /// Move the target of grab `index` to `target` (m, each coordinate within ±1e6), from the next
    /// step on.
    ///
    /// # Errors
    /// When there is no such grab, or the target is out of range; nothing is changed then.
    pub fn pull(&mut self, index: usize, target: DVec3) -> Result<(), InputError> {
        for (axis, value) in target.to_array().into_iter().enumerate() {
            check_range(&format!("target.{axis}"), value, -FURTHEST, FURTHEST, "m")?;
        }
        let Some(pull) = self.pulls.get_mut(index) else { return Err(InputError::new("pull", "nobody pulls there")) };
        if pull.target != target {
            pull.target = target;
            // The element keeps its place in the list, so the block indices of the others stay
            // valid.
            let at = self.elements.len() - self.pulls.len() + index;
            self.elements[at] = self.boxed(index);
            self.wake();
        }
        Ok(())
    }

    /// Release grab `index`; later indices decrease by one. False when there is none.
    pub fn let_go(&mut self, index: usize) -> bool {
        if index >= self.pulls.len() {
            return false;
        }
        let at = self.elements.len() - self.pulls.len() + index;
        self.elements.remove(at);
        self.pulls.remove(index);
        if let Some(system) = &mut self.system {
            system.forget_constant();
        }
        self.wake();
        true
    }

    /// Grabs of the sheet.
    pub fn pulls(&self) -> &[Pull] {
        &self.pulls
    }

    /// Grab `index` as an element, bound to the blocks of the linear system if there is one.
    fn boxed(&self, index: usize) -> Box<Pull> {
        let mut pull = Box::new(self.pulls[index]);
        if let Some(system) = &self.system {
            pull.bind(&|a, b| system.block(a, b).unwrap_or(NO_BLOCK));
        }
        pull
    }

    /// Add the last grab to the elements.
    pub(crate) fn add_pull(&mut self) {
        let Some(pull) = self.pulls.last() else { return };
        if let Some(system) = &mut self.system {
            let mut missing = false;
            pull.couples(&mut |a, b| missing |= system.lacks(a, b));
            system.forget_constant();
            if missing {
                // No element couples these nodes of one triangle, so the linear system is rebuilt
                // and the integrator restarts.
                self.system = None;
                self.field_before = None;
            }
        }
        self.elements.push(self.boxed(self.pulls.len() - 1));
        self.wake();
    }
}
