//! Serialisation of the membrane of a grid.
//!
//! An edge shared by two cells has one strain in both, bit for bit, and so one strain rate, which
//! is serialised once.

use crate::elements::grid_membrane::{CellMembrane, LANES};
use crate::serialize::{ReadResult, StateReader, StateWriter};

impl CellMembrane {
    /// Calls `visit` for every strain rate with its packet, component and lane, and with the
    /// indices of the equal rate in a cell visited before, if there is one.
    fn for_each_rate(&self, mut visit: impl FnMut((usize, usize, usize), Option<(usize, usize, usize)>)) {
        let across = (self.cell.row.saturating_sub(1)).div_ceil(LANES);
        for (index, p) in self.packets.iter().enumerate() {
            for k in 0..5 {
                for l in 0..p.count {
                    let shared = match k {
                        // The first edge along u is the second one of the row before; the second
                        // edge along v is the first one of the next cell.
                        0 => index.checked_sub(across).map(|before| (before, 1, l)),
                        2 if l == 0 && !index.is_multiple_of(across) => Some((index - 1, 3, LANES - 1)),
                        3 if l + 1 < p.count => Some((index, 2, l + 1)),
                        _ => None,
                    };
                    visit((index, k, l), shared);
                }
            }
        }
    }

    pub(crate) fn serialise_rates(&self, to: &mut StateWriter) {
        let of = |(index, k, l): (usize, usize, usize)| self.packets[index].rate[k].0[l];
        let mut alike = true;
        self.for_each_rate(|this, shared| {
            alike &= shared.is_none_or(|other| of(this).to_bits() == of(other).to_bits())
        });
        to.flag(alike);
        let mut rates = Vec::with_capacity(5 * LANES * self.packets.len());
        self.for_each_rate(|this, shared| {
            if !(alike && shared.is_some()) {
                rates.push(of(this));
            }
        });
        to.sparse(&rates);
    }

    pub(crate) fn deserialise_rates(&mut self, from: &mut StateReader) -> ReadResult {
        let alike = from.flag()?;
        let mut count = 0;
        self.for_each_rate(|_, shared| count += usize::from(!(alike && shared.is_some())));
        let mut rates = vec![0.0; count];
        from.sparse(&mut rates)?;
        let mut rates = rates.into_iter();
        let mut values = vec![[[0.0; LANES]; 5]; self.packets.len()];
        self.for_each_rate(|(index, k, l), shared| {
            let value = match shared {
                Some((before, edge, lane)) if alike => values[before][edge][lane],
                _ => rates.next().unwrap_or_default(),
            };
            values[index][k][l] = value;
        });
        for (p, values) in self.packets.iter_mut().zip(values) {
            for (rate, value) in p.rate.iter_mut().zip(values) {
                rate.0 = value;
            }
        }
        Ok(())
    }
}
