//! Disjoint sets of objects (union-find) whose representative is the smallest index.

/// Forest of disjoint sets over the indices 0 to n - 1.
#[derive(Default)]
pub(crate) struct UnionFind {
    /// A parent has a smaller index than its children; a root is its own parent.
    parent: Vec<u32>,
}

impl UnionFind {
    /// Make `count` sets of one object each.
    pub fn reset(&mut self, count: usize) {
        self.parent.clear();
        self.parent.extend(0..count as u32);
    }

    /// Smallest index of the set of `i`.
    pub fn find(&mut self, i: usize) -> usize {
        let mut i = i as u32;
        while self.parent[i as usize] != i {
            // Path halving.
            self.parent[i as usize] = self.parent[self.parent[i as usize] as usize];
            i = self.parent[i as usize];
        }
        i as usize
    }

    /// Unite the sets of `a` and `b`. Returns `false` if they are the same set.
    pub fn unite(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b)] = a.min(b) as u32;
        a != b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_index_represents_a_set() {
        let mut sets = UnionFind::default();
        sets.reset(6);
        assert!(sets.unite(5, 3));
        assert!(sets.unite(3, 1));
        assert!(!sets.unite(1, 5));
        assert!(sets.unite(4, 2));
        assert_eq!((0..6).map(|i| sets.find(i)).collect::<Vec<_>>(), [0, 1, 2, 1, 2, 1]);
    }
}
