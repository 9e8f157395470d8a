//! Content of a frame of a recording, and its creation from a world.

use std::sync::Arc;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::scene::HeatMode;
use crate::sheet::Sheet;

/// Header of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
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

/// Temperatures of the nodes of a sheet, to a twentieth of a degree, or their remaining stiffness.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Warmth {
    /// No data: the sheet has no thermal model, or the file has version 1.
    #[default]
    Unknown,
    /// Temperature of each node, uniform through the thickness, °C.
    Mean(Vec<f32>),
    /// Temperature of each node on the lower side, then of each on the upper side, °C.
    Sides(Vec<f32>),
    /// Remaining stiffness at each node, 0 to 1, for the thesis's formulas, which have no
    /// temperature of a sheet.
    Stiffness(Vec<f32>),
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Simulated time, s.
    pub time: f64,
    /// Positions of the nodes of each sheet, m.
    pub sheets: Vec<Vec<Vec3>>,
    /// Position (m) and rotation of each body.
    pub bodies: Vec<(Vec3, Quat)>,
    /// Temperatures of each sheet; empty without data.
    pub warmth: Vec<Warmth>,
    /// Open state of the cells of each sheet, as in [`Sheet::open_cells`]; empty for a sheet
    /// without open cells. The list is empty when no sheet has data.
    pub open: Vec<Arc<[bool]>>,
}

impl Warmth {
    /// Temperatures of a sheet, at the nodes of `grid`.
    fn of(sheet: &Sheet, grid: (u32, u32), by_thesis: bool) -> Self {
        let Some(heat) = sheet.heat() else { return Self::Unknown };
        let single = |values: &[f64]| sheet.values_at(grid, values).iter().map(|v| *v as f32).collect::<Vec<_>>();
        if by_thesis {
            let left: Vec<f64> = (0..sheet.masses()).map(|i| 1.0 / heat.compliance(i)).collect();
            return Self::Stiffness(single(&left));
        }
        match heat.halves() {
            Some((lower, upper)) => Self::Sides([single(lower), single(upper)].concat()),
            None => Self::Mean(single(heat.celsius())),
        }
    }

    /// Values; empty without data.
    pub fn values(&self) -> &[f32] {
        match self {
            Self::Unknown => &[],
            Self::Mean(values) | Self::Sides(values) | Self::Stiffness(values) => values,
        }
    }

    /// Number of values for `masses` nodes.
    pub(crate) fn count(&self, masses: usize) -> usize {
        match self {
            Self::Unknown => 0,
            Self::Mean(_) | Self::Stiffness(_) => masses,
            Self::Sides(_) => masses.saturating_mul(2),
        }
    }

    /// Linear interpolation at `part` (0 to 1) from `self` to `other`; `self` when their kinds or
    /// lengths differ.
    pub fn towards(&self, other: &Self, part: f32) -> Self {
        let (from, to) = (self.values(), other.values());
        let between = || from.iter().zip(to).map(|(a, b)| a + (b - a) * part).collect();
        match (self, other) {
            (Self::Mean(_), Self::Mean(_)) if from.len() == to.len() => Self::Mean(between()),
            (Self::Sides(_), Self::Sides(_)) if from.len() == to.len() => Self::Sides(between()),
            (Self::Stiffness(_), Self::Stiffness(_)) if from.len() == to.len() => Self::Stiffness(between()),
            _ => self.clone(),
        }
    }
}

impl Frame {
    /// Frame of a world; a sheet on another grid is interpolated at the nodes of its scene's grid.
    pub fn of(world: &World) -> Self {
        let by_thesis = matches!(world.scene().heat_mode, HeatMode::Thesis { .. });
        let sheets = world.sheets();
        let grids = world.scene().sheets.iter().map(|s| (s.grid.0, s.grid.2));
        let places = |(s, grid): (&Sheet, (u32, u32))| s.places_at(grid).iter().map(|p| p.as_vec3()).collect();
        let open = |s: &Sheet| s.open_cells().filter(|_| s.open_count() > 0).unwrap_or_default().into();
        let poses = world.rigid().into_iter().flat_map(|r| (0..r.bodies().len()).filter_map(|i| r.pose(i)));
        Self {
            time: world.time(),
            sheets: sheets.iter().zip(grids.clone()).map(places).collect(),
            bodies: poses.map(|(position, rotation)| (position.as_vec3(), rotation.as_quat())).collect(),
            warmth: sheets.iter().zip(grids).map(|(s, grid)| Warmth::of(s, grid, by_thesis)).collect(),
            open: sheets.iter().map(open).collect(),
        }
    }

    /// Temperatures of the sheet `index`.
    pub fn warmth_of(&self, index: usize) -> &Warmth {
        self.warmth.get(index).unwrap_or(&Warmth::Unknown)
    }

    /// Open state of the cells of the sheet `index`; empty for a sheet without open cells.
    pub fn open_of(&self, index: usize) -> &[bool] {
        self.open.get(index).map_or(&[], |cells| cells)
    }
}
