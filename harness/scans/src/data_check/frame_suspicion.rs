//! Possible errors in the frame of scans and labels.

use std::fmt;

use super::empty_boxes::{EmptyBoxes, NEAR_M};
use super::label_suspicion::LabelSuspicion;
use super::same_position::SamePosition;
use super::seen_ground::UpAxis;

/// No sensor is so low above the ground, in metres.
const LEAST_HEIGHT_M: f64 = 0.3;

/// Why the frame of a data set is suspect, and what to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameSuspicion {
    /// There is no ground around the origin.
    NoGround,
    /// Another axis than z points up.
    Axis(UpAxis),
    /// The origin is this high above the ground, in metres, where no sensor is.
    OnGround(f64),
    /// The ground is not where the height of the sensor puts it.
    Height {
        /// How high the origin is above the ground, in metres.
        seen_m: f64,
        /// How high the sensor is said to be, in metres.
        said_m: f64,
    },
    /// The ground is tilted by this many degrees.
    Tilt(f64),
    /// Most boxes hold no point.
    EmptyBoxes(EmptyBoxes),
    /// Many points are at one position.
    SamePosition(SamePosition),
    /// Labels do not lie where the points are.
    Labels(LabelSuspicion),
}

impl FrameSuspicion {
    /// Whether the suspicion is about the labels, and not about the frame of the scans.
    pub fn is_about_labels(&self) -> bool {
        matches!(self, Self::Labels(_) | Self::EmptyBoxes(_))
    }

    /// Whether numbers are in doubt. Objects may really lie to one side, as their annotators know. Points without a return
    /// are the same for all detectors.
    pub fn is_doubt(&self) -> bool {
        !matches!(self, Self::Labels(LabelSuspicion::Sector { .. }) | Self::SamePosition(_))
    }
}

impl fmt::Display for FrameSuspicion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoGround => write!(
                formatter,
                "no ground is seen around the origin; see in the recording of a run whether z is up"
            ),
            Self::Axis(axis) => write!(
                formatter,
                "the axis that points up is {}, not z: write `{}` into a file, and give it with --transform FILE",
                axis.name(),
                axis.sensor_from_file()
            ),
            Self::OnGround(seen_m) => write!(
                formatter,
                "the origin is {seen_m:.2} m above the ground, where no sensor is: move it to the sensor with --transform"
            ),
            Self::Height { seen_m, said_m } => {
                let correct = if *seen_m < LEAST_HEIGHT_M {
                    String::new()
                } else {
                    format!("correct it with --sensor-height {seen_m:.2}, or ")
                };
                write!(
                    formatter,
                    "the ground is {seen_m:.2} m below the origin, but the sensor is said to be {} m above the road: {correct}move \
                     the origin to the sensor with --transform",
                    *said_m as f32
                )
            }
            Self::Tilt(tilt_deg) => write!(
                formatter,
                "the ground is tilted by {tilt_deg:.1} degrees in the frame of the scans: level it with --transform"
            ),
            Self::EmptyBoxes(EmptyBoxes { n_near, n_empty }) => write!(
                formatter,
                "{n_empty} of {n_near} boxes nearer than {NEAR_M} m contain no point: the labels and scans may differ in \
                 frame or time"
            ),
            Self::SamePosition(SamePosition { share, position_m: [x_m, y_m, z_m] }) => write!(
                formatter,
                "{:.0} % of the points of a scan are at {x_m} {y_m} {z_m}, as drivers write beams without a return: leave \
                 them out, or write NaN",
                100.0 * share
            ),
            Self::Labels(suspicion) => write!(formatter, "{suspicion}"),
        }
    }
}
