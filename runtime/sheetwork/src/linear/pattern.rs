//! Sparsity pattern of a symmetric matrix of 3x3 blocks.
//!
//! A block row and column stand for one free node; a block couples x, y and z of two nodes. Only
//! the lower triangle is stored.

/// Lower triangle, with diagonal, of a symmetric matrix of 3x3 blocks, by columns: rows ascend
/// within a column, and the diagonal block comes first and always exists.
///
/// The values of a matrix are 9 numbers per block, row by row within the block, block after block
/// in the order of `rows`. Diagonal blocks are stored in full.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pattern {
    /// Start of each column's blocks in `rows`; one entry more than columns.
    pub starts: Vec<u32>,
    /// Block row of each block.
    pub rows: Vec<u32>,
}

impl Pattern {
    /// The pattern of `n` block rows with couplings `pairs`. Pairs may repeat, in either order,
    /// with or without the diagonal.
    ///
    /// # Panics
    /// If a pair has an index of `n` or more.
    pub fn new(n: usize, pairs: impl IntoIterator<Item = (u32, u32)>) -> Self {
        let diagonal = (0..n as u32).map(|i| (i, i));
        let mut blocks: Vec<(u32, u32)> =
            pairs.into_iter().map(|(a, b)| (a.min(b), a.max(b))).chain(diagonal).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let mut starts = vec![0; n + 1];
        for &(column, row) in &blocks {
            assert!((row as usize) < n, "a pair names mass {row} of {n}");
            starts[column as usize + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        Self { starts, rows: blocks.into_iter().map(|(_, row)| row).collect() }
    }

    /// Number of block rows.
    pub fn size(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of stored blocks.
    pub fn blocks(&self) -> usize {
        self.rows.len()
    }

    /// Slots of the blocks of a column.
    pub fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// The slot of block (`row`, `column`), with `row` not less than `column`, both below
    /// [`Pattern::size`]; `None` if the matrix has no such block.
    pub fn slot(&self, row: u32, column: u32) -> Option<u32> {
        let blocks = self.column(column as usize);
        let first = blocks.start;
        self.rows[blocks].binary_search(&row).ok().map(|i| (first + i) as u32)
    }

    /// Every block as (slot, row, column), in the order of the slots.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u32, u32)> + '_ {
        (0..self.size()).flat_map(move |c| self.column(c).map(move |slot| (slot, self.rows[slot], c as u32)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_either_way_round_and_repeated() {
        let pattern = Pattern::new(4, [(3, 1), (1, 3), (0, 2), (2, 2)]);
        assert_eq!(pattern.starts, [0, 2, 4, 5, 6]);
        assert_eq!(pattern.rows, [0, 2, 1, 3, 2, 3]);
        assert_eq!(pattern.slot(3, 1), Some(3));
        assert_eq!(pattern.slot(2, 1), None);
        assert_eq!(pattern.slot(3, 3), Some(5));
        assert_eq!(pattern.iter().nth(3), Some((3, 3, 1)));
    }

    #[test]
    fn an_empty_pattern_has_no_blocks() {
        let pattern = Pattern::new(0, []);
        assert_eq!((pattern.size(), pattern.blocks()), (0, 0));
    }
}
