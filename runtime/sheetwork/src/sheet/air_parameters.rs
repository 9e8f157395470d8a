//! Parameters of a running sheet for the air, drag and pressure, and the choice of its damping.

use crate::error::InputError;
use crate::sheet::Sheet;
use crate::units::parameters::ParameterId as Id;

impl Sheet {
    /// Length and width at rest (m) to which [`SheetModel::uv`](crate::sheet::SheetModel::uv)
    /// refers.
    pub fn rest_size(&self) -> (f64, f64) {
        self.model.extent
    }

    /// Whether it has the bending stiffness of its material, as a shell and calibrated springs do.
    /// [`Sheet::damping_ratio`] then gives its damping, otherwise [`Sheet::damping`].
    pub fn follows_material(&self) -> bool {
        self.parameters.springs.is_calibrated || self.elements.len() > self.grabs.len()
    }

    /// Drag coefficients across and along the air stream.
    pub fn drag(&self) -> (f64, f64) {
        self.parameters.drag.coefficients
    }

    /// Pressure on the upper side above that on the lower, Pa.
    pub fn pressure(&self) -> f64 {
        self.parameters.drag.pressure
    }

    /// Set a constant pressure on the upper side above that on the lower, Pa, -1e6 to 1e6.
    ///
    /// # Errors
    /// When it is out of range; nothing is changed then.
    pub fn set_pressure(&mut self, pressure: f64) -> Result<(), InputError> {
        Id::Pressure.check("pressure", pressure)?;
        self.parameters.drag.set_pressure(pressure);
        self.wake();
        Ok(())
    }

    /// Change the drag coefficients across and along the air stream, each 0 to 10.
    ///
    /// # Errors
    /// When one is out of range; nothing is changed then.
    pub fn set_drag(&mut self, across: f64, along: f64) -> Result<(), InputError> {
        Id::DragAcross.check("drag.0", across)?;
        Id::DragAlong.check("drag.1", along)?;
        self.parameters.drag.coefficients = (across, along);
        self.wake();
        Ok(())
    }
}

/// Update the pressure to the schedule of the scene at `time` (s).
pub(crate) fn update_pressure(sheet: &mut Sheet, time: f64) {
    if sheet.parameters.drag.follow_schedule(time) {
        sheet.wake();
    }
}
