//! Detectors that are programs of their own: `docs/protocol.md`. The time to ask one and to get its answer, without
//! detection, is the process overhead.

pub mod problem;
pub mod message;
pub mod answer;
pub mod written_answer;
#[cfg(target_os = "linux")]
pub mod pipe;
#[cfg(target_os = "linux")]
pub mod shared_cloud;
#[cfg(target_os = "linux")]
pub mod received_cloud;
#[cfg(target_os = "linux")]
pub mod last_words;
#[cfg(target_os = "linux")]
pub mod processes;
#[cfg(target_os = "linux")]
mod sandbox;
#[cfg(target_os = "linux")]
pub mod supervisor;
#[cfg(target_os = "linux")]
pub mod program;
#[cfg(target_os = "linux")]
pub mod conversation;
