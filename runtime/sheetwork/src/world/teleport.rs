//! Rigid displacement of a sheet in a running world, at once: x -> R x + d (m), v -> R v, with the
//! rotation R about the origin of the world. Objects on the way are not touched.

use glam::{DQuat, DVec3};

use crate::SheetId;
use crate::error::InputError;
use crate::sheet::remap::motion::PIN_TOLERANCE;
use crate::sheet::stage;
use crate::world::World;
use crate::world::bodies::is_valid_pose;

impl World {
    /// Move the sheet `id` at once, rotated by `rotation` about the origin of the world and then
    /// displaced by `by` (m), with its shape, velocities, heat and pins; it wakes. To stop it,
    /// clear `state.v` of [`World::get_sheet_mut`]. Where it then lies inside a body or crosses
    /// another sheet, contact treats it as one that began there.
    ///
    /// # Errors
    /// When there is no such sheet, a number is not finite or out of range, the sheet is attached
    /// to a body, or it is clamped and would rotate; nothing changes then.
    pub fn move_sheet(&mut self, id: SheetId, by: DVec3, rotation: DQuat) -> Result<(), InputError> {
        if !is_valid_pose(by, rotation) {
            return Err(InputError::new("by", "must be finite and within 10 km, with a rotation of unit length"));
        }
        let index = self.index_of_sheet(id)?;
        let (rotation, time, sheet) = (rotation.normalize(), self.time, &mut self.sheets[index]);
        if sheet.pins.is_attached() {
            return Err(InputError::new("sheet", format!("{}: is attached to a body; move the body", sheet.name)));
        }
        if sheet.model.clamped.contains(&true) && rotation.xyz().length() > PIN_TOLERANCE {
            return Err(InputError::new(
                "rotation",
                format!("{}: is clamped, and a clamp keeps its slope", sheet.name),
            ));
        }
        self.wake_around(index);
        let sheet = &mut self.sheets[index];
        for i in 0..sheet.node_count() {
            let (x, v) = (sheet.state.x.get(i), sheet.state.v.get(i));
            sheet.state.x.set(i, rotation * x + by);
            sheet.state.v.set(i, rotation * v);
        }
        sheet.pins.adopt_positions(time, &mut sheet.state.x, PIN_TOLERANCE * sheet.model.length);
        sheet.state.touching.fill(false);
        stage::restart_engine(sheet);
        sheet.invalidate_interpenetration();
        sheet.wake();
        self.discard_contact_cache(index);
        Ok(())
    }
}
