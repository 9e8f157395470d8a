//! What a frame of a recording holds, and what it takes of a world.

use std::sync::Arc;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::scene::HeatMode;
use crate::sheet::Sheet;

/// What a recording holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Name of the scene.
    pub scene: String,
    /// The scene itself (RON), so that a player can rebuild surfaces and bodies.
    pub source: String,
    /// Frames a simulated second.
    pub frames_per_second: f64,
    /// Masses of each sheet.
    pub masses: Vec<usize>,
    /// Number of bodies.
    pub bodies: usize,
}

/// How warm the masses of a sheet are, to a twentieth of a degree, or what that has made of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Warmth {
    /// Not known: nothing heats the sheet, or the file is of the first version.
    #[default]
    Unknown,
    /// Of each mass through the whole thickness, °C.
    Mean(Vec<f32>),
    /// Of each mass on the lower side, and then of each on the upper side, °C.
    Sides(Vec<f32>),
    /// What is left of the stiffness of each mass, 0 to 1: by the thesis's formulas, which know no temperature of a sheet.
    Stiffness(Vec<f32>),
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Simulated time, s.
    pub time: f64,
    /// Positions of the masses of each sheet, m.
    pub sheets: Vec<Vec<Vec3>>,
    /// Position (m) and rotation of each body.
    pub bodies: Vec<(Vec3, Quat)>,
    /// How warm each sheet is; none where none is known.
    pub warmth: Vec<Warmth>,
    /// Of each sheet its cells, and whether each is open, as [`Sheet::open_cells`] has them; empty for one that is whole. None where
    /// all are.
    pub open: Vec<Arc<[bool]>>,
}

impl Warmth {
    /// Of a sheet as it is now, at the masses of `grid`.
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

    /// Its numbers; none of them where nothing is known.
    pub fn values(&self) -> &[f32] {
        match self {
            Self::Unknown => &[],
            Self::Mean(values) | Self::Sides(values) | Self::Stiffness(values) => values,
        }
    }

    /// How many numbers one of `masses` masses has.
    pub(crate) fn count(&self, masses: usize) -> usize {
        match self {
            Self::Unknown => 0,
            Self::Mean(_) | Self::Stiffness(_) => masses,
            Self::Sides(_) => masses.saturating_mul(2),
        }
    }

    /// What lies at `part` (0 to 1) of the way from this to `other`; this where the two are not alike.
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
    /// A world as it is now; a sheet that has gone to another grid at the masses that its scene has.
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

    /// How warm sheet `index` is.
    pub fn warmth_of(&self, index: usize) -> &Warmth {
        self.warmth.get(index).unwrap_or(&Warmth::Unknown)
    }

    /// The cells of sheet `index`, and whether each is open; none of one that is whole.
    pub fn open_of(&self, index: usize) -> &[bool] {
        self.open.get(index).map_or(&[], |cells| cells)
    }
}
