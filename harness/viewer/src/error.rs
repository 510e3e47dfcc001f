//! Why a recording cannot be made.

use std::path::PathBuf;

/// Why a recording cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The address of the viewer cannot be understood.
    #[error("{url:?} is not the address of a viewer, such as rerun+http://127.0.0.1:9876/proxy: {reason}")]
    BadUrl {
        /// The given address.
        url: String,
        /// Why it is refused.
        reason: String,
    },
    /// The user's environment forbids recordings.
    #[error("the environment variable RERUN turns recordings off; unset it")]
    SwitchedOff,
    /// A viewer is to be started, but there is none.
    #[error(
        "there is no program `rerun` in PATH; install the viewer with `pip install rerun-sdk=={version}` or `cargo binstall rerun-cli@{version}`"
    )]
    ViewerNotInstalled {
        /// The version that fits the recordings.
        version: String,
    },
    /// A viewer is there, but does not start.
    #[error("cannot start the viewer `rerun`")]
    ViewerFailed {
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The recording cannot be served.
    #[error("cannot serve the recording at port {port} of 127.0.0.1")]
    Serve {
        /// The port.
        port: u16,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be created.
    #[error("cannot create the recording {path:?}")]
    Create {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be written to its end.
    #[error("cannot write the recording {path:?}: {reason}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The error, in Rerun's words.
        reason: String,
    },
    /// A recording that detectors are to join does not say how.
    #[error("no detector can join the recording with the layout {path:?}: {reason}")]
    NoLayout {
        /// The layer.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Rerun refused.
    #[error("cannot log {entity}: {reason}")]
    Log {
        /// The entity.
        entity: String,
        /// The error, in Rerun's words.
        reason: String,
    },
    /// A detector logs, but was not announced when the stream was opened.
    #[error("detector {detector:?} was not announced; announced are {announced:?}")]
    UnknownDetector {
        /// Its name.
        detector: String,
        /// The announced detectors.
        announced: Vec<String>,
    },
    /// A stage product of another scan.
    #[error("{product} of {detector} has {n_labels} labels, but the scan has {n_points} points")]
    ProductLength {
        /// The detector.
        detector: String,
        /// The product.
        product: &'static str,
        /// Points of the scan.
        n_points: usize,
        /// Labels of the product.
        n_labels: usize,
    },
    /// An assignment of another scan.
    #[error(
        "an assignment of {detector} has {n_annotation_outcomes} annotations and {n_detection_outcomes} detections, but the scan has {n_annotations} and {n_detections}"
    )]
    AssignmentLength {
        /// The detector.
        detector: String,
        /// Outcomes of annotations.
        n_annotation_outcomes: usize,
        /// Outcomes of detections.
        n_detection_outcomes: usize,
        /// Annotations of the scan.
        n_annotations: usize,
        /// Detections in the scan.
        n_detections: usize,
    },
}
