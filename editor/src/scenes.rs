//! Scenes in menus; [`sheetwork::scene::library`] finds their folder.

use std::path::Path;

pub use sheetwork::scene::library::{find, folder, is_scene, list};

/// Scene opened by default.
pub const FIRST_SCENE: &str = "wedge_stiff.ron";

/// Name of a scene file in menus: `two_walls.ron` becomes `two walls`.
pub fn title(file: &Path) -> String {
    file.file_stem().map(|s| s.to_string_lossy().replace('_', " ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_is_the_name_without_its_ending() {
        assert_eq!(title(Path::new("there/two_walls.ron")), "two walls");
        assert!(find(Path::new(FIRST_SCENE)).is_file());
    }
}
