//! Numbers with units in text form: "0.3 mm", "2.1 GPa", "140 °C".
//!
//! Values are SI, temperatures °C, angles degrees. A number without a unit has the unit of its
//! field. A decimal comma is accepted. Unit names are case-sensitive, since mPa and MPa differ;
//! spellings without superscripts ("m/s2", "kg/m3") are accepted.

pub(crate) mod parameters;
pub(crate) mod quantity;
pub(crate) mod settings;
pub mod temperature;

use std::fmt;

/// Physical quantity, which determines the admissible units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Dimensionless number; "%" is 0.01.
    Number,
    /// Length, m.
    Length,
    /// Time, s.
    Time,
    /// Pressure or stress, Pa.
    Pressure,
    /// Mass, kg.
    Mass,
    /// Density, kg/m³.
    Density,
    /// Speed, m/s.
    Speed,
    /// Acceleration, m/s².
    Acceleration,
    /// Temperature, °C.
    Temperature,
    /// Force, N.
    Force,
    /// Stiffness, N/m.
    Stiffness,
    /// Angle, degrees.
    Angle,
    /// Energy, J.
    Energy,
    /// Convection coefficient, W/(m² K).
    Convection,
}

/// Reason why a text is not a value.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnitError {
    /// The text is empty.
    Empty,
    /// The text does not begin with a number.
    NoNumber(String),
    /// The number is not finite.
    NotFinite(String),
    /// The unit is unknown.
    UnknownUnit {
        /// Unit in the text.
        unit: String,
        /// Admissible units.
        known: String,
    },
    /// The unit belongs to another quantity.
    WrongUnit {
        /// Unit in the text.
        unit: String,
        /// Quantity of that unit.
        quantity: &'static str,
        /// Admissible units.
        known: String,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "a number is missing"),
            Self::NoNumber(text) => write!(f, "\"{text}\" does not begin with a number"),
            Self::NotFinite(text) => write!(f, "{text} is not a finite number"),
            Self::UnknownUnit { unit, known } => write!(f, "\"{unit}\" is no unit; there are {known}"),
            Self::WrongUnit { unit, quantity: of, known } => write!(f, "{unit} is a unit of {of}; there are {known}"),
        }
    }
}

impl std::error::Error for UnitError {}

/// SI prefixes, largest first.
const PREFIXES: [(f64, &str); 9] =
    [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")];

/// Quantities in order, with their names and their units with the value in SI. Temperature is
/// converted separately, because its units have different zeros.
const TABLE: [(Quantity, &str, &[(&str, f64)]); 14] = [
    (Quantity::Number, "a plain number", &[("%", 0.01)]),
    (
        Quantity::Length,
        "length",
        &[
            ("m", 1.0),
            ("cm", 1e-2),
            ("mm", 1e-3),
            ("µm", 1e-6),
            ("um", 1e-6),
            ("nm", 1e-9),
            ("km", 1e3),
            ("in", 0.0254),
            ("ft", 0.3048),
            ("mil", 2.54e-5),
        ],
    ),
    (Quantity::Time, "time", &[("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)]),
    (
        Quantity::Pressure,
        "pressure",
        &[
            ("Pa", 1.0),
            ("kPa", 1e3),
            ("MPa", 1e6),
            ("GPa", 1e9),
            ("TPa", 1e12),
            ("mPa", 1e-3),
            ("bar", 1e5),
            ("N/mm²", 1e6),
            ("N/mm2", 1e6),
            ("psi", 6_894.757_293_168),
        ],
    ),
    (Quantity::Mass, "mass", &[("kg", 1.0), ("g", 1e-3), ("mg", 1e-6), ("t", 1e3)]),
    (Quantity::Density, "density", &[("kg/m³", 1.0), ("kg/m3", 1.0), ("g/cm³", 1e3), ("g/cm3", 1e3)]),
    (Quantity::Speed, "speed", &[("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3), ("km/h", 1.0 / 3.6)]),
    (Quantity::Acceleration, "acceleration", &[("m/s²", 1.0), ("m/s2", 1.0), ("g", 9.806_65)]),
    (Quantity::Temperature, "temperature", &[("°C", 1.0), ("C", 1.0), ("K", 1.0), ("°F", 1.0), ("F", 1.0)]),
    (Quantity::Force, "force", &[("N", 1.0), ("mN", 1e-3), ("µN", 1e-6), ("kN", 1e3)]),
    (Quantity::Stiffness, "stiffness", &[("N/m", 1.0), ("mN/m", 1e-3), ("kN/m", 1e3), ("N/mm", 1e3)]),
    (Quantity::Angle, "angle", &[("°", 1.0), ("degrees", 1.0), ("deg", 1.0), ("rad", 180.0 / std::f64::consts::PI)]),
    (Quantity::Energy, "energy", &[("J", 1.0), ("mJ", 1e-3), ("µJ", 1e-6), ("kJ", 1e3)]),
    (Quantity::Convection, "convection", &[("W/(m² K)", 1.0), ("W/m²K", 1.0), ("W/m2K", 1.0)]),
];

impl Quantity {
    /// Name of the quantity.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].1
    }

    fn units(self) -> &'static [(&'static str, f64)] {
        TABLE[self as usize].2
    }

    /// Unit in SI (or °C, or degrees); empty for a dimensionless number.
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::Temperature => "°C",
            _ => self.units().iter().find(|u| u.1 == 1.0).map_or("", |u| u.0),
        }
    }

    /// Comma-separated list of the units, for messages.
    fn unit_list(self) -> String {
        self.units().iter().map(|u| u.0).collect::<Vec<_>>().join(", ")
    }

    /// Quantity of an SI unit (or °C, or degrees) as named by parameters and errors; `None` for an
    /// unknown unit.
    pub fn from_unit(unit: &str) -> Option<Self> {
        if unit.is_empty() || unit == "of critical" {
            return Some(Self::Number);
        }
        TABLE.into_iter().map(|row| row.0).find(|q| q.to_si(1.0, unit) == Some(1.0))
    }

    /// SI value of `number` in `unit`; `None` for a unit of another quantity.
    fn to_si(self, number: f64, unit: &str) -> Option<f64> {
        if self == Self::Temperature {
            return match unit {
                "K" => Some(number - 273.15),
                "°F" | "F" => Some((number - 32.0) / 1.8),
                "°C" | "C" => Some(number),
                _ => None,
            };
        }
        self.units().iter().find(|u| u.0 == unit).map(|u| number * u.1)
    }
}

/// Unit in which a field is displayed, and which a number without a unit has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Quantity of the field.
    pub quantity: Quantity,
    /// Unit name after the number; may be empty.
    pub unit: &'static str,
    /// Value of the unit in SI; 0 for a unit whose prefix follows the magnitude of the number.
    pub scale: f64,
}

impl DisplayUnit {
    /// Display in this fixed unit.
    pub const fn fixed(quantity: Quantity, unit: &'static str, scale: f64) -> Self {
        Self { quantity, unit, scale }
    }

    /// Display in this SI unit with a suitable prefix: 2.10 GPa.
    pub const fn prefixed(quantity: Quantity, unit: &'static str) -> Self {
        Self { quantity, unit, scale: 0.0 }
    }

    /// Text of the SI value `value`.
    pub fn format(&self, value: f64) -> String {
        if self.scale == 0.0 {
            return format_si(value, self.unit);
        }
        let scaled = value / self.scale;
        let number = round_off(scaled);
        if self.unit.is_empty() { number } else { format!("{number} {}", self.unit) }
    }

    /// SI value of a text.
    ///
    /// # Errors
    /// If the text has no finite number, an unknown unit, or a unit of another quantity.
    pub fn parse(&self, text: &str) -> Result<f64, UnitError> {
        let (number, unit) = split(text)?;
        if unit.is_empty() {
            return Ok(number * if self.scale == 0.0 { 1.0 } else { self.scale });
        }
        if let Some(value) = self.quantity.to_si(number, unit) {
            return Ok(value);
        }
        // A prefix alone stands for the unit with that prefix: "3 k" equals "3 kPa".
        if self.scale == 0.0
            && let Some((scale, _)) = PREFIXES.iter().find(|(_, p)| !p.is_empty() && *p == unit)
        {
            return Ok(number * scale);
        }
        let (unit, known) = (unit.to_owned(), self.quantity.unit_list());
        match TABLE.iter().find(|row| row.0.to_si(number, &unit).is_some()) {
            Some((_, quantity, _)) => Err(UnitError::WrongUnit { unit, quantity, known }),
            None => Err(UnitError::UnknownUnit { unit, known }),
        }
    }
}

/// Number at the start of a text, and the rest.
fn split(text: &str) -> Result<(f64, &str), UnitError> {
    let text = text.trim();
    if text.is_empty() {
        return Err(UnitError::Empty);
    }
    // The longest prefix that is a number; "1e" and "5in" are numbers with units, "inf" and "nan"
    // are not numbers.
    let ends = text.char_indices().map(|(i, c)| i + c.len_utf8());
    let ends: Vec<usize> =
        ends.filter(|end| text[..*end].ends_with(|c: char| c.is_ascii_digit() || c == '.' || c == ',')).collect();
    let read = |end: &usize| {
        Some((text[..*end].replace(',', ".").replace('−', "-").parse::<f64>().ok()?, text[*end..].trim()))
    };
    let (number, unit) = ends.iter().rev().find_map(read).ok_or_else(|| UnitError::NoNumber(text.to_owned()))?;
    if number.is_finite() { Ok((number, unit)) } else { Err(UnitError::NotFinite(text.to_owned())) }
}

/// At most five significant digits, without trailing zeros.
fn round_off(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    let before = value.abs().log10().floor() as i32 + 1;
    if before > 9 {
        return format!("{value:.3e}");
    }
    let decimals = (5 - before).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Text with three or four digits and an SI prefix: `3.00 GPa`.
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

#[cfg(test)]
mod tests {
    use super::*;

    const MM: DisplayUnit = DisplayUnit::fixed(Quantity::Length, "mm", 1e-3);
    const PA: DisplayUnit = DisplayUnit::prefixed(Quantity::Pressure, "Pa");
    const CELSIUS: DisplayUnit = DisplayUnit::fixed(Quantity::Temperature, "°C", 1.0);

    fn near(a: Result<f64, UnitError>, b: f64) {
        let a = a.expect("understood");
        assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    }

    #[test]
    fn units_are_understood_as_people_type_them() {
        near(MM.parse("0.3 mm"), 3e-4);
        near(MM.parse("0.3"), 3e-4);
        near(MM.parse("0,3mm"), 3e-4);
        near(MM.parse("12 µm"), 1.2e-5);
        near(MM.parse("5in"), 0.127);
        near(MM.parse(" 1.5e-3 m "), 1.5e-3);
        near(PA.parse("2.1 GPa"), 2.1e9);
        near(PA.parse("3 k"), 3e3);
        near(PA.parse("3G"), 3e9);
        near(PA.parse("185"), 185.0);
        near(PA.parse("2.5e9 Pa"), 2.5e9);
        near(PA.parse("40 kPa"), 4e4);
        near(PA.parse("1 mPa"), 1e-3);
        near(PA.parse("300 N/mm²"), 3e8);
        near(CELSIUS.parse("140 °C"), 140.0);
        near(CELSIUS.parse("-40 °F"), -40.0);
        near(CELSIUS.parse("373.15 K"), 100.0);
        near(DisplayUnit::fixed(Quantity::Acceleration, "m/s²", 1.0).parse("1 g"), 9.80665);
        near(DisplayUnit::fixed(Quantity::Mass, "g", 1e-3).parse("1 g"), 1e-3);
        near(DisplayUnit::fixed(Quantity::Density, "kg/m³", 1.0).parse("1.05 g/cm3"), 1050.0);
        near(DisplayUnit::fixed(Quantity::Number, "", 1.0).parse("12 %"), 0.12);
        near(DisplayUnit::fixed(Quantity::Angle, "°", 1.0).parse("3.141592653589793 rad"), 180.0);
    }

    #[test]
    fn unit_errors_name_the_text() {
        assert_eq!(MM.parse("  "), Err(UnitError::Empty));
        assert_eq!(MM.parse("thin"), Err(UnitError::NoNumber("thin".into())));
        assert_eq!(MM.parse("inf mm"), Err(UnitError::NoNumber("inf mm".into())));
        assert!(matches!(MM.parse("1e999"), Err(UnitError::NotFinite(_))));
        let wrong = MM.parse("3 GPa").expect_err("no length");
        assert!(wrong.to_string().contains("GPa is a unit of pressure") && wrong.to_string().contains("mm"), "{wrong}");
        let unknown = PA.parse("3 furlongs").expect_err("no unit");
        assert!(matches!(unknown, UnitError::UnknownUnit { .. }) && unknown.to_string().contains("GPa"), "{unknown}");
        // A field in millimetres accepts no prefix without a unit.
        assert!(MM.parse("3 k").is_err());
    }

    #[test]
    fn displayed_values_parse_back() {
        for value in [3e-4, 0.25, 1.6e-5, 0.0, 12.345] {
            let text = MM.format(value);
            near(MM.parse(&text), value);
        }
        assert_eq!((MM.format(3e-4), MM.format(0.25)), ("0.3 mm".into(), "250 mm".into()));
        assert_eq!(CELSIUS.format(140.0), "140 °C");
        assert_eq!(PA.format(2.1e9), "2.10 GPa");
        assert_eq!(DisplayUnit::fixed(Number, "", 1.0).format(0.115), "0.115");
        let quantities = ["", "Pa", "kg/m³", "°C", "degrees", "of critical"].map(Quantity::from_unit);
        use Quantity::{Angle, Density, Number, Pressure, Temperature};
        assert_eq!(quantities, [Number, Pressure, Density, Temperature, Angle, Number].map(Some));
        assert_eq!(Quantity::from_unit("furlong"), None);
        for (i, (q, ..)) in TABLE.into_iter().enumerate() {
            assert!(q as usize == i && !q.name().is_empty() && !q.unit_list().is_empty());
        }
    }

    #[test]
    fn numbers_are_written_with_a_prefix() {
        assert_eq!(format_si(3e9, "Pa"), "3.00 GPa");
        assert_eq!(format_si(1000.0, "Pa"), "1.00 kPa");
        assert_eq!(format_si(-2.5e-6, "J"), "-2.50 µJ");
        assert_eq!(format_si(185.0, "Pa"), "185.0 Pa");
        assert_eq!(format_si(0.0, "J"), "0 J");
    }
}
