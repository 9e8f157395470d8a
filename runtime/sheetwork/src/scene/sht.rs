//! Sheet files (.SHT, thesis 4.4.1): nodes, springs and layout of a sheet as text, one record a
//! line.
//!
//! ```text
//! # a comment
//! M ax ay az px py pz fx fy fz vx vy vz mass layer border     a node
//! S kind a b stiffness rest                                   a spring between nodes a and b
//! K index                                                     five: bottom corners, centre node
//! *                                                           ends the lists
//! D nx layers nz                                              dimensions of the grid
//! C damping                                                   damping of the springs, percent
//! T name                                                      structure
//! ```
//!
//! Records come in this order. Nodes are counted from 0 in the order of the file: layer by layer
//! from the bottom, row by row (z), along x. The file has the units of the thesis: cm, cm/s, cm/s²,
//! 1e-3 N, 1e-3 N/m, 1e-4 kg; the program uses SI. The order of the columns is defined here, since
//! the thesis prints no file.

pub(crate) mod reader;
mod tube;

use std::path::Path;

use glam::DVec3;

pub use crate::scene::sht::reader::read_sht;
pub use crate::scene::sht::tube::{BodySprings, TubeSpec, prism, tube};

use crate::error::{InputError, check_range, reject_if};
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{MAX_NODES, StructureKind};
use crate::scene::record_lines::{RecordColumn, decimal, read_file};

/// Maximum number of springs of a sheet.
const MAX_SPRINGS: u64 = 32 * MAX_NODES;

/// Numeric columns of a node, in the order of the file.
const MASS: [RecordColumn; 13] = [
    component("M.ax", ("cm/s²", "m/s²", -2), 1e12),
    component("M.ay", ("cm/s²", "m/s²", -2), 1e12),
    component("M.az", ("cm/s²", "m/s²", -2), 1e12),
    component("M.px", ("cm", "m", -2), 1e4),
    component("M.py", ("cm", "m", -2), 1e4),
    component("M.pz", ("cm", "m", -2), 1e4),
    component("M.fx", ("1e-3 N", "N", -3), 1e6),
    component("M.fy", ("1e-3 N", "N", -3), 1e6),
    component("M.fz", ("1e-3 N", "N", -3), 1e6),
    component("M.vx", ("cm/s", "m/s", -2), 1e6),
    component("M.vy", ("cm/s", "m/s", -2), 1e6),
    component("M.vz", ("cm/s", "m/s", -2), 1e6),
    RecordColumn { name: "M.mass", unit: "1e-4 kg", si_unit: "kg", shift: -4, min: 1e-12, max: 1e6 },
];
const MASS_FIELDS: &str = "ax ay az px py pz fx fy fz vx vy vz mass layer border";
const STIFFNESS: RecordColumn =
    RecordColumn { name: "S.stiffness", unit: "1e-3 N/m", si_unit: "N/m", shift: -3, min: 0.0, max: 1e12 };
const REST: RecordColumn = RecordColumn { name: "S.rest", unit: "cm", si_unit: "m", shift: -2, min: 1e-12, max: 1e4 };
const DAMPING: RecordColumn =
    RecordColumn { name: "C.damping", unit: "%", si_unit: "", shift: -2, min: 0.0, max: 10.0 };

/// Column of a component of a vector, each within ±`most` in SI.
const fn component(
    name: &'static str,
    (unit, si_unit, shift): (&'static str, &'static str, i32),
    most: f64,
) -> RecordColumn {
    RecordColumn { name, unit, si_unit, shift, min: -most, max: most }
}

/// Content of a sheet file: state, springs and layout, all SI.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetFile {
    /// Nodes, layer by layer from the bottom, row by row (z), along x.
    pub masses: Vec<SheetFileNode>,
    /// Springs.
    pub springs: Vec<SheetFileSpring>,
    /// Corner nodes of the bottom layer: (-x, -z), (+x, -z), (-x, +z), (+x, +z).
    pub corners: [u32; 4],
    /// Node of the bottom layer nearest to its middle.
    pub centre: u32,
    /// Nodes along x (2 or more), layers (1 or more), nodes along z (2 or more); every other layer
    /// is one smaller in x and z.
    pub dimensions: [u32; 3],
    /// Dashpot of the springs as a fraction of critical damping, 0 to 10.
    pub damping: f64,
    /// Name of the structure, as in the table of [`crate::mesh::structure`].
    pub structure: String,
}

/// Node of a sheet file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetFileNode {
    /// Acceleration, m/s²; each component within ±1e12.
    pub acceleration: DVec3,
    /// Position, m; each component within ±1e4.
    pub position: DVec3,
    /// Applied force, N; each component within ±1e6.
    pub force: DVec3,
    /// Velocity, m/s; each component within ±1e6.
    pub velocity: DVec3,
    /// Mass, kg, 1e-12 to 1e6.
    pub mass: f64,
    /// Layer, 0 the bottom one.
    pub layer: u32,
    /// Whether the node lies on the outline of its layer.
    pub border: bool,
}

/// Spring of a sheet file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetFileSpring {
    /// Spring class.
    pub kind: SpringClass,
    /// First node.
    pub a: u32,
    /// Second node, different from the first.
    pub b: u32,
    /// Stiffness, N/m, 0 to 1e12.
    pub stiffness: f64,
    /// Rest length, m, 1e-12 to 1e4.
    pub rest: f64,
}

impl SheetFileNode {
    /// Values in the order of [`MASS`].
    fn numbers(&self) -> [f64; 13] {
        let (a, p, f, v) = (self.acceleration, self.position, self.force, self.velocity);
        [a.x, a.y, a.z, p.x, p.y, p.z, f.x, f.y, f.z, v.x, v.y, v.z, self.mass]
    }

    /// Node with these values in the order of [`MASS`].
    fn from_numbers(numbers: [f64; 13], layer: u32, border: bool) -> Self {
        let [ax, ay, az, px, py, pz, fx, fy, fz, vx, vy, vz, mass] = numbers;
        Self {
            acceleration: DVec3::new(ax, ay, az),
            position: DVec3::new(px, py, pz),
            force: DVec3::new(fx, fy, fz),
            velocity: DVec3::new(vx, vy, vz),
            mass,
            layer,
            border,
        }
    }
}

impl SheetFile {
    /// Check whether a file of this sheet can be read: values in range, springs, corners and centre
    /// on existing nodes, numbers of nodes per layer consistent with the dimensions, a known
    /// structure.
    ///
    /// # Errors
    /// The first defect; its field is `masses.N.px`, `springs.N.rest`, `corners.N`, `centre`,
    /// `dimensions`, `damping` or `structure`.
    pub fn check(&self) -> Result<(), InputError> {
        let mut layers = LayerCounts::default();
        for (index, mass) in self.masses.iter().enumerate() {
            for (column, value) in MASS.iter().zip(mass.numbers()) {
                column.check(|| format!("masses.{index}.{}", column.short()), value)?;
            }
            let of_layer = |problem| InputError::new(format!("masses.{index}.layer"), problem);
            layers.add(mass.layer).map_err(of_layer)?;
        }
        check_range("masses", self.masses.len() as f64, 4.0, MAX_NODES as f64, "masses")?;
        check_range("springs", self.springs.len() as f64, 0.0, MAX_SPRINGS as f64, "springs")?;
        let masses = self.masses.len();
        for (index, spring) in self.springs.iter().enumerate() {
            STIFFNESS.check(|| format!("springs.{index}.stiffness"), spring.stiffness)?;
            REST.check(|| format!("springs.{index}.rest"), spring.rest)?;
            let (a, b, field) = (spring.a, spring.b, format!("springs.{index}"));
            let is_wrong = a == b || a.max(b) as usize >= masses;
            reject_if!(is_wrong, field, "joins {a} to {b}: two different masses of {masses} are needed");
        }
        let marks = self.marks();
        for (index, mark) in marks.iter().enumerate() {
            let field = if index < 4 { format!("corners.{index}") } else { "centre".to_owned() };
            layers.check_mark(*mark, &marks[..index]).map_err(|problem| InputError::new(field, problem))?;
        }
        layers.check_dimensions(self.dimensions).map_err(|problem| InputError::new("dimensions", problem))?;
        DAMPING.check(|| "damping".to_owned(), self.damping)?;
        self.structure.parse::<StructureKind>().map(drop)
    }

    /// Corners and centre.
    fn marks(&self) -> [u32; 5] {
        let [a, b, c, d] = self.corners;
        [a, b, c, d, self.centre]
    }
}

/// Number of nodes in each layer, bottom first.
#[derive(Default)]
struct LayerCounts {
    counts: Vec<u64>,
}

impl LayerCounts {
    /// Count a node of this layer, which must be that of the last node or the next.
    fn add(&mut self, layer: u32) -> Result<(), String> {
        let next = self.counts.len();
        match self.counts.get_mut(layer as usize) {
            Some(count) if layer as usize + 1 == next => *count += 1,
            None if layer as usize == next => self.counts.push(1),
            _ if next == 0 => return Err(format!("{layer} of the first mass must be 0")),
            _ => return Err(format!("{layer} follows {}: masses come layer by layer from 0", next - 1)),
        }
        Ok(())
    }

    /// Check that a corner or centre is a node of the bottom layer and that corners differ.
    /// `others` are the corners before it.
    fn check_mark(&self, mark: u32, others: &[u32]) -> Result<(), String> {
        let bottom = self.counts.first().copied().unwrap_or(0);
        if u64::from(mark) >= bottom {
            return Err(format!("mass {mark} is not in the bottom layer, which has {bottom} masses"));
        }
        // The centre may be a corner: a sheet of 2 x 2 has no other node.
        if others.len() < 4 && others.contains(&mark) {
            return Err(format!("mass {mark} is a corner already: the four corners must differ"));
        }
        Ok(())
    }

    /// Check that layers alternate between nx·nz and (nx-1)·(nz-1) nodes.
    fn check_dimensions(&self, [nx, layers, nz]: [u32; 3]) -> Result<(), String> {
        let size = format!("{nx} x {layers} x {nz}");
        if nx < 2 || nz < 2 || layers < 1 {
            return Err(format!("{size}: at least 2 x 1 x 2 masses are needed"));
        }
        if u64::from(layers) != self.counts.len() as u64 {
            return Err(format!("{size} contradicts the masses, which are in {} layers", self.counts.len()));
        }
        for (layer, found) in self.counts.iter().enumerate() {
            let less = (layer % 2) as u32;
            let expected = u64::from(nx - less) * u64::from(nz - less);
            if *found != expected {
                return Err(format!("{size} has {expected} masses in layer {layer}, but {found} are there"));
            }
        }
        Ok(())
    }
}

/// Read a .SHT file.
///
/// # Errors
/// Those of [`read_sht`], and when the file cannot be read.
pub fn read_sht_file(path: &Path) -> Result<SheetFile, InputError> {
    read_file(path, read_sht)
}

/// Text of a sheet as .SHT. Reading it gives the same sheet bit for bit if [`SheetFile::check`]
/// accepts it.
pub fn write_sht(sheet: &SheetFile) -> String {
    let mut text = format!("# M {MASS_FIELDS} (cm, cm/s, cm/s2, 1e-3 N, 1e-4 kg)\n");
    for mass in &sheet.masses {
        text.push('M');
        for (column, value) in MASS.iter().zip(mass.numbers()) {
            text.push(' ');
            text.push_str(&decimal(value, column.shift));
        }
        text.push_str(&format!(" {} {}\n", mass.layer, u8::from(mass.border)));
    }
    text.push_str("# S kind a b stiffness (1e-3 N/m) rest (cm)\n");
    for spring in &sheet.springs {
        let (stiffness, rest) = (decimal(spring.stiffness, STIFFNESS.shift), decimal(spring.rest, REST.shift));
        text.push_str(&format!("S {} {} {} {stiffness} {rest}\n", spring.kind.name(), spring.a, spring.b));
    }
    text.push_str("# K corners -x-z, +x-z, -x+z, +x+z, then the centre; D nx layers nz; C damping (%); T structure\n");
    for mark in sheet.marks() {
        text.push_str(&format!("K {mark}\n"));
    }
    let [nx, layers, nz] = sheet.dimensions;
    let damping = decimal(sheet.damping, DAMPING.shift);
    text.push_str(&format!("*\nD {nx} {layers} {nz}\nC {damping}\nT {}\n", sheet.structure));
    text
}

/// Write a .SHT file.
///
/// # Errors
/// When [`SheetFile::check`] rejects the sheet, and when the file cannot be written. A file that
/// could not be read again is not written.
pub fn write_sht_file(path: &Path, sheet: &SheetFile) -> Result<(), InputError> {
    sheet.check().map_err(|error| error.in_file(path))?;
    std::fs::write(path, write_sht(sheet)).map_err(|error| InputError::io(path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::record_lines::damage;

    /// Sheet of 2 x 2 x 2, five nodes in 17 lines.
    pub(crate) const SMALL: &str = "M 0 0 0 0 0 0 0 0 0 0 0 0 4 0 1\n\
        M 0 -98.1 0 1.15 0 0 0 0 0 0 0 0 4 0 1\n\
        M 0 0 0 0 0 1.15 0 -3.9 0 0 0 0 4 0 1\n\
        M 0 0 0 1.15 0 1.15 0 0 0 0 7 0 4 0 1\n\
        M 0 0 0 0.575 0.1 0.575 0 0 0 0 0 0 0.5 1 1\n\
        S x 0 1 185 1.15\n\
        S z 0 2 185 1.15\n\
        S inter 4 0 60.5 0.8193\n\
        K 0\nK 1\nK 2\nK 3\nK 0\n\
        *\nD 2 2 2\nC 11.5\nT samm\n";

    #[test]
    fn the_thesis_units_become_si() {
        let sheet = read_sht(SMALL).expect("good");
        assert_eq!(sheet.masses.len(), 5);
        assert_eq!(sheet.masses[1].acceleration, DVec3::new(0.0, -0.981, 0.0));
        assert_eq!(sheet.masses[1].position, DVec3::new(0.0115, 0.0, 0.0));
        assert_eq!(sheet.masses[2].force, DVec3::new(0.0, -0.0039, 0.0));
        assert_eq!(sheet.masses[3].velocity, DVec3::new(0.0, 0.07, 0.0));
        assert_eq!((sheet.masses[3].mass, sheet.masses[4].mass), (4e-4, 5e-5));
        assert_eq!((sheet.masses[4].layer, sheet.masses[4].border), (1, true));
        let inter = SheetFileSpring { kind: SpringClass::Inter, a: 4, b: 0, stiffness: 0.0605, rest: 0.008193 };
        assert_eq!(sheet.springs[2], inter);
        assert_eq!((sheet.corners, sheet.centre, sheet.dimensions), ([0, 1, 2, 3], 0, [2, 2, 2]));
        assert_eq!((sheet.damping, sheet.structure.as_str()), (0.115, "samm"));
        assert_eq!(sheet.check(), Ok(()));
        assert_eq!(read_sht(&SMALL.replace('\n', "\r\n")), Ok(sheet));
    }

    #[test]
    fn round_trips_are_exact() {
        let mut sheet = read_sht(SMALL).expect("good");
        let mut dice = damage::RandomBytes(7);
        for mass in &mut sheet.masses {
            let mut numbers = mass.numbers();
            for number in &mut numbers {
                *number = (dice.below(1 << 50) as f64 + 1.0) / 3.0_f64.powi(30 + dice.below(9) as i32);
            }
            *mass = SheetFileNode::from_numbers(numbers, mass.layer, mass.border);
            mass.velocity.z = -0.0;
        }
        for (spring, kind) in sheet.springs.iter_mut().zip(SpringClass::ALL.into_iter().rev()) {
            (spring.kind, spring.stiffness, spring.rest) = (kind, 1.0 / 3.0, 2.0 / 3.0);
        }
        sheet.damping = 0.1 + 0.2;
        assert_eq!(sheet.check(), Ok(()));
        let text = write_sht(&sheet);
        let back = read_sht(&text).expect("ours");
        assert_eq!(back, sheet);
        for (a, b) in back.masses.iter().zip(&sheet.masses) {
            assert_eq!(a.numbers().map(f64::to_bits), b.numbers().map(f64::to_bits));
        }
        assert_eq!(write_sht(&back), text);
    }

    #[test]
    fn sheets_made_by_program_are_checked_before_they_are_written() {
        let path = std::env::temp_dir().join(format!("sheetwork-sht-{}.sht", std::process::id()));
        let good = read_sht(SMALL).expect("good");
        let refused = |spoil: fn(&mut SheetFile)| {
            let mut sheet = good.clone();
            spoil(&mut sheet);
            let error = write_sht_file(&path, &sheet).expect_err("spoilt");
            assert!(!path.exists() && error.file.is_some());
            error.field
        };
        assert_eq!(refused(|s| s.masses[2].position.y = f64::NAN), "masses.2.py");
        assert_eq!(refused(|s| s.masses[2].layer = 1), "masses.3.layer");
        assert_eq!(refused(|s| s.masses.clear()), "masses");
        assert_eq!(refused(|s| s.springs[1].rest = 0.0), "springs.1.rest");
        assert_eq!(refused(|s| s.springs[1].b = 5), "springs.1");
        assert_eq!(refused(|s| s.corners[3] = 4), "corners.3");
        assert_eq!(refused(|s| s.corners[3] = 0), "corners.3");
        assert_eq!(refused(|s| s.centre = 9), "centre");
        assert_eq!(refused(|s| s.dimensions = [2, 2, u32::MAX]), "dimensions");
        assert_eq!(refused(|s| s.damping = 11.0), "damping");
        assert_eq!(refused(|s| s.structure = "a b".into()), "structure");
        write_sht_file(&path, &good).expect("written");
        let read = read_sht_file(&path);
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(read, Ok(good));
    }
}
