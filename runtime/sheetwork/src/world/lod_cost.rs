//! Cost model of sheets at a level of detail, and the choice of levels within a budget.
//!
//! Both are independent of a clock: the same run makes the same choices. A step of a sheet costs
//!
//!   c = s (a + b n^p) ns,
//!
//! s the number of linear solves (implicit integrators) or force evaluations (explicit), n the
//! number of nodes. `sheetwork bench detail --calibrate` measures the constants on a machine. A
//! host with a clock corrects the budget by measured times.

/// a (ns), b (ns) and p of a linear solve, without forces and contact.
const SOLVE_COST: (f64, f64, f64) = (2.0e3, 240.0, 1.3);
/// a (ns), b (ns) and p of a force evaluation.
const FORCE_COST: (f64, f64, f64) = (2.0e2, 183.0, 1.0);

/// Cost of one solve, or force evaluation, of a sheet of `masses` nodes, ns.
pub fn cost_of(masses: usize, implicit: bool) -> f64 {
    let (a, b, p) = if implicit { SOLVE_COST } else { FORCE_COST };
    a + b * (masses as f64).powf(p)
}

/// A sheet with levels of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LodCandidate {
    /// Cost of a step at each level, finest first, ns.
    pub costs: Vec<f64>,
    /// Level for the distance of the sheet.
    pub wanted: usize,
    /// Visual importance: less important sheets are coarsened first.
    pub importance: f64,
}

impl LodCandidate {
    fn cost(&self, level: usize) -> f64 {
        self.costs.get(level).copied().unwrap_or(0.0)
    }
}

/// Planner of levels, with reused arrays.
#[derive(Clone, Debug, Default)]
pub struct LodPlanner {
    order: Vec<u32>,
}

impl LodPlanner {
    /// Write the level of each of `sheets` to `levels`: the level of its distance, or a coarser one
    /// where the total cost with `others` (ns) would exceed `budget` (ns). Sheets are coarsened one
    /// level at a time, the least important first, so that differences between sheets stay small.
    pub fn plan(&mut self, sheets: &[LodCandidate], others: f64, budget: f64, levels: &mut Vec<usize>) {
        levels.clear();
        levels.extend(sheets.iter().map(|s| s.wanted));
        let mut total = others + sheets.iter().map(|s| s.cost(s.wanted)).sum::<f64>();
        if total <= budget {
            return;
        }
        self.order.clear();
        self.order.extend(0..sheets.len() as u32);
        let importance = |i: &u32| sheets[*i as usize].importance;
        self.order.sort_unstable_by(|a, b| importance(a).total_cmp(&importance(b)).then(b.cmp(a)));
        let deepest = sheets.iter().map(|s| s.costs.len()).max().unwrap_or(0);
        for _ in 1..deepest {
            for i in self.order.iter().map(|i| *i as usize) {
                if total <= budget {
                    return;
                }
                let (sheet, level) = (&sheets[i], levels[i]);
                let saved = sheet.cost(level) - sheet.cost(level + 1);
                if level + 1 < sheet.costs.len() && saved > 0.0 {
                    levels[i] += 1;
                    total -= saved;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(sheets: &[LodCandidate], others: f64, budget: f64) -> Vec<usize> {
        let mut levels = Vec::new();
        LodPlanner::default().plan(sheets, others, budget, &mut levels);
        levels
    }

    fn sheet(importance: f64, wanted: usize) -> LodCandidate {
        LodCandidate { costs: vec![16.0, 4.0, 1.0], wanted, importance }
    }

    #[test]
    fn the_least_important_is_made_coarser_first() {
        let sheets = [sheet(3.0, 0), sheet(1.0, 0), sheet(2.0, 0)];
        assert_eq!(plan(&sheets, 0.0, 48.0), [0, 0, 0]);
        assert_eq!(plan(&sheets, 0.0, 40.0), [0, 1, 0]);
        assert_eq!(plan(&sheets, 0.0, 24.0), [0, 1, 1]);
        assert_eq!(plan(&sheets, 8.0, 20.0), [1, 1, 1]);
        assert_eq!(plan(&sheets, 0.0, 7.0), [1, 2, 2]);
        // A budget that cannot be met yields the coarsest levels.
        assert_eq!(plan(&sheets, 0.0, 1.0), [2, 2, 2]);
    }

    #[test]
    fn sleeping_sheets_keep_their_level() {
        let asleep = LodCandidate { costs: vec![0.0; 3], ..sheet(0.1, 0) };
        assert_eq!(plan(&[asleep, sheet(1.0, 1)], 0.0, 3.0), [0, 2]);
    }

    #[test]
    fn cost_grows_with_the_number_of_nodes() {
        for implicit in [false, true] {
            assert!(cost_of(441, implicit) > 2.5 * cost_of(121, implicit));
        }
    }
}
