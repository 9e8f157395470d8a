//! Temperatures of a recording on a sheet, for display only.

use crate::error::{InputError, check_range};
use crate::sheet::remap::motion;
use crate::sheet::{Sheet, temperature};
use crate::units::temperature::{COLDEST, HOTTEST, REFERENCE};

/// Minimum remaining stiffness: a recording can round it to zero.
const MIN_STIFFNESS: f64 = 1e-6;

/// Temperatures of the nodes of a sheet, to a twentieth of a degree, or their remaining stiffness.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RecordedTemperature {
    /// No data: the sheet has no thermal model, or the file has version 1.
    #[default]
    Unknown,
    /// Temperature of each node, uniform through the thickness, °C.
    Mean(Vec<f32>),
    /// Temperature of each node on the lower side, then of each on the upper side, °C.
    Sides(Vec<f32>),
    /// Remaining stiffness at each node, 0 to 1, for the thesis's formulas, which have no
    /// temperature of a sheet.
    Stiffness(Vec<f32>),
}

impl RecordedTemperature {
    /// Temperatures of a sheet, at the nodes of `grid`.
    pub(crate) fn of(sheet: &Sheet, grid: (u32, u32), by_thesis: bool) -> Self {
        let Some(heat) = sheet.heat() else { return Self::Unknown };
        let single =
            |values: &[f64]| motion::values_at(sheet, grid, values).iter().map(|v| *v as f32).collect::<Vec<_>>();
        if by_thesis {
            let left: Vec<f64> = (0..sheet.node_count()).map(|i| 1.0 / heat.compliance(i)).collect();
            return Self::Stiffness(single(&left));
        }
        match heat.halves() {
            Some((lower, upper)) => Self::Sides([single(lower), single(upper)].concat()),
            None => Self::Mean(single(heat.celsius())),
        }
    }

    /// Values; empty without data.
    pub fn values(&self) -> &[f32] {
        match self {
            Self::Unknown => &[],
            Self::Mean(values) | Self::Sides(values) | Self::Stiffness(values) => values,
        }
    }

    /// Number of values for `masses` nodes.
    pub(crate) fn count(&self, masses: usize) -> usize {
        match self {
            Self::Unknown => 0,
            Self::Mean(_) | Self::Stiffness(_) => masses,
            Self::Sides(_) => masses.saturating_mul(2),
        }
    }

    /// Linear interpolation at `part` (0 to 1) from `self` to `other`; `self` when their kinds or
    /// lengths differ.
    pub fn towards(&self, other: &Self, part: f32) -> Self {
        let (from, to) = (self.values(), other.values());
        let between = || from.iter().zip(to).map(|(a, b)| a + (b - a) * part).collect();
        match (self, other) {
            (Self::Mean(_), Self::Mean(_)) if from.len() == to.len() => Self::Mean(between()),
            (Self::Sides(_), Self::Sides(_)) if from.len() == to.len() => Self::Sides(between()),
            (Self::Stiffness(_), Self::Stiffness(_)) if from.len() == to.len() => Self::Stiffness(between()),
            _ => self.clone(),
        }
    }

    /// Check the ranges of the values.
    ///
    /// # Errors
    /// When one is out of range.
    pub(crate) fn check(&self) -> Result<(), InputError> {
        let (name, low, high, unit) = match self {
            Self::Stiffness(_) => ("stiffness", 0.0, 1.0, ""),
            _ => ("temperature", COLDEST, HOTTEST, "°C"),
        };
        // Rounding can exceed the ends of the range slightly.
        self.values().iter().try_for_each(|v| check_range(name, f64::from(*v), low - 0.1, high + 0.1, unit))
    }
}

/// Set recorded temperatures, which must be in range. Without effect when the number of values
/// does not fit.
pub(crate) fn show_temperatures(sheet: &mut Sheet, warmth: &RecordedTemperature) {
    let n = sheet.node_count();
    if warmth.values().len() != warmth.count(n) || *warmth == RecordedTemperature::Unknown {
        return;
    }
    temperature::start_temperatures(sheet, REFERENCE);
    let Some(mut heat) = sheet.state.heat.take() else { return };
    let two = heat.halves().is_some();
    let celsius = |t: f32| f64::from(t).clamp(COLDEST, HOTTEST);
    match warmth {
        RecordedTemperature::Unknown => {}
        RecordedTemperature::Mean(mean) => {
            let sides = if two { 2 } else { 1 };
            heat.set_nodes((0..sides * n).map(|k| celsius(mean[k % n])));
        }
        RecordedTemperature::Sides(sides) if two => heat.set_nodes(sides.iter().map(|t| celsius(*t))),
        RecordedTemperature::Sides(sides) => heat.set_nodes((0..n).map(|i| celsius(0.5 * (sides[i] + sides[i + n])))),
        RecordedTemperature::Stiffness(left) => {
            let room = heat.celsius().first().copied().unwrap_or(REFERENCE);
            heat.set_fractions(room, |i| f64::from(left[i]).clamp(MIN_STIFFNESS, 1.0));
        }
    }
    sheet.state.heat = Some(heat);
    temperature::update_thermal_stiffness(sheet);
}
