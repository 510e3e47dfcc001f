//! How objects are told of which only a part has been seen: curves over what is seen, and what the paper claims of them.

pub mod object_draws;
pub mod partial_curves;
pub mod partial_claims;
pub mod peer_rows;
