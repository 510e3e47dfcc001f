//! Data sets and results as their readers see them: damaged ones, and real ones where they are there.

mod columns_of_real_scans;
mod damaged_datasets;
mod foreign_real_scans;
mod kitti_real_scans;
mod cut_out_real_objects;
mod labels_against_points;
