//! Detections and annotations of another program, judged in memory as a run judges them.

pub mod request;
pub mod scans_in_memory;
pub mod scored;
