//! KITTI's object benchmark: from labels and results, as KITTI's files have them, to rows.

pub mod overlaps;
pub mod scan_facts;
pub mod label_facts;
pub mod protocol;
#[cfg(test)]
mod kit_vectors;
