//! Tools of the view: action of the left button, object held, brush.

use clap::ValueEnum;
use glam::Vec2;

use crate::gizmo::{Gizmo, Handle};
use crate::session::{Item, Session};

/// Action of the left button in the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// Rotate the view.
    #[default]
    Look,
    /// Grab a sheet.
    Grab,
    /// Pin or unpin a node.
    Pin,
    /// Move bodies and heaters, and sheets before the first step.
    Move,
    /// Crease a sheet along a line.
    Crease,
    /// Paint heat.
    Heat,
    /// Cut a sheet along a line.
    Cut,
    /// Pan the view.
    Pan,
    /// Zoom the view.
    Zoom,
    /// Leave view and scene as they are.
    None,
}

impl Tool {
    /// Mouse modes of the view (thesis 4.8.1): name and description.
    pub const MODES: [(Self, &'static str, &'static str); 4] = [
        (Self::Look, "Rotate", "Left drag rotates the view (Q)"),
        (Self::Pan, "Pan", "Left drag pans the view"),
        (Self::Zoom, "Zoom", "Left drag to the right zooms in, to the left out"),
        (Self::None, "None", "Left drag does nothing"),
    ];

    /// Tools: name and description.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Look, "Look", "Left drag rotates the view (Q)"),
        (Self::Grab, "Grab", "Left drag pulls a sheet with a spring; its force is shown (G)"),
        (Self::Pin, "Pin", "A click pins a node at its position, or unpins it (P)"),
        (
            Self::Move,
            "Move",
            "A click selects a body, heater, heat gun, or before the first step a sheet; its arrows move it (W)",
        ),
        (Self::Crease, "Crease", "Left drag draws a crease of a shell (C)"),
        (Self::Heat, "Heat", "Left drag paints heat on a sheet (H)"),
        (Self::Cut, "Cut", "Left drag draws a line along which the cells of a sheet open (X)"),
    ];
}

/// Settings of the brush and the crease tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Painted temperature, °C.
    pub celsius: f64,
    /// Radius, m; `None` for a twelfth of the sheet.
    pub radius: Option<f64>,
    /// Angle of a crease, degrees.
    pub angle: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { celsius: 120.0, radius: None, angle: 60.0 }
    }
}

impl Brush {
    /// Radius on a sheet of this length and width, m.
    pub fn radius_on(&self, (length, width): (f64, f64)) -> f64 {
        self.radius.unwrap_or_else(|| length.max(width) / 12.0).clamp(1e-6, 1e3)
    }
}

/// Object held by the left button.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// Point of a sheet, m; the mouse moves in the plane through it parallel to the picture plane.
    Sheet(glam::Vec3),
    /// Line on a sheet: index of the sheet, start and end, (u, v).
    Line(usize, (f64, f64), (f64, f64)),
    /// Brush on a sheet, and position of its last dab, m.
    Brush(usize, glam::DVec3),
    /// Handle of the gizmo, gizmo at the grab, and position of the mouse at the grab.
    Handle(Handle, Gizmo, Vec2),
}

/// Position of the handle of an item, m.
pub(super) fn handle_of(session: &Session, item: Item) -> Option<glam::Vec3> {
    session.handle_of(item).map(|at| at.as_vec3())
}
