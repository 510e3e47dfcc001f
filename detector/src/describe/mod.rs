//! The features that distinguish vehicles from other objects.

// Which objects are described at all, and their surroundings.
pub mod seen_size;
mod cells_near;
pub mod surroundings;
pub mod cells_around;

// The points in the frame of their box, and the values taken from them.
pub mod box_frame_points;
pub mod corner_spheres;
pub mod side_profile;
pub mod elevation_spread;
pub mod side_shares;
pub mod lengthwise_thirds;
pub mod height_slices;
pub mod surface_roughness;

// The side profiles of known vehicles.
pub mod turning_function;
pub mod trained_file;
pub mod prototype_library;
pub mod prototype_file;

// The values that a classifier sees of an object: those of the papers, and ours.
pub mod object_describer;
pub mod paper_features;
pub mod vehicle_features;
