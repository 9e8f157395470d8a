//! Nested dissection: a fill-reducing order of elimination.
//!
//! A separator, a set of nodes without which the rest has no coupling across, divides the nodes in
//! two; each part is divided again until it is small. Both parts are eliminated before their
//! separator, so that neither fills the other (A. George, *Nested dissection of a regular finite
//! element mesh*, SIAM J. Numer. Anal. 10 (1973) 345). The result is a tree of *fronts*: sets of
//! nodes eliminated together, children before parents.
//!
//! Cuts are tried along u, v, u + v and u - v, because the stencil of a shell is a diamond and its
//! cheapest separators run along diagonals. For this, u and v are scaled with the mean distance of
//! coupled nodes, which turns the diamond of a rectangular grid into a square one. Several sheets
//! in contact have a third coordinate w, along which cuts separate them. Among all cuts between the
//! 30th and the 70th percentile of a part, the one with the least
//!
//!   |separator| (1 + 4 (b - ½)²),   b the larger part's share of the remainder,
//!
//! is chosen. A cut at c separates the nodes below c from the rest; the separator is the set of
//! nodes on one side with a partner on the other. The size of the separator follows for every c in
//! one pass: a node at level l with its lowest partner at m is in the separator of the cuts
//! m < c <= l, so a running sum over levels counts them all.
//!
//! A pile of small sheets is a chain of layers, each coupled with its neighbours alone. A separator
//! (one layer) is then as large as the parts, and eliminating layer after layer from both ends to
//! the middle takes half the work of nested dissection.
//!
//! Where no coordinate separates the nodes (many coincide), the graph distance from a remote node
//! serves as the coordinate.

use std::ops::Range;

use crate::linear::Pattern;

/// Maximum number of nodes of a part that is not divided; a backend may join small fronts.
const MAXIMUM_LEAF_SIZE: usize = 6;
/// Maximum size of a separator as a fraction of the part: a larger one saves no work.
const MAXIMUM_SEPARATOR_FRACTION: f64 = 0.7;
/// Number of coordinates: u, v, u + v, u - v, w.
const AXES: usize = 5;
/// Index of w.
const W: usize = AXES - 1;
/// Minimum number of layers of a pile, and maximum number of nodes per layer: larger layers are
/// divided.
const MINIMUM_PILE_LAYERS: u32 = 4;
const MAXIMUM_LAYER_SIZE: usize = 48;

/// The fronts in the order of elimination, children before parents, every subtree contiguous.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct EliminationTree {
    /// The nodes in the order of elimination.
    pub order: Vec<u32>,
    /// Fronts, as ranges of `order`.
    pub fronts: Vec<Range<u32>>,
    /// Parent of each front, with a larger index; `None` for a root.
    pub parents: Vec<Option<u32>>,
}

/// Coupled partners of every node.
struct AdjacencyGraph {
    starts: Vec<u32>,
    partners: Vec<u32>,
}

impl AdjacencyGraph {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.size();
        let off_diagonal = || pattern.iter().filter(|(_, r, c)| r != c);
        let mut starts = vec![0; n + 1];
        for (_, r, c) in off_diagonal() {
            starts[r as usize + 1] += 1;
            starts[c as usize + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut partners = vec![0; starts[n] as usize];
        for (_, r, c) in off_diagonal() {
            for (a, b) in [(r, c), (c, r)] {
                partners[next[a as usize] as usize] = b;
                next[a as usize] += 1;
            }
        }
        Self { starts, partners }
    }

    fn of(&self, mass: u32) -> &[u32] {
        let i = mass as usize;
        &self.partners[self.starts[i] as usize..self.starts[i + 1] as usize]
    }
}

/// A division of a set of nodes.
#[derive(Clone, Copy)]
struct SeparatorCut {
    axis: usize,
    /// Nodes of a lower level are on one side, the rest on the other.
    level: u32,
    /// Whether the separator lies on the lower side.
    lower: bool,
    score: f64,
}

/// Nested dissection of one pattern.
struct Dissection {
    graph: AdjacencyGraph,
    /// Rank of every node's coordinate along u, v, u + v, u - v and w, and a buffer for graph
    /// distances.
    levels: [Vec<u32>; AXES + 1],
    /// The part of each node, numbered uniquely; 0 for a node already in a front.
    part: Vec<u32>,
    /// Running sums over levels.
    counts: [Vec<i32>; 3],
    tree: EliminationTree,
}

/// Dissects the nodes of `pattern` at `places` (u, v) and, unless empty, at `depths` (w).
pub(crate) fn dissect(pattern: &Pattern, places: &[[f64; 2]], depths: &[f64]) -> EliminationTree {
    let graph = AdjacencyGraph::new(pattern);
    let n = pattern.size();
    let [u, v] = [0, 1].map(|k| scaled(&graph, places, k));
    let combine = |f: fn(f64, f64) -> f64| ranks(u.iter().zip(&v).map(|(&u, &v)| f(u, v)).collect());
    let w = if depths.is_empty() { vec![0; n] } else { ranks(depths.to_vec()) };
    let levels = [ranks(u.clone()), ranks(v.clone()), combine(|u, v| u + v), combine(|u, v| u - v), w, vec![0; n]];
    let counts = [0; 3].map(|_| vec![0; n + 2]);
    let mut dissection = Dissection { graph, levels, part: vec![1; n], counts, tree: EliminationTree::default() };
    dissection.run();
    dissection.tree
}

/// Coordinate `k` in units of the mean distance of coupled nodes along it.
fn scaled(graph: &AdjacencyGraph, places: &[[f64; 2]], k: usize) -> Vec<f64> {
    let mut sum = 0.0;
    for (i, place) in places.iter().enumerate() {
        sum += graph.of(i as u32).iter().map(|&j| (places[j as usize][k] - place[k]).abs()).sum::<f64>();
    }
    let mean = sum / graph.partners.len().max(1) as f64;
    let scale = if mean > 0.0 && mean.is_finite() { 1.0 / mean } else { 1.0 };
    places.iter().map(|p| p[k] * scale).collect()
}

/// Rank of each coordinate among the distinct values; differences within rounding count as equal.
fn ranks(coordinates: Vec<f64>) -> Vec<u32> {
    let mut order: Vec<u32> = (0..coordinates.len() as u32).collect();
    order.sort_by(|&a, &b| coordinates[a as usize].total_cmp(&coordinates[b as usize]));
    let ends = order.first().zip(order.last());
    let extent = ends.map_or(0.0, |(&a, &b)| coordinates[b as usize] - coordinates[a as usize]);
    let tolerance = 1e-6 * extent;
    let mut ranks = vec![0; coordinates.len()];
    let mut rank = 0;
    for pair in order.windows(2) {
        let [a, b] = [pair[0] as usize, pair[1] as usize];
        rank += u32::from(coordinates[b] - coordinates[a] > tolerance);
        ranks[b] = rank;
    }
    ranks
}

impl Dissection {
    /// Divides parts until all nodes are in fronts. Parents are found before their children.
    fn run(&mut self) {
        let mut fronts: Vec<(Vec<u32>, Option<u32>)> = Vec::new();
        let mut open: Vec<(Vec<u32>, Option<u32>)> = vec![((0..self.part.len() as u32).collect(), None)];
        let mut part = 0;
        while let Some((set, parent)) = open.pop() {
            part += 1;
            self.assign_part(&set, part);
            for component in self.components(&set, part) {
                part += 1;
                self.assign_part(&component, part);
                if let Some(layers) = self.pile_layers(&component) {
                    self.add_pile(layers, parent, &mut fronts);
                    continue;
                }
                match self.best_cut(&component) {
                    Some(cut) => {
                        let [separator, below, above] = self.apply(component, cut);
                        let own = Some(fronts.len() as u32);
                        fronts.push((separator, parent));
                        open.extend([(below, own), (above, own)]);
                    }
                    None => fronts.push((self.sorted_along(component, 0), parent)),
                }
            }
        }
        self.tree = EliminationTree::from_roots_down(fronts);
    }

    /// Layers of a part along w from the lowest; `None` if it is not a pile.
    fn pile_layers(&self, set: &[u32]) -> Option<Vec<Vec<u32>>> {
        let level = |i: u32| self.levels[W][i as usize];
        let (first, last) = set.iter().map(|&i| level(i)).fold((u32::MAX, 0), |(a, b), l| (a.min(l), b.max(l)));
        let count = (last - first + 1) as usize;
        let own = self.part[set[0] as usize];
        let inside = |j: &&u32| self.part[**j as usize] == own;
        let next = |i: u32| self.graph.of(i).iter().filter(inside).all(|&j| level(j).abs_diff(level(i)) <= 1);
        if last - first < MINIMUM_PILE_LAYERS - 1
            || count * MAXIMUM_LAYER_SIZE < set.len()
            || !set.iter().all(|&i| next(i))
        {
            return None;
        }
        let mut layers = vec![Vec::new(); count];
        for &i in set {
            layers[(level(i) - first) as usize].push(i);
        }
        layers.iter().all(|layer| layer.len() <= MAXIMUM_LAYER_SIZE).then_some(layers)
    }

    /// Adds the fronts of a pile: the middle layer, and from it towards both ends each layer as
    /// child of the previous one.
    fn add_pile(&self, layers: Vec<Vec<u32>>, parent: Option<u32>, fronts: &mut Vec<(Vec<u32>, Option<u32>)>) {
        let middle = layers.len() / 2;
        let root = fronts.len() as u32;
        let mut lower = Vec::new();
        for (k, layer) in layers.into_iter().enumerate() {
            let front = self.sorted_along(layer, W);
            match k {
                k if k < middle => lower.push(front),
                k if k == middle => fronts.push((front, parent)),
                _ => fronts.push((front, Some(fronts.len() as u32 - 1))),
            }
        }
        for (k, front) in lower.into_iter().rev().enumerate() {
            let above = if k == 0 { root } else { fronts.len() as u32 - 1 };
            fronts.push((front, Some(above)));
        }
    }

    /// Assigns the nodes of `set` to a part.
    fn assign_part(&mut self, set: &[u32], part: u32) {
        for &i in set {
            self.part[i as usize] = part;
        }
    }

    /// Connected components of the nodes of a part.
    fn components(&mut self, set: &[u32], part: u32) -> Vec<Vec<u32>> {
        let mut components = Vec::new();
        for &seed in set {
            if self.part[seed as usize] == part {
                components.push(self.spread(seed, part));
            }
        }
        components
    }

    /// Nodes of a part connected to `seed`, nearest first. Moves them to part 0 and stores their
    /// distances in the last of the levels.
    fn spread(&mut self, seed: u32, part: u32) -> Vec<u32> {
        let Self { graph, levels, part: parts, .. } = self;
        let distance = &mut levels[AXES];
        distance[seed as usize] = 0;
        parts[seed as usize] = 0;
        let mut reached = vec![seed];
        let mut next = 0;
        while next < reached.len() {
            let i = reached[next];
            next += 1;
            for &j in graph.of(i) {
                if parts[j as usize] == part {
                    parts[j as usize] = 0;
                    distance[j as usize] = distance[i as usize] + 1;
                    reached.push(j);
                }
            }
        }
        reached
    }

    /// The best cut of a connected part; `None` if no cut saves work.
    fn best_cut(&mut self, set: &[u32]) -> Option<SeparatorCut> {
        if set.len() <= MAXIMUM_LEAF_SIZE {
            return None;
        }
        let mut best: Option<SeparatorCut> = None;
        for axis in 0..AXES {
            let cut = self.best_along(set, axis);
            best = [best, cut].into_iter().flatten().reduce(|a, b| if b.score < a.score { b } else { a });
        }
        best.or_else(|| {
            let part = self.part[set[0] as usize];
            let far = self.spread(set[0], part).last().copied().unwrap_or(set[0]);
            self.assign_part(set, part);
            self.spread(far, part);
            self.assign_part(set, part);
            self.best_along(set, AXES)
        })
    }

    /// The best cut along one axis.
    fn best_along(&mut self, set: &[u32], axis: usize) -> Option<SeparatorCut> {
        let Self { graph, levels, part, counts: [below, from_upper, from_lower], .. } = self;
        let levels = &levels[axis];
        let own = part[set[0] as usize];
        let level = |i: u32| levels[i as usize];
        let (first, last) = set.iter().map(|&i| level(i)).fold((u32::MAX, 0), |(a, b), l| (a.min(l), b.max(l)));
        let at = |l: u32| (l - first) as usize;
        let span = at(last) + 2;
        for count in [&mut *below, &mut *from_upper, &mut *from_lower] {
            count[..span].fill(0);
        }
        for &i in set {
            let l = level(i);
            let (mut lowest, mut highest) = (l, l);
            for &j in graph.of(i).iter().filter(|&&j| part[j as usize] == own) {
                lowest = lowest.min(level(j));
                highest = highest.max(level(j));
            }
            below[at(l) + 1] += 1;
            from_upper[at(lowest) + 1] += 1;
            from_upper[at(l) + 1] -= 1;
            from_lower[at(l) + 1] += 1;
            from_lower[at(highest) + 1] -= 1;
        }
        let total = set.len() as i32;
        let mut best: Option<SeparatorCut> = None;
        let mut sums = [0; 3];
        for l in first + 1..=last {
            for (sum, count) in sums.iter_mut().zip([&*below, &*from_upper, &*from_lower]) {
                *sum += count[at(l)];
            }
            // Levels from the 30th to the 70th percentile.
            let through = sums[0] + below[at(l) + 1];
            if through * 10 <= total * 3 || sums[0] * 10 > total * 7 {
                continue;
            }
            for (lower, separator) in [(false, sums[1]), (true, sums[2])] {
                let under = sums[0] - if lower { separator } else { 0 };
                let over = total - separator - under;
                if under <= 0 || over <= 0 || f64::from(separator) >= MAXIMUM_SEPARATOR_FRACTION * f64::from(total) {
                    continue;
                }
                let share = f64::from(under.max(over)) / f64::from(under + over);
                let score = f64::from(separator) * (1.0 + 4.0 * (share - 0.5).powi(2));
                if best.is_none_or(|b| score < b.score) {
                    best = Some(SeparatorCut { axis, level: l, lower, score });
                }
            }
        }
        best
    }

    /// Applies a cut: separator, nodes below and nodes above.
    fn apply(&self, set: Vec<u32>, cut: SeparatorCut) -> [Vec<u32>; 3] {
        let levels = &self.levels[cut.axis];
        let is_lower = |i: u32| levels[i as usize] < cut.level;
        let own = self.part[set[0] as usize];
        let mut sides = [const { Vec::new() }; 3];
        for i in set {
            let across = |&j: &u32| self.part[j as usize] == own && is_lower(j) != cut.lower;
            let side = match is_lower(i) {
                side if side == cut.lower && self.graph.of(i).iter().any(across) => 0,
                true => 1,
                false => 2,
            };
            sides[side].push(i);
        }
        let [separator, below, above] = sides;
        [self.sorted_along(separator, cut.axis), below, above]
    }

    /// Nodes in order along a cut, so that partners of a node are close to each other in the front.
    fn sorted_along(&self, mut set: Vec<u32>, cut_axis: usize) -> Vec<u32> {
        let [across, along] = [[0, 1], [1, 0], [2, 3], [3, 2], [0, 1], [0, 1]][cut_axis].map(|axis| &self.levels[axis]);
        set.sort_by_key(|&i| (along[i as usize], across[i as usize], i));
        set
    }
}

impl EliminationTree {
    /// The position of every node in the elimination.
    pub fn places(&self) -> Vec<u32> {
        let mut places = vec![0; self.order.len()];
        for (i, &mass) in self.order.iter().enumerate() {
            places[mass as usize] = i as u32;
        }
        places
    }

    /// The tree of the given fronts with parents, parents first, every subtree contiguous.
    fn from_roots_down(fronts: Vec<(Vec<u32>, Option<u32>)>) -> Self {
        let last = fronts.len() as u32;
        let mut tree = Self::default();
        for (masses, parent) in fronts.into_iter().rev() {
            let first = tree.order.len() as u32;
            tree.order.extend(masses);
            tree.fronts.push(first..tree.order.len() as u32);
            tree.parents.push(parent.map(|p| last - 1 - p));
        }
        tree
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::cases;
    use crate::linear::cases::FactorCase;

    /// Checks that every node appears once, and that coupled nodes lie in one front or in fronts of
    /// which one is an ancestor of the other.
    fn check(case: &FactorCase, tree: &EliminationTree) {
        let n = case.pattern.size();
        let mut seen = vec![usize::MAX; n];
        for (front, masses) in tree.fronts.iter().enumerate() {
            for &i in &tree.order[masses.start as usize..masses.end as usize] {
                assert_eq!(seen[i as usize], usize::MAX, "{}: mass {i} twice", case.name);
                seen[i as usize] = front;
            }
            assert!(tree.parents[front].is_none_or(|p| p as usize > front), "{}: a parent before its child", case.name);
        }
        assert!(seen.iter().all(|&f| f != usize::MAX), "{}: a mass without a front", case.name);
        let above = |mut front: usize, other: usize| loop {
            match tree.parents[front] {
                _ if front == other => return true,
                Some(parent) => front = parent as usize,
                None => return false,
            }
        };
        for (_, r, c) in case.pattern.iter() {
            let [a, b] = [r, c].map(|i| seen[i as usize]);
            assert!(above(a.min(b), a.max(b)), "{}: {r} and {c} are joined across a separator", case.name);
        }
    }

    #[test]
    fn no_pair_reaches_across_a_separator() {
        for case in cases::all() {
            check(&case, &dissect(&case.pattern, &case.places, &[]));
        }
        for seed in 0..20 {
            let case = cases::random(90, f64::from(seed as u32) / 3.0, seed);
            check(&case, &dissect(&case.pattern, &case.places, &[]));
        }
    }

    #[test]
    fn fronts_are_small_and_the_tree_is_not_deep() {
        for case in [cases::shell(41, 41), cases::two_layers(21, 21), cases::triangles(31, 1), cases::chain(2000)] {
            let tree = dissect(&case.pattern, &case.places, &[]);
            let largest = tree.fronts.iter().map(|f| f.len()).max().unwrap_or(0) as f64;
            let across = (case.pattern.size() as f64).sqrt();
            assert!(largest <= 2.5 * across, "{}: a front of {largest}", case.name);
            let depth = |mut f: usize| std::iter::from_fn(|| tree.parents[f].map(|p| f = p as usize)).count() as f64;
            let deepest = (0..tree.fronts.len()).map(depth).fold(0.0, f64::max);
            assert!(deepest <= 2.0 * (case.pattern.size() as f64).log2(), "{}: {deepest} deep", case.name);
        }
    }

    #[test]
    fn a_pile_is_eliminated_from_both_ends() {
        let (layers, size) = (9, 6);
        let all = move |l: usize| (l * size..(l + 1) * size).map(|i| i as u32);
        let pairs = (0..layers).flat_map(|l| {
            let near = move || all(l).chain(all((l + 1).min(layers - 1)));
            all(l).flat_map(move |i| near().map(move |j| (i, j)))
        });
        let places: Vec<[f64; 2]> = (0..layers * size).map(|i| [(i % size) as f64, 0.0]).collect();
        let depths: Vec<f64> = (0..layers * size).map(|i| (i / size) as f64).collect();
        let case = FactorCase::new("pile", places, pairs);
        let tree = dissect(&case.pattern, &case.places, &depths);
        check(&case, &tree);
        assert!(tree.fronts.iter().all(|f| f.len() == size));
        assert_eq!(tree.parents.iter().filter(|p| p.is_none()).count(), 1);
        let leaves = (0..layers as u32).filter(|f| !tree.parents.contains(&Some(*f))).count();
        assert_eq!(leaves, 2);
    }

    #[test]
    fn coincident_nodes_are_divided_by_graph_distance() {
        let mut case = cases::chain(300);
        case.places.fill([1.0, 2.0]);
        let tree = dissect(&case.pattern, &case.places, &[]);
        assert!(tree.fronts.iter().all(|f| f.len() <= MAXIMUM_LEAF_SIZE));
        check(&case, &tree);
    }
}
