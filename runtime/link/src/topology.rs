//! Triangles of sheets for drawing, sent after changes.
//!
//! A sample of the stream `topology` is a [`TopologyHeader`], a [`SheetTopology`] for each sheet of
//! a frame, in the same order, then arrays as in a frame. Frames name the `version` of their
//! topology in their headers. The service keeps the last sample for readers that attach later. A
//! fractured sheet has fewer triangles and the same nodes.

use crate::layout::{
    ALIGNMENT, LAYOUT, MAXIMUM_SHEETS, PlainData, aligned, array, check_origin, name_field, name_of, read, slice_mut,
    write_header,
};
use crate::plan::FramePlan;
use sheetwork::World;

/// First bytes of every sample of topology.
pub const TOPOLOGY_MAGIC: [u8; 8] = *b"sheettop";

/// Values common to all sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct TopologyHeader {
    /// [`TOPOLOGY_MAGIC`].
    pub magic: [u8; 8],
    /// [`LAYOUT`].
    pub layout: u32,
    /// Size of this header, bytes.
    pub header_bytes: u32,
    /// Size of each sheet's header, bytes.
    pub sheet_bytes: u32,
    /// Number of sheets.
    pub sheets: u32,
    /// Size of the sample, bytes.
    pub bytes: u64,
    /// Number of the run of the game.
    pub epoch: u64,
    /// Number of the topology in this epoch, from 1.
    pub version: u32,
    /// Reserved: 0.
    pub reserved: u32,
}

/// One sheet's topology.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SheetTopology {
    /// Name, UTF-8, padded with zeros; truncated to the size.
    pub name: [u8; 64],
    /// Number of nodes.
    pub masses: u32,
    /// Number of triangles.
    pub triangles: u32,
    /// Offset of the triangles, 3 u32 each: node indices, counter-clockwise seen from the upper
    /// side.
    pub triangles_at: u64,
    /// Cells along length and width of a sheet with fracture or slits.
    pub cells: [u32; 2],
    /// Offset of the cells, one u8 each, 1 for an open cell, along the length first; 0 for a sheet
    /// without open cells.
    pub cells_at: u64,
}

// SAFETY: `repr(C)`, with plain numbers and arrays of them, without gaps.
unsafe impl PlainData for TopologyHeader {}
// SAFETY: `repr(C)`, with plain numbers and arrays of them, without gaps.
unsafe impl PlainData for SheetTopology {}

/// Triangles of a sheet, as received.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SheetMesh {
    /// Name of the sheet, truncated to 64 bytes.
    pub name: String,
    /// Number of nodes.
    pub masses: usize,
    /// Triangles of the closed cells of all layers, counter-clockwise seen from the upper side.
    pub triangles: Vec<[u32; 3]>,
    /// Cells along length and width of a sheet with fracture or slits; zero otherwise.
    pub cells: (usize, usize),
    /// Whether each cell is open.
    pub open: Vec<bool>,
}

/// Topology of all sheets, as received.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meshes {
    /// Number of the run of the game; 0 before the first sample.
    pub epoch: u64,
    /// Version of the topology in that run.
    pub version: u32,
    /// Topology of each sheet, in the order of the frames.
    pub sheets: Vec<SheetMesh>,
}

/// Size (bytes) of a sample for sheets with these numbers of triangles and cells.
fn size(sheets: impl Iterator<Item = (usize, usize)> + Clone) -> usize {
    let heads = size_of::<TopologyHeader>() + sheets.clone().count() * size_of::<SheetTopology>();
    let arrays = sheets.map(|(triangles, cells)| aligned(triangles * size_of::<[u32; 3]>()) + aligned(cells));
    aligned(heads) + arrays.sum::<usize>()
}

/// Size (bytes) of the sample of `plan`'s sheets in their present state.
pub fn bytes(plan: &FramePlan) -> usize {
    size(plan.sheets.iter().map(|s| (s.triangles.len(), s.cells.0 * s.cells.1)))
}

/// Maximum size (bytes) of a sample of these sheets: without open cells.
pub fn sample_capacity(plan: &FramePlan) -> usize {
    size(plan.largest())
}

/// Writes the topology of `world` to `out`, which is [`bytes`] long and aligned.
pub fn write(plan: &FramePlan, world: &World, (epoch, version): (u64, u32), out: &mut [u8]) {
    let header = TopologyHeader {
        magic: TOPOLOGY_MAGIC,
        layout: LAYOUT,
        header_bytes: size_of::<TopologyHeader>() as u32,
        sheet_bytes: size_of::<SheetTopology>() as u32,
        sheets: plan.sheets.len() as u32,
        bytes: out.len() as u64,
        epoch,
        version,
        reserved: 0,
    };
    write_header(out, 0, header);
    let mut end = aligned(size_of::<TopologyHeader>() + plan.sheets.len() * size_of::<SheetTopology>());
    for (index, (plan, sheet)) in plan.sheets.iter().zip(world.sheets()).enumerate() {
        let cells = sheet.open_cells().unwrap_or_default();
        let mut head = SheetTopology {
            name: name_field(&sheet.name),
            masses: sheet.node_count() as u32,
            triangles: plan.triangles.len() as u32,
            triangles_at: end as u64,
            cells: [plan.cells.0 as u32, plan.cells.1 as u32],
            cells_at: 0,
        };
        slice_mut::<[u32; 3]>(out, head.triangles_at, plan.triangles.len()).copy_from_slice(&plan.triangles);
        end += aligned(size_of_val(plan.triangles.as_slice()));
        if !cells.is_empty() {
            head.cells_at = end as u64;
            let flags = slice_mut::<u8>(out, head.cells_at, cells.len()).iter_mut();
            flags.zip(cells).for_each(|(flag, open)| *flag = u8::from(*open));
            end += aligned(cells.len());
        }
        write_header(out, size_of::<TopologyHeader>() + index * size_of::<SheetTopology>(), head);
    }
}

impl Meshes {
    /// Reads a sample and checks every number in it.
    ///
    /// # Errors
    /// A sample that is too short, has another layout, or has offsets or node indices out of range,
    /// as a sentence.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let header: TopologyHeader = read(bytes, 0).ok_or_else(|| format!("{} bytes are no topology", bytes.len()))?;
        check_origin("topology", header.magic == TOPOLOGY_MAGIC, header.layout)?;
        let (own, each) = (header.header_bytes as usize, header.sheet_bytes as usize);
        let sheets = header.sheets as usize;
        let long_enough = own >= size_of::<TopologyHeader>() && each >= size_of::<SheetTopology>();
        if !long_enough || sheets > MAXIMUM_SHEETS || header.bytes != bytes.len() as u64 {
            return Err(format!("the topology says it has {} bytes and has {}", header.bytes, bytes.len()));
        }
        let mesh = |index: usize| {
            let head = index.checked_mul(each).and_then(|at| read::<SheetTopology>(bytes, at.checked_add(own)?));
            let head = head.ok_or_else(|| format!("the header of sheet {index} is cut off"))?;
            SheetMesh::read(bytes, &head).map_err(|e| format!("sheet {index}: {e}"))
        };
        let sheets = (0..sheets).map(mesh).collect::<Result<_, String>>()?;
        Ok(Self { epoch: header.epoch, version: header.version, sheets })
    }
}

impl SheetMesh {
    fn read(bytes: &[u8], head: &SheetTopology) -> Result<Self, String> {
        let triangles = match head.triangles {
            0 => &[],
            n => {
                array::<[u32; 3]>(bytes, head.triangles_at, n as usize).ok_or("its triangles lie outside the sample")?
            }
        };
        if triangles.iter().flatten().any(|mass| *mass >= head.masses) {
            return Err(format!("a triangle is of a mass beyond its {}", head.masses));
        }
        let mut cells = (0, 0);
        let mut open = Vec::new();
        if head.cells_at != 0 {
            cells = (head.cells[0] as usize, head.cells[1] as usize);
            let flags = cells.0.checked_mul(cells.1).and_then(|n| array::<u8>(bytes, head.cells_at, n));
            open = flags.ok_or("its cells lie outside the sample")?.iter().map(|flag| *flag != 0).collect();
        }
        let name = name_of(&head.name).to_owned();
        Ok(Self { name, masses: head.masses as usize, triangles: triangles.to_vec(), cells, open })
    }
}

const _: () = assert!(size_of::<TopologyHeader>() == 48 && size_of::<SheetTopology>() == 96 && ALIGNMENT == 64);
