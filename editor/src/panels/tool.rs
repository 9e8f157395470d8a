//! The tools of the view: what the left button does, holds, and puts on a sheet.

use clap::ValueEnum;
use glam::Vec2;

use crate::gizmo::{Gizmo, Handle};
use crate::session::{Item, Session};

/// What the left button does in the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// Turns the view.
    #[default]
    Look,
    /// Pulls at a sheet.
    Grab,
    /// Pins a mass, or lets it go.
    Pin,
    /// Moves bodies and heaters, and sheets before time has passed.
    Move,
    /// Folds a sheet along a line.
    Crease,
    /// Paints warmth.
    Heat,
    /// Cuts a sheet along a line.
    Cut,
}

impl Tool {
    /// All of them: name and what they do.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Look, "Look", "Left drag turns the view (Q)"),
        (Self::Grab, "Grab", "Left drag pulls at a sheet with a spring, whose force is shown (G)"),
        (Self::Pin, "Pin", "A click pins a mass where it is, or lets it go (P)"),
        (
            Self::Move,
            "Move",
            "A click chooses a body, heater, heat gun, or before time has passed a sheet; its arrows move it (W)",
        ),
        (Self::Crease, "Crease", "Left drag draws a line along which a shell is folded (C)"),
        (Self::Heat, "Heat", "Left drag paints warmth on a sheet (H)"),
        (Self::Cut, "Cut", "Left drag draws a line along which the cells of a sheet open (X)"),
    ];
}

/// What the tools put on a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Temperature of what is painted, °C.
    pub celsius: f64,
    /// Its radius, m; none for a twelfth of the sheet.
    pub radius: Option<f64>,
    /// By how much a line folds the sheet, degrees.
    pub angle: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { celsius: 120.0, radius: None, angle: 60.0 }
    }
}

impl Brush {
    /// The radius on a sheet of this length and width, m.
    pub fn radius_on(&self, (length, width): (f64, f64)) -> f64 {
        self.radius.unwrap_or_else(|| length.max(width) / 12.0).clamp(1e-6, 1e3)
    }
}

/// What the left button holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// A point of a sheet, m; the mouse moves in the plane through it that faces the eye.
    Sheet(glam::Vec3),
    /// A line on a sheet: which sheet, from where, to where, (u, v).
    Line(usize, (f64, f64), (f64, f64)),
    /// The brush on a sheet, and where it last touched it, m.
    Brush(usize, glam::DVec3),
    /// A handle of the gizmo, the gizmo as it was then, and where the mouse took it.
    Handle(Handle, Gizmo, Vec2),
}

/// Where the handle of an item is, m.
pub(super) fn handle_of(session: &Session, item: Item) -> Option<glam::Vec3> {
    session.handle_of(item).map(|at| at.as_vec3())
}
