//! Display options: of the scene, of the plots, of the controls.

use bevy_sheetwork::render::ColourScale;
use bevy_sheetwork::{SheetColour, SheetLayer};
use clap::ValueEnum;
use sheetwork::World;
use sheetwork::sheet::surface::SurfaceSmoothing;

use crate::picture::Look;
use crate::session::Session;

/// Displayed items of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Surfaces of the sheets.
    pub surface: bool,
    /// Layer of the surface.
    pub layer: SheetLayer,
    /// Whether the surface is smoothed by splines or flat between the nodes.
    pub smooth: bool,
    /// Kind of the splines.
    pub spline: SurfaceSmoothing,
    /// Field of the colours; `None` for the one that displays the scene's heat.
    pub colour: Option<SheetColour>,
    /// Springs as lines, coloured by strain.
    pub springs: bool,
    /// Nodes as dots.
    pub nodes: bool,
    /// Floor and back wall.
    pub room: bool,
    /// Rigid bodies.
    pub bodies: bool,
    /// Marks of fixed nodes.
    pub pins: bool,
    /// Marks of nodes in contact.
    pub contacts: bool,
    /// Normals of the displayed side, as lines from the nodes.
    pub normals: bool,
}

impl Default for Display {
    fn default() -> Self {
        let (layer, colour) = (SheetLayer::Top, None);
        let (pins, contacts, room, bodies) = (true, false, true, true);
        Self {
            surface: true,
            layer,
            smooth: true,
            spline: SurfaceSmoothing::Interpolating,
            colour,
            springs: false,
            nodes: false,
            room,
            bodies,
            pins,
            contacts,
            normals: false,
        }
    }
}

impl Display {
    /// Options for `session`: a recording without temperatures has no colours of them.
    pub fn for_session(self, session: &Session) -> Self {
        let plain = session.playback().is_some_and(|recording| !recording.has_heat());
        if plain { Self { colour: Some(SheetColour::Plain), ..self } } else { self }
    }

    /// Options of the software rasteriser.
    pub fn look(&self) -> Look {
        let parts = if self.smooth { 4 } else { 1 };
        Look { layer: self.layer, parts, spline: self.spline, colour: self.colour }
    }

    /// Colour scale of the surfaces of `world`; `None` where they have none, or are hidden.
    pub fn scale(&self, world: &World) -> Option<ColourScale> {
        let colour = self.colour.unwrap_or_else(|| SheetColour::of_heat(world));
        colour.scale(world).filter(|_| self.surface)
    }

    /// Common scale of all worlds of `session`, from the lowest to the highest value.
    pub fn scale_of(&self, session: &Session) -> Option<ColourScale> {
        let shown = (0..).map_while(|which| session.shown(which));
        let all = shown.filter_map(|one| self.scale(one.world()));
        all.reduce(|mut a, b| {
            if a.low < a.high {
                (a.low, a.high) = (a.low.min(b.low), a.high.max(b.high));
            }
            a
        })
    }
}

/// Section of the controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Section {
    /// Structure, grid, size, placement, damping, pins.
    Sheet,
    /// Material of the sheet.
    Material,
    /// Rigid bodies.
    Bodies,
    /// Integrator, time step, gravity, air.
    Engine,
    /// Heat sources.
    Heat,
    /// Displayed items.
    Display,
    /// Camera and mouse tool.
    Camera,
    /// Variants of the scene.
    Compare,
    /// Other processes.
    Link,
}

impl Section {
    /// All sections with their titles.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Material, "Material"),
        (Self::Sheet, "Sheet"),
        (Self::Bodies, "Bodies"),
        (Self::Engine, "Integrator"),
        (Self::Heat, "Heat"),
        (Self::Display, "Display"),
        (Self::Camera, "Camera"),
        (Self::Compare, "Compare"),
        (Self::Link, "Live link"),
    ];
}

/// Displayed plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plots {
    /// Whether the plots are shown.
    pub shown: bool,
    /// Energies.
    pub energy: bool,
    /// Wall-clock time of a step.
    pub step: bool,
    /// Wall-clock time of each phase of a step; measured only while shown.
    pub stages: bool,
    /// Heights of probes.
    pub height: bool,
    /// Temperatures.
    pub temperature: bool,
    /// Delivered stiffness relative to the requested one.
    pub stiffness: bool,
}

impl Default for Plots {
    fn default() -> Self {
        Self { shown: false, energy: true, step: true, stages: false, height: true, temperature: true, stiffness: true }
    }
}
