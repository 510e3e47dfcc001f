//! Classification of partly seen objects: curves over the part that is seen, and the claims of the paper about them.

pub mod object_draws;
pub mod partial_curves;
pub mod partial_claims;
pub mod peer_rows;
