//! Layout of a frame in shared memory.
//!
//! A sample is one frame of the whole world: a [`FrameHeader`], a [`SheetHeader`] for each sheet,
//! then the arrays. Each array is at an offset given by its sheet's header, in bytes from the start
//! of the sample and a multiple of 64. Offset 0 means that the array is absent. Numbers are in
//! native byte order (little endian), in SI units, temperatures in °C.
//!
//! | array | per node | unit |
//! |---|---|---|
//! | positions | 3 f32 | m |
//! | normals | 3 f32, unit vector out of the upper side | 1 |
//! | strain | f32, mean strain of the edges that meet at the node | 1 |
//! | temperature | f32 | °C |
//! | contact | u8, 1 for contact with a body in the last step | 1 |
//! | contact_force | 3 f32, mean of the last step; absent unless the game records forces | N |
//! | pin_force | 3 f32 likewise | N |
//!
//! Headers contain their own length and may grow at their end. Any other change increments
//! [`LAYOUT`]. A reader trusts no number in a sample: [`FrameView::new`] checks all of them before
//! access.

/// First bytes of every sample.
pub const MAGIC: [u8; 8] = *b"sheetlnk";
/// Version of the layout.
pub const LAYOUT: u32 = 1;
/// Units of the arrays, as in the header.
pub const UNITS: [u8; 32] = *b"m 1 1 degC 1; s; J\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
/// Alignment of the arrays, bytes.
pub const ALIGNMENT: usize = 64;
/// Maximum number of sheets in a frame.
pub const MAXIMUM_SHEETS: usize = 4096;

/// Values common to all sheets of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct FrameHeader {
    /// [`MAGIC`].
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
    /// Number of the run of the game, different after every start.
    pub epoch: u64,
    /// Number of previous frames in this epoch. A gap means missed frames.
    pub frame: u64,
    /// Number of steps taken.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Time step, s.
    pub dt: f64,
    /// Wall-clock time of the last step or tick, s.
    pub step_time: f64,
    /// Time of writing: CLOCK_MONOTONIC of the machine, ns.
    pub written_at: u64,
    /// 1 for a running game, 0 for a paused one.
    pub playing: u32,
    /// 1 for a frame with normals, strain and energies.
    pub complete: u32,
    /// Number of bodies.
    pub bodies: u32,
    /// Number of the topology in this epoch. It changes when cells open or sheets change.
    pub topology: u32,
    /// Offset of the body poses, 7 f32 each: position (m) and rotation (quaternion x, y, z, w).
    pub bodies_at: u64,
    /// [`UNITS`].
    pub units: [u8; 32],
}

/// One sheet of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SheetHeader {
    /// Name, UTF-8, padded with zeros; truncated to the size.
    pub name: [u8; 64],
    /// Name of its structure, padded with zeros.
    pub structure: [u8; 32],
    /// Nodes along the length, layers, nodes along the width.
    pub grid: [u32; 3],
    /// Number of nodes.
    pub masses: u32,
    /// 0 awake, 1 asleep, 2 unstable and frozen.
    pub status: u32,
    /// Number of nodes in contact with a body in the last step.
    pub contacts: u32,
    /// Kinetic, elastic, potential and total energy, J; NaN in an incomplete frame.
    pub energy: [f64; 4],
    /// Offset of the positions.
    pub positions: u64,
    /// Offset of the normals.
    pub normals: u64,
    /// Offset of the strain.
    pub strain: u64,
    /// Offset of the temperature.
    pub temperature: u64,
    /// Offset of the contact flags.
    pub contact: u64,
    /// Offset of the contact forces.
    pub contact_force: u64,
    /// Offset of the forces of the pins.
    pub pin_force: u64,
}

/// Fills a fixed field with a name, truncated at a character boundary.
pub(crate) fn name_field<const N: usize>(name: &str) -> [u8; N] {
    let mut field = [0; N];
    let mut end = name.len().min(N);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    field[..end].copy_from_slice(&name.as_bytes()[..end]);
    field
}

/// The name in a fixed field.
pub(crate) fn name_of(field: &[u8]) -> &str {
    let end = field.iter().position(|b| *b == 0).unwrap_or(field.len());
    std::str::from_utf8(&field[..end]).unwrap_or("?")
}

impl SheetHeader {
    /// Name of the sheet.
    pub fn name(&self) -> &str {
        name_of(&self.name)
    }

    /// Name of its structure.
    pub fn structure(&self) -> &str {
        name_of(&self.structure)
    }
}

/// Checks the first bytes and the layout of a sample.
pub(crate) fn check_origin(what: &str, is_magic: bool, layout: u32) -> Result<(), String> {
    match layout {
        _ if !is_magic => Err(format!("the sample is no {what} of Sheetwork")),
        LAYOUT => Ok(()),
        _ => Err(format!("the game writes layout {layout}, and this reader knows {LAYOUT}")),
    }
}

/// `bytes` rounded up to [`ALIGNMENT`].
pub(crate) const fn aligned(bytes: usize) -> usize {
    bytes.div_ceil(ALIGNMENT) * ALIGNMENT
}

/// A received frame: checked headers over the bytes of a sample.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    bytes: &'a [u8],
    header: FrameHeader,
}

/// A sheet of a received frame.
#[derive(Clone, Copy)]
pub struct SheetView<'a> {
    bytes: &'a [u8],
    header: SheetHeader,
}

impl<'a> FrameView<'a> {
    /// Checks a sample.
    ///
    /// # Errors
    /// A sample that is too short, has another layout, or has offsets outside itself, as a
    /// sentence.
    pub fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let header: FrameHeader = read(bytes, 0).ok_or_else(|| format!("{} bytes are no frame", bytes.len()))?;
        check_origin("frame", header.magic == MAGIC, header.layout)?;
        let (own, each) = (header.header_bytes as usize, header.sheet_bytes as usize);
        let long_enough = own >= size_of::<FrameHeader>() && each >= size_of::<SheetHeader>();
        let sheets = header.sheets as usize;
        let ends = own.saturating_add(sheets.saturating_mul(each));
        if !long_enough || sheets > MAXIMUM_SHEETS || ends > bytes.len() || header.bytes != bytes.len() as u64 {
            return Err(format!("the frame says it has {} bytes and has {}", header.bytes, bytes.len()));
        }
        let frame = Self { bytes, header };
        if header.bodies > 0 && frame.bodies().is_empty() {
            return Err("its bodies lie outside the sample".into());
        }
        for index in 0..sheets {
            let sheet = frame.sheet_at(index).ok_or("a sheet's header is cut off")?;
            sheet.check().map_err(|e| format!("sheet {index}: {e}"))?;
        }
        Ok(frame)
    }

    /// Values common to all sheets.
    pub fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// The sheets.
    pub fn sheets(&self) -> impl Iterator<Item = SheetView<'a>> + '_ {
        (0..self.header.sheets as usize).filter_map(|i| self.sheet_at(i))
    }

    /// Position (m) and rotation (quaternion x, y, z, w) of each body of the world.
    pub fn bodies(&self) -> &'a [[f32; 7]] {
        array(self.bytes, self.header.bodies_at, self.header.bodies as usize).unwrap_or_default()
    }

    /// The sheet of that name.
    pub fn sheet(&self, name: &str) -> Option<SheetView<'a>> {
        self.sheets().find(|s| s.header.name() == name)
    }

    fn sheet_at(&self, index: usize) -> Option<SheetView<'a>> {
        let at = self.header.header_bytes as usize + index * self.header.sheet_bytes as usize;
        Some(SheetView { bytes: self.bytes, header: read(self.bytes, at)? })
    }
}

impl<'a> SheetView<'a> {
    /// Header of the sheet.
    pub fn header(&self) -> &SheetHeader {
        &self.header
    }

    /// Positions, m.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.array(self.header.positions).unwrap_or_default()
    }

    /// Normals; empty in an incomplete frame.
    pub fn normals(&self) -> &'a [[f32; 3]] {
        self.array(self.header.normals).unwrap_or_default()
    }

    /// Strain; empty in an incomplete frame.
    pub fn strain(&self) -> &'a [f32] {
        self.array(self.header.strain).unwrap_or_default()
    }

    /// Temperature, °C; empty without heat.
    pub fn temperature(&self) -> &'a [f32] {
        self.array(self.header.temperature).unwrap_or_default()
    }

    /// Contact flags.
    pub fn contact(&self) -> &'a [u8] {
        self.array(self.header.contact).unwrap_or_default()
    }

    /// Contact force on each node, N; empty unless the game records forces.
    pub fn contact_force(&self) -> &'a [[f32; 3]] {
        self.array(self.header.contact_force).unwrap_or_default()
    }

    /// Force of the pins on each node, N; empty unless the game records forces.
    pub fn pin_force(&self) -> &'a [[f32; 3]] {
        self.array(self.header.pin_force).unwrap_or_default()
    }

    fn check(&self) -> Result<(), String> {
        let h = &self.header;
        let fit = [
            ("positions", self.array::<[f32; 3]>(h.positions).is_some() && h.positions != 0),
            ("normals", h.normals == 0 || self.array::<[f32; 3]>(h.normals).is_some()),
            ("strain", h.strain == 0 || self.array::<f32>(h.strain).is_some()),
            ("temperature", h.temperature == 0 || self.array::<f32>(h.temperature).is_some()),
            ("contact", h.contact == 0 || self.array::<u8>(h.contact).is_some()),
            ("contact forces", h.contact_force == 0 || self.array::<[f32; 3]>(h.contact_force).is_some()),
            ("pin forces", h.pin_force == 0 || self.array::<[f32; 3]>(h.pin_force).is_some()),
        ];
        match fit.iter().find(|f| !f.1) {
            Some((name, _)) => Err(format!("its {name} lie outside the sample")),
            None => Ok(()),
        }
    }

    /// An array of one `T` per node at `offset`.
    fn array<T: PlainData>(&self, offset: u64) -> Option<&'a [T]> {
        array(self.bytes, offset, self.header.masses as usize)
    }
}

/// `n` values of `T` at `offset`; none for offset 0, a misaligned offset, or one beyond the end.
pub(crate) fn array<T: PlainData>(bytes: &[u8], offset: u64, n: usize) -> Option<&[T]> {
    let at = usize::try_from(offset).ok()?;
    let end = at.checked_add(n.checked_mul(size_of::<T>())?)?;
    let part = bytes.get(at..end).filter(|_| at != 0)?;
    if !part.as_ptr().cast::<T>().is_aligned() {
        return None;
    }
    // SAFETY: the range is inside the sample and aligned for T, and T is valid for any bytes.
    Some(unsafe { std::slice::from_raw_parts(part.as_ptr().cast(), n) })
}

/// Types that are valid for any bytes.
///
/// # Safety
/// Only plain numbers, arrays of them, and `repr(C)` structures of those.
pub(crate) unsafe trait PlainData: Copy {}
// SAFETY: plain numbers.
unsafe impl PlainData for u8 {}
// SAFETY: plain numbers.
unsafe impl PlainData for f32 {}
// SAFETY: an array of plain numbers.
unsafe impl PlainData for [u32; 3] {}
// SAFETY: an array of plain numbers.
unsafe impl PlainData for [f32; 3] {}
// SAFETY: an array of plain numbers.
unsafe impl PlainData for [f32; 7] {}
// SAFETY: `repr(C)`, with plain numbers and arrays of them.
unsafe impl PlainData for FrameHeader {}
// SAFETY: `repr(C)`, with plain numbers and arrays of them.
unsafe impl PlainData for SheetHeader {}

/// A `T` at byte `at`, without alignment.
pub(crate) fn read<T: PlainData>(bytes: &[u8], at: usize) -> Option<T> {
    let part = bytes.get(at..at.checked_add(size_of::<T>())?)?;
    // SAFETY: the bytes exist, and T is valid for any bytes.
    Some(unsafe { part.as_ptr().cast::<T>().read_unaligned() })
}

/// The `n` numbers at `offset` for writing. Empty if they lie outside `out`, which a valid plan
/// rules out.
pub(crate) fn slice_mut<T: PlainData>(out: &mut [u8], offset: u64, n: usize) -> &mut [T] {
    let at = offset as usize;
    let Some(part) = out.get_mut(at..at + n * size_of::<T>()) else { return &mut [] };
    if !part.as_ptr().cast::<T>().is_aligned() {
        return &mut [];
    }
    // SAFETY: inside `out`, aligned, and T is valid for any bytes.
    unsafe { std::slice::from_raw_parts_mut(part.as_mut_ptr().cast(), n) }
}

/// Copies a header to byte `at`.
pub(crate) fn write_header<T: PlainData>(out: &mut [u8], at: usize, value: T) {
    if let Some(part) = out.get_mut(at..at + size_of::<T>()) {
        // SAFETY: the range has the size of T, and T has plain numbers only.
        unsafe { part.as_mut_ptr().cast::<T>().write_unaligned(value) };
    }
}
