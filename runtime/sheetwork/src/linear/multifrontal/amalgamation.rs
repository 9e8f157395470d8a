//! Amalgamation: joining small fronts to their parents.
//!
//! Joining a front to its parent costs multiplications by zeros and saves the computation of an S
//! and its addition to the parent; small fronts also leave vectors partly empty. Every front in
//! turn, children first, is joined to its parent if the estimated time decreases (after C. Ashcraft
//! and R. Grimes, *The influence of relaxed supernode partitions on the multifrontal method*, ACM
//! Trans. Math. Softw. 15 (1989) 291). The estimate [`cost`] counts vector operations. It affects
//! rounding and speed only, and is equal on every machine.

use crate::linear::Pattern;
use crate::linear::dissection::EliminationTree;

/// The boundary of every front: later nodes coupled with it, as positions in the elimination,
/// ascending.
pub(crate) fn boundaries(pattern: &Pattern, tree: &EliminationTree) -> Vec<Vec<u32>> {
    let place = tree.places();
    let mut later = vec![Vec::new(); place.len()];
    for (_, row, column) in pattern.iter().filter(|(_, r, c)| r != c) {
        let (r, c) = (place[row as usize], place[column as usize]);
        later[r.min(c) as usize].push(r.max(c));
    }
    let mut boundaries: Vec<Vec<u32>> = vec![Vec::new(); tree.fronts.len()];
    for (k, pivots) in tree.fronts.iter().enumerate() {
        // Contains the boundaries of the children.
        let mut boundary = std::mem::take(&mut boundaries[k]);
        boundary.extend(pivots.clone().flat_map(|i| &later[i as usize]));
        boundary.retain(|&mass| mass >= pivots.end);
        boundary.sort_unstable();
        boundary.dedup();
        if let Some(parent) = tree.parents[k] {
            boundaries[parent as usize].extend(&boundary);
        }
        boundaries[k] = boundary;
    }
    boundaries
}

/// Estimated time of a front with `np` pivots and `nb` boundary rows, in vector operations of eight
/// numbers.
fn cost(np: usize, nb: usize) -> f64 {
    const LANES: usize = 8;
    /// Writing a tile of S.
    const TILE: f64 = 16.0;
    /// Factorising a diagonal square, column by column.
    const WORK_DIVISOR: f64 = 400.0;
    /// Starting a front; adding a row of S and a number of S to the parent; clearing a number.
    const BEGIN: f64 = 300.0;
    const ROW: f64 = 10.0;
    const ADD: f64 = 0.5;
    const CLEAR: f64 = 0.25;
    let [wide, tall] = [np, nb].map(|n| n.div_ceil(LANES) as f64);
    let [np, nb] = [np as f64, nb as f64];
    let schur = tall * (tall + 1.0) / 2.0 * (LANES as f64 * np + TILE);
    let tiles = tall * wide * (wide + 1.0) / 2.0 + wide * (wide + 1.0) * (wide + 2.0) / 6.0;
    let panels = tiles * (LANES * LANES) as f64 + WORK_DIVISOR * wide;
    let additions = ADD * nb * nb / 2.0 + ROW * nb;
    BEGIN + schur + panels + additions + CLEAR * (np + nb) * np
}

/// Joins fronts to their parents where the estimated time decreases.
pub(crate) fn amalgamate(pattern: &Pattern, tree: &EliminationTree) -> EliminationTree {
    let count = tree.fronts.len();
    let sizes: Vec<usize> = boundaries(pattern, tree).iter().map(|b| 3 * b.len()).collect();
    let mut pivots: Vec<usize> = tree.fronts.iter().map(|f| 3 * f.len()).collect();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut joined = vec![false; count];
    for k in 0..count {
        if let Some(parent) = tree.parents[k] {
            children[parent as usize].push(k as u32);
        }
        // The child with the largest saving first, while there is one.
        let saving = |pivots: &[usize], c: u32| {
            let c = c as usize;
            cost(pivots[c], sizes[c]) + cost(pivots[k], sizes[k]) - cost(pivots[c] + pivots[k], sizes[k])
        };
        loop {
            let best =
                children[k].iter().map(|&c| (saving(&pivots, c), c)).fold(None, |best: Option<(f64, u32)>, new| {
                    if best.is_none_or(|b| new.0 > b.0) { Some(new) } else { best }
                });
            let Some((_, child)) = best.filter(|b| b.0 > 0.0) else { break };
            pivots[k] += pivots[child as usize];
            joined[child as usize] = true;
            let grandchildren = std::mem::take(&mut children[child as usize]);
            children[k].retain(|&c| c != child);
            children[k].extend(grandchildren);
        }
    }
    rebuild(tree, &joined)
}

/// The tree in which the `joined` fronts are part of their parents.
fn rebuild(tree: &EliminationTree, joined: &[bool]) -> EliminationTree {
    let count = tree.fronts.len();
    let mut into: Vec<usize> = (0..count).collect();
    for k in (0..count).rev() {
        if let Some(parent) = tree.parents[k].filter(|_| joined[k]) {
            into[k] = into[parent as usize];
        }
    }
    let mut masses: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (k, front) in tree.fronts.iter().enumerate() {
        masses[into[k]].extend(&tree.order[front.start as usize..front.end as usize]);
    }
    let mut new_index = vec![0; count];
    let mut built = EliminationTree::default();
    for k in (0..count).filter(|&k| !joined[k]) {
        new_index[k] = built.fronts.len() as u32;
        let first = built.order.len() as u32;
        built.order.append(&mut masses[k]);
        built.fronts.push(first..built.order.len() as u32);
    }
    for k in (0..count).filter(|&k| !joined[k]) {
        built.parents.push(tree.parents[k].map(|parent| new_index[into[parent as usize]]));
    }
    built
}
