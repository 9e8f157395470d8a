//! Content of a frame of a recording, and its creation from a world.

use std::sync::Arc;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::scene::HeatMode;
use crate::sheet::Sheet;
use crate::sheet::remap::motion;
use crate::sheet::temperature::RecordedTemperature;

/// Header of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingHeader {
    /// Name of the scene.
    pub scene: String,
    /// The scene itself (RON), from which a player builds surfaces and bodies.
    pub source: String,
    /// Frames per simulated second.
    pub frames_per_second: f64,
    /// Number of nodes of each sheet.
    pub masses: Vec<usize>,
    /// Number of bodies.
    pub bodies: usize,
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedFrame {
    /// Simulated time, s.
    pub time: f64,
    /// Positions of the nodes of each sheet, m.
    pub sheets: Vec<Vec<Vec3>>,
    /// Position (m) and rotation of each body.
    pub bodies: Vec<(Vec3, Quat)>,
    /// Temperatures of each sheet; empty without data.
    pub temperatures: Vec<RecordedTemperature>,
    /// Open state of the cells of each sheet, as in [`Sheet::open_cells`]; empty for a sheet
    /// without open cells. The list is empty when no sheet has data.
    pub open: Vec<Arc<[bool]>>,
}

impl RecordedFrame {
    /// Frame of a world; a sheet on another grid is interpolated at the nodes of its scene's grid.
    pub fn of(world: &World) -> Self {
        let by_thesis = matches!(world.scene().heat_mode, HeatMode::Thesis { .. });
        let sheets = world.sheets();
        // A sheet from a file has the grid of the file.
        let grids = world.scene().sheets.iter().zip(sheets).map(|(spec, sheet)| {
            let grid = if spec.file.is_some() { sheet.model.grid } else { spec.grid };
            (grid.0, grid.2)
        });
        let places =
            |(s, grid): (&Sheet, (u32, u32))| motion::positions_at(s, grid).iter().map(|p| p.as_vec3()).collect();
        let open = |s: &Sheet| s.open_cells().filter(|_| s.open_count() > 0).unwrap_or_default().into();
        let poses = world.rigid().into_iter().flat_map(|r| (0..r.bodies().len()).filter_map(|i| r.pose(i)));
        Self {
            time: world.time(),
            sheets: sheets.iter().zip(grids.clone()).map(places).collect(),
            bodies: poses.map(|(position, rotation)| (position.as_vec3(), rotation.as_quat())).collect(),
            temperatures: sheets
                .iter()
                .zip(grids)
                .map(|(s, grid)| RecordedTemperature::of(s, grid, by_thesis))
                .collect(),
            open: sheets.iter().map(open).collect(),
        }
    }

    /// Temperatures of the sheet `index`.
    pub fn temperatures_of(&self, index: usize) -> &RecordedTemperature {
        self.temperatures.get(index).unwrap_or(&RecordedTemperature::Unknown)
    }

    /// Open state of the cells of the sheet `index`; empty for a sheet without open cells.
    pub fn open_of(&self, index: usize) -> &[bool] {
        self.open.get(index).map_or(&[], |cells| cells)
    }
}
