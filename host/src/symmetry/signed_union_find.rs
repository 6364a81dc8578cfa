//! Signed union-find: disjoint sets of creases that turn alike, each crease with a sign (union-find with parity).

/// Disjoint sets of items, each with a sign relative to its set.
#[derive(Clone)]
pub(super) struct SignedUnionFind {
    parent: Vec<u32>,
    /// `true` if the item turns against its parent.
    negative: Vec<bool>,
    /// For each representative the lowest and highest value in its set, relative to the sign of the representative; ∞
    /// and -∞ if no item of the set has a value.
    range: Vec<[f64; 2]>,
    /// Largest difference between two values of a set.
    spread: f64,
}

impl SignedUnionFind {
    /// Makes a set of each item, with its value if it has one. No set may come to hold values more than `spread` apart.
    pub(super) fn new(values: impl Iterator<Item = Option<f64>>, spread: f64) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let range: Vec<_> = values.map(|v| v.map_or(none, |v| [v, v])).collect();
        Self {
            parent: (0..).take(range.len()).collect(),
            negative: vec![false; range.len()],
            range,
            spread,
        }
    }

    /// Returns the representative of the item's set, and `true` if the item turns against it.
    pub(super) fn find(&mut self, item: usize) -> (usize, bool) {
        let mut root = item;
        let mut negative = false;
        while self.parent[root] as usize != root {
            negative ^= self.negative[root];
            root = self.parent[root] as usize;
        }
        // Path compression: every item on the way is attached to the root directly.
        let (mut item, mut sign) = (item, negative);
        while self.parent[item] as usize != root && item != root {
            let next = self.parent[item] as usize;
            let next_sign = sign ^ self.negative[item];
            self.parent[item] = self.parent[root];
            self.negative[item] = sign;
            (item, sign) = (next, next_sign);
        }
        (root, negative)
    }

    /// Returns `true` if both items are known to turn alike (with `negative`: against each other).
    pub(super) fn related(&mut self, a: usize, b: usize, negative: bool) -> bool {
        let ((a, a_sign), (b, b_sign)) = (self.find(a), self.find(b));
        a == b && a_sign ^ b_sign == negative
    }

    /// Joins the sets of two items that turn alike (with `negative`: against each other). The smaller of the two
    /// representatives represents the joined set. Returns `false` and changes nothing if that contradicts the known
    /// signs, or if values of the joined set would be too far apart.
    pub(super) fn join(&mut self, a: usize, b: usize, negative: bool) -> bool {
        let ((a, a_sign), (b, b_sign)) = (self.find(a), self.find(b));
        if a == b {
            return a_sign ^ b_sign == negative;
        }
        let (root, child) = (a.min(b), a.max(b));
        let [low, high] = self.range[root];
        let mut other = self.range[child];
        if a_sign ^ b_sign ^ negative {
            other = [-other[1], -other[0]];
        }
        let range = [low.min(other[0]), high.max(other[1])];
        if range[1] - range[0] > self.spread {
            return false;
        }
        self.range[root] = range;
        self.parent[child] = self.parent[root];
        self.negative[child] = a_sign ^ b_sign ^ negative;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parity_is_carried_through_chains_and_contradictions_are_refused() {
        let mut sets = SignedUnionFind::new([None; 5].into_iter(), 0.0);
        assert!(sets.join(4, 3, true) && sets.join(3, 2, true) && sets.join(2, 1, true));
        assert!(sets.related(4, 1, true) && sets.related(4, 2, false));
        assert!(!sets.related(0, 1, false));
        assert!(!sets.join(1, 3, true));
        assert_eq!(sets.find(4), (1, true));
        assert_eq!(sets.find(0), (0, false));
    }

    /// Each value is close enough to the next, but the first is too far from the last.
    #[test]
    fn values_never_drift_apart_along_a_chain() {
        let values = [Some(1.0), Some(-1.4), None, Some(1.8)];
        let mut sets = SignedUnionFind::new(values.into_iter(), 0.5);
        assert!(sets.join(0, 1, true) && sets.join(1, 2, true));
        assert!(!sets.join(2, 3, false) && !sets.related(0, 3, false));
        assert!(!sets.join(3, 1, false), "of opposite sign");
    }
}
