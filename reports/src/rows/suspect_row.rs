//! `suspects.csv`: labels that several detectors contradict.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::files::shown_text::printable_name;
use crate::rows::match_outcome::BoxFacts;
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

row! {
    /// A suspect label in a project of an annotation tool.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct SuspectBoxRow {
        /// Its rank among the suspects.
        pub rank: u32,
        /// Data set, drive and scan.
        pub scan: String,
        /// The file of the project that it is in.
        pub file: String,
        /// Its place among the boxes of that file, from 1.
        pub place: u32,
        /// Why it is suspect.
        pub kind: SuspectKind,
        /// The labelled class, or what the first detector takes it for.
        pub class: String,
        /// What the detectors say, in words.
        pub reason: String,
    }
}

impl SuspectRow {
    /// The box that the first detector found where nothing is labelled, if its size is known.
    pub fn unlabelled_box(&self) -> Option<BoxFacts> {
        if self.annotation_id.is_some() {
            return None;
        }
        let known = |values: [Option<Fixed<3>>; 3]| {
            let [Fixed(a), Fixed(b), Fixed(c)] = [values[0]?, values[1]?, values[2]?];
            Some([a, b, c].map(|it| it as f32))
        };
        Some(BoxFacts {
            center_m: known([self.center_x_m, self.center_y_m, self.center_z_m])?,
            length_width_height_m: known([self.found_length_m, self.found_width_m, self.found_height_m])?,
            yaw_rad: self.found_yaw_rad?.0 as f32,
        })
    }

    /// Where it is on the ground plan, in metres, if that is known.
    pub fn position_m(&self) -> Option<[f32; 2]> {
        Some([self.center_x_m?, self.center_y_m?].map(|Fixed(at_m)| at_m as f32))
    }
}
