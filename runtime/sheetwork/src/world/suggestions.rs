//! What was meant by a path that no parameter has.

use crate::error::InputError;
use crate::world::World;

/// Most paths that are proposed.
const MOST: usize = 3;
/// How alike (0 to 1) a path must be to be proposed.
const ALIKE: f64 = 0.5;

impl World {
    /// The refusal of a path that is none of [`World::parameters`]', with the nearest of those.
    pub fn no_such_parameter(&self, path: &str) -> InputError {
        let all = self.parameters();
        let near = nearest(path, all.iter().map(|p| p.path.as_str()));
        let meant = match near.as_slice() {
            [] => ".".to_owned(),
            [one] => format!("; did you mean {one}?"),
            [most @ .., last] => format!("; did you mean {} or {last}?", most.join(", ")),
        };
        let count = all.len();
        let problem = "cannot be set or read while the world runs: there is no such parameter";
        InputError::new(path, format!("{problem}{meant} There are {count}: `sheetwork params` lists them"))
    }
}

/// The few of `paths` that are most like `path`, the best first: by their letters, or because they end as it does.
fn nearest<'a>(path: &str, paths: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let last = |p: &str| p.rsplit('.').next().unwrap_or_default().to_lowercase();
    let wanted = path.to_lowercase();
    let alike = |other: &str| {
        let whole = strsim::normalized_damerau_levenshtein(&wanted, &other.to_lowercase());
        // The right name of the wrong sheet, or a name without its sheet.
        let end = strsim::normalized_damerau_levenshtein(&last(&wanted), &last(other));
        whole.max(0.9 * end)
    };
    let mut scored: Vec<(f64, &str)> = paths.map(|p| (alike(p), p)).filter(|s| s.0 >= ALIKE).collect();
    // Stable: of those alike the first in the list.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(MOST).map(|s| s.1).collect()
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn slips_and_missing_sheets_are_understood() {
        let paths = ["gravity", "engine", "dt", "sheets.strip.material.young", "sheets.strip.friction", "oven.on"];
        let of = |path| nearest(path, paths.into_iter());
        assert_eq!(of("gravty"), ["gravity"]);
        assert_eq!(of("young"), ["sheets.strip.material.young"]);
        assert_eq!(of("sheets.stirp.friction")[0], "sheets.strip.friction");
        assert_eq!(of("Sheets.other.material.young")[0], "sheets.strip.material.young");
        assert!(of("xyzzy").is_empty());
    }
}
