//! Contact force on each node, from the equilibrium of the sheet.
//!
//! R_i = -(Σ element and spring forces + applied force) - m_i g (N). For a sheet at rest R_i is the
//! contact force on node i. In motion it has an error of the inertial force and of the air drag.
//! Fixed nodes are left out, because their reaction comes from the pin, and forces of the thickness
//! limit between layers are not included.

use glam::DVec3;

use crate::elements::spring::SpringWorkspace;
use crate::math::Vectors;
use crate::sheet::Sheet;

impl Sheet {
    /// Write the contact force on each node (N) under `gravity` (m/s²), for a sheet at rest; 0 for
    /// nodes that neither touch anything nor share an edge with a node that does.
    pub fn contact_forces(&self, gravity: DVec3, out: &mut Vec<DVec3>) {
        let n = self.node_count();
        out.clear();
        out.resize(n, DVec3::ZERO);
        if !self.touching().contains(&true) {
            return;
        }
        let still = Vectors::zeros(n);
        let (mut force, mut scratch) = (self.parameters.applied.clone(), SpringWorkspace::default());
        self.springs.add_forces(&self.state.x, &still, false, &mut scratch, &mut force);
        self.elements.iter().for_each(|e| e.add_forces(&self.state.x, &still, &mut force));
        // A contact within a face or an edge acts on its corners.
        let mut near = self.touching().to_vec();
        for [a, b] in self.edges() {
            let (a, b) = (a as usize, b as usize);
            let (at_a, at_b) = (self.touching()[a], self.touching()[b]);
            near[a] |= at_b;
            near[b] |= at_a;
        }
        for i in (0..n).filter(|i| near[*i] && !self.is_held(*i)) {
            out[i] = -(force.get(i) + gravity * self.node_mass(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::World;
    use crate::scene::Scene;

    #[test]
    fn contact_forces_of_a_resting_sheet_balance_its_weight() {
        for (structure, layers, springs) in [("shell", 1, "Uniform"), ("slamm", 2, "Calibrated")] {
            let scene = Scene::parse(&format!(
                r#"(dt: 0.002, engine: "tr-bdf2", room: (x: (-1, 1), y: (0, 1), z: (-1, 1), back_wall: false), contact: (restitution: 0),
                    sheets: [(structure: "{structure}", grid: (7, {layers}, 7), size: (0.1, 0.1), springs: {springs}, material: "hips",
                        damping_ratio: 0.5, placement: (position: (0, 0.001, 0)))])"#
            ));
            let mut world = World::new(&scene.expect("valid")).expect("valid");
            let mut forces = Vec::new();
            world.sheets()[0].contact_forces(world.gravity(), &mut forces);
            assert!(forces.iter().all(|f| *f == DVec3::ZERO), "in the air");
            world.advance(3.0);
            let sheet = &world.sheets()[0];
            sheet.contact_forces(world.gravity(), &mut forces);
            let (held, weight) = (forces.iter().sum::<DVec3>(), 9.81 * sheet.total_mass());
            assert!((held / weight).distance(DVec3::Y) < 0.02, "{structure}: {held} of {weight}");
        }
    }
}
