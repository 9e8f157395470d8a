//! Controls for numbers with units: drag, type, double-click to reset.
//!
//! A typed value may exceed the range of its slider; the setter validates it. Text that is not a
//! value is reported as a message. A value that costs a new world is applied when the mouse button
//! is released.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use bevy::math::DVec3;
use bevy_egui::egui::{self, ComboBox, DragValue, Label, PointerButton, Response, Sense, Slider, SliderClamping, Ui};

use sheetwork::ParameterId;

use super::ParameterAccess;
use super::units::{DisplayUnit, Quantity, UnitError};

/// Number without unit.
pub const PLAIN: DisplayUnit = DisplayUnit::fixed(Quantity::Number, "", 1.0);
/// Lengths in millimetres.
pub const MM: DisplayUnit = DisplayUnit::fixed(Quantity::Length, "mm", 1e-3);
/// Angles in degrees.
pub const DEGREES: DisplayUnit = DisplayUnit::fixed(Quantity::Angle, "°", 1.0);
/// Temperatures in °C.
pub const CELSIUS: DisplayUnit = DisplayUnit::fixed(Quantity::Temperature, "°C", 1.0);
/// Moduli and stresses.
pub const PASCAL: DisplayUnit = DisplayUnit::prefixed(Quantity::Pressure, "Pa");
/// Times in milliseconds.
pub const MS: DisplayUnit = DisplayUnit::fixed(Quantity::Time, "ms", 1e-3);

/// Options of a number control.
#[derive(Clone, Debug, Default)]
pub struct ControlOptions {
    /// Range of a slider; `None` for a number alone.
    pub range: Option<RangeInclusive<f64>>,
    /// Whether the slider is logarithmic.
    pub logarithmic: bool,
    /// Change per point of dragging, in the displayed unit; 0 for a step that suits the value.
    pub speed: f64,
    /// Whether the value is applied only on release.
    pub late: bool,
}

impl ControlOptions {
    /// Slider over the usual values of a parameter.
    pub fn usual(id: ParameterId) -> Self {
        let usual = id.row().usual;
        Self {
            range: usual.map(|usual| usual.min..=usual.max),
            logarithmic: usual.is_some_and(|usual| usual.logarithmic),
            ..Self::default()
        }
    }

    /// Number that changes by `speed` per point of dragging, in the displayed unit.
    pub fn speed(speed: f64) -> Self {
        Self { speed, ..Self::default() }
    }

    /// The control, applied on release.
    pub fn on_release(self) -> Self {
        Self { late: true, ..self }
    }
}

/// Result of a number control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlResult {
    /// New value, SI.
    pub value: Option<f64>,
    /// Error of typed text.
    pub error: Option<UnitError>,
    /// Whether the user asked for the default.
    pub reset: bool,
}

/// Label that accepts a double click.
pub fn name(ui: &mut Ui, text: &str, about: &str) -> Response {
    let label = ui.add(Label::new(text).sense(Sense::click()));
    if about.is_empty() { label } else { label.on_hover_text(about) }
}

/// Number control of the value `now`, SI, displayed in its unit and named by `label`.
pub fn input(ui: &mut Ui, label: &Response, now: f64, shown: DisplayUnit, how: &ControlOptions) -> ControlResult {
    let draft_id = label.id.with("draft");
    let draft = if how.late { ui.data(|d| d.get_temp::<f64>(draft_id)) } else { None };
    let start = draft.unwrap_or(now);
    let mut value = start;
    let problem = RefCell::new(None);
    let text_now = shown.format(start);
    let parse = |text: &str| {
        // Unchanged text is not parsed: it has fewer digits than the value.
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
    let mut done =
        ControlResult { error: problem.into_inner().filter(|_| response.lost_focus()), ..ControlResult::default() };
    let twice = ui.input(|i| i.pointer.button_double_clicked(PointerButton::Primary));
    let on_it = ui.input(|i| i.pointer.interact_pos()).is_some_and(|p| response.rect.contains(p));
    if label.double_clicked() || (twice && on_it && response.enabled() && ui.rect_contains_pointer(response.rect)) {
        // The text edited by the first click of a double click is discarded.
        ui.data_mut(|d| d.remove::<String>(response.id));
        ui.memory_mut(|m| m.surrender_focus(response.id));
        ui.data_mut(|d| d.remove::<f64>(draft_id));
        return ControlResult { reset: true, ..ControlResult::default() };
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

/// Parameter of the world, by path, as a row with its name.
pub fn parameter_row(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    (title, about, path): (&str, &str, &str),
    now: f64,
    shown: DisplayUnit,
    how: &ControlOptions,
) {
    let label = name(ui, title, about);
    parameter_control(ui, access, &label, path, now, shown, how);
    ui.end_row();
}

/// Parameter of the world, by path, as a row with its name and a slider over its usual values.
pub fn usual_row(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    row: (&str, &str, &str),
    now: f64,
    shown: DisplayUnit,
    id: ParameterId,
) {
    parameter_row(ui, access, row, now, shown, &ControlOptions::usual(id));
}

/// Parameter of the world, by path, without row and name.
pub fn parameter_control(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    label: &Response,
    path: &str,
    now: f64,
    shown: DisplayUnit,
    how: &ControlOptions,
) {
    let done = input(ui, label, now, shown, how);
    if let Some(value) = done.value {
        access.set(path, &value.to_string());
    }
    tell(access, path, done.error);
    if done.reset {
        access.set_default(path);
    }
}

/// Number with its name; `of` names it in messages, and text that is not a value is reported.
pub fn number(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    (title, about, of): (&str, &str, &str),
    now: f64,
    shown: DisplayUnit,
    how: &ControlOptions,
) -> ControlResult {
    let label = name(ui, title, about);
    let mut done = input(ui, &label, now, shown, how);
    tell(access, of, done.error.take());
    done
}

/// Choice among `options`, each a value with its title and its description, `width` points wide.
pub fn choice<'a, T: PartialEq>(
    ui: &mut Ui,
    label: &Response,
    (id, selected, width): (&str, &str, f32),
    chosen: &mut T,
    options: impl IntoIterator<Item = (T, &'a str, &'a str)>,
) -> Response {
    let shown = ComboBox::from_id_salt(id).selected_text(selected).width(width).show_ui(ui, |ui| {
        for (value, title, about) in options {
            ui.selectable_value(chosen, value, title).on_hover_text(about);
        }
    });
    shown.response.labelled_by(label.id)
}

/// Report text that is not a value.
pub fn tell(access: &mut dyn ParameterAccess, of: &str, error: Option<UnitError>) {
    if let Some(error) = error {
        access.fail(format!("{of}: {error}"));
    }
}

/// Control of the vector `now`, three numbers with one unit. Returns the new vector after a change.
/// `of` names it in messages.
pub fn vector(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    of: &str,
    now: DVec3,
    shown: DisplayUnit,
    how: &ControlOptions,
) -> (Option<DVec3>, bool) {
    let (mut changed, mut reset) = (None, false);
    // One unit after all three numbers: the column is narrow.
    let bare = DisplayUnit { unit: "", ..shown };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.spacing_mut().interact_size.x = 44.0;
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let label = ui.add(Label::new(egui::RichText::new(letter).weak()).sense(Sense::click()));
            let done = input(ui, &label, now[axis], bare, how);
            if let Some(value) = done.value {
                let mut new = now;
                new[axis] = value;
                changed = Some(new);
            }
            tell(access, of, done.error);
            reset |= done.reset;
        }
        if !shown.unit.is_empty() {
            ui.weak(shown.unit);
        }
    });
    (changed, reset)
}

/// Vector of the world, by path, as a row with its name.
pub fn vector_row(
    ui: &mut Ui,
    access: &mut dyn ParameterAccess,
    (title, about, path): (&str, &str, &str),
    now: DVec3,
    shown: DisplayUnit,
) {
    name(ui, title, about);
    let (changed, reset) = vector(ui, access, path, now, shown, &ControlOptions::speed(0.02));
    if let Some(v) = changed {
        access.set(path, &text_of(v));
    }
    if reset {
        access.set_default(path);
    }
    ui.end_row();
}

/// Text of a vector for [`ParameterAccess::set`].
pub fn text_of(v: DVec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}
