//! Assembly of a sheet from its parts: nodes at their placement, springs, surfaces, settings.
//!
//! With R the rotation and o (m) the position of the placement, a node at p (m) with velocity u
//! (m/s) and force f (N) in the frame of the sheet starts at
//!
//!   x = R p + o,  v = R u + v₀ + ω × (x - c),  f = R f,
//!
//! with v₀ (m/s) and ω (rad/s) of the description and c (m) the centre of mass. Springs store
//! their stiffness per unit: of E t (N/m), or of the bending stiffness D (N m) if they are
//! calibrated to it.

use glam::DVec3;

use crate::elements::spring::{Spring, Springs};
use crate::elements::thickness_limit::ThicknessLimit;
use crate::math::Vectors;
use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::refine::Refinement;
use crate::mesh::structure::{Lattice, LatticeLayer, StructureKind};
use crate::scene::{Material, Scene, SheetSpec};
use crate::sheet::air_drag::AirDrag;
use crate::sheet::generation::CalibratedSprings;
use crate::sheet::layer_stack::LayerStack;
use crate::sheet::model::{DescribedTemperature, OutlineMeshes};
use crate::sheet::parameters::{Flexion, SpringParameters};
use crate::sheet::{Pins, Probe, Sheet, SheetModel, SheetParameters, SheetState, StepWorkspace, creases, instability};

/// Parts of a generated sheet or of a sheet from a file, before placement.
pub(crate) struct SheetParts {
    pub lattice: Lattice,
    /// Rest length of each link, m.
    pub rest: Vec<f64>,
    /// Stiffness of each link, N/m.
    pub stiffness: Vec<f64>,
    pub mass: Vec<f64>,
    pub velocity: Vec<DVec3>,
    pub force: Vec<DVec3>,
    /// Material coordinates of each node, 0 to 1 over the bottom layer.
    pub uv: Vec<(f64, f64)>,
    /// Length and width (m) to which `uv` refers.
    pub extent: (f64, f64),
    pub structure: StructureKind,
    pub grid: (u32, u32, u32),
    pub damping: f64,
    /// Clamp springs and delivered stiffness of a calibrated lattice.
    pub calibrated: Option<CalibratedSprings>,
    /// Triangle mesh of a sheet with an outline.
    pub mesh: Option<TriangleMesh>,
    /// Local refinement of that mesh.
    pub refinement: Option<Box<Refinement>>,
}

/// Assemble a sheet without elements and prescribed degrees of freedom. `bends` says whether the
/// stiffness of the springs is per bending stiffness; `triangles` are those of an outline.
pub(super) fn assemble(
    scene: &Scene,
    spec: &SheetSpec,
    material: Material,
    parts: SheetParts,
    bends: bool,
    triangles: Option<Vec<[u32; 3]>>,
) -> Sheet {
    let mut sheet = empty_sheet(scene, spec, material);
    sheet.engine.set_tolerance(scene.tolerance);
    place_nodes(&mut sheet, spec, &parts);
    join_springs(&mut sheet, &parts, bends);
    let SheetParts { lattice, mass, uv, extent, structure, grid, damping, .. } = parts;
    (sheet.model.structure, sheet.model.grid, sheet.model.extent, sheet.parameters.springs.damping) =
        (structure, grid, extent, damping);
    sheet.inverse_mass = mass.iter().map(|m| 1.0 / m).collect();
    sheet.model.mass = mass;
    sheet.model.uv = uv;
    let second = lattice.layers.get(1);
    sheet.model.gap = second.map_or(1.0, |l| lattice.positions.get(l.first as usize).map_or(1.0, |p| p.y));
    (sheet.model.layers, sheet.model.layer_of, sheet.model.border) = (lattice.layers, lattice.layer_of, lattice.border);
    sheet.parameters.flexion.triples = lattice.flexion;
    set_surface(&mut sheet, spec, triangles);
    instability::set_recovery_policy(&mut sheet, spec.when_unstable, scene.tolerance);
    sheet.model.initial_diagonal = sheet.state.x.bounds().map_or(0.0, |(low, high)| low.distance(high));
    if spec.thickness_limit > 0.0 && sheet.stack.is_layered() {
        let mut limit = ThicknessLimit::new(spec.thickness_limit);
        sheet.stack.cells().for_each(|(apex, corners)| limit.add(apex, corners, &lattice.positions));
        sheet.parameters.thickness_limit = Some(limit);
    }
    add_spin(&mut sheet, spec.spin);
    sheet.refresh();
    sheet
}

/// A sheet without nodes, with the settings of `spec` in `scene`.
fn empty_sheet(scene: &Scene, spec: &SheetSpec, material: Material) -> Sheet {
    Sheet {
        name: spec.name.clone(),
        model: SheetModel {
            structure: StructureKind::Shell,
            grid: (0, 0, 0),
            layers: Vec::new(),
            triangles: None,
            uv: Vec::new(),
            border: Vec::new(),
            layer_of: Vec::new(),
            refinement: None,
            meshes: OutlineMeshes::default(),
            mass: Vec::new(),
            clamped: Vec::new(),
            length: spec.size.0.max(spec.size.1),
            extent: (0.0, 0.0),
            gap: 1.0,
            initial_diagonal: 0.0,
            folds: creases::folds(spec),
            contact_surface: spec.contact_surface,
            adhesion_areas: Vec::new(),
            described_temperature: DescribedTemperature {
                initial: spec.temperature,
                has_gradient: spec.temperature_gradient,
            },
        },
        parameters: SheetParameters {
            applied: Vectors::default(),
            friction: spec.friction.unwrap_or(scene.contact.friction),
            restitution: spec.restitution.unwrap_or(scene.contact.restitution),
            damping_ratio: spec.damping_ratio.unwrap_or(material.damping()),
            springs: SpringParameters::default(),
            drag: AirDrag::default(),
            flexion: Flexion::default(),
            thickness_limit: None,
            max_step: f64::INFINITY,
            material,
        },
        state: SheetState::default(),
        probes: Vec::new(),
        inverse_mass: Vec::new(),
        springs: Springs::default(),
        elements: Vec::new(),
        grabs: Vec::new(),
        pins: Pins::default(),
        stack: LayerStack::default(),
        recovery: None,
        engine_kind: scene.engine,
        engine: scene.engine.construct(),
        system: None,
        last_field: None,
        work: StepWorkspace::default(),
    }
}

/// Place the nodes: positions, velocities without spin, and applied forces.
fn place_nodes(sheet: &mut Sheet, spec: &SheetSpec, parts: &SheetParts) {
    let rotation = spec.placement.quaternion();
    for ((p, u), f) in parts.lattice.positions.iter().zip(&parts.velocity).zip(&parts.force) {
        sheet.state.x.push(spec.placement.apply(*p));
        sheet.state.v.push(rotation * *u + spec.velocity);
        sheet.parameters.applied.push(rotation * *f);
    }
    sheet.model.clamped = vec![false; sheet.state.x.len()];
}

/// Add the springs and the stack of layers that they join.
fn join_springs(sheet: &mut Sheet, parts: &SheetParts, bends: bool) {
    let each = parts.lattice.links.iter().zip(&parts.rest).zip(&parts.stiffness);
    let list: Vec<Spring> = each
        .map(|((link, rest), k)| Spring {
            a: link.a,
            b: link.b,
            class: link.class,
            stiffness: *k,
            rest: *rest,
            damping: 0.0,
        })
        .collect();
    sheet.springs = Springs::new(&list);
    sheet.stack = LayerStack::new(&sheet.springs, &parts.lattice.layer_of);
    let material = &sheet.parameters.material;
    let unit = if bends { material.plate_stiffness() } else { material.young * material.thickness };
    sheet.parameters.springs.per_unit = parts.stiffness.iter().map(|k| k / unit).collect();
    sheet.parameters.springs.is_calibrated = bends;
}

/// Set the triangles of an outline, the probes, and the surface that meets air and pressure.
fn set_surface(sheet: &mut Sheet, spec: &SheetSpec, triangles: Option<Vec<[u32; 3]>>) {
    let layers = &sheet.model.layers;
    sheet.probes = layers.first().map_or_else(Vec::new, |bottom| {
        let list = triangles.clone().unwrap_or_else(|| bottom.triangles());
        spec.probes.iter().map(|(name, at)| Probe::new(name, *at, bottom.first, &list, &sheet.model.uv)).collect()
    });
    let covered = match &triangles {
        Some(list) => list.clone(),
        None => layers.iter().flat_map(LatticeLayer::triangles).collect(),
    };
    let lowest = if triangles.is_some() { usize::MAX } else { layers.first().map_or(0, |l| l.triangles().len()) };
    sheet.parameters.drag = AirDrag::new(covered, layers.len(), spec.drag).with_law(spec.aerodynamics);
    sheet.parameters.drag.set_schedule(&spec.pressure, &sheet.state.x, lowest);
    sheet.model.triangles = triangles;
}

/// Add the velocities of a rotation with angular velocity `spin` (rad/s) about the centre of mass.
fn add_spin(sheet: &mut Sheet, spin: DVec3) {
    if spin == DVec3::ZERO {
        return;
    }
    let centre = sheet.centre_of_mass();
    for i in 0..sheet.node_count() {
        sheet.state.v.add(i, spin.cross(sheet.state.x.get(i) - centre));
    }
}
