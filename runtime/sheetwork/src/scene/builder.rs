//! Builders of specifications in code: a sheet of a real material in one line, and a scene of
//! sheets and bodies.

use glam::DVec3;

use crate::mesh::outline::{HoleSpec, OutlineSpec};
use crate::mesh::structure::StructureKind;
use crate::scene::{
    BodySpec, DetailSpec, IntegratorKind, Material, MaterialChoice, PathKey, PinSpec, Placement, Region, Scene,
    SheetSpec, SpringLaw,
};

impl SheetSpec {
    /// Sheet of a material of the library: `card`, `paper`, `hips` (polystyrene), `pvc`, `pet`,
    /// `steel-foil`, `rubber`, ... ([`LIBRARY`](crate::scene::material::LIBRARY)). A shell of 21 by
    /// 21 nodes, 25 cm square, with the thickness of the material. An unknown name is refused when
    /// the world is built.
    pub fn new(material: impl Into<String>) -> Self {
        Self { material: MaterialChoice::Named(material.into()), ..Self::default() }
    }

    /// The soft lattice of the thesis: `trimm`, 11 x 2 x 11 nodes, 25 mm square, 1 mm between the
    /// layers, of the material `thesis` with the spring law `Uniform` and 0.115 of critical damping
    /// in every spring.
    pub fn thesis() -> Self {
        Self {
            structure: StructureKind::Trimm,
            grid: (11, 2, 11),
            size: (0.025, 0.025),
            gap: 0.001,
            material: MaterialChoice::Named("thesis".into()),
            springs: SpringLaw::Uniform,
            damping: 0.115,
            ..Self::default()
        }
    }

    /// Name in the world, in events and parameter paths.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Length (x) and width (z), m; 1e-6 to 1000.
    pub fn size(self, length: f64, width: f64) -> Self {
        Self { size: (length, width), ..self }
    }

    /// Numbers of nodes along length and width, 2 to 2000 each.
    pub fn grid(self, along_length: u32, along_width: u32) -> Self {
        Self { grid: (along_length, self.grid.1, along_width), ..self }
    }

    /// Number of layers (1 to 64) of a lattice and the distance between them, m (1e-7 to 10).
    pub fn layers(self, layers: u32, gap: f64) -> Self {
        Self { grid: (self.grid.0, layers, self.grid.2), gap, ..self }
    }

    /// Discretisation. A lattice gets two layers if it can have them: with one it does not resist
    /// bending.
    pub fn structure(self, structure: StructureKind) -> Self {
        let (fewest, most) = structure.info().layers;
        Self { structure, grid: (self.grid.0, 2.clamp(fewest, most), self.grid.2), ..self }
    }

    /// Law of the spring stiffnesses of a lattice.
    pub fn springs(self, springs: SpringLaw) -> Self {
        Self { springs, ..self }
    }

    /// Outer boundary of a shell that is not a rectangle.
    pub fn outline(self, outline: OutlineSpec) -> Self {
        Self { outline: Some(outline), ..self }
    }

    /// Hole in a shell.
    pub fn hole(mut self, hole: HoleSpec) -> Self {
        self.holes.push(hole);
        self
    }

    /// Polyline (x, z), m, from the middle of the sheet, along which a shell is cut.
    pub fn cut(mut self, line: impl Into<Vec<(f64, f64)>>) -> Self {
        self.cuts.push(line.into());
        self
    }

    /// Material given in place.
    pub fn material(self, material: Material) -> Self {
        Self { material: MaterialChoice::Inline(material), ..self }
    }

    /// Position of the middle of the bottom layer, m.
    pub fn at(mut self, x: f64, y: f64, z: f64) -> Self {
        self.placement.position = DVec3::new(x, y, z);
        self
    }

    /// Initial placement.
    pub fn placement(self, placement: Placement) -> Self {
        Self { placement, ..self }
    }

    /// Initial velocity, m/s; each component within ±1e4.
    pub fn velocity(self, velocity: DVec3) -> Self {
        Self { velocity, ..self }
    }

    /// Initial spin about the centre of mass, rad/s; each component within ±1e4.
    pub fn spin(self, spin: DVec3) -> Self {
        Self { spin, ..self }
    }

    /// Friction coefficient, 0 to 10.
    pub fn friction(self, friction: f64) -> Self {
        Self { friction: Some(friction), ..self }
    }

    /// Restitution coefficient, 0 to 1.
    pub fn restitution(self, restitution: f64) -> Self {
        Self { restitution: Some(restitution), ..self }
    }

    /// Damping ratio of the slowest bending motion, 0 to 10, in place of the material's.
    pub fn damping_ratio(self, ratio: f64) -> Self {
        Self { damping_ratio: Some(ratio), ..self }
    }

    /// Fix positions and slope of a region: an edge between two boards.
    pub fn clamp(mut self, region: Region) -> Self {
        self.pins.push(PinSpec::clamped(region));
        self
    }

    /// Fix positions of a region; a shell can rotate about them, as on a hinge.
    pub fn pin(self, region: Region) -> Self {
        self.pin_along(region, [])
    }

    /// Prescribe the motion of a region by a path of displacements from its initial positions.
    pub fn pin_along(mut self, region: Region, path: impl Into<Vec<PathKey>>) -> Self {
        self.pins.push(PinSpec { path: path.into(), ..PinSpec::fixed(region) });
        self
    }

    /// Attach a region to the body of that name, at its position when the sheet is built.
    pub fn glue(mut self, region: Region, body: impl Into<String>) -> Self {
        self.pins.push(PinSpec::attached(region, body));
        self
    }

    /// Probe: a named material point (u, v), each 0 to 1 over the bottom layer.
    pub fn probe(mut self, name: impl Into<String>, u: f64, v: f64) -> Self {
        self.probes.insert(name.into(), (u, v));
        self
    }

    /// Levels of detail.
    pub fn detail(self, levels: DetailSpec) -> Self {
        Self { detail: Some(levels), ..self }
    }
}

impl Scene {
    /// Empty scene, as the default: the implicit integrator `tr-bdf2`, which is stable for sheets
    /// of real materials, with steps of 1/60 s.
    pub fn new() -> Self {
        Self::default()
    }

    /// Empty scene with the explicit integrator and the step of the thesis: `euler-richardson`,
    /// 1 ms. A stiff sheet is unstable in it.
    pub fn thesis() -> Self {
        Self { engine: IntegratorKind::EulerRichardson, dt: 1.0e-3, ..Self::default() }
    }

    /// Add a sheet.
    pub fn with_sheet(mut self, sheet: SheetSpec) -> Self {
        self.sheets.push(sheet);
        self
    }

    /// Add a rigid body.
    pub fn with_body(mut self, body: BodySpec) -> Self {
        self.bodies.push(body);
        self
    }
}

impl PinSpec {
    /// Whether a running sheet can be given this pin, and be freed from it: without `clamp`, `body`
    /// and `axes`.
    pub fn is_live(&self) -> bool {
        !self.clamp && self.body.is_none() && self.axes == (true, true, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::World;

    #[test]
    fn a_sheet_built_in_one_line_is_stable_and_bends_as_its_material() {
        let scene = Scene::new().with_sheet(SheetSpec::new("card").at(0.0, 0.5, 0.0).clamp(Region::Left));
        let mut world = World::new(&scene).expect("valid");
        world.advance(1.0);
        assert!(world.unstable().is_none());
        let lowest = world.sheets()[0].state.x.y.iter().copied().fold(f64::INFINITY, f64::min);
        // Card of 25 cm droops by some centimetres and not by its length.
        assert!((0.3..0.499).contains(&lowest), "{lowest}");
    }
}
