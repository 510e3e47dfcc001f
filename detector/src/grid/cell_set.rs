//! A set of cells of a grid.

/// A set of cells that comes out in ascending order without being sorted: one bit a cell, read word by word.
#[derive(Debug, Clone)]
pub struct CellSet {
    words: Vec<u64>,
    ascending: Vec<u32>,
}

impl CellSet {
    /// The empty set of cells below `n_cells`.
    pub fn new(n_cells: usize) -> Self {
        Self { words: vec![0; n_cells.div_ceil(64)], ascending: Vec::new() }
    }

    /// Forgets all cells.
    pub fn clear(&mut self) {
        self.words.fill(0);
        self.ascending.clear();
    }

    /// Adds a cell, which may be in it already. [`Self::ascending`] lists it after the next [`Self::sort`].
    pub fn insert(&mut self, cell_idx: u32) {
        self.words[cell_idx as usize / 64] |= 1 << (cell_idx % 64);
    }

    /// Makes [`Self::ascending`] list every cell inserted since the set was cleared.
    pub fn sort(&mut self) {
        self.ascending.clear();
        for (&word, first_cell) in self.words.iter().zip((0..).step_by(64)) {
            let mut left = word;
            while left != 0 {
                self.ascending.push(first_cell + left.trailing_zeros());
                left &= left - 1;
            }
        }
    }

    /// The cells, each once.
    pub fn ascending(&self) -> &[u32] {
        &self.ascending
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn cells_come_out_once_and_ascending(cells in prop::collection::vec(0_u32..300, 0..200)) {
            let mut set = CellSet::new(300);
            set.insert(299);
            set.sort();
            set.clear();
            for &cell_idx in &cells {
                set.insert(cell_idx);
            }
            set.sort();
            let expected: BTreeSet<u32> = cells.into_iter().collect();
            prop_assert!(set.ascending().iter().eq(&expected));
        }
    }
}
