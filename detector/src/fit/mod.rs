//! Boxes around objects.

pub mod outline;
pub mod convex_hull;
pub mod convex_hull_box;
pub mod strays;
pub mod outline_box;
pub mod principal_axes_box;
pub mod fitted_objects;
