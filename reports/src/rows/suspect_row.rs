//! `suspects.csv`: labels that several detectors contradict.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::files::shown_text::printable_name;
use crate::vocabulary::named::named;

named! {
    /// Why a label is suspect.
    pub enum SuspectKind {
        /// No detector finds the labelled object.
        FoundByNone = "found-by-none",
        /// All detectors find something where nothing is labelled.
        NotLabelled = "not-labelled",
        /// All detectors find it elsewhere.
        Place = "place",
        /// For all detectors it is longer, or shorter.
        Size = "size",
        /// All detectors turn it the same way.
        Heading = "heading",
        /// All detectors give it the same other class.
        Class = "class",
    }
}

row! {
    /// A suspect label, or a place where one may be missing.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct SuspectRow {
        /// Id of the data set.
        #[serde(deserialize_with = "printable_name")]
        pub dataset: String,
        /// The drive.
        #[serde(deserialize_with = "printable_name")]
        pub sequence: String,
        /// Number of the scan within the drive.
        pub scan: u32,
        /// Why it is suspect.
        pub kind: SuspectKind,
        /// How unusual that is, in nats.
        pub(crate) surprise_nats: Fixed<3>,
        /// Number of the annotation; none where nothing is labelled.
        pub annotation_id: Option<u64>,
        /// The annotated class, or what the first detector takes it for.
        pub class: String,
        /// Number of its points, or of the first detection.
        pub n_points: u64,
        /// What the detectors say, in words.
        pub reason: String,
        /// Centre of the labelled box, or of the one that was found.
        pub(crate) center_x_m: Option<Fixed<3>>,
        pub(crate) center_y_m: Option<Fixed<3>>,
        pub(crate) center_z_m: Option<Fixed<3>>,
        /// Length along the heading, width and height of the first detector's box, where there is one.
        pub(crate) found_length_m: Option<Fixed<3>>,
        pub(crate) found_width_m: Option<Fixed<3>>,
        pub(crate) found_height_m: Option<Fixed<3>>,
        /// Its heading.
        pub(crate) found_yaw_rad: Option<Fixed<5>>,
    }
}

impl SuspectRow {
    /// Where it is on the ground plan, in metres, if that is known.
    pub fn position_m(&self) -> Option<[f32; 2]> {
        Some([self.center_x_m?, self.center_y_m?].map(|Fixed(at_m)| at_m as f32))
    }
}
