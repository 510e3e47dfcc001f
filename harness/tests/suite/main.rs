//! Tests of the whole: the structure of the code, and the program from outside.

mod damaged_datasets;
mod kitti_real_scans;
mod layers;
