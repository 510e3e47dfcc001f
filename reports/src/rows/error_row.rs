//! `errors.csv`: how many objects were missed, and how many detections are false, for each reason, and what repairing it
//! would gain.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::files::shown_text::printable_name;
use crate::vocabulary::reason::MistakeKind;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

row! {
    /// The mistakes of a detector for one reason.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct ErrorRow {
        /// Id of the data set, or the name of an [`Extent`](crate::vocabulary::extent::Extent) of several.
        #[serde(deserialize_with = "printable_name")]
        pub dataset: String,
        /// The task.
        pub task: Task,
        /// Name of the detector.
        #[serde(deserialize_with = "printable_name")]
        pub detector: String,
        /// Which objects: all, those of a class, or those in a bin of range.
        pub slice: Slice,
        /// Whether annotations were missed or detections are false.
        pub mistake: MistakeKind,
        /// Why: the name of a [`MissReason`](crate::vocabulary::reason::MissReason) or a
        /// [`FalseReason`](crate::vocabulary::reason::FalseReason).
        pub reason: String,
        /// How many.
        pub n: u64,
        /// Of how many: NO, the annotations that count, of what was missed; ND, the detections that count, of what is false.
        pub of: u64,
        /// What the F-rate, 0 to 1, would gain if these alone were repaired: were the missed objects found, or the false
        /// detections not there. `None` where the F-rate is undefined.
        pub(crate) f_rate_gain: Option<Fixed<6>>,
    }
}
