//! Legend of an image: a colour bar with numbers, in a bitmap font of 5 x 7 dots.

use bevy_sheetwork::render::ColourScale;

use super::image::{Picture, encode};
use crate::panels::ticks;

/// Dots of a letter, rows from the top, five bits per row; other characters are blank.
const LETTERS: [(char, [u8; 7]); 15] = [
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111]),
    ('3', [0b11110, 0b00001, 0b00001, 0b01110, 0b00001, 0b00001, 0b11110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000]),
    ('8', [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100]),
    ('-', [0, 0, 0, 0b11111, 0, 0, 0]),
    ('.', [0, 0, 0, 0, 0, 0b01100, 0b01100]),
    ('°', [0b01100, 0b10010, 0b10010, 0b01100, 0, 0, 0]),
    ('C', [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110]),
    ('%', [0b11001, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b10011]),
];

/// Width of a letter with the gap to the next, dots.
const ADVANCE: u32 = 6;

/// Draw the legend of `scale` into the lower left corner, if the picture is large enough.
pub(super) fn draw(picture: &mut Picture, scale: &ColourScale) {
    let dot = (picture.height / 400).max(1);
    let (width, height, margin) = (160 * dot, 8 * dot, 12 * dot);
    if picture.width < width + 4 * margin || picture.height < 8 * margin {
        return;
    }
    let (left, top) = (2 * margin, picture.height - 3 * margin);
    for x in 0..width {
        let value = scale.low + (scale.high - scale.low) * x as f32 / (width - 1) as f32;
        let colour = scale.colour(value);
        let pixel = [colour.red, colour.green, colour.blue].map(encode);
        (0..height).for_each(|y| set(picture, (left + x, top + y), pixel));
    }
    for (s, text) in ticks(scale) {
        let at = left + (s * (width - 1) as f32) as u32;
        (0..2 * dot).for_each(|y| set(picture, (at, top + height + y), [40; 3]));
        let half = ADVANCE * dot * text.chars().count() as u32 / 2;
        write(picture, (at.saturating_sub(half), top + height + 3 * dot), dot, &text);
    }
    write(picture, (left + width + margin, top + dot / 2), dot, scale.unit);
}

fn write(picture: &mut Picture, (left, top): (u32, u32), dot: u32, text: &str) {
    for (i, letter) in text.chars().enumerate() {
        let Some((_, rows)) = LETTERS.iter().find(|l| l.0 == letter) else { continue };
        for y in 0..7 * dot {
            for x in 0..5 * dot {
                if rows[(y / dot) as usize] >> (4 - x / dot) & 1 == 1 {
                    set(picture, (left + ADVANCE * dot * i as u32 + x, top + y), [40; 3]);
                }
            }
        }
    }
}

fn set(picture: &mut Picture, (x, y): (u32, u32), pixel: [u8; 3]) {
    let at = 3 * (y as usize * picture.width as usize + x as usize);
    if let Some(there) = picture.pixels.get_mut(at..at + 3).filter(|_| x < picture.width) {
        there.copy_from_slice(&pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_sheetwork::SheetColour;
    use sheetwork::World;
    use sheetwork::scene::{OvenSpec, Scene, SheetSpec};

    #[test]
    fn the_bar_spans_the_colours_of_the_lowest_and_the_highest_value() {
        let scene = Scene { sheets: vec![SheetSpec::thesis()], oven: Some(OvenSpec::default()), ..Scene::thesis() };
        let scale = SheetColour::Temperature.scale(&World::new(&scene).expect("valid")).expect("heated");
        let mut picture = Picture { width: 400, height: 300, pixels: vec![255; 3 * 400 * 300] };
        draw(&mut picture, &scale);
        let shown = |c: bevy::color::LinearRgba| [c.red, c.green, c.blue].map(encode);
        assert_eq!(picture.at(24, 266), shown(scale.colour(scale.low)));
        assert_eq!(picture.at(24 + 159, 266), shown(scale.colour(scale.high)));
        assert!(picture.pixels.contains(&40), "numbers");
        let mut small = Picture { width: 40, height: 30, pixels: vec![9; 3 * 40 * 30] };
        draw(&mut small, &scale);
        assert!(small.pixels.iter().all(|p| *p == 9));
    }
}
