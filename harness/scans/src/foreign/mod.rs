//! Detections of other programs in the scans of a data set, read from their files.
//!
//! A format is a file here with a type that implements [`ResultReader`](result_reader::ResultReader);
//! [`open_results`](foreign_results::open_results) recognises the format and checks the detections.

pub mod foreign_class;
pub mod detections;
pub mod points_in_boxes;
pub mod result_files;
pub mod result_reader;
pub mod kitti_text;
pub mod nuscenes_json;
pub mod argoverse2_table;
pub mod semantic_labels;
pub mod own_files;
pub mod recorded_detections;
pub mod result_format;
pub mod foreign_results;
