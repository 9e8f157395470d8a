//! Controls that several panels use: numbers with units that are set through the session, which checks them.

use std::ops::RangeInclusive;

use bevy_egui::egui::{self, DragValue, Slider, SliderClamping, Ui};

use crate::session::Session;

const PREFIXES: [(f64, &str); 9] =
    [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")];

/// A number with three or four digits and an SI prefix: `3.00 GPa`.
pub fn format_si(value: f64, unit: &str) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value} {unit}");
    }
    let size = value.abs() * 1.000_000_1;
    let (scale, prefix) = PREFIXES.into_iter().find(|(s, _)| size >= *s).unwrap_or((1e-12, "p"));
    let scaled = value / scale;
    let decimals = if scaled.abs() >= 99.95 { 1 } else { 2 };
    format!("{scaled:.decimals$} {prefix}{unit}")
}

/// Reads what [`format_si`] writes: `3 GPa`, `3G`, `3e9`.
pub fn parse_si(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let text = text.strip_suffix(unit).unwrap_or(text).trim();
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let last = text.chars().last()?;
    let (scale, _) = PREFIXES.into_iter().find(|(_, p)| p.chars().eq([last]))?;
    text[..text.len() - last.len_utf8()].trim().parse::<f64>().ok().map(|v| v * scale)
}

/// A slider for the parameter at `path`, in a row with its name. What is typed may leave the slider's range: the session
/// checks it and says what it refuses.
pub(super) fn slider(
    ui: &mut Ui,
    session: &mut Session,
    (name, about, path): (&str, &str, &str),
    (now, range): (f64, RangeInclusive<f64>),
    adjust: impl FnOnce(Slider<'_>) -> Slider<'_>,
) {
    let mut value = now;
    let label = ui.label(name).on_hover_text(about);
    let slider = Slider::new(&mut value, range).clamping(SliderClamping::Never).update_while_editing(false);
    let response = ui.add(adjust(slider)).labelled_by(label.id).on_hover_text(about);
    if response.changed() && value != now {
        session.set(path, &value.to_string());
    }
    ui.end_row();
}

/// A number that is dragged or typed, `scale` times the parameter. Returns the new value in the parameter's own unit, once
/// it has been changed.
pub(super) fn number(
    ui: &mut Ui,
    label: &egui::Response,
    now: f64,
    scale: f64,
    speed: f64,
    suffix: &str,
) -> Option<f64> {
    let mut value = now * scale;
    let drag = DragValue::new(&mut value).speed(speed).max_decimals(6).suffix(suffix).update_while_editing(false);
    let response = ui.add(drag).labelled_by(label.id);
    // Dividing back would leave rounding noise in a value that was not touched.
    (response.changed() && value != now * scale).then_some(value / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_with_a_prefix_and_read_back() {
        assert_eq!(format_si(3e9, "Pa"), "3.00 GPa");
        assert_eq!(format_si(1000.0, "Pa"), "1.00 kPa");
        assert_eq!(format_si(-2.5e-6, "J"), "-2.50 µJ");
        assert_eq!(format_si(185.0, "Pa"), "185.0 Pa");
        assert_eq!(format_si(0.0, "J"), "0 J");
        for (text, value) in [("3 GPa", 3e9), ("3G", 3e9), ("185", 185.0), ("2.5e9 Pa", 2.5e9), ("40 kPa", 4e4)] {
            assert_eq!(parse_si(text, "Pa"), Some(value), "{text}");
        }
        assert_eq!(parse_si("stiff", "Pa"), None);
        assert_eq!(parse_si("", "Pa"), None);
    }
}
