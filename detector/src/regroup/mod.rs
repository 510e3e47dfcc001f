//! Objects that are cut and joined again, once it is known what is a vehicle.

pub mod regrouping_params;
pub mod cut_places;
pub mod joinable;
pub mod regrouping;
