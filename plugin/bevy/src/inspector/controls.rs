//! Numbers with units that are dragged, typed and, by a double click, brought back to what they were.
//!
//! What is typed may leave a slider's range: who is edited checks it and says what it refuses. A text that is no value is told as a message. A value
//! that costs a new world is taken up when the mouse lets go of it, not on its way.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use bevy::math::DVec3;
use bevy_egui::egui::{self, DragValue, Label, PointerButton, Response, Sense, Slider, SliderClamping, Ui};

use super::Knobs;
use super::units::{Quantity, Shown, UnitError};

/// A plain number.
pub const PLAIN: Shown = Shown::fixed(Quantity::Number, "", 1.0);
/// Lengths in millimetres.
pub const MM: Shown = Shown::fixed(Quantity::Length, "mm", 1e-3);
/// Temperatures.
pub const CELSIUS: Shown = Shown::fixed(Quantity::Temperature, "°C", 1.0);
/// Moduli and stresses.
pub const PASCAL: Shown = Shown::prefixed(Quantity::Pressure, "Pa");
/// Times in milliseconds.
pub const MS: Shown = Shown::fixed(Quantity::Time, "ms", 1e-3);

/// How a number is changed.
#[derive(Clone, Debug, Default)]
pub struct How {
    /// A slider over this range in place of a number alone.
    pub range: Option<RangeInclusive<f64>>,
    /// Whether the slider is logarithmic.
    pub logarithmic: bool,
    /// Change for a point of dragging, in the unit that is shown; 0 for what suits the value.
    pub speed: f64,
    /// Whether it is only taken up when the mouse lets go.
    pub late: bool,
}

impl How {
    /// A slider.
    pub fn slider(range: RangeInclusive<f64>) -> Self {
        Self { range: Some(range), ..Self::default() }
    }

    /// A slider that is even in the logarithm.
    pub fn log(range: RangeInclusive<f64>) -> Self {
        Self { range: Some(range), logarithmic: true, ..Self::default() }
    }

    /// A number that is taken up when the mouse lets go.
    pub fn late() -> Self {
        Self { late: true, ..Self::default() }
    }
}

/// What was done to a number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Done {
    /// The new value, SI.
    pub value: Option<f64>,
    /// What was typed and not understood.
    pub error: Option<UnitError>,
    /// Whether its default was asked for.
    pub reset: bool,
}

/// A label that can be double-clicked.
pub fn name(ui: &mut Ui, text: &str, about: &str) -> Response {
    let label = ui.add(Label::new(text).sense(Sense::click()));
    if about.is_empty() { label } else { label.on_hover_text(about) }
}

/// A number that is `now`, SI, shown in its unit and named by `label`.
pub fn input(ui: &mut Ui, label: &Response, now: f64, shown: Shown, how: &How) -> Done {
    let draft_id = label.id.with("draft");
    let draft = if how.late { ui.data(|d| d.get_temp::<f64>(draft_id)) } else { None };
    let start = draft.unwrap_or(now);
    let mut value = start;
    let problem = RefCell::new(None);
    let text_now = shown.format(start);
    let parse = |text: &str| {
        // What was not changed is not read: the text has fewer digits.
        if text == text_now {
            return Some(start);
        }
        shown.parse(text).map_err(|e| *problem.borrow_mut() = Some(e)).ok()
    };
    let format = |v: f64, _: RangeInclusive<usize>| shown.format(v);
    let response = match &how.range {
        Some(range) => {
            let slider =
                Slider::new(&mut value, range.clone()).clamping(SliderClamping::Never).update_while_editing(false);
            ui.add(slider.logarithmic(how.logarithmic).custom_formatter(format).custom_parser(parse))
        }
        None => {
            let unit = if shown.scale > 0.0 { shown.scale } else { 1.0 };
            let speed = if how.speed > 0.0 { how.speed * unit } else { (start.abs() * 0.004).max(1e-3 * unit) };
            let number = DragValue::new(&mut value).speed(speed).update_while_editing(false);
            ui.add(number.custom_formatter(format).custom_parser(parse))
        }
    };
    let response = response.labelled_by(label.id);
    let mut done = Done { error: problem.into_inner().filter(|_| response.lost_focus()), ..Done::default() };
    let twice = ui.input(|i| i.pointer.button_double_clicked(PointerButton::Primary));
    let on_it = ui.input(|i| i.pointer.interact_pos()).is_some_and(|p| response.rect.contains(p));
    if label.double_clicked() || (twice && on_it && response.enabled() && ui.rect_contains_pointer(response.rect)) {
        // What the first click had begun to edit is not taken up.
        ui.data_mut(|d| d.remove::<String>(response.id));
        ui.memory_mut(|m| m.surrender_focus(response.id));
        ui.data_mut(|d| d.remove::<f64>(draft_id));
        return Done { reset: true, ..Done::default() };
    }
    let changed = response.changed() && value != start;
    if how.late && response.dragged() {
        ui.data_mut(|d| d.insert_temp(draft_id, value));
    } else if let Some(draft) = draft.filter(|_| !changed) {
        ui.data_mut(|d| d.remove::<f64>(draft_id));
        done.value = (draft != now).then_some(draft);
    } else if changed {
        done.value = Some(value);
    }
    done
}

/// A parameter of the world by path, in a row with its name.
pub fn dial(
    ui: &mut Ui,
    knobs: &mut dyn Knobs,
    (title, about, path): (&str, &str, &str),
    now: f64,
    shown: Shown,
    how: &How,
) {
    let label = name(ui, title, about);
    dial_of(ui, knobs, &label, path, now, shown, how);
    ui.end_row();
}

/// The same without a row and a name of its own.
pub fn dial_of(ui: &mut Ui, knobs: &mut dyn Knobs, label: &Response, path: &str, now: f64, shown: Shown, how: &How) {
    let done = input(ui, label, now, shown, how);
    if let Some(value) = done.value {
        knobs.set(path, &value.to_string());
    }
    tell(knobs, path, done.error);
    if done.reset {
        knobs.set_default(path);
    }
}

/// Tells of a text that is no value.
pub fn tell(knobs: &mut dyn Knobs, of: &str, error: Option<UnitError>) {
    if let Some(error) = error {
        knobs.fail(format!("{of}: {error}"));
    }
}

/// Three numbers of a vector that is `now`, and their unit; the new one when it has been changed. `of` names it in messages.
pub fn vector(
    ui: &mut Ui,
    knobs: &mut dyn Knobs,
    of: &str,
    now: DVec3,
    shown: Shown,
    how: &How,
) -> (Option<DVec3>, bool) {
    let (mut changed, mut reset) = (None, false);
    // The unit is written once, behind all three: a column is narrow.
    let bare = Shown { unit: "", ..shown };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.spacing_mut().interact_size.x = 52.0;
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let label = ui.add(Label::new(egui::RichText::new(letter).weak()).sense(Sense::click()));
            let done = input(ui, &label, now[axis], bare, how);
            if let Some(value) = done.value {
                let mut new = now;
                new[axis] = value;
                changed = Some(new);
            }
            tell(knobs, of, done.error);
            reset |= done.reset;
        }
        if !shown.unit.is_empty() {
            ui.weak(shown.unit);
        }
    });
    (changed, reset)
}

/// A vector of the world by path, in a row with its name.
pub fn dial_vector(
    ui: &mut Ui,
    knobs: &mut dyn Knobs,
    (title, about, path): (&str, &str, &str),
    now: DVec3,
    shown: Shown,
) {
    name(ui, title, about);
    let (changed, reset) = vector(ui, knobs, path, now, shown, &How { speed: 0.02, ..How::default() });
    if let Some(v) = changed {
        knobs.set(path, &text_of(v));
    }
    if reset {
        knobs.set_default(path);
    }
    ui.end_row();
}

/// A vector as [`Knobs::set`] takes it.
pub fn text_of(v: DVec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}
