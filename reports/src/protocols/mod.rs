//! The numbers that others publish, made of rows as their makers make them, and how sure they are.

pub mod kitti_object;
