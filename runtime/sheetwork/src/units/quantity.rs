//! Values with units of scene fields: `young=2.1 GPa`, `size=(30 cm, 0.2)`.

use crate::error::InputError;
use crate::units::parameters::ParameterId;
use crate::units::{DisplayUnit, Quantity};

/// SI text of `value` if it is a number with a unit, or a tuple of numbers at least one of which
/// has a unit; `None` for any other text.
///
/// # Errors
/// If the unit does not belong to the quantity of the field.
pub(crate) fn in_si(path: &str, value: &str) -> Result<Option<String>, InputError> {
    // An unknown field is a dimensionless number.
    let quantity = ParameterId::from_path(path).and_then(|id| id.row().quantity()).unwrap_or(Quantity::Number);
    let tuple = value.strip_prefix('(').and_then(|v| v.strip_suffix(')'));
    let parts: Vec<&str> = tuple.unwrap_or(value).split(',').map(str::trim).collect();
    let has_unit = |part: &&str| part.parse::<f64>().is_err();
    let begins = |part: &&str| part.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    // A unit consists of letters, digits and a few symbols; ranges, maps and calls contain others.
    let is_unit = |c: char| c.is_alphanumeric() || " .+-/%°²³µ*".contains(c);
    let all_numbers = parts.iter().all(|part| begins(part) && part.chars().all(is_unit));
    if !all_numbers || !parts.iter().any(has_unit) {
        return Ok(None);
    }
    let shown = DisplayUnit::fixed(quantity, quantity.si_unit(), 1.0);
    let place = |i: usize| if tuple.is_some() { format!("{path}.{i}") } else { path.to_owned() };
    let read = |(i, part): (usize, &&str)| match part.parse::<f64>() {
        Ok(number) => Ok(number.to_string()),
        Err(_) => shown.parse(part).map(|v| v.to_string()).map_err(|e| InputError::new(place(i), e.to_string())),
    };
    let numbers = parts.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?.join(", ");
    Ok(Some(if tuple.is_some() { format!("({numbers})") } else { numbers }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_units_become_si_and_others_are_left_alone() {
        let si = |path: &str, value: &str| in_si(path, value).expect("understood");
        assert_eq!(si("sheets.0.material.young", "2.1 GPa"), Some("2100000000".into()));
        assert_eq!(si("gravity.1", "-1 g"), Some("-9.80665".into()));
        assert_eq!(si("dt", "1ms"), Some("0.001".into()));
        assert_eq!(si("sheets.0.size", "(30 cm, 0.25)"), Some("(0.3, 0.25)".into()));
        assert_eq!(si("gravity", "(0, -1 g, 0)"), Some("(0, -9.80665, 0)".into()));
        assert_eq!(si("oven.temperature", "373.15 K"), Some("100".into()));
        assert_eq!(si("sheets.0.damping", "5 %"), Some("0.05".into()));
        for plain in ["2e9", "(1, 2, 3)", "Ball(1)", "hips", "rk4", "\"3 mm\"", "[1, 2]", "(1.0, (2 mm))"] {
            assert_eq!(si("sheets.0.material", plain), None, "{plain}");
        }
        let wrong = in_si("sheets.0.size", "(1 m, 3 GPa)").expect_err("no length");
        assert_eq!(wrong.field, "sheets.0.size.1");
        let wrong = in_si("sheets.0.material.thickness", "3 GPa").expect_err("no length").to_string();
        assert!(wrong.contains("thickness") && wrong.contains("pressure") && wrong.contains("mm"), "{wrong}");
    }
}
