//! Suggestions for an unknown parameter path.

use crate::error::InputError;
use crate::world::World;

/// Maximum number of suggested paths.
const MAX_SUGGESTIONS: usize = 3;
/// Similarity threshold (0 to 1) of a suggested path.
const SIMILARITY_THRESHOLD: f64 = 0.5;

impl World {
    /// Error for a path that is not in [`World::parameters`], with the most similar paths.
    pub(crate) fn no_such_parameter(&self, path: &str) -> InputError {
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

/// The most similar of `paths`, the best first: by all letters, or by the last part.
fn nearest<'a>(path: &str, paths: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let last = |p: &str| p.rsplit('.').next().unwrap_or_default().to_lowercase();
    let wanted = path.to_lowercase();
    let alike = |other: &str| {
        let whole = strsim::normalized_damerau_levenshtein(&wanted, &other.to_lowercase());
        // The right name of the wrong sheet, or a name without its sheet.
        let end = strsim::normalized_damerau_levenshtein(&last(&wanted), &last(other));
        whole.max(0.9 * end)
    };
    let mut scored: Vec<(f64, &str)> = paths.map(|p| (alike(p), p)).filter(|s| s.0 >= SIMILARITY_THRESHOLD).collect();
    // The sort is stable: among equals the first in the list wins.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(MAX_SUGGESTIONS).map(|s| s.1).collect()
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn misspelt_paths_and_missing_sheet_names_get_suggestions() {
        let paths = ["gravity", "engine", "dt", "sheets.strip.material.young", "sheets.strip.friction", "oven.on"];
        let of = |path| nearest(path, paths.into_iter());
        assert_eq!(of("gravty"), ["gravity"]);
        assert_eq!(of("young"), ["sheets.strip.material.young"]);
        assert_eq!(of("sheets.stirp.friction")[0], "sheets.strip.friction");
        assert_eq!(of("Sheets.other.material.young")[0], "sheets.strip.material.young");
        assert!(of("xyzzy").is_empty());
    }
}
