//! Rows of the kernel matrix, computed when they are first wanted.

use super::rbf_kernel::{LANES, VectorBlock, blocks_of, rbf_kernel};

/// Kept kernels take at most this much memory: 256 MiB.
const MAX_KERNELS: usize = 1 << 26;

/// The kernels of every vector with all others, row by row.
pub(super) struct KernelRows<'a, const D: usize> {
    vectors: &'a [[f32; D]],
    blocks: Vec<VectorBlock<D>>,
    gamma: f32,
    rows: Vec<Option<Box<[f32]>>>,
    n_kept: usize,
    max_kept: usize,
}

impl<'a, const D: usize> KernelRows<'a, D> {
    /// No row yet.
    pub fn new(vectors: &'a [[f32; D]], gamma: f32) -> Self {
        Self::with_capacity(vectors, gamma, MAX_KERNELS)
    }

    fn with_capacity(vectors: &'a [[f32; D]], gamma: f32, max_kernels: usize) -> Self {
        let max_kept = (max_kernels / vectors.len().max(1)).max(2);
        let rows = vectors.iter().map(|_| None).collect();
        Self { vectors, blocks: blocks_of(vectors), gamma, rows, n_kept: 0, max_kept }
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.vectors.len()
    }

    /// Makes sure that the rows of `wanted`, at most two, are there; others may be dropped.
    pub fn prepare<const N: usize>(&mut self, wanted: [usize; N]) {
        let n_missing = wanted.iter().filter(|&&row_idx| self.rows[row_idx].is_none()).count();
        if n_missing > 0 && self.n_kept + n_missing > self.max_kept {
            // Rare, and simpler than remembering which row was used last.
            self.rows.fill(None);
            self.n_kept = 0;
        }
        for row_idx in wanted {
            if self.rows[row_idx].is_none() {
                self.rows[row_idx] = Some(self.compute(row_idx));
                self.n_kept += 1;
            }
        }
    }

    /// A row that was prepared last.
    pub fn row(&self, row_idx: usize) -> &[f32] {
        self.rows[row_idx].as_deref().expect("rows are prepared before they are read")
    }

    fn compute(&self, row_idx: usize) -> Box<[f32]> {
        let vector = &self.vectors[row_idx];
        let mut row = Vec::with_capacity(self.blocks.len() * LANES);
        for block in &self.blocks {
            row.extend(rbf_kernel(vector, block, self.gamma));
        }
        row.truncate(self.vectors.len());
        row.into_boxed_slice()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_same_however_few_are_kept() {
        let vectors: Vec<[f32; 2]> = (0_u8..11).map(|it| [f32::from(it), f32::from(it * it % 7)]).collect();
        let mut all = KernelRows::new(&vectors, 0.1);
        let mut few = KernelRows::with_capacity(&vectors, 0.1, 2 * 11);
        for (a, b) in (0..11).flat_map(|a| (0..11).map(move |b| (a, b))) {
            all.prepare([a, b]);
            few.prepare([a, b]);
            assert_eq!((all.row(a), all.row(b)), (few.row(a), few.row(b)));
            assert!(few.n_kept <= 2);
            assert_eq!(all.row(a)[b], all.row(b)[a]);
            assert_eq!(all.row(a)[a], 1.0);
        }
    }
}
