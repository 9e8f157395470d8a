//! Reference backend: supernodal Cholesky factorisation of the `faer` library, on one thread, in
//! the ordering of [`crate::linear::dissection`].
//!
//! Blocks are gathered into the lower triangle of the permuted matrix, scalar column by scalar
//! column, so that faer neither orders nor copies: it adds the entries to its supernodes and
//! factorises them in the memory and scratch space stored here.

use ::faer::dyn_stack::{MemBuffer, MemStack};
use ::faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use ::faer::linalg::cholesky::llt::factor::LltRegularization;
use ::faer::sparse::linalg::SupernodalThreshold;
use ::faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use ::faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use ::faer::{Conj, MatMut, Par, Side, Spec};

use crate::linear::dissection::EliminationTree;
use crate::linear::{Factor, HalfSolutions, NotPositiveDefinite, Pattern, SparseLoads};

/// A factor by faer.
pub(crate) struct FaerFactor {
    /// The node at each position of the elimination.
    order: Vec<u32>,
    /// The position of each node in the elimination.
    place: Vec<u32>,
    /// Lower triangle of the permuted matrix.
    lower: SymbolicSparseColMat<usize>,
    /// Index of each of its entries in the caller's values.
    source: Vec<u32>,
    entries: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    is_factorised: bool,
    /// L D Lᵀ instead of L Lᵀ, for indefinite matrices; without pivoting it fails if a leading
    /// minor is singular.
    is_indefinite: bool,
    scratch: MemBuffer,
    solution: Vec<f64>,
    flops: f64,
    nonzeros: usize,
}

impl FaerFactor {
    /// Prepares factorisations of matrices of `pattern` in the order of `tree`.
    ///
    /// # Panics
    /// If memory runs out.
    pub fn new(pattern: &Pattern, tree: &EliminationTree, indefinite: bool) -> Self {
        let n = 3 * pattern.size();
        let place = tree.places();
        let (lower, source) = permuted_lower(pattern, &place);
        // Without its own ordering, faer's analysis reads the upper triangle and its factorisation
        // the lower one.
        let upper = lower.to_row_major().expect("out of memory");
        let upper = upper.transpose();
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(upper, Side::Upper, SymmetricOrdering::Identity, params)
            .expect("out of memory");
        let need = if indefinite {
            symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default())
        } else {
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
        };
        let scratch = MemBuffer::new(need.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)));
        let (flops, nonzeros) = cost(&symbolic);
        Self {
            order: tree.order.clone(),
            place,
            entries: vec![0.0; source.len()],
            factor: vec![0.0; symbolic.len_val()],
            is_factorised: false,
            is_indefinite: indefinite,
            solution: vec![0.0; n],
            lower,
            source,
            symbolic,
            scratch,
            flops,
            nonzeros,
        }
    }
}

/// The lower triangle of the matrix with nodes eliminated at `place`, and the index of each of its
/// entries in the caller's values.
fn permuted_lower(pattern: &Pattern, place: &[u32]) -> (SymbolicSparseColMat<usize>, Vec<u32>) {
    let mut entries = Vec::with_capacity(9 * pattern.blocks());
    for (slot, row, column) in pattern.iter() {
        let (r, c) = (place[row as usize] as usize, place[column as usize] as usize);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let source = (9 * slot + 3 * i + j) as u32;
            let (r, c) = (3 * r + i, 3 * c + j);
            if row != column || i >= j {
                entries.push((r.min(c), r.max(c), source));
            }
        }
    }
    entries.sort_unstable();
    let n = 3 * place.len();
    let mut starts = vec![0; n + 1];
    for &(column, ..) in &entries {
        starts[column + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let rows = entries.iter().map(|&(_, row, _)| row).collect();
    let source = entries.iter().map(|&(.., source)| source).collect();
    (SymbolicSparseColMat::new_checked(n, n, starts, None, rows), source)
}

/// Floating-point operations of a factorisation (sum of the squared column lengths) and numbers in
/// the factor, including the zeros of faer's relaxed supernodes.
fn cost(symbolic: &SymbolicCholesky<usize>) -> (f64, usize) {
    let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else { return (0.0, symbolic.len_val()) };
    let mut cost = (0.0, 0);
    for s in 0..symbolic.n_supernodes() {
        let columns = symbolic.supernode_end()[s] - symbolic.supernode_begin()[s];
        let rows = columns + symbolic.supernode(s).pattern().len();
        for length in rows - columns + 1..=rows {
            cost.0 += (length * length) as f64;
            cost.1 += length;
        }
    }
    cost
}

impl Factor for FaerFactor {
    fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite> {
        self.is_factorised = false;
        for (entry, &source) in self.entries.iter_mut().zip(&self.source) {
            *entry = values[source as usize];
        }
        if self.is_indefinite {
            let done = self.symbolic.factorize_numeric_ldlt(
                &mut self.factor,
                SparseColMatRef::new(self.lower.as_ref(), &self.entries),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Spec::default(),
            );
            self.is_factorised = done.is_ok();
            return done.map(|_| ()).map_err(|_| NotPositiveDefinite);
        }
        let done = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(self.lower.as_ref(), &self.entries),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Spec::default(),
        );
        self.is_factorised = done.is_ok();
        done.map(|_| ()).map_err(|_| NotPositiveDefinite)
    }

    fn solve(&mut self, b: &mut [f64]) {
        assert_eq!(b.len(), self.solution.len(), "3 entries a block row");
        if !self.is_factorised {
            b.fill(f64::NAN);
            return;
        }
        for (i, &mass) in self.order.iter().enumerate() {
            self.solution[3 * i..3 * i + 3].copy_from_slice(&b[3 * mass as usize..3 * mass as usize + 3]);
        }
        let n = self.solution.len();
        let right = MatMut::from_column_major_slice_mut(&mut self.solution, n, 1);
        let scratch = MemStack::new(&mut self.scratch);
        if self.is_indefinite {
            LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(Conj::No, right, Par::Seq, scratch);
        } else {
            LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(Conj::No, right, Par::Seq, scratch);
        }
        for (i, &mass) in self.order.iter().enumerate() {
            b[3 * mass as usize..3 * mass as usize + 3].copy_from_slice(&self.solution[3 * i..3 * i + 3]);
        }
    }

    fn half_solve(&mut self, loads: &SparseLoads, solutions: &mut HalfSolutions) {
        let n = self.solution.len();
        for load in loads.iter() {
            self.solution.fill(if self.is_factorised { 0.0 } else { f64::NAN });
            for &(mass, value) in load {
                let at = 3 * self.place[mass as usize] as usize;
                for (x, v) in self.solution[at..at + 3].iter_mut().zip(value) {
                    *x += v;
                }
            }
            if let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() {
                SupernodalLltRef::new(symbolic, &self.factor).l_solve_with_conj(
                    Conj::No,
                    MatMut::from_column_major_slice_mut(&mut self.solution, n, 1),
                    Par::Seq,
                    MemStack::new(&mut self.scratch),
                );
            }
            solutions.add_segment(0, &self.solution);
            solutions.close();
        }
    }

    fn name(&self) -> &'static str {
        if self.is_indefinite { "faer, indefinite" } else { "faer" }
    }

    fn flops(&self) -> f64 {
        self.flops
    }

    fn nonzeros(&self) -> usize {
        self.nonzeros
    }
}
