//! Possible errors of labels, as the points of labelled vehicles show them.

use std::fmt;

use super::label_correction::Correction;
use crate::dataset::proposal_list::PROPOSALS_CSV;

/// Why labels are suspect, and how to correct them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LabelSuspicion {
    /// Boxes lie beside their vehicles.
    Position {
        /// The change that corrects it.
        correction: Correction,
        /// How many times as well points lie along the sides of the changed boxes.
        gain: f64,
        /// Vehicles that were looked at.
        n_vehicles: usize,
    },
    /// Boxes hang above the ground, or are sunk into it.
    Height {
        /// How far bottoms are above the ground, the median in metres.
        above_ground_m: f64,
        /// A possible reason.
        taken_for: TakenFor,
        /// Vehicles that were looked at.
        n_vehicles: usize,
    },
    /// Most vehicles are wider than long, but points lie along their sides.
    Sideways {
        /// Vehicles that are wider than long.
        n_wide: usize,
        /// Vehicles that were looked at.
        n_vehicles: usize,
    },
    /// Boxes hold no point where others at the same range hold many.
    Holes {
        /// Boxes without a point.
        n_empty: usize,
        /// Vehicles among boxes with many points.
        n_vehicles: usize,
    },
    /// All boxes lie to one side, as where only the view of a camera is labelled.
    Sector {
        /// The angle around the sensor that holds the centres of all boxes.
        width_deg: f64,
        /// Share of the points outside of this angle.
        share_elsewhere: f64,
        /// Labelled boxes that were looked at.
        n_boxes: usize,
    },
    /// Most boxes are as a detector proposed them.
    Proposed {
        /// Boxes that are as proposed.
        n_proposed: usize,
        /// Labelled boxes that were looked at.
        n_boxes: usize,
    },
    /// Yaws are beyond a whole turn.
    Degrees {
        /// Yaws beyond a whole turn.
        n_beyond: usize,
        /// Labelled boxes that were looked at.
        n_boxes: usize,
    },
}

impl LabelSuspicion {
    /// Its text for boxes of a detector: results instead of labels.
    pub fn about_results(&self) -> String {
        self.to_string().replace("labels", "results")
    }
}

/// Reason why boxes have a wrong height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakenFor {
    /// The height of the bottom stands where that of the centre belongs.
    BottomForCentre,
    /// The height of the centre stands where that of the bottom belongs.
    CentreForBottom,
    /// No known reason.
    Unknown,
}

impl fmt::Display for LabelSuspicion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Position { correction, gain, n_vehicles } => write!(
                formatter,
                "the points of {n_vehicles} vehicles do not lie along the sides of their boxes; {correction}; they fit \
                 {gain:.1} times as well then"
            ),
            Self::Height { above_ground_m, taken_for, n_vehicles } => {
                let [where_, off_m] = if above_ground_m < 0.0 { ["below", "+"] } else { ["above", "-"] };
                let distance_m = above_ground_m.abs();
                let mend = match taken_for {
                    TakenFor::BottomForCentre => {
                        "as if the z of bottoms stood for that of centres: add half the height of each box".to_owned()
                    }
                    TakenFor::CentreForBottom => {
                        "as if the z of centres stood for that of bottoms: subtract half the height of each box".to_owned()
                    }
                    TakenFor::Unknown => format!("add {off_m}{distance_m:.2} m to every z in the labels"),
                };
                write!(
                    formatter,
                    "the bottoms of the boxes of {n_vehicles} vehicles are {distance_m:.2} m {where_} the ground (median): {mend}"
                )
            }
            Self::Sideways { n_wide, n_vehicles } => write!(
                formatter,
                "{n_wide} of {n_vehicles} vehicles are wider than long, but points lie along their sides: swap length and width, and \
                 turn yaws by 90 degrees"
            ),
            Self::Holes { n_empty, n_vehicles } => write!(
                formatter,
                "{n_empty} of {n_vehicles} boxes of vehicles hold no point, but others at the same range hold many: leave out boxes of \
                 what the sensor cannot see, and look for labels of other scans"
            ),
            Self::Sector { width_deg, share_elsewhere, n_boxes } => write!(
                formatter,
                "all {n_boxes} boxes lie within {width_deg:.0} degrees around the sensor, and {:.0} % of the points elsewhere: if only \
                 this part is labelled, detections elsewhere count as false; then leave out those points",
                100.0 * share_elsewhere
            ),
            Self::Proposed { n_proposed, n_boxes } => write!(
                formatter,
                "{n_proposed} of {n_boxes} boxes are as a detector proposed them ({PROPOSALS_CSV}): labels of a detector cannot \
                 judge it, so correct them first"
            ),
            Self::Degrees { n_beyond, n_boxes } => write!(
                formatter,
                "{n_beyond} of {n_boxes} yaws are beyond a whole turn, as if they were degrees: write them in radians"
            ),
        }
    }
}
