//! KITTI's object benchmark: rows made of labels and results in the form of KITTI's files.

pub mod overlaps;
pub mod scan_facts;
pub mod label_facts;
pub mod protocol;
#[cfg(test)]
mod kit_vectors;
