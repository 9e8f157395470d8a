//! Pinning and unpinning of nodes of a sheet in a running world. The state of the sheet is kept.
//! Both are part of a snapshot; a reset returns to the pins of the description.

use crate::error::InputError;
use crate::scene::{PinSpec, Region};
use crate::sheet::{attachment, region};
use crate::world::World;
use crate::{SheetId, scene};

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

    /// Unpin the nodes of `region` of the sheet `id`; they start with the velocity of their pin.
    /// Returns how many of them were pinned. The sheet keeps its grid from then on.
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
