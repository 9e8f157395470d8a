//! Specification of the levels of detail of a sheet.

use serde::{Deserialize, Serialize};

use crate::error::{InputError, check_range};
use crate::scene::SheetSpec;
use crate::units::parameters::ParameterId as Id;

/// Maximum number of levels.
const MAX_LEVELS: usize = 16;

/// Levels of detail of a sheet, chosen by its distance from the viewpoint and by the budget of the
/// world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetailSpec {
    /// Levels, finest first, 1 to 16.
    pub levels: Vec<DetailLevel>,
    /// Hysteresis of the distances, as a fraction of each, 0 to 0.5.
    #[serde(default = "DetailSpec::default_hysteresis")]
    pub hysteresis: f64,
}

/// A level of detail.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetailLevel {
    /// Nodes along length and width, 2 to 2000 each; fewer in total than in the level before.
    pub grid: (u32, u32),
    /// Distance from the viewpoint up to which this level is used, m, 0 to 1e6, larger than that of
    /// the level before; `None`, for the last level only, for all distances beyond.
    pub within: Option<f64>,
}

impl DetailSpec {
    fn default_hysteresis() -> f64 {
        0.1
    }

    /// Levels of these grids, each with its distance (m), `None` for the last.
    pub fn new(levels: impl IntoIterator<Item = ((u32, u32), Option<f64>)>) -> Self {
        let levels = levels.into_iter().map(|(grid, within)| DetailLevel { grid, within }).collect();
        Self { levels, hysteresis: Self::default_hysteresis() }
    }

    /// Level at `distance` (m), for a sheet that is at level `now`.
    pub fn wanted(&self, distance: f64, now: Option<usize>) -> usize {
        let reach = |i: usize| {
            let within = self.levels[i].within.unwrap_or(f64::INFINITY);
            // Hysteresis: the distance to leave a level exceeds the distance to enter it.
            let inside = now.is_some_and(|now| now <= i);
            within * if inside { 1.0 + self.hysteresis } else { 1.0 - self.hysteresis }
        };
        let last = self.levels.len().saturating_sub(1);
        (0..last).find(|i| distance <= reach(*i)).unwrap_or(last)
    }
}

/// Check the levels of a sheet.
///
/// # Errors
/// When a value is out of range or the sheet cannot change its grid.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    let Some(detail) = &s.detail else { return Ok(()) };
    let refused = |field: String, problem: String| Err(InputError::new(field, problem));
    check_range("detail.levels", detail.levels.len() as f64, 1.0, MAX_LEVELS as f64, "levels")?;
    Id::DetailHysteresis.check("detail.hysteresis", detail.hysteresis)?;
    let masses = |l: &DetailLevel| u64::from(l.grid.0) * u64::from(l.grid.1);
    let mut before: Option<&DetailLevel> = None;
    for (i, level) in detail.levels.iter().enumerate() {
        Id::DetailGrid.check_each(&format!("detail.levels.{i}.grid"), [level.grid.0.into(), level.grid.1.into()])?;
        let at = format!("detail.levels.{i}.within");
        match level.within {
            Some(within) => Id::DetailDistance.check(&at, within)?,
            None if i + 1 < detail.levels.len() => {
                return refused(at, "is none, which only the last level may have".into());
            }
            None => {}
        }
        if let Some(before) = before {
            if masses(level) >= masses(before) {
                let problem = format!("{} masses are not fewer than the {} before", masses(level), masses(before));
                return refused(format!("detail.levels.{i}.grid"), problem);
            }
            if level.within.zip(before.within).is_some_and(|(now, then)| now <= then) {
                return refused(at, "is not more than that of the level before".into());
            }
        }
        before = Some(level);
    }
    let reason = if s.file.is_some() {
        "does not go with a sheet from a file, which has its masses"
    } else if s.sticky {
        "does not go with sticky: what sticks does so by its masses"
    } else if !s.slits.is_empty() {
        "does not go with slits: another grid has other cells"
    } else if s.pins.iter().any(|p| p.body.is_some()) {
        "does not go with glue: it is by masses"
    } else {
        return Ok(());
    };
    refused("detail".into(), reason.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::StructureKind;

    #[test]
    fn a_level_is_left_later_than_it_is_entered() {
        let detail = DetailSpec::new([((41, 41), Some(1.0)), ((21, 21), Some(3.0)), ((11, 11), None)]);
        assert_eq!(detail.wanted(0.5, None), 0);
        assert_eq!((detail.wanted(1.05, Some(0)), detail.wanted(1.05, Some(1))), (0, 1));
        assert_eq!((detail.wanted(0.95, Some(1)), detail.wanted(0.85, Some(1))), (1, 0));
        assert_eq!((detail.wanted(3.2, Some(1)), detail.wanted(3.2, Some(2)), detail.wanted(9.0, Some(0))), (1, 2, 2));
    }

    #[test]
    fn inconsistent_levels_are_rejected() {
        let spec = |levels: Vec<((u32, u32), Option<f64>)>| SheetSpec {
            structure: StructureKind::Shell,
            grid: (11, 1, 11),
            detail: Some(DetailSpec::new(levels)),
            ..SheetSpec::thesis()
        };
        assert!(check(&spec(vec![((21, 21), Some(1.0)), ((11, 11), None)])).is_ok());
        let refused = |levels| check(&spec(levels)).expect_err("refused").field;
        assert_eq!(refused(vec![]), "detail.levels");
        assert_eq!(refused(vec![((1, 21), None)]), "detail.levels.0.grid.0");
        assert_eq!(refused(vec![((11, 11), Some(1.0)), ((21, 21), None)]), "detail.levels.1.grid");
        assert_eq!(refused(vec![((21, 21), None), ((11, 11), None)]), "detail.levels.0.within");
        assert_eq!(refused(vec![((21, 21), Some(2.0)), ((11, 11), Some(1.0))]), "detail.levels.1.within");
        let lattice = SheetSpec { structure: StructureKind::Slamm, ..spec(vec![((21, 21), None)]) };
        assert!(check(&lattice).is_ok());
        let sticky = SheetSpec { sticky: true, ..lattice };
        assert_eq!(check(&sticky).expect_err("refused").field, "detail");
    }
}
