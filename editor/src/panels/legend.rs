//! Legend of the colours of the sheets: a bar with numbers and a unit.

use bevy_egui::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};
use bevy_sheetwork::render::ColourScale;

/// Size of the bar, points.
const BAR: (f32, f32) = (230.0, 12.0);

/// Ticks of a scale: positions, 0 to 1, and numbers; five, or four where those are rounder.
pub fn ticks(scale: &ColourScale) -> Vec<(f32, String)> {
    let span = scale.high - scale.low;
    let whole = |parts: usize| (span / parts as f32).fract().abs() < 1e-3;
    let parts = [4, 5, 3].into_iter().find(|p| whole(*p)).unwrap_or(4);
    let at = |i: usize| i as f32 / parts as f32;
    // Enough decimals to distinguish the numbers.
    let decimals = if span.abs() < 0.4 { (2.0 - span.abs().max(1e-9).log10().floor()) as usize } else { 1 };
    let number = |value: f32| {
        let text = format!("{value:.decimals$}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    (0..=parts).map(|i| (at(i), number(scale.low + span * at(i)))).collect()
}

/// Paint the legend of `scale` into the lower left corner of `rect`, the view of the scene.
pub fn legend(painter: &Painter, rect: Rect, scale: &ColourScale) {
    let box_size = vec2(BAR.0 + 44.0, 62.0);
    if rect.width() < box_size.x + 20.0 || rect.height() < box_size.y + 20.0 {
        return;
    }
    let place = Rect::from_min_size(rect.left_bottom() + vec2(14.0, -14.0 - box_size.y), box_size);
    painter.rect_filled(place, 6.0, Color32::from_rgba_unmultiplied(24, 26, 30, 205));
    let bar = Rect::from_min_size(place.min + vec2(22.0, 26.0), vec2(BAR.0, BAR.1));
    let ink = Color32::from_rgb(232, 232, 236);
    let title = format!("{}, {}", scale.title, scale.unit);
    painter.text(pos2(bar.left(), place.top() + 6.0), Align2::LEFT_TOP, title, FontId::proportional(12.5), ink);
    let steps = 116;
    for i in 0..steps {
        let s = (i as f32 + 0.5) / steps as f32;
        let colour = bevy::color::Srgba::from(scale.colour(scale.low + (scale.high - scale.low) * s));
        let [r, g, b] = [colour.red, colour.green, colour.blue].map(|c| (255.0 * c + 0.5) as u8);
        let x = |i: i32| bar.left() + bar.width() * i as f32 / steps as f32;
        let piece = Rect::from_min_max(pos2(x(i), bar.top()), pos2(x(i + 1) + 0.5, bar.bottom()));
        painter.rect_filled(piece, 0.0, Color32::from_rgb(r, g, b));
    }
    for (s, text) in ticks(scale) {
        let foot = Pos2::new(bar.left() + bar.width() * s, bar.bottom());
        painter.line_segment([foot, foot + vec2(0.0, 3.0)], Stroke::new(1.0, ink));
        painter.text(foot + vec2(0.0, 4.0), Align2::CENTER_TOP, text, FontId::proportional(11.0), ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_sheetwork::SheetColour;
    use sheetwork::World;
    use sheetwork::scene::{OvenSpec, Scene, SheetSpec};

    #[test]
    fn numbers_along_a_scale_are_round() {
        let scene = Scene { sheets: vec![SheetSpec::thesis()], oven: Some(OvenSpec::default()), ..Scene::thesis() };
        let world = World::new(&scene).expect("valid");
        let read = |low, high| {
            let scale = SheetColour::TemperatureBetween { low, high }.scale(&world).expect("heated");
            ticks(&scale).into_iter().map(|t| t.1).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(read(20.0, 120.0), "20 45 70 95 120");
        assert_eq!(read(20.0, 45.0), "20 25 30 35 40 45");
        assert_eq!(read(20.0, 20.5), "20 20.1 20.2 20.4 20.5");
        let mut fine = SheetColour::Speed.scale(&world).expect("a sheet");
        (fine.low, fine.high) = (0.0, 0.1);
        let fine = ticks(&fine).into_iter().map(|t| t.1).collect::<Vec<_>>().join(" ");
        assert_eq!(fine, "0 0.025 0.05 0.075 0.1");
        let left = SheetColour::Stiffness.scale(&world).expect("heated");
        assert_eq!(ticks(&left)[1], (0.25, "75".into()));
    }
}
