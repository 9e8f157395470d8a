//! Bodies that are no sheets, from the masses and springs of a sheet: tubes, bags and cables
//! (thesis 7.4 i).
//!
//! A tube is a lattice of both diagonals that is rolled about x, its upper layers outside. With
//! N rows and the arc a = 2π/N, row j of the bottom layer is at the angle j a and row j of the
//! layer above it at (j + ½) a; layer l is l times the gap outside the bottom one. Row N - 1 and
//! row 0 are one arc apart, where the layer above lacks a row. This seam is closed by the springs
//! of a layer across it, `z` and both diagonals, and by braces through its thickness, from the last
//! rows of a layer to the first rows of the next. They are of class `cross-over`.
//!
//! A bag is a tube with a flat bottom at -x: with the spacing d along the length, the first
//! ⌊(R - d/8)/d⌋ columns are rings around the axis, and the innermost ring is held open by
//! springs across its diameter.
//!
//! A prism is a lattice as generated, of any structure and number of layers; a long one of three
//! layers is a cable.
//!
//! Every spring is at rest in the shape in which it is made. Lengths in m, masses in kg, stiffness
//! in N/m.

use glam::DVec3;

use crate::error::{InputError, reject_if};
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeLayer, LatticeSpec, LatticeSpring, StructureKind, generate};
use crate::scene::sht::{SheetFile, SheetFileNode, SheetFileSpring};
use crate::units::parameters::ParameterId as Id;

/// Springs and masses of a body: the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySprings {
    /// Stiffness of every spring, N/m, 0 to 1e12.
    pub stiffness: f64,
    /// Mass of every node, kg, 1e-12 to 1e6.
    pub node_mass: f64,
    /// Dashpot of the springs as a fraction of critical damping, 0 to 10.
    pub damping: f64,
}

/// Tube or bag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeSpec {
    /// Nodes along the wall (2 or more; from the middle of the bottom for a bag), layers of the
    /// wall (1 to 64), nodes around (6 or more, even).
    pub grid: (u32, u32, u32),
    /// Length of the wall along the same line, m.
    pub length: f64,
    /// Radius of the innermost layer, m; more than the spacing along the wall for a bag.
    pub radius: f64,
    /// Distance between layers, m.
    pub gap: f64,
    /// Whether it is a bag: closed at -x.
    pub closed: bool,
}

/// Sheet file of a lattice at rest.
///
/// # Errors
/// When the lattice or the springs are out of range.
pub fn prism(lattice: &LatticeSpec, springs: &BodySprings) -> Result<SheetFile, InputError> {
    file(&generate(lattice)?, lattice.structure, lattice.grid, springs)
}

/// Sheet file of a tube about x, its middle or the bottom of the bag at the origin.
///
/// # Errors
/// When the description or the springs are out of range.
pub fn tube(spec: &TubeSpec, springs: &BodySprings) -> Result<SheetFile, InputError> {
    let (columns, layers, rows) = spec.grid;
    Id::Size.check("radius", spec.radius)?;
    reject_if!(rows < 6 || rows % 2 == 1, "grid.2", "{rows} nodes around: an even number from 6 on is needed");
    let structure = StructureKind::DoubleDiagonal;
    let (grid, size) = ((columns, layers, rows), (spec.length, spec.radius));
    let mut lattice = generate(&LatticeSpec { structure, grid, size, gap: spec.gap, cross_over: false })?;
    let (arc, spacing) = (std::f64::consts::TAU / f64::from(rows), spec.length / f64::from(columns - 1));
    // The innermost ring has a radius of at least an eighth of the spacing.
    let rings = if spec.closed { (spec.radius / spacing - 0.125).floor().max(0.0) } else { 0.0 };
    reject_if!(
        spec.closed && !(1.0..f64::from(columns - 1)).contains(&rings),
        "grid.0",
        "{rings} rings make the bottom of the bag, but 1 to {} are possible",
        columns.saturating_sub(2)
    );
    for index in 0..lattice.layers.len() {
        let layer = lattice.layers[index];
        let (half, lift) = (0.5 * (index % 2) as f64, index as f64 * spec.gap);
        for (j, i) in (0..layer.nz).flat_map(|j| (0..layer.nx).map(move |i| (j, i))) {
            let along = (f64::from(i) + half - rings) * spacing;
            let (x, radius) = match () {
                () if !spec.closed => (along - 0.5 * spec.length, spec.radius + lift),
                // The bottom is below x = 0 by its layers, and the wall around it.
                () if along < 0.0 => (-lift, spec.radius + along),
                () => (along, spec.radius + lift),
            };
            let (sine, cosine) = ((f64::from(j) + half) * arc).sin_cos();
            lattice.positions[layer.at(i, j) as usize] = DVec3::new(x, radius * cosine, radius * sine);
        }
    }
    lattice.links.extend(seam(&lattice.layers));
    if spec.closed {
        let ring = lattice.layers[0];
        let opposite = |j: u32| LatticeSpring {
            a: ring.at(0, j),
            b: ring.at(0, j + rows / 2),
            class: SpringClass::CrossOver,
            layer: 0,
        };
        lattice.links.extend((0..rows / 2).map(opposite));
    }
    // The ends of a tube are its outline; its first and last row are not.
    for (index, layer) in lattice.layers.iter().enumerate() {
        for (j, i) in (0..layer.nz).flat_map(|j| (0..layer.nx).map(move |i| (j, i))) {
            let is_end = i + 1 == layer.nx || (i == 0 && !(spec.closed && index > 0));
            lattice.border[layer.at(i, j) as usize] = is_end;
        }
    }
    file(&lattice, structure, grid, springs)
}

/// Springs that join the last row of every layer to the first, and braces through the thickness.
fn seam(layers: &[LatticeLayer]) -> Vec<LatticeSpring> {
    let mut springs = Vec::new();
    let mut join = |(from, to): (&LatticeLayer, &LatticeLayer), di: i32, class: SpringClass, layer: usize| {
        for i in 0..from.nx {
            if let Some(k) = i.checked_add_signed(di).filter(|k| *k < to.nx) {
                let (a, b) = (from.at(i, from.nz - 1), to.at(k, 0));
                springs.push(LatticeSpring { a, b, class, layer: layer as u32 });
            }
        }
    };
    for (index, layer) in layers.iter().enumerate() {
        for (di, class) in [(0, SpringClass::Z), (1, SpringClass::Diagonal), (-1, SpringClass::AntiDiagonal)] {
            join((layer, layer), di, class, index);
        }
        // The columns of a smaller layer lie half a cell further.
        if let Some(next) = layers.get(index + 1) {
            let shift = if index % 2 == 0 { [-1, 0] } else { [0, 1] };
            for di in shift {
                join((layer, next), di, SpringClass::CrossOver, index);
            }
            for di in shift {
                join((next, layer), -di, SpringClass::CrossOver, index);
            }
        }
    }
    springs
}

/// Sheet file of a lattice whose springs are at rest.
fn file(
    lattice: &Lattice,
    structure: StructureKind,
    (nx, layers, nz): (u32, u32, u32),
    springs: &BodySprings,
) -> Result<SheetFile, InputError> {
    let node = |i: usize| SheetFileNode {
        position: lattice.positions[i],
        mass: springs.node_mass,
        layer: lattice.layer_of[i],
        border: lattice.border[i],
        ..SheetFileNode::default()
    };
    let spring = |link: &LatticeSpring| SheetFileSpring {
        kind: link.class,
        a: link.a,
        b: link.b,
        stiffness: springs.stiffness,
        rest: lattice.positions[link.a as usize].distance(lattice.positions[link.b as usize]),
    };
    let bottom = lattice.layers[0];
    let file = SheetFile {
        masses: (0..lattice.positions.len()).map(node).collect(),
        springs: lattice.links.iter().map(spring).collect(),
        corners: [bottom.at(0, 0), bottom.at(nx - 1, 0), bottom.at(0, nz - 1), bottom.at(nx - 1, nz - 1)],
        centre: bottom.at(nx / 2, nz / 2),
        dimensions: [nx, layers, nz],
        damping: springs.damping,
        structure: structure.name().to_owned(),
    };
    file.check()?;
    Ok(file)
}
