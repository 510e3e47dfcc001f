//! What tells vehicles from other objects.

pub mod box_frame_points;
pub mod corner_spheres;
pub mod elevation_spread;
pub mod side_shares;
pub mod lengthwise_thirds;
pub mod surface_roughness;
pub mod surroundings;
pub mod seen_size;
pub mod side_profile;
pub mod turning_function;
pub mod trained_file;
pub mod prototype_library;
pub mod prototype_file;
pub mod vehicle_features;
