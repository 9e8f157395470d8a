//! Pinning, attachment to bodies, and release of nodes of a sheet in a running world. The state of
//! the sheet is kept. They are part of a snapshot; a reset returns to the pins of the description.

use glam::{DQuat, DVec3};
use rapier3d::prelude::{RigidBodyHandle, RigidBodySet};

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::rigid::lent::lent_pose;
use crate::scene::{PinSpec, Region};
use crate::sheet::attached_body::AttachedTo;
use crate::sheet::remap::motion::PIN_TOLERANCE;
use crate::sheet::{attachment, region};
use crate::world::World;
use crate::world::bodies::is_valid_pose;
use crate::{BodyId, SheetId, scene};

impl World {
    /// Pin nodes of the sheet `id` where they are: fixed, or along a path. The times of the path
    /// and of `until` count from now, its offsets from the present positions. A node that another
    /// pin holds is taken over. Returns the number of nodes. The sheet keeps its grid from then on.
    ///
    /// # Errors
    /// When there is no such sheet, the pin is invalid or its region empty, or it has `clamp`,
    /// `axes` or `body`, which a sheet has from the start; nothing changes then.
    pub fn pin(&mut self, id: SheetId, pin: &PinSpec) -> Result<usize, InputError> {
        scene::validate::pin(pin)?;
        if !pin.is_live() {
            let field = if pin.clamp {
                "clamp"
            } else if pin.body.is_some() {
                "body"
            } else {
                "axes"
            };
            let problem = "cannot be given to a running sheet; two pinned rows of nodes hold the slope";
            return Err(InputError::new(field, problem));
        }
        let now = self.time;
        let index = self.index_of_sheet(id)?;
        let sheet = &mut self.sheets[index];
        let nodes = sorted(region::select(&pin.region, sheet)?);
        let mut path = pin.path.clone();
        path.iter_mut().for_each(|key| key.time += now);
        let count = nodes.len();
        attachment::pin_nodes(sheet, nodes, path, pin.until.map(|until| until + now));
        Ok(count)
    }

    /// Attach nodes of the sheet `id`, where they are, to a body of the world: it takes them along,
    /// and if it is dynamic their force moves it. A row of nodes is a hinge; two rows hold the
    /// slope. A node that a pin or another body holds is taken over. Returns the number of nodes.
    /// The sheet keeps its grid from then on.
    ///
    /// # Errors
    /// When there is no such sheet or body, the region is empty, or one of its nodes is clamped;
    /// nothing changes then.
    pub fn attach(&mut self, id: SheetId, region: &Region, body: BodyId) -> Result<usize, InputError> {
        let gone = || InputError::new("body", "was removed");
        let body = self.body_ids.position(body.0).ok_or_else(gone)?;
        let state = *self.rigid.as_deref().and_then(|rigid| rigid.state(body)).ok_or_else(gone)?;
        self.attach_to(id, region, AttachedTo::Own(body), state)
    }

    /// As [`World::attach`], to a body of the caller's rigid world, whose bodies are `bodies`
    /// between two calls of [`World::advance_with`]. If the view of these calls is
    /// [`RigidView::pushing`](crate::RigidView::pushing), a dynamic body is moved by the sheet;
    /// otherwise it leads it. A removed body lets the nodes go.
    ///
    /// # Errors
    /// As [`World::attach`].
    pub fn attach_lent(
        &mut self,
        id: SheetId,
        region: &Region,
        (bodies, handle): (&RigidBodySet, RigidBodyHandle),
    ) -> Result<usize, InputError> {
        let body = bodies.get(handle).ok_or_else(|| InputError::new("body", "is not in this set"))?;
        self.attach_to(id, region, AttachedTo::Lent(handle), lent_pose(body))
    }

    fn attach_to(
        &mut self,
        id: SheetId,
        region: &Region,
        owner: AttachedTo,
        state: BodyState,
    ) -> Result<usize, InputError> {
        let index = self.index_of_sheet(id)?;
        let sheet = &mut self.sheets[index];
        let nodes = sorted(region::select(region, sheet)?);
        if let Some(node) = nodes.iter().find(|node| sheet.model.clamped[**node as usize]) {
            return Err(InputError::new("region", format!("node {node} is clamped, and a clamp keeps its slope")));
        }
        attachment::attach_nodes(sheet, &nodes, owner, state);
        Ok(nodes.len())
    }

    /// Lead the pins of the sheet `id` as parts of one rigid body, rotated by `rotation` about the
    /// origin of the world and then displaced by `by` (m), within the next `duration` (s) at
    /// constant velocity. The paths of the pins turn with them, and the free nodes follow by their
    /// forces. Nodes that are attached to bodies stay with these. Returns the number of pinned
    /// nodes.
    ///
    /// # Errors
    /// When there is no such sheet, a number is not finite or out of range, the duration is not
    /// positive, a pin has `axes`, or one is clamped and would rotate; nothing changes then.
    pub fn lead_pins(&mut self, id: SheetId, by: DVec3, rotation: DQuat, duration: f64) -> Result<usize, InputError> {
        if !is_valid_pose(by, rotation) {
            return Err(InputError::new("by", "must be finite and within 10 km, with a rotation of unit length"));
        }
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(InputError::new("duration", "must be positive"));
        }
        let index = self.index_of_sheet(id)?;
        let (rotation, time, sheet) = (rotation.normalize(), self.time, &mut self.sheets[index]);
        if sheet.pins.fixed_axes().next().is_some() {
            return Err(InputError::new("pins", "pins with axes, which are those of the world, are not led"));
        }
        if sheet.model.clamped.contains(&true) && rotation.xyz().length() > PIN_TOLERANCE {
            return Err(InputError::new("rotation", "a clamp keeps its slope; pin two rows of nodes instead"));
        }
        let count = sheet.pins.lead((by, rotation), time, duration);
        if count > 0 {
            sheet.wake();
        }
        Ok(count)
    }

    /// Let go of the nodes of `region` of the sheet `id`: unpin them, and detach them from bodies.
    /// They start with the velocity that they had. Returns how many of them were held. The sheet
    /// keeps its grid from then on.
    ///
    /// # Errors
    /// When there is no such sheet, the region is empty, or one of its nodes is clamped; nothing
    /// changes then.
    pub fn unpin(&mut self, id: SheetId, region: &Region) -> Result<usize, InputError> {
        let index = self.index_of_sheet(id)?;
        let sheet = &mut self.sheets[index];
        let nodes = sorted(region::select(region, sheet)?);
        if let Some(node) = nodes.iter().find(|node| sheet.model.clamped[**node as usize]) {
            let problem =
                format!("node {node} is clamped, which a running sheet cannot undo; pin two rows of nodes instead");
            return Err(InputError::new("region", problem));
        }
        Ok(attachment::unpin_nodes(sheet, &nodes))
    }
}

fn sorted(mut nodes: Vec<u32>) -> Vec<u32> {
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
