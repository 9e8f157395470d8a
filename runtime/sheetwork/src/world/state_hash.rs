//! Hash of the state of a world, to compare runs: equal bits give the same hash on any machine.

use crate::world::World;

impl World {
    /// FNV-1a hash (64 bit) of the positions and velocities of all sheets, in order.
    pub fn state_hash(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for sheet in &self.sheets {
            for axis in sheet.state.x.axes().into_iter().chain(sheet.state.v.axes()) {
                for byte in axis.iter().flat_map(|value| value.to_bits().to_le_bytes()) {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                }
            }
        }
        hash
    }
}
