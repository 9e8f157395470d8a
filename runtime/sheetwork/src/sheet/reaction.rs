//! What contact holds a sheet with, worked out from the sheet: the force that each mass lacks to stand still.
//!
//! R_i = -(Σ element and spring forces + applied) - m_i g. At rest that is the force of contact on the mass; of masses that move it is off by
//! their inertia, and by the drag of the air, which is left out. Held masses are left out too: what holds them is their pin; and what a limit on the
//! thickness bears between two layers is not seen.

use glam::DVec3;

use crate::elements::spring::SpringScratch;
use crate::math::Vectors;
use crate::sheet::Sheet;

impl Sheet {
    /// Writes the force of contact on each mass, N, under `gravity` (m/s²), as if the sheet stood still; 0 for masses that neither
    /// touch anything nor are joined to one that does.
    pub fn contact_forces(&self, gravity: DVec3, out: &mut Vec<DVec3>) {
        let n = self.masses();
        out.clear();
        out.resize(n, DVec3::ZERO);
        if !self.touching().contains(&true) {
            return;
        }
        let still = Vectors::zeros(n);
        let (mut force, mut scratch) = (self.applied.clone(), SpringScratch::default());
        self.springs.add_forces(&self.x, &still, false, &mut scratch, &mut force);
        self.elements.iter().for_each(|e| e.add_forces(&self.x, &still, &mut force));
        // A face that lies on an edge is held at its corners.
        let mut near = self.touching().to_vec();
        for [a, b] in self.edges() {
            let (a, b) = (a as usize, b as usize);
            let (at_a, at_b) = (self.touching()[a], self.touching()[b]);
            near[a] |= at_b;
            near[b] |= at_a;
        }
        for i in (0..n).filter(|i| near[*i] && !self.is_held(*i)) {
            out[i] = -(force.get(i) + gravity * self.mass(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::World;
    use crate::scene::Scene;

    #[test]
    fn a_sheet_at_rest_is_held_by_its_weight() {
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
