//! Recordings for the Rerun viewer; the only crate that knows Rerun.
//!
//! A [`session::Stream`] takes labelled scans, the results of each detector and the outcome of every object, and writes them
//! to an `.rrd` file and, on request, to a viewer at the same time. It draws the generic products of
//! [`detector::stage_product`], so a new detector is drawn without a new line here.
//!
//! A recording is a view: nothing is read back from it.

pub mod palette;
mod error;
mod legend;
mod entity_paths;
mod recording_axis;
mod recording;
mod rounding;
mod drawn_points;
mod box_edges;
mod archetypes;
mod product_views;
mod recording_file;
mod viewer;
mod stream_options;
mod recording_layout;
mod layers;
mod single_file;
mod blueprint;
mod scan_views;
mod log_static;
mod log_scan;
mod log_products;
mod log_scores;
mod log_outcomes;
mod log_series;
pub mod session;
mod drive_frame;
pub mod run_recording;
pub mod sweep_recording;
pub mod partial_recording;
pub mod stream_recording;
pub mod marks_layer;

pub use drawn_points::PointChoice;
pub use error::StreamError;
pub use recording_axis::RecordingAxis;
pub use scan_views::{DetectorView, ScanView, TaskView};
pub use session::{Stream, StreamEnding};
pub use stream_options::{FirstTab, Opening, RecordingTarget, StreamOptions};
pub use viewer::{ServedRecording, ViewerChoice, ViewerState, ViewerUrl};

/// Version of the Rerun library; a viewer of this version opens the recordings.
pub fn rerun_version() -> String {
    rerun::build_info().version.to_string()
}
