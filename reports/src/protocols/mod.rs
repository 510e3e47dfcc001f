//! The numbers that others publish, made of rows as their makers make them, and how sure they are.

pub mod protocol_number;
pub mod drawn_scans;
pub mod under_protocol;
mod scan_terms;
mod semantic_kitti;
mod ground;
mod ranked_classes;
mod recall_grid;
mod nuscenes_curves;
mod argoverse2_precisions;
pub mod nuscenes;
pub mod argoverse2;
pub mod kitti_object;
pub mod protocol_tally;
#[cfg(test)]
mod made_rows;
pub mod protocol_report;
mod short_forms;
pub mod given_classes;
pub mod swept_numbers;
