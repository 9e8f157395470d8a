//! Suggestions for an unknown parameter path.

use crate::error::{InputError, ParameterError, did_you_mean, most_similar, similarity};
use crate::world::World;

impl World {
    /// Error for a path that is not in [`World::parameters`], with the most similar paths.
    pub(crate) fn no_such_parameter(&self, path: &str) -> ParameterError {
        let all = self.parameters();
        let near = nearest(path, all.iter().map(|p| p.path.as_str()));
        let meant = did_you_mean(&near).map_or_else(|| ".".to_owned(), |question| format!("; {question}"));
        let count = all.len();
        let problem = "cannot be set or read while the world runs: there is no such parameter";
        let problem = format!("{problem}{meant} There are {count}: `sheetwork params` lists them");
        ParameterError::UnknownPath(InputError::new(path, problem))
    }
}

/// The most similar of `paths`, the best first: by all letters, or by the last part.
fn nearest<'a>(path: &str, paths: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let last = |p: &str| p.rsplit('.').next().unwrap_or_default().to_lowercase();
    // The right name of the wrong sheet, or a name without its sheet.
    most_similar(paths, |other| similarity(path, other).max(0.9 * similarity(&last(path), &last(other))))
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
