//! Numbers on the command line: plain in SI units (temperatures in °C, angles in degrees), or with
//! a unit, as in `0.3mm`, `"2.1 GPa"`, `1ms`.

use sheetwork::units::{DisplayUnit, Quantity};

/// Parses a number or a fraction such as `1/60`.
pub fn parse_number(text: &str) -> Result<f64, String> {
    let parse = |t: &str| t.trim().parse::<f64>().map_err(|_| format!("\"{text}\" is not a number"));
    let value = match text.split_once('/') {
        Some((above, below)) => parse(above)? / parse(below)?,
        None => parse(text)?,
    };
    if value.is_finite() { Ok(value) } else { Err(format!("\"{text}\" is not a finite number")) }
}

/// Parses a plain number, a fraction, or a number with a unit of `quantity`.
fn parse_quantity(quantity: Quantity, text: &str) -> Result<f64, String> {
    match parse_number(text) {
        Ok(value) => Ok(value),
        Err(plain) if !text.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => Err(plain),
        Err(plain) if !text.contains(|c: char| c.is_alphabetic() || "%°".contains(c)) => Err(plain),
        Err(_) => DisplayUnit::fixed(quantity, quantity.si_unit(), 1.0).parse(text).map_err(|e| e.to_string()),
    }
}

/// Parses three plain numbers, `x,y,z`.
pub fn parse_vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<f64> = text.split(',').map(parse_number).collect::<Result<_, _>>()?;
    parts.try_into().map_err(|_| format!("\"{text}\" is not x,y,z"))
}

macro_rules! parsers {
    ($($name:ident $quantity:ident,)*) => {
        $(
            #[doc = concat!("See [`Quantity::", stringify!($quantity), "`].")]
            pub fn $name(text: &str) -> Result<f64, String> {
                parse_quantity(Quantity::$quantity, text)
            }
        )*
    };
}

parsers! {
    acceleration Acceleration,
    angle Angle,
    convection Convection,
    density Density,
    length Length,
    mass Mass,
    pressure Pressure,
    speed Speed,
    stiffness Stiffness,
    temperature Temperature,
    time Time,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_parse_plain_as_fractions_and_with_units() {
        assert_eq!((length("0.3"), length("0.5 mm"), time("1/60")), (Ok(0.3), Ok(5e-4), Ok(1.0 / 60.0)));
        assert_eq!((time("1ms"), pressure("2 GPa"), temperature("373.15 K")), (Ok(1e-3), Ok(2e9), Ok(100.0)));
        assert!(length("3 GPa").is_err_and(|e| e.contains("pressure") && e.contains("mm")));
        assert!(length("inf").is_err() && parse_number("nan").is_err() && time("1/0").is_err() && length("").is_err());
    }
}
