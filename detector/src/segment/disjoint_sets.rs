//! Sets that only ever merge.

/// A partition of `0..n` that starts as single elements.
#[derive(Debug, Clone, Default)]
pub struct DisjointSets {
    // Invariant: a parent is never larger than its child, so that the representative is the smallest element.
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Makes `n` sets of one element each.
    pub fn reset(&mut self, n: usize) {
        self.parent.clear();
        self.parent.extend(0..n as u32);
    }

    /// The smallest element of the set of `element`.
    pub fn representative(&mut self, mut element: u32) -> u32 {
        while self.parent[element as usize] != element {
            // Halving the path on the way keeps later look-ups short.
            let grandparent = self.parent[self.parent[element as usize] as usize];
            self.parent[element as usize] = grandparent;
            element = grandparent;
        }
        element
    }

    /// Merges the sets of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.representative(a), self.representative(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
