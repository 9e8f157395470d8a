//! Templates of scenes.

use sheetwork::scene::Scene;

/// Template of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// Name in the menu.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    text: &'static str,
}

/// All templates, in the order of the menu.
pub const TABLE: &[Template] = &[
    Template {
        name: "Empty room",
        about: "A floor only: drop sheet, polyhedra and heater files on the window",
        text: r#"(name: "untitled", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            room: (x: (-0.3, 0.3), y: (0.0, 0.4), z: (-0.3, 0.3), grid: 0.05, back_wall: false))"#,
    },
    Template {
        name: "Clamped strip",
        about: "A strip of polystyrene, clamped at one edge",
        text: r#"(name: "clamped strip", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            sheets: [(name: "strip", structure: "shell", grid: (21, 1, 5), size: (0.2, 0.04), material: "hips",
                pins: [(region: Left, clamp: true)], probes: {"tip": (1, 0.5)})],
            bodies: [(name: "clamp", shape: Box((0.03, 0.02, 0.06)), placement: (position: (-0.1155, 0, 0)))])"#,
    },
    Template {
        name: "Sheet on a box",
        about: "A square of card falls over a box",
        text: r#"(name: "sheet on a box", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            room: (x: (-0.25, 0.25), y: (0.0, 0.25), z: (-0.25, 0.25), grid: 0.05, back_wall: false),
            sheets: [(name: "sheet", structure: "shell", grid: (21, 1, 21), size: (0.2, 0.2), material: "paper",
                placement: (position: (0.02, 0.14, 0.01)), probes: {"corner": (1, 1), "middle": (0.5, 0.5)})],
            bodies: [(name: "box", shape: Box((0.08, 0.08, 0.08)), placement: (position: (0, 0.04, 0)))])"#,
    },
    Template {
        name: "Ball on a fixed sheet",
        about: "A ball falls on a sheet fixed along its border",
        text: r#"(name: "ball on a held sheet", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            sheets: [(name: "sheet", structure: "shell", grid: (21, 1, 21), size: (0.2, 0.2), material: "rubber",
                pins: [(region: Border)], probes: {"middle": (0.5, 0.5)})],
            bodies: [(name: "ball", shape: Ball(0.015), mass: 0.02, placement: (position: (0.01, 0.06, 0)))])"#,
    },
    Template {
        name: "Under a heater",
        about: "A sheet of rigid PVC, fixed at two edges, sags under a heater at 350 °C",
        text: r#"(name: "under a heater", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2), time_lapse: 10,
            sheets: [(name: "sheet", structure: "shell", grid: (17, 1, 13), size: (0.2, 0.15), material: "pvc", damping_ratio: 0.3,
                pins: [(region: Left), (region: Right)], probes: {"middle": (0.5, 0.5)})],
            heaters: [(name: "panel", size: (0.12, 0.01, 0.1), hot: [(face: 2, temperature: 350, emissivity: 0.9)],
                placement: (position: (0, 0.09, 0)))])"#,
    },
    Template {
        name: "The thesis's wedge",
        about: "A soft three-dimensional lattice (TRiMM 11x2x11) over a wedge, by Euler-Richardson",
        text: r#"(name: "wedge", engine: "euler-richardson", dt: 0.005, gravity: (0, -0.981, 0),
            room: (x: (-0.065, 0.065), y: (-0.0281, 0.03), z: (-0.0299, 0.0333), grid: 0.005),
            air: (factor: 0.97, per: 0.015),
            sheets: [(name: "sheet", structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis",
                springs: Uniform, node_mass: 4e-5, placement: (position: (-0.0015, 0.0025, -0.0015)), probes: {"centre": (0.5, 0.5)})],
            bodies: [(name: "wedge", shape: Polyhedron((
                vertices: [(-0.0165, -0.0281, 0.0145), (0.0135, -0.0281, 0.0145), (-0.0015, -0.0121, 0.0145),
                    (-0.0165, -0.0281, -0.0175), (0.0135, -0.0281, -0.0175), (-0.0015, -0.0121, -0.0175)],
                faces: [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]])))])"#,
    },
];

impl Template {
    /// Scene of the template.
    pub fn scene(&self) -> Scene {
        // The tests parse every template.
        Scene::parse(self.text).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::World;

    #[test]
    fn every_template_is_a_scene_that_runs() {
        for template in TABLE {
            let scene = Scene::parse(template.text).expect(template.name);
            let mut world = World::new(&scene).expect(template.name);
            world.advance(0.1);
            assert!(world.unstable().is_none() && !template.about.is_empty(), "{}", template.name);
        }
    }
}
