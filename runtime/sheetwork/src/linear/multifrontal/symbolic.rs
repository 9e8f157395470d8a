//! Symbolic analysis: fronts, their shapes, and the destination of every number.
//!
//! A front eliminates its *pivots* and passes on its *boundary*: the nodes coupled with it that are
//! eliminated later. Its columns are
//!
//!   | L11     |   pivots, np of them, padded to npp with ones on the diagonal
//!   | L21  S  |   boundary, nb rows, padded to nbp with zeros,
//!
//! with S = -L21 L21ᵀ plus the S of its children; S is added to the parent's columns. Padding is to
//! whole vectors of `g` numbers. The boundary of a front consists of the nodes coupled with its
//! pivots and the children's boundaries, without the pivots: all of them later nodes.
//!
//! L is stored in *panels*: `g` rows by all npp columns, column after column, so that the kernels
//! read it contiguously. S and the columns to be factorised are stored by columns. The memory of an
//! S is reused after its parent.

use std::ops::Range;

use crate::linear::Pattern;
use crate::linear::dissection::EliminationTree;
use crate::linear::multifrontal::amalgamation::boundaries;

/// Minimum number of operations in the smaller half of the tree for the use of two threads; zero
/// in tests.
const PARALLEL_WORK_THRESHOLD: f64 = if cfg!(test) { 0.0 } else { 1e6 };

/// One front. Rows are numbered from 0, pivots first, the boundary from `wide`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Front {
    /// Index of the first unknown.
    pub first: usize,
    /// Pivots, np.
    pub pivots: usize,
    /// Columns with padding, npp.
    pub wide: usize,
    /// Boundary rows with padding, nbp.
    pub tall: usize,
    /// Nodes of the boundary, in `SymbolicFactor::boundaries`.
    pub boundary: Range<usize>,
    /// Start of L.
    pub factor: usize,
    /// Start of S.
    pub schur: usize,
    /// Blocks of the matrix that are added without transposition, in `SymbolicFactor::blocks`.
    pub straight: Range<usize>,
    /// Blocks that are added transposed.
    pub mirrored: Range<usize>,
    /// The front to which S is added.
    pub parent: Option<u32>,
    /// Children, in `SymbolicFactor::children`.
    pub children: Range<usize>,
    /// Destination of the rows of S in the parent, in `SymbolicFactor::runs`.
    pub runs: Range<usize>,
}

impl Front {
    /// Rows with padding.
    pub fn rows(&self) -> usize {
        self.wide + self.tall
    }

    /// Range of the numbers of L, with padding.
    pub fn factor_range(&self) -> Range<usize> {
        self.factor..self.factor + self.rows() * self.wide
    }

    /// Range of the numbers of S, with padding.
    pub fn schur_range(&self) -> Range<usize> {
        self.schur..self.schur + self.tall * self.tall
    }
}

/// Destination of a block of the matrix in a front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct BlockEntry {
    /// Index of its first number in the columns of the front.
    pub target: u32,
    /// Index of its first number in the values.
    pub source: u32,
}

/// Consecutive rows of an S that stay consecutive in the parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowRun {
    /// First row of S.
    pub from: usize,
    /// First row of the parent.
    pub to: usize,
    /// Number of rows.
    pub len: usize,
}

/// The analysis of one pattern.
#[derive(Debug, Default)]
pub(crate) struct SymbolicFactor {
    /// The node at each position of the elimination.
    pub order: Vec<u32>,
    /// The position of each node in the elimination.
    pub place: Vec<u32>,
    /// The front that eliminates each position.
    pub owner: Vec<u32>,
    /// Children before parents.
    pub fronts: Vec<Front>,
    pub boundaries: Vec<u32>,
    pub children: Vec<u32>,
    pub runs: Vec<RowRun>,
    pub blocks: Vec<BlockEntry>,
    /// Numbers in all L, in all S alive at once, in the columns of the largest front, in its rows.
    pub factor_len: usize,
    pub schur_len: usize,
    pub columns_len: usize,
    pub rows_len: usize,
    /// Two independent ranges of fronts with much work in each: fronts below the first number, and
    /// from it to the second. The S of the second range start at the third number. `None` if the
    /// smaller range has too little work.
    pub halves: Option<[usize; 3]>,
    /// Floating-point operations of a factorisation and numbers in L, without padding.
    pub flops: f64,
    pub nonzeros: usize,
}

impl SymbolicFactor {
    /// Analyses for vectors of `g` numbers.
    pub fn new(pattern: &Pattern, tree: &EliminationTree, g: usize) -> Self {
        let place = tree.places();
        let mut symbolic = Self { order: tree.order.clone(), ..Self::default() };
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); tree.fronts.len()];
        for (front, parent) in tree.parents.iter().enumerate() {
            if let Some(parent) = parent {
                children[*parent as usize].push(front as u32);
            }
        }
        let boundaries = boundaries(pattern, tree);
        for ((pivots, children), boundary) in tree.fronts.iter().zip(&children).zip(boundaries) {
            symbolic.add_front(pivots, children, boundary, g);
        }
        for (front, &parent) in tree.parents.iter().enumerate() {
            symbolic.fronts[front].parent = parent;
            if let Some(parent) = parent {
                symbolic.add_runs(front, parent as usize);
            }
        }
        symbolic.add_owners();
        symbolic.add_blocks(pattern, &place);
        symbolic.halves = symbolic.find_halves();
        symbolic.place_schur();
        symbolic.place = place;
        symbolic
    }

    /// The nodes of a front's boundary, as positions in the elimination, ascending.
    pub fn boundary(&self, front: &Front) -> &[u32] {
        &self.boundaries[front.boundary.clone()]
    }

    fn add_front(&mut self, pivots: &Range<u32>, children: &[u32], boundary: Vec<u32>, g: usize) {
        let [np, nb] = [3 * pivots.len(), 3 * boundary.len()];
        let first_of_boundary = self.boundaries.len();
        let first_child = self.children.len();
        self.boundaries.extend(boundary);
        self.children.extend(children);
        let front = Front {
            first: 3 * pivots.start as usize,
            pivots: np,
            wide: np.next_multiple_of(g),
            tall: nb.next_multiple_of(g),
            boundary: first_of_boundary..self.boundaries.len(),
            factor: self.factor_len,
            children: first_child..self.children.len(),
            ..Front::default()
        };
        self.factor_len = front.factor_range().end.next_multiple_of(8);
        self.columns_len = self.columns_len.max(front.rows() * front.wide);
        self.rows_len = self.rows_len.max(front.rows());
        for length in nb + 1..=nb + np {
            self.flops += (length * length) as f64;
            self.nonzeros += length;
        }
        self.fronts.push(front);
    }

    /// Computes the destination of the rows of `child`'s S in `parent`. A run does not cross from
    /// pivots into the boundary.
    fn add_runs(&mut self, child: usize, parent: usize) {
        let start = self.runs.len();
        let into = &self.fronts[parent];
        let first = (into.first / 3) as u32;
        let end = first + (into.pivots / 3) as u32;
        let boundary = self.boundary(into);
        let mut runs: Vec<RowRun> = Vec::new();
        for (i, &mass) in self.boundary(&self.fronts[child]).iter().enumerate() {
            let to = match mass < end {
                true => 3 * (mass - first) as usize,
                false => into.wide + 3 * boundary.partition_point(|&b| b < mass),
            };
            match runs.last_mut() {
                Some(run) if run.to + run.len == to && (to < into.pivots) == (run.to < into.pivots) => run.len += 3,
                _ => runs.push(RowRun { from: 3 * i, to, len: 3 }),
            }
        }
        self.runs.extend(runs);
        self.fronts[child].runs = start..self.runs.len();
    }

    fn add_owners(&mut self) {
        self.owner = vec![0; self.order.len()];
        for (k, front) in self.fronts.iter().enumerate() {
            self.owner[front.first / 3..(front.first + front.pivots) / 3].fill(k as u32);
        }
    }

    /// Computes the destination of the blocks of the matrix.
    fn add_blocks(&mut self, pattern: &Pattern, place: &[u32]) {
        let mut blocks: Vec<[Vec<BlockEntry>; 2]> = vec![Default::default(); self.fronts.len()];
        for (slot, row, column) in pattern.iter() {
            let (r, c) = (place[row as usize], place[column as usize]);
            let (low, high) = (r.min(c), r.max(c));
            let k = self.owner[low as usize] as usize;
            let front = &self.fronts[k];
            let local = match self.owner[high as usize] as usize == k {
                true => 3 * high as usize - front.first,
                false => front.wide + 3 * self.boundary(front).partition_point(|&b| b < high),
            };
            let target = ((3 * low as usize - front.first) * front.rows() + local) as u32;
            blocks[k][usize::from(r < c)].push(BlockEntry { target, source: 9 * slot as u32 });
        }
        for (front, [mut straight, mut mirrored]) in self.fronts.iter_mut().zip(blocks) {
            straight.sort_unstable();
            mirrored.sort_unstable();
            let start = self.blocks.len();
            self.blocks.append(&mut straight);
            let middle = self.blocks.len();
            self.blocks.append(&mut mirrored);
            front.straight = start..middle;
            front.mirrored = middle..self.blocks.len();
        }
    }

    /// Finds the division of the fronts in two: below the first front from the root with several
    /// children, or between the roots.
    fn find_halves(&self) -> Option<[usize; 3]> {
        let work = |fronts: Range<usize>| -> f64 {
            let of = |front: &Front| (front.pivots * (front.pivots + front.tall) * (front.pivots + front.tall)) as f64;
            self.fronts[fronts].iter().map(of).sum()
        };
        // A subtree is contiguous and ends with its root: each child of `top` ends where the next
        // begins.
        let mut end = self.fronts.len();
        let is_chain = |k: usize| {
            self.fronts[k].children.len() == 1 && self.children[self.fronts[k].children.start] + 1 == k as u32
        };
        while end > 0 && self.fronts[end - 1].parent.is_none_or(|p| p as usize == end) && is_chain(end - 1) {
            end -= 1;
        }
        let top = end.checked_sub(1).map(|k| self.fronts[k].children.clone())?;
        // Joined fronts may have children from other subtrees.
        let below = |k: usize| self.children[self.fronts[k].children.clone()].iter().min().map_or(k, |c| *c as usize);
        let is_own = |cut: &usize| *cut + 1 < end && (*cut..end - 1).all(|k| below(k) >= *cut);
        let cuts = self.children[top].iter().map(|c| *c as usize + 1).filter(is_own);
        let lesser = |cut: &usize| work(0..*cut).min(work(*cut..end - 1));
        let cut = cuts.max_by(|a, b| lesser(a).total_cmp(&lesser(b)))?;
        (lesser(&cut) >= PARALLEL_WORK_THRESHOLD).then_some([cut, end - 1, 0])
    }

    /// Places every S in the first memory that is free until its parent is finished; the two halves
    /// have separate memory.
    fn place_schur(&mut self) {
        let mut alive: Vec<(Range<usize>, usize)> = Vec::new();
        for k in 0..self.fronts.len() {
            let size = self.fronts[k].schur_range().len().next_multiple_of(8);
            if let Some([_, _, from]) = self.halves.as_mut().filter(|halves| halves[0] == k) {
                *from = self.schur_len;
            }
            let second = |halves: [usize; 3]| k >= halves[0] && k < halves[1];
            let mut start = self.halves.filter(|h| second(*h)).map_or(0, |h| h[2]);
            for (taken, _) in &alive {
                if start + size <= taken.start {
                    break;
                }
                start = start.max(taken.end);
            }
            self.fronts[k].schur = start;
            self.schur_len = self.schur_len.max(start + size);
            let done = &self.children[self.fronts[k].children.clone()];
            alive.retain(|(_, front)| !done.contains(&(*front as u32)));
            if size > 0 {
                let at = alive.partition_point(|(taken, _)| taken.start < start);
                alive.insert(at, (start..start + size, k));
            }
        }
    }
}
