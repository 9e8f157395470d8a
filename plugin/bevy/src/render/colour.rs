//! Vertex colours that display a field of a sheet: temperature, remaining stiffness, strain,
//! curvature, speed or contact force.
//!
//! The colour map runs from indigo through magenta and orange to pale yellow with uniformly
//! increasing lightness, so that the order is preserved in greyscale and for colour-blind readers.
//! Lightness, chroma and hue are those of Oklab (Ottosson, *A perceptual color space for image
//! processing*, 2020).

use std::sync::LazyLock;

use bevy::prelude::*;
use sheetwork::World;
use sheetwork::scene::HeatMode;
use sheetwork::sheet::Sheet as SheetInWorld;
use sheetwork::sheet::surface::DrawingSurface;
use sheetwork::units::temperature::ZERO_CELSIUS;

use super::measure;

/// Field displayed by the colours of a sheet.
///
/// The vertex colours multiply the colour of the material; a sheet with the plugin's own material
/// gets a white one. A sheet without heat sources has no temperature colours and keeps its
/// material.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum SheetColour {
    /// No field: the colour of the material.
    #[default]
    Plain,
    /// Temperature of the displayed side, on one scale for all sheets, from the room's temperature
    /// to the highest, rounded.
    Temperature,
    /// Temperature of the displayed side, on a given scale.
    TemperatureBetween {
        /// Temperature of the darkest colour, °C; -273.15 to 5000.
        low: f32,
        /// Temperature of the brightest colour, °C; -273.15 to 5000.
        high: f32,
    },
    /// Remaining stiffness, %: darkest for all of it, brightest for none.
    Stiffness,
    /// Largest strain of the edges at each node, in tension or compression, %.
    Stretch,
    /// Largest curvature along the edges at each node, 1/m.
    Bending,
    /// Speed, m/s.
    Speed,
    /// Contact force at each node, mN; exact at rest, with the error of the inertial force in
    /// motion.
    Contact,
}

/// Values of the darkest and the brightest colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    /// Value of the darkest colour.
    pub low: f32,
    /// Value of the brightest colour.
    pub high: f32,
    /// Title of the legend.
    pub title: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    field: SheetColour,
    /// Gravity (m/s²) of contact forces.
    gravity: bevy::math::DVec3,
}

/// Spans of a temperature scale, K: fixed steps, so that the scale does not change in every frame.
const SPANS: [f32; 15] =
    [25.0, 50.0, 75.0, 100.0, 125.0, 150.0, 200.0, 250.0, 300.0, 400.0, 500.0, 750.0, 1000.0, 2000.0, 6000.0];

impl SheetColour {
    /// Field that displays the heat of `world`: the remaining stiffness with the thesis's formulas,
    /// which have no temperature of a sheet; the temperature otherwise.
    pub fn of_heat(world: &World) -> Self {
        if matches!(world.scene().heat_mode, HeatMode::Thesis { .. }) { Self::Stiffness } else { Self::Temperature }
    }

    /// Scale of the field in `world`; `None` where no sheet has it.
    pub fn scale(self, world: &World) -> Option<ColourScale> {
        let (title, unit, least) = self.legend()?;
        let blank = ColourScale { low: 0.0, high: 0.0, title, unit, field: self, gravity: world.gravity() };
        let (low, high) = match self {
            Self::Stiffness => world.sheets().iter().any(|s| s.heat().is_some()).then_some((100.0, 0.0))?,
            Self::Temperature => temperatures_of(world)?,
            Self::TemperatureBetween { low, high } => temperatures_of(world).map(|_| (low, high))?,
            _ => (0.0, round_up(blank.largest(world)?).max(least)),
        };
        Some(ColourScale { low, high, ..blank })
    }

    /// Title, unit, and the least value of the brightest colour, above the noise.
    fn legend(self) -> Option<(&'static str, &'static str, f32)> {
        Some(match self {
            Self::Plain => return None,
            Self::Temperature | Self::TemperatureBetween { .. } => ("Temperature", "°C", 25.0),
            Self::Stiffness => ("Remaining stiffness", "%", 100.0),
            Self::Stretch => ("Strain", "%", 1e-3),
            Self::Bending => ("Curvature", "1/m", 0.1),
            Self::Speed => ("Speed", "m/s", 1e-3),
            Self::Contact => ("Contact force", "mN", 1e-3),
        })
    }
}

/// Range from the room's or the lowest temperature to the highest, °C, rounded outwards.
fn temperatures_of(world: &World) -> Option<(f32, f32)> {
    let ranges = world.sheets().iter().filter_map(|s| s.heat()).map(|h| h.range());
    let (coldest, hottest) = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    // A difference of 0.1 °C counts as the room's temperature.
    let room = world.scene().ambient_temperature;
    let low = if coldest > room - 0.1 { room } else { (coldest / 10.0).floor() * 10.0 } as f32;
    let low = low.max(-ZERO_CELSIUS as f32);
    let needed = hottest as f32 - low - 0.1;
    let span = SPANS.iter().copied().find(|s| *s >= needed).unwrap_or(SPANS[SPANS.len() - 1]);
    Some((low, low + span))
}

/// Smallest 1, 2 or 5 times a power of ten that is at least `value`.
fn round_up(value: f32) -> f32 {
    let power = 10.0_f32.powf(value.max(1e-20).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|n| *n >= 0.999 * value).unwrap_or(value)
}

impl ColourScale {
    /// Compute the field at each node; returns false for heat, which has its own values.
    fn measure(&self, sheet: &SheetInWorld, out: &mut Vec<f64>) -> bool {
        match self.field {
            SheetColour::Stretch => measure::stretch(sheet, out),
            SheetColour::Bending => measure::bending(sheet, out),
            SheetColour::Speed => measure::speed(sheet, out),
            SheetColour::Contact => measure::contact(sheet, self.gravity, out),
            _ => return false,
        }
        true
    }

    /// Largest value of the field; `None` without sheets.
    fn largest(&self, world: &World) -> Option<f32> {
        let mut values = Vec::new();
        let mut most = 0.0_f64;
        world.sheets().first()?;
        for sheet in world.sheets() {
            self.measure(sheet, &mut values);
            most = values.iter().copied().filter(|v| v.is_finite()).fold(most, f64::max);
        }
        Some(most as f32)
    }

    /// Whether `sheet` has the field.
    pub fn applies_to(&self, sheet: &SheetInWorld) -> bool {
        use SheetColour::{Bending, Contact, Speed, Stretch};
        matches!(self.field, Stretch | Bending | Speed | Contact) || sheet.heat().is_some()
    }

    /// Colour of a value.
    pub fn colour(&self, value: f32) -> LinearRgba {
        heat_colour((value - self.low) / (self.high - self.low))
    }

    /// Write the vertex colours of `surface`, a surface of `sheet`'s upper or lower side; `values`
    /// is a buffer. A sheet without temperatures is white.
    pub fn paint(
        &self,
        (sheet, upper): (&SheetInWorld, bool),
        surface: &DrawingSurface,
        values: &mut Vec<f32>,
        out: &mut Vec<[f32; 4]>,
    ) {
        values.resize(surface.len(), 0.0);
        out.resize(surface.len(), [1.0; 4]);
        let mut measured = Vec::new();
        if self.measure(sheet, &mut measured) {
            surface.interpolate(&measured, values);
            self.write(values, out);
            return;
        }
        let Some(celsius) = sheet.side_temperatures(upper) else {
            out.fill([1.0; 4]);
            return;
        };
        match (self.field, sheet.heat()) {
            (SheetColour::Stiffness, Some(heat)) => {
                let left: Vec<f64> = (0..sheet.node_count()).map(|i| 100.0 / heat.compliance(i)).collect();
                surface.interpolate(&left, values);
            }
            _ => surface.interpolate(celsius, values),
        }
        self.write(values, out);
    }

    fn write(&self, values: &[f32], out: &mut [[f32; 4]]) {
        for (out, value) in out.iter_mut().zip(values) {
            *out = self.colour(*value).to_f32_array();
        }
    }
}

/// Colour at `s`, from 0 (cold) to 1 (hot).
pub fn heat_colour(s: f32) -> LinearRgba {
    let steps = (COLOURS.len() - 1) as f32;
    // NaN is cold.
    let at = if s.is_finite() { s.clamp(0.0, 1.0) * steps } else { 0.0 };
    let (i, rest) = (at as usize, at.fract());
    let (a, b) = (COLOURS[i], COLOURS[(i + 1).min(COLOURS.len() - 1)]);
    let [r, g, b] = std::array::from_fn(|c| a[c] + (b[c] - a[c]) * rest);
    LinearRgba::rgb(r, g, b)
}

/// Linear red, green and blue, from cold to hot.
static COLOURS: LazyLock<[[f32; 3]; 129]> = LazyLock::new(|| std::array::from_fn(|i| colour_at(i as f32 / 128.0)));

/// Position, chroma and hue, degrees; lightness is linear in position.
const STOPS: [(f32, f32, f32); 7] = [
    (0.0, 0.115, 282.0),
    (0.20, 0.185, 306.0),
    (0.40, 0.205, 350.0),
    (0.55, 0.200, 387.0),
    (0.75, 0.165, 420.0),
    (0.90, 0.145, 456.0),
    (1.0, 0.060, 466.0),
];

fn colour_at(s: f32) -> [f32; 3] {
    let after = STOPS.iter().position(|p| p.0 >= s).unwrap_or(STOPS.len() - 1).max(1);
    let ((s0, c0, h0), (s1, c1, h1)) = (STOPS[after - 1], STOPS[after]);
    let part = (s - s0) / (s1 - s0);
    let (chroma, hue) = (c0 + (c1 - c0) * part, (h0 + (h1 - h0) * part).to_radians());
    let lightness = 0.31 + 0.66 * s;
    let colour = LinearRgba::from(Oklaba::lab(lightness, chroma * hue.cos(), chroma * hue.sin()));
    [colour.red, colour.green, colour.blue].map(|c| c.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{OvenSpec, Scene, SheetSpec};

    #[test]
    fn lightness_rises_evenly_from_cold_to_hot() {
        let lightness = |s: f32| Oklaba::from(heat_colour(s)).lightness;
        for i in 0..64 {
            let (a, b) = (lightness(i as f32 / 64.0), lightness((i + 1) as f32 / 64.0));
            // Clipping to the sRGB gamut makes it slightly non-uniform.
            assert!((0.4..2.0).contains(&((b - a) * 64.0 / 0.66)), "{a} {b} at {i}");
        }
        assert_eq!(heat_colour(f32::NAN), heat_colour(-3.0));
        assert_eq!(heat_colour(1.0), heat_colour(7.0));
    }

    fn heated(celsius: f64) -> World {
        let oven = Some(OvenSpec::default());
        let mut world =
            World::new(&Scene { sheets: vec![SheetSpec::thesis()], oven, ..Scene::thesis() }).expect("valid");
        world.sheets_mut()[0].set_temperatures(|i| if i == 0 { celsius } else { 20.0 }).expect("in range");
        world
    }

    #[test]
    fn the_scale_contains_all_values_in_whole_steps() {
        let scale = |celsius| SheetColour::Temperature.scale(&heated(celsius)).expect("heated");
        assert_eq!((scale(20.0).low, scale(20.0).high), (20.0, 45.0));
        assert_eq!(scale(100.0).high, 120.0);
        assert_eq!(scale(120.0).high, 120.0);
        assert_eq!((scale(-17.0).low, scale(-17.0).high), (-20.0, 30.0));
        let own = SheetColour::TemperatureBetween { low: 0.0, high: 200.0 }.scale(&heated(90.0)).expect("heated");
        assert_eq!((own.low, own.high), (0.0, 200.0));
        let cold = World::new(&Scene { sheets: vec![SheetSpec::thesis()], ..Scene::thesis() }).expect("valid");
        for colour in [SheetColour::Plain, SheetColour::Temperature, SheetColour::Stiffness] {
            assert_eq!(colour.scale(&cold), None, "{colour:?}");
        }
    }

    #[test]
    fn measured_fields_are_coloured_on_a_round_scale_without_heat() {
        let mut world = World::new(&Scene { sheets: vec![SheetSpec::thesis()], ..Scene::thesis() }).expect("valid");
        let still = SheetColour::Speed.scale(&world).expect("a sheet");
        assert_eq!((still.low, still.high, still.unit), (0.0, 1e-3, "m/s"));
        world.sheets_mut()[0].state.v.set(0, bevy::math::DVec3::new(0.0, 0.3, 0.0));
        let scale = SheetColour::Speed.scale(&world).expect("a sheet");
        assert_eq!(scale.high, 0.5);
        let sheet = &world.sheets()[0];
        let surface = sheet.surface(0, 1).expect("drawn");
        let (mut values, mut colours) = (Vec::new(), Vec::new());
        scale.paint((sheet, false), &surface, &mut values, &mut colours);
        assert!((values[0] - 0.3).abs() < 1e-6 && values[1] == 0.0 && scale.applies_to(sheet));
        assert_eq!((colours[0], colours[1]), (scale.colour(0.3).to_f32_array(), heat_colour(0.0).to_f32_array()));
        for colour in [SheetColour::Stretch, SheetColour::Bending, SheetColour::Contact] {
            assert!(colour.scale(&world).is_some_and(|s| s.high > 0.0), "{colour:?}");
        }
        assert_eq!([0.3, 1.0, 0.011, 7.0].map(round_up), [0.5, 1.0, 0.02, 10.0]);
    }

    #[test]
    fn a_hot_node_is_bright_at_its_position() {
        let world = heated(120.0);
        let sheet = &world.sheets()[0];
        let surface = sheet.surface(0, 1).expect("drawn");
        let (mut values, mut colours) = (Vec::new(), Vec::new());
        let scale = SheetColour::Temperature.scale(&world).expect("heated");
        scale.paint((sheet, true), &surface, &mut values, &mut colours);
        assert_eq!(colours[0], heat_colour(1.0).to_f32_array());
        assert_eq!(colours[5], heat_colour(0.0).to_f32_array());
        let stiff = SheetColour::Stiffness.scale(&world).expect("heated");
        stiff.paint((sheet, true), &surface, &mut values, &mut colours);
        assert_eq!(colours[5], heat_colour(0.0).to_f32_array(), "all of its stiffness");
    }
}
