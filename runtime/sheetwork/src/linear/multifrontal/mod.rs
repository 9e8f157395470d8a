//! Multifrontal supernodal Cholesky factorisation for sheets.
//!
//! For front after front, children before parents: the columns of a front's pivots are assembled
//! from the matrix and from the children's Schur complements, factorised as a dense matrix, and
//! their Schur complement is passed to the parent (I. S. Duff and J. K. Reid, *The multifrontal
//! solution of indefinite sparse symmetric linear systems*, ACM Trans. Math. Softw. 9 (1983) 302).
//! Nothing is allocated after the analysis. One thread is used, or two where the tree has two large
//! branches, with equal bits.
//!
//! There are three instruction sets: AVX-512, AVX2 with FMA, and portable code; the best that the
//! processor has is chosen at run time. Each gives equal bits on every machine; they differ from
//! one another by rounding (`lanes`).

pub(crate) mod amalgamation;
pub(crate) mod kernels;
pub(crate) mod lanes;
pub(crate) mod numeric;
pub(crate) mod solve;
pub(crate) mod symbolic;

use crate::linear::dissection::EliminationTree;
use crate::linear::multifrontal::lanes::{Portable, VectorKernel};
use crate::linear::multifrontal::numeric::{ArenaSlice, Factorise};
use crate::linear::multifrontal::solve::{HalfSolve, RightHandSide, Solve};
use crate::linear::multifrontal::symbolic::SymbolicFactor;
use crate::linear::{HalfSolutions, NotPositiveDefinite, Pattern, SparseLoads};

/// Instruction set of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// Scalar arithmetic.
    Portable,
    /// Four lanes and fused multiply-add.
    Avx2,
    /// Eight lanes and fused multiply-add.
    Avx512,
}

impl InstructionSet {
    /// All instruction sets, the best last.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The best instruction set of this processor.
    pub fn best() -> Self {
        Instructions::best().path()
    }

    pub(crate) fn instructions(self) -> Option<Instructions> {
        match self {
            Self::Portable => Some(Instructions::Portable(Portable)),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => lanes::Avx2::detect().map(Instructions::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => lanes::Avx512::detect().map(Instructions::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => None,
        }
    }
}

/// Token of an instruction set that this processor has.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Instructions {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(lanes::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(lanes::Avx512),
}

impl Instructions {
    /// The best instruction set of this processor.
    pub fn best() -> Self {
        let paths = InstructionSet::ALL.into_iter().rev();
        paths.filter_map(InstructionSet::instructions).next().unwrap_or(Self::Portable(Portable))
    }

    fn path(self) -> InstructionSet {
        match self {
            Self::Portable(_) => InstructionSet::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => InstructionSet::Avx2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => InstructionSet::Avx512,
        }
    }

    /// Numbers per vector.
    fn width(self) -> usize {
        match self.path() {
            InstructionSet::Portable | InstructionSet::Avx2 => 4,
            InstructionSet::Avx512 => 8,
        }
    }

    fn run<T, J: VectorKernel<4, Output = T> + VectorKernel<8, Output = T>>(self, job: J) -> T {
        use crate::linear::multifrontal::lanes::Lanes;
        match self {
            Self::Portable(lanes) => lanes.run(job),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.run(job),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.run(job),
        }
    }
}

/// Numbers aligned to a cache line, so that no vector spans two lines.
struct AlignedBuffer {
    memory: Vec<f64>,
    shift: usize,
}

impl AlignedBuffer {
    fn new(len: usize) -> Self {
        let memory = vec![0.0; len + 7];
        let shift = memory.as_ptr().align_offset(64).min(7);
        Self { memory, shift }
    }

    fn get(&self) -> &[f64] {
        &self.memory[self.shift..]
    }

    fn get_mut(&mut self) -> &mut [f64] {
        &mut self.memory[self.shift..]
    }
}

/// The Cholesky factor of matrices with one pattern, with its memory.
pub struct Factor {
    instructions: Instructions,
    symbolic: SymbolicFactor,
    factor: AlignedBuffer,
    /// One buffer per half of the tree.
    columns: [AlignedBuffer; 2],
    schur: AlignedBuffer,
    is_parallel: bool,
    x: Vec<f64>,
    local: AlignedBuffer,
    is_factorised: bool,
    /// Number of values of the matrix.
    values: usize,
    /// Fronts of one half solution, and whether each front is among them.
    path: Vec<u32>,
    on_path: Vec<bool>,
}

impl Factor {
    /// Prepares factorisations of matrices of `pattern` in the order of `tree`.
    pub(crate) fn new(pattern: &Pattern, tree: &EliminationTree, instructions: Instructions) -> Self {
        let tree = amalgamation::amalgamate(pattern, tree);
        let symbolic = SymbolicFactor::new(pattern, &tree, instructions.width());
        Self {
            instructions,
            factor: AlignedBuffer::new(symbolic.factor_len),
            columns: [symbolic.columns_len, if symbolic.halves.is_some() { symbolic.columns_len } else { 0 }]
                .map(AlignedBuffer::new),
            is_parallel: false,
            schur: AlignedBuffer::new(symbolic.schur_len),
            x: vec![0.0; 3 * pattern.size()],
            local: AlignedBuffer::new(symbolic.rows_len),
            is_factorised: false,
            values: 9 * pattern.blocks(),
            path: Vec::with_capacity(symbolic.fronts.len()),
            on_path: vec![false; symbolic.fronts.len()],
            symbolic,
        }
    }
}

impl Factor {
    /// Factorises; `with_side` includes the forward substitution of the right-hand side in `x`.
    fn run(&mut self, values: &[f64], with_side: bool) -> Result<(), NotPositiveDefinite> {
        assert_eq!(values.len(), self.values, "9 values a block");
        let done = match self.symbolic.halves.filter(|_| self.is_parallel && !with_side) {
            Some(halves) => self.run_halves(halves, values),
            None => 0,
        };
        let side = RightHandSide { x: &mut self.x, local: self.local.get_mut() };
        self.is_factorised = done < usize::MAX
            && self.instructions.run(Factorise {
                symbolic: &self.symbolic,
                fronts: done..self.symbolic.fronts.len(),
                values,
                columns: self.columns[0].get_mut(),
                schur: ArenaSlice { from: 0, memory: self.schur.get_mut() },
                factor: ArenaSlice { from: 0, memory: self.factor.get_mut() },
                forward: with_side.then_some(side),
            });
        if self.is_factorised { Ok(()) } else { Err(NotPositiveDefinite) }
    }

    /// Factorises two halves of the fronts on two threads; returns the number of finished fronts,
    /// or `usize::MAX` if a pivot was not positive.
    fn run_halves(&mut self, [cut, end, schur_from]: [usize; 3], values: &[f64]) -> usize {
        let Self { symbolic, instructions, columns: [first, second], .. } = self;
        let from = symbolic.fronts[cut].factor;
        let (low, high) = self.schur.get_mut().split_at_mut(schur_from);
        let (below, above) = self.factor.get_mut().split_at_mut(from);
        let half = |fronts, columns, schur, factor| {
            let job = Factorise { symbolic, fronts, values, columns, schur, factor, forward: None };
            instructions.run(job)
        };
        let (a, b) = crate::parallel::join(
            || {
                half(
                    0..cut,
                    first.get_mut(),
                    ArenaSlice { from: 0, memory: low },
                    ArenaSlice { from: 0, memory: below },
                )
            },
            || {
                let schur = ArenaSlice { from: schur_from, memory: high };
                half(cut..end, second.get_mut(), schur, ArenaSlice { from, memory: above })
            },
        );
        if a && b { end } else { usize::MAX }
    }

    /// Permutes a right-hand side into the order of elimination.
    fn permute_in(&mut self, b: &[f64]) {
        assert_eq!(b.len(), self.x.len(), "3 entries a block row");
        for (x, &mass) in self.x.as_chunks_mut::<3>().0.iter_mut().zip(&self.symbolic.order) {
            x.copy_from_slice(&b[3 * mass as usize..3 * mass as usize + 3]);
        }
    }

    /// Solves for the permuted right-hand side and returns the solution in the caller's order.
    fn finish(&mut self, b: &mut [f64], half_done: bool) {
        self.instructions.run(Solve {
            symbolic: &self.symbolic,
            factor: self.factor.get(),
            side: RightHandSide { x: &mut self.x, local: self.local.get_mut() },
            half_done,
        });
        for (x, &mass) in self.x.as_chunks::<3>().0.iter().zip(&self.symbolic.order) {
            b[3 * mass as usize..3 * mass as usize + 3].copy_from_slice(x);
        }
    }

    /// The fronts where the half solution of a load is non-zero, ascending: those of its nodes and
    /// their ancestors.
    fn compute_path(&mut self, load: &[(u32, [f64; 3])]) {
        let Self { symbolic, path, on_path, .. } = self;
        path.clear();
        for &(mass, _) in load {
            let mut next = Some(symbolic.owner[symbolic.place[mass as usize] as usize]);
            while let Some(k) = next.filter(|&k| !on_path[k as usize]) {
                on_path[k as usize] = true;
                path.push(k);
                next = symbolic.fronts[k as usize].parent;
            }
        }
        path.sort_unstable();
        for &k in &*path {
            on_path[k as usize] = false;
        }
    }
}

impl Factor {
    /// Factorises. `values` has 9 numbers per block of the pattern, in the order that [`Pattern`]
    /// defines; diagonal blocks need their lower triangle only.
    ///
    /// # Errors
    /// If a pivot is not positive or not finite. There is then no factor until the next success.
    ///
    /// # Panics
    /// If `values` does not have 9 numbers per block.
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite> {
        self.run(values, false)
    }

    /// Factorises, then solves A x = b in place: equal to [`Factor::factorize`] and
    /// [`Factor::solve`], but the forward substitution uses L while it is in the cache. On failure
    /// the content of `b` is undefined.
    ///
    /// # Errors
    /// As [`Factor::factorize`].
    ///
    /// # Panics
    /// As [`Factor::factorize`] and [`Factor::solve`].
    pub fn factorize_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), NotPositiveDefinite> {
        self.permute_in(b);
        self.run(values, true)?;
        self.finish(b, true);
        Ok(())
    }

    /// Solves A x = b in place with the last factor: `b` has 3 entries (x, y, z) per block row.
    /// Without a factor `b` becomes NaN.
    ///
    /// # Panics
    /// If `b` does not have 3 entries per block row.
    pub fn solve(&mut self, b: &mut [f64]) {
        self.permute_in(b);
        if self.is_factorised {
            self.finish(b, false);
        } else {
            b.fill(f64::NAN);
        }
    }

    /// Appends the half solutions of `loads` with the last factor to `solutions`, without
    /// allocation if the capacity of `solutions` suffices. Without a factor they are NaN.
    ///
    /// # Panics
    /// If a load names a block row out of range.
    pub fn half_solve(&mut self, loads: &SparseLoads, solutions: &mut HalfSolutions) {
        for load in loads.iter() {
            self.compute_path(load);
            // A front on the path modifies pivots of fronts on the path only.
            for &k in &self.path {
                let front = &self.symbolic.fronts[k as usize];
                let start = if self.is_factorised { 0.0 } else { f64::NAN };
                self.x[front.first..front.first + front.pivots].fill(start);
            }
            for &(mass, value) in load {
                let at = 3 * self.symbolic.place[mass as usize] as usize;
                for (x, v) in self.x[at..at + 3].iter_mut().zip(value) {
                    *x += v;
                }
            }
            self.instructions.run(HalfSolve {
                symbolic: &self.symbolic,
                factor: self.factor.get(),
                side: RightHandSide { x: &mut self.x, local: self.local.get_mut() },
                path: &self.path,
            });
            for &k in &self.path {
                let front = &self.symbolic.fronts[k as usize];
                solutions.add_segment(front.first, &self.x[front.first..front.first + front.pivots]);
            }
            solutions.close();
        }
    }

    /// Enables threads of the calling thread's pool in factorisations; off by default. The bits of
    /// the result do not depend on it.
    pub fn set_parallel(&mut self, parallel: bool) {
        self.is_parallel = parallel;
    }

    /// Name of the method and its instruction set.
    pub fn name(&self) -> &'static str {
        match self.instructions.path() {
            InstructionSet::Portable => "multifrontal",
            InstructionSet::Avx2 => "multifrontal, AVX2",
            InstructionSet::Avx512 => "multifrontal, AVX-512",
        }
    }

    /// Multiply-add operations of one factorisation, without padding.
    pub fn flops(&self) -> f64 {
        self.symbolic.flops
    }

    /// Non-zeros of L, without padding.
    pub fn nonzeros(&self) -> usize {
        self.symbolic.nonzeros
    }
}
