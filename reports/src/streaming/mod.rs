//! What detections are worth while the world moves on: counts over the moments of drives, and the numbers made of them.

pub mod closeness;
pub mod machine_speed;
pub mod stream_sums;
pub mod streamed;
