//! Data sets as their readers see them: damaged ones, and real ones where they are there.

mod damaged_datasets;
mod kitti_real_scans;
