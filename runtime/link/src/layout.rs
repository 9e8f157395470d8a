//! Layout of a frame in shared memory: what the game writes and every reader checks.
//!
//! A sample is one frame of the whole world: a [`FrameHeader`], a [`SheetHeader`] for each sheet, then the arrays, each at an
//! offset that its sheet's header gives, in bytes from the start of the sample and a multiple of 64. Offset 0 is an array that
//! is not there. Numbers are little endian, as the machine has them; positions and all else are SI, temperatures °C.
//!
//! | array | of each mass | unit |
//! |---|---|---|
//! | positions | 3 f32 | m |
//! | normals | 3 f32, unit vector out of the upper side | 1 |
//! | strain | f32, mean strain of the edges that meet at it | 1 |
//! | temperature | f32 | °C |
//! | contact | u8, 1 where it touched a body in the last step | 1 |
//!
//! The headers only grow at their end, and say how long they are; anything else that changes makes another [`LAYOUT`]. A
//! reader trusts no number in a sample: [`FrameView::new`] checks all of them before anything is read.

/// First bytes of every sample.
pub const MAGIC: [u8; 8] = *b"sheetlnk";
/// Version of the layout.
pub const LAYOUT: u32 = 1;
/// Units of the arrays, as the header says them.
pub const UNITS: [u8; 32] = *b"m 1 1 degC 1; s; J\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
/// Arrays begin at multiples of this, bytes.
pub const ALIGNMENT: usize = 64;
/// Most sheets in a frame.
pub const MOST_SHEETS: usize = 4096;

/// What is common to all sheets of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct FrameHeader {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`LAYOUT`].
    pub layout: u32,
    /// Bytes of this header.
    pub header_bytes: u32,
    /// Bytes of each sheet's header.
    pub sheet_bytes: u32,
    /// Number of sheets.
    pub sheets: u32,
    /// Bytes of the sample.
    pub bytes: u64,
    /// Number of the run of the game that wrote it: another after every start.
    pub epoch: u64,
    /// Frames written in this epoch before this one; a gap is frames that were missed.
    pub frame: u64,
    /// Steps the world has taken.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Engine's step, s.
    pub dt: f64,
    /// Wall-clock time of the last step or tick, s.
    pub step_time: f64,
    /// When it was written: CLOCK_MONOTONIC of the machine, ns.
    pub written_at: u64,
    /// 1 where the game plays, 0 where it is paused.
    pub playing: u32,
    /// 1 where normals, strain and energies are in it.
    pub complete: u32,
    /// Number of bodies.
    pub bodies: u32,
    /// Which topology of this epoch the sheets have: another number where triangles have opened or sheets are others.
    pub topology: u32,
    /// Where the bodies are: of each 7 f32, its position (m) and its rotation (quaternion x, y, z, w).
    pub bodies_at: u64,
    /// [`UNITS`].
    pub units: [u8; 32],
}

/// One sheet of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SheetHeader {
    /// Name, UTF-8, filled with zeros; cut where it is longer.
    pub name: [u8; 64],
    /// Name of its structure, filled with zeros.
    pub structure: [u8; 32],
    /// Masses along the length, layers, masses along the width.
    pub grid: [u32; 3],
    /// Number of masses.
    pub masses: u32,
    /// 0 awake, 1 asleep, 2 unstable and stopped.
    pub status: u32,
    /// Masses that touched a body in the last step.
    pub contacts: u32,
    /// Kinetic, elastic, gravity's and total energy, J; NaN where the frame is not complete.
    pub energy: [f64; 4],
    /// Where the positions are.
    pub positions: u64,
    /// Where the normals are.
    pub normals: u64,
    /// Where the strain is.
    pub strain: u64,
    /// Where the temperature is.
    pub temperature: u64,
    /// Where the contact flags are.
    pub contact: u64,
}

/// Fills a fixed field with a name, cut at a character.
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
    /// Its name.
    pub fn name(&self) -> &str {
        name_of(&self.name)
    }

    /// Its structure's name.
    pub fn structure(&self) -> &str {
        name_of(&self.structure)
    }
}

/// `bytes` rounded up to [`ALIGNMENT`].
pub(crate) const fn aligned(bytes: usize) -> usize {
    bytes.div_ceil(ALIGNMENT) * ALIGNMENT
}

/// A frame that was read: checked headers over the bytes of a sample.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    bytes: &'a [u8],
    header: FrameHeader,
}

/// A sheet of a frame that was read.
#[derive(Clone, Copy)]
pub struct SheetView<'a> {
    bytes: &'a [u8],
    header: SheetHeader,
}

impl<'a> FrameView<'a> {
    /// Looks at a sample; a sentence about what is wrong with it where it cannot be read.
    ///
    /// # Errors
    /// When it is too short, of another layout, or names places outside itself.
    pub fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let header: FrameHeader = read(bytes, 0).ok_or_else(|| format!("{} bytes are no frame", bytes.len()))?;
        if header.magic != MAGIC {
            return Err("the sample is no frame of Sheetwork".into());
        }
        if header.layout != LAYOUT {
            return Err(format!("the game writes layout {}, and this reader knows {LAYOUT}", header.layout));
        }
        let (own, each) = (header.header_bytes as usize, header.sheet_bytes as usize);
        let long_enough = own >= size_of::<FrameHeader>() && each >= size_of::<SheetHeader>();
        let sheets = header.sheets as usize;
        let ends = own.saturating_add(sheets.saturating_mul(each));
        if !long_enough || sheets > MOST_SHEETS || ends > bytes.len() || header.bytes != bytes.len() as u64 {
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

    /// What is common to all sheets.
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
    /// What it is and how it fares.
    pub fn header(&self) -> &SheetHeader {
        &self.header
    }

    /// Positions, m.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.array(self.header.positions).unwrap_or_default()
    }

    /// Normals; empty where the frame is not complete.
    pub fn normals(&self) -> &'a [[f32; 3]] {
        self.array(self.header.normals).unwrap_or_default()
    }

    /// Strain; empty where the frame is not complete.
    pub fn strain(&self) -> &'a [f32] {
        self.array(self.header.strain).unwrap_or_default()
    }

    /// Temperature, °C; empty where nothing heats.
    pub fn temperature(&self) -> &'a [f32] {
        self.array(self.header.temperature).unwrap_or_default()
    }

    /// Contact flags.
    pub fn contact(&self) -> &'a [u8] {
        self.array(self.header.contact).unwrap_or_default()
    }

    fn check(&self) -> Result<(), String> {
        let h = &self.header;
        let fit = [
            ("positions", self.array::<[f32; 3]>(h.positions).is_some() && h.positions != 0),
            ("normals", h.normals == 0 || self.array::<[f32; 3]>(h.normals).is_some()),
            ("strain", h.strain == 0 || self.array::<f32>(h.strain).is_some()),
            ("temperature", h.temperature == 0 || self.array::<f32>(h.temperature).is_some()),
            ("contact", h.contact == 0 || self.array::<u8>(h.contact).is_some()),
        ];
        match fit.iter().find(|f| !f.1) {
            Some((name, _)) => Err(format!("its {name} lie outside the sample")),
            None => Ok(()),
        }
    }

    /// As many `T` as there are masses at `offset`.
    fn array<T: Plain>(&self, offset: u64) -> Option<&'a [T]> {
        array(self.bytes, offset, self.header.masses as usize)
    }
}

/// `n` of `T` at `offset`; none where that is 0, not aligned or beyond the end.
pub(crate) fn array<T: Plain>(bytes: &[u8], offset: u64, n: usize) -> Option<&[T]> {
    let at = usize::try_from(offset).ok()?;
    let end = at.checked_add(n.checked_mul(size_of::<T>())?)?;
    let part = bytes.get(at..end).filter(|_| at != 0)?;
    if !part.as_ptr().cast::<T>().is_aligned() {
        return None;
    }
    // SAFETY: the range is inside the sample, aligned for T, and any bytes make a T.
    Some(unsafe { std::slice::from_raw_parts(part.as_ptr().cast(), n) })
}

/// Types that any bytes make.
///
/// # Safety
/// Only plain numbers, arrays of them, and `repr(C)` structures of those.
pub(crate) unsafe trait Plain: Copy {}
// SAFETY: plain numbers.
unsafe impl Plain for u8 {}
// SAFETY: plain numbers.
unsafe impl Plain for f32 {}
// SAFETY: an array of plain numbers.
unsafe impl Plain for [u32; 3] {}
// SAFETY: an array of plain numbers.
unsafe impl Plain for [f32; 3] {}
// SAFETY: an array of plain numbers.
unsafe impl Plain for [f32; 7] {}
// SAFETY: `repr(C)`, of plain numbers and arrays of them.
unsafe impl Plain for FrameHeader {}
// SAFETY: `repr(C)`, of plain numbers and arrays of them.
unsafe impl Plain for SheetHeader {}

/// A `T` at byte `at`, wherever that is aligned.
pub(crate) fn read<T: Plain>(bytes: &[u8], at: usize) -> Option<T> {
    let part = bytes.get(at..at.checked_add(size_of::<T>())?)?;
    // SAFETY: the bytes are there, and any bytes make a T.
    Some(unsafe { part.as_ptr().cast::<T>().read_unaligned() })
}

/// The `n` numbers at `offset`, to be written; none where they do not lie in `out`, which a plan that fits never has.
pub(crate) fn take<T: Plain>(out: &mut [u8], offset: u64, n: usize) -> &mut [T] {
    let at = offset as usize;
    let Some(part) = out.get_mut(at..at + n * size_of::<T>()) else { return &mut [] };
    if !part.as_ptr().cast::<T>().is_aligned() {
        return &mut [];
    }
    // SAFETY: inside `out`, aligned, and any bytes make a T.
    unsafe { std::slice::from_raw_parts_mut(part.as_mut_ptr().cast(), n) }
}

/// Copies a header to byte `at`.
pub(crate) fn put<T: Plain>(out: &mut [u8], at: usize, value: T) {
    if let Some(part) = out.get_mut(at..at + size_of::<T>()) {
        // SAFETY: as many bytes as a T has; T is made of plain numbers.
        unsafe { part.as_mut_ptr().cast::<T>().write_unaligned(value) };
    }
}
