//! What the user has chosen to see: of the scene, of the plots, of the controls.

use bevy_sheetwork::SheetColour;
use bevy_sheetwork::render::ColourScale;
use clap::ValueEnum;
use sheetwork::World;

use crate::picture::{Layer, Look};
use crate::session::Session;

/// What is drawn of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// The sheets' surfaces.
    pub surface: bool,
    /// Which layer the surface goes through.
    pub layer: Layer,
    /// Whether the surface is smoothed through the masses, or flat between them.
    pub smooth: bool,
    /// What the surface is coloured by; none for what shows most of a scene's heat, where it has any.
    pub colour: Option<SheetColour>,
    /// The springs as lines, coloured by their strain.
    pub springs: bool,
    /// The masses as dots.
    pub masses: bool,
    /// The floor and the back wall.
    pub room: bool,
    /// Rigid bodies.
    pub bodies: bool,
    /// Masses that are held, as marks.
    pub pins: bool,
    /// Masses that touch something, as marks.
    pub contacts: bool,
    /// Which way the drawn side faces, as lines from the masses.
    pub normals: bool,
}

impl Default for Display {
    fn default() -> Self {
        let (layer, colour) = (Layer::Top, None);
        let (pins, contacts, room, bodies) = (true, false, true, true);
        Self {
            surface: true,
            layer,
            smooth: true,
            colour,
            springs: false,
            masses: false,
            room,
            bodies,
            pins,
            contacts,
            normals: false,
        }
    }
}

impl Display {
    /// The same for `session`: an old recording has no temperatures that sheets could be coloured by.
    pub fn of(self, session: &Session) -> Self {
        let plain = session.playback().is_some_and(|recording| !recording.has_heat());
        if plain { Self { colour: Some(SheetColour::Plain), ..self } } else { self }
    }

    /// The same for our own rasteriser.
    pub fn look(&self) -> Look {
        Look { layer: self.layer, parts: if self.smooth { 4 } else { 1 }, colour: self.colour }
    }

    /// The scale of the colours that the surfaces of `world` have; `None` where they have none, or are not drawn.
    pub fn scale(&self, world: &World) -> Option<ColourScale> {
        let colour = self.colour.unwrap_or_else(|| SheetColour::of_heat(world));
        colour.scale(world).filter(|_| self.surface)
    }

    /// One scale for all worlds that `session` shows: from the least to the most of any.
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

/// A part of the controls on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Section {
    /// Structure, grid, size, place, damping, pins.
    Sheet,
    /// What it is made of.
    Material,
    /// Rigid bodies.
    Bodies,
    /// How time passes.
    Engine,
    /// What heats.
    Heat,
    /// What is drawn.
    Display,
    /// Where it is seen from.
    Camera,
    /// Variants beside the scene.
    Compare,
    /// Other processes.
    Link,
}

impl Section {
    /// All of them, with their titles.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Material, "Material"),
        (Self::Sheet, "Sheet"),
        (Self::Bodies, "Bodies"),
        (Self::Engine, "Engine"),
        (Self::Heat, "Heat"),
        (Self::Display, "Display"),
        (Self::Camera, "Camera"),
        (Self::Compare, "Compare"),
        (Self::Link, "Live link"),
    ];
}

/// Which plots are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plots {
    /// Whether there are any.
    pub shown: bool,
    /// Energies.
    pub energy: bool,
    /// Wall-clock time of a step.
    pub step: bool,
    /// The same of each part of a step; what is not shown is not measured.
    pub stages: bool,
    /// Heights of probes.
    pub height: bool,
    /// Temperatures.
    pub temperature: bool,
    /// What is delivered of the stiffness that was asked for.
    pub stiffness: bool,
}

impl Default for Plots {
    fn default() -> Self {
        Self { shown: false, energy: true, step: true, stages: false, height: true, temperature: true, stiffness: true }
    }
}
