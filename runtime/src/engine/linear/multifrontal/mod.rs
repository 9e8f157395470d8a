//! Our own backend: a multifrontal supernodal Cholesky factorisation for sheets.
//!
//! Front after front, children before parents, the pivots of a front are assembled from the matrix and from what the
//! children leave, factorised densely, and their effect on later masses is left to the parent (I. S. Duff and J. K. Reid,
//! *The multifrontal solution of indefinite sparse symmetric linear systems*, ACM Trans. Math. Softw. 9 (1983) 302). Nothing
//! is allocated after the analysis. One thread.
//!
//! There are three paths, for AVX-512, for AVX2 with FMA, and a portable one; the best that the processor has is taken when
//! the program runs. Each gives the same bits wherever it runs; they differ from one another by rounding (`lanes`).

mod kernels;
mod lanes;
mod numeric;
mod solve;
mod symbolic;

use super::dissection::Tree;
use super::{Factor, NotPositive, Pattern};
use lanes::{Job, Portable};
use numeric::Factorise;
use solve::Solve;
use symbolic::Symbolic;

/// The instructions a factorisation runs with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Plain arithmetic.
    Portable,
    /// Four lanes and fused multiply-add.
    Avx2,
    /// Eight lanes and fused multiply-add.
    Avx512,
}

impl Path {
    /// All of them, the best last.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The best this processor has.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|p| p.available()).unwrap_or(Self::Portable)
    }

    /// Whether this processor has it.
    pub fn available(self) -> bool {
        self.instructions().is_some()
    }

    fn instructions(self) -> Option<Instructions> {
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

/// The instructions of a path that this processor has.
#[derive(Clone, Copy)]
enum Instructions {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(lanes::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(lanes::Avx512),
}

impl Instructions {
    /// Numbers in a vector.
    fn width(self) -> usize {
        match self {
            Self::Portable(_) => 4,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => 4,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => 8,
        }
    }

    fn run<T, J: Job<4, Output = T> + Job<8, Output = T>>(self, job: J) -> T {
        use lanes::Lanes;
        match self {
            Self::Portable(lanes) => lanes.run(job),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.run(job),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.run(job),
        }
    }
}

/// Numbers that start where a line of the cache does, so that no vector lies across two.
struct Aligned {
    memory: Vec<f64>,
    shift: usize,
}

impl Aligned {
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

/// A multifrontal factor.
pub(super) struct MultifrontalFactor {
    instructions: Instructions,
    symbolic: Symbolic,
    factor: Aligned,
    columns: Aligned,
    schur: Aligned,
    x: Vec<f64>,
    local: Aligned,
    factorised: bool,
}

impl MultifrontalFactor {
    /// Prepares factorisations of matrices of `pattern` in the order of `tree`; none where the processor lacks the path.
    pub fn new(pattern: &Pattern, tree: &Tree, path: Path) -> Option<Self> {
        let instructions = path.instructions()?;
        let symbolic = Symbolic::new(pattern, tree, instructions.width());
        Some(Self {
            instructions,
            factor: Aligned::new(symbolic.factor_len),
            columns: Aligned::new(symbolic.columns_len),
            schur: Aligned::new(symbolic.schur_len),
            x: vec![0.0; 3 * pattern.size()],
            local: Aligned::new(symbolic.rows_len),
            factorised: false,
            symbolic,
        })
    }
}

impl Factor for MultifrontalFactor {
    fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositive> {
        self.factorised = self.instructions.run(Factorise {
            symbolic: &self.symbolic,
            values,
            columns: self.columns.get_mut(),
            schur: self.schur.get_mut(),
            factor: self.factor.get_mut(),
        });
        if self.factorised { Ok(()) } else { Err(NotPositive) }
    }

    fn solve(&mut self, b: &mut [f64]) {
        assert_eq!(b.len(), self.x.len(), "3 entries a block row");
        if !self.factorised {
            b.fill(f64::NAN);
            return;
        }
        let order = &self.symbolic.order;
        for (x, &mass) in self.x.as_chunks_mut::<3>().0.iter_mut().zip(order) {
            x.copy_from_slice(&b[3 * mass as usize..3 * mass as usize + 3]);
        }
        self.instructions.run(Solve {
            symbolic: &self.symbolic,
            factor: self.factor.get(),
            x: &mut self.x,
            local: self.local.get_mut(),
        });
        for (x, &mass) in self.x.as_chunks::<3>().0.iter().zip(order) {
            b[3 * mass as usize..3 * mass as usize + 3].copy_from_slice(x);
        }
    }

    fn name(&self) -> &'static str {
        match self.instructions {
            Instructions::Portable(_) => "multifrontal",
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2(_) => "multifrontal, AVX2",
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512(_) => "multifrontal, AVX-512",
        }
    }

    fn flops(&self) -> f64 {
        self.symbolic.flops
    }

    fn nonzeros(&self) -> usize {
        self.symbolic.nonzeros
    }
}
