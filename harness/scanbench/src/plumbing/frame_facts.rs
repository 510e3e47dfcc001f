//! Facts about the frame of a data set, and which of them are stated.

use reports::run_folder::manifest::SeenMounting;
use reports::run_folder::seen_labels::SeenLabels;
use scans::data_check::frame_suspicion::FrameSuspicion;

use crate::cli::SourceArgs;

/// The look at the first scans of a data set.
#[derive(Debug, Clone, Default)]
pub struct FirstLook {
    /// Sensor and mounting; `None` for simulated scans, unless their density was taken from them.
    pub seen: Option<SeenMounting>,
    /// Where points lie in the frames of labelled boxes; `None` if these are too few.
    pub label_points: Option<SeenLabels>,
    /// Why its frame or its labels are suspect.
    pub suspicions: Vec<FrameSuspicion>,
    /// Whether the user says that the labels are right, whatever is suspect about them.
    pub labels_are_right: bool,
}

impl FirstLook {
    /// Whether labels are in doubt, and the user has not overruled it.
    pub fn doubts_labels(&self) -> bool {
        !self.labels_are_right && self.suspicions.iter().any(|it| it.is_about_labels() && it.is_doubt())
    }

    /// The doubts about numbers that the user did not overrule, and those that the user did, a sentence each.
    pub fn doubts(&self) -> [Vec<String>; 2] {
        let is_overruled = |it: &&FrameSuspicion| self.labels_are_right && it.is_about_labels();
        let (overruled, doubts): (Vec<_>, Vec<_>) =
            self.suspicions.iter().filter(|it| it.is_doubt()).partition(is_overruled);
        [doubts, overruled].map(|it| it.into_iter().map(ToString::to_string).collect())
    }
}

/// Facts about the sensor that the user, the catalogue or a data sheet states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stated {
    pub sensor: bool,
    pub height: bool,
    /// The transform from the frame of the files to the sensor.
    pub transform: bool,
}

impl Stated {
    pub const ALL: Self = Self { sensor: true, height: true, transform: true };

    /// Facts that the options of the command line state.
    pub fn by_options(source: &SourceArgs) -> Self {
        Self {
            sensor: source.sensor.is_some(),
            height: source.sensor_height.is_some(),
            transform: source.transform.is_some(),
        }
    }
}

/// Largest number of scans that are looked at, from first to last.
const N_SCANS: usize = 5;

/// Indices of the scans that are looked at, of `n` scans: always the same of a data set, whichever of them are run.
pub fn indices_looked_at(n: usize) -> impl Iterator<Item = usize> {
    (0..n.min(N_SCANS)).map(move |it| it * n / n.min(N_SCANS))
}
