//! `protocol_boxes.csv`: one row for every annotation and detection under a protocol that ranks boxes.
//!
//! Boxes are as the makers' own evaluation takes them, and numbers have all digits, so that it can be run on this file
//! alone.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::exact_number::Exact;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::protocol::{ERROR_DISTANCE, PAIR_DISTANCES_M, Protocol};

/// An annotation or a detection of a class that the protocol evaluates, with its outcome.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "BoxRecord", try_from = "BoxRecord")]
pub struct RankedBoxRow {
    /// The scan.
    pub scan: ScanName,
    /// Name of the detector.
    pub detector: String,
    /// The protocol.
    pub protocol: Protocol,
    /// The box.
    pub ranked_box: RankedBox,
}

/// A box of one scan.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedBox {
    /// Its index among the annotations, or among the detections, of the scan: from the best score down, boxes of like scores
    /// by their numbers.
    pub id: u32,
    /// Its name in the files.
    pub name: String,
    /// One of the protocol's classes.
    pub class: &'static str,
    /// Whether it is evaluated.
    pub state: BoxState,
    /// Its centre from where ranges are measured, in metres, on the axes of the makers' files.
    pub center_m: [f64; 3],
    /// Its sides, each above 0.
    pub length_width_height_m: [f64; 3],
    /// Its heading on the ground plan.
    pub yaw_rad: f64,
    /// Its velocity on the ground plan; `None` where it is not known.
    pub velocity_m_per_s: Option<[f64; 2]>,
    /// Its attribute: what the object is doing; `None` where it is not known.
    pub attribute: Option<String>,
    /// Number of points in it, as the makers count them; `None` of detections.
    pub n_points: Option<u64>,
    /// Whether it is an annotation or a detection, with what only a detection has.
    pub kind: BoxKind,
}

/// The kind of a box.
#[derive(Debug, Clone, PartialEq)]
pub enum BoxKind {
    /// An annotation.
    Annotation,
    /// A detection.
    Detection {
        /// How sure the detector is.
        score: f64,
        /// The annotation that it finds at each of [`PAIR_DISTANCES_M`].
        pairs: [Option<u32>; PAIR_DISTANCES_M.len()],
        /// How far it is from the annotation that it finds at 2 m.
        errors: Option<PairErrors>,
    },
}

/// How far a detection is from the annotation that it finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairErrors {
    /// Distance of the centres in metres, on the ground plan or in space as the protocol has it.
    pub translation_m: f64,
    /// One minus the intersection over union of the boxes, laid on one another.
    pub scale: f64,
    /// Angle between the headings.
    pub orientation_rad: f64,
    /// Difference of velocities in metres per second; `None` where one is not known.
    pub velocity_m_per_s: Option<f64>,
    /// 1 if the attribute is another, else 0; `None` where the annotation has none.
    pub attribute: Option<f64>,
}

/// Whether a box is evaluated, or why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxState {
    /// It is.
    Counts,
    /// It is too far away.
    BeyondRange,
    /// It holds no point.
    WithoutPoints,
    /// It stands in a rack for bicycles.
    InBikeRack,
    /// The protocol takes no more detections of its class in a scan.
    BeyondNumber,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindName {
    Annotation,
    Detection,
}

row! {
    for RankedBoxRow:
    #[derive(Serialize, Deserialize)]
    struct BoxRecord {
        scan: ScanName = ["dataset", "sequence", "scan"],
        detector: String,
        protocol: Protocol,
        kind: KindName,
        id: u32,
        name: String,
        class: String,
        state: BoxState,
        score: Option<Exact>,
        center_m: [Exact; 3] = ["center_x_m", "center_y_m", "center_z_m"],
        length_width_height_m: [Exact; 3] = ["length_m", "width_m", "height_m"],
        yaw_rad: Exact,
        velocity_m_per_s: [Option<Exact>; 2] = ["velocity_x_m_per_s", "velocity_y_m_per_s"],
        attribute: Option<String>,
        n_points: Option<u64>,
        pairs: [Option<u32>; 4] = ["pair_at_0.5_m", "pair_at_1_m", "pair_at_2_m", "pair_at_4_m"],
        errors: [Option<Exact>; 5] = [
            "translation_error_m",
            "scale_error",
            "orientation_error_rad",
            "velocity_error_m_per_s",
            "attribute_error",
        ],
    }
}

impl From<RankedBoxRow> for BoxRecord {
    fn from(row: RankedBoxRow) -> Self {
        let RankedBoxRow { scan, detector, protocol, ranked_box: it } = row;
        let (kind, score, pairs, errors) = match it.kind {
            BoxKind::Annotation => (KindName::Annotation, None, [None; 4], None),
            BoxKind::Detection { score, pairs, errors } => (KindName::Detection, Some(score), pairs, errors),
        };
        let in_columns = |it: PairErrors| {
            let [translation, scale, orientation] =
                [it.translation_m, it.scale, it.orientation_rad].map(Some);
            [translation, scale, orientation, it.velocity_m_per_s, it.attribute].map(|it| it.map(Exact))
        };
        Self {
            scan,
            detector,
            protocol,
            kind,
            id: it.id,
            name: it.name,
            class: it.class.to_owned(),
            state: it.state,
            score: score.map(Exact),
            center_m: it.center_m.map(Exact),
            length_width_height_m: it.length_width_height_m.map(Exact),
            yaw_rad: Exact(it.yaw_rad),
            velocity_m_per_s: it.velocity_m_per_s.map_or([None; 2], |it| it.map(|it| Some(Exact(it)))),
            attribute: it.attribute,
            n_points: it.n_points,
            pairs,
            errors: errors.map_or([None; 5], in_columns),
        }
    }
}

impl TryFrom<BoxRecord> for RankedBoxRow {
    type Error = String;

    fn try_from(record: BoxRecord) -> Result<Self, String> {
        let class = record.protocol.class_named(&record.class);
        let class = class.ok_or_else(|| format!("{} has no class {:?}", record.protocol, record.class))?;
        let kind = record.kind()?;
        let sides_m = record.length_width_height_m.map(|it| it.0);
        if sides_m.iter().any(|it| *it <= 0.0) {
            return Err(format!("a box has sides of {sides_m:?} m"));
        }
        let [velocity_x, velocity_y] = record.velocity_m_per_s;
        Ok(Self {
            scan: record.scan,
            detector: record.detector,
            protocol: record.protocol,
            ranked_box: RankedBox {
                id: record.id,
                name: record.name,
                class,
                state: record.state,
                center_m: record.center_m.map(|it| it.0),
                length_width_height_m: sides_m,
                yaw_rad: record.yaw_rad.0,
                velocity_m_per_s: velocity_x.zip(velocity_y).map(|(x, y)| [x.0, y.0]),
                attribute: record.attribute,
                n_points: record.n_points,
                kind,
            },
        })
    }
}

impl BoxRecord {
    fn kind(&self) -> Result<BoxKind, String> {
        let pairs = self.pairs;
        let score = match (self.kind, self.score) {
            (KindName::Detection, Some(score)) => score.0,
            (KindName::Detection, None) => return Err("a detection has no score".to_owned()),
            (KindName::Annotation, None) if pairs == [None; 4] => return Ok(BoxKind::Annotation),
            (KindName::Annotation, _) => return Err("an annotation has a score or a pair".to_owned()),
        };
        let errors = match self.errors.map(|it| it.map(|it| it.0)) {
            [Some(translation_m), Some(scale), Some(orientation_rad), velocity_m_per_s, attribute] => {
                Some(PairErrors { translation_m, scale, orientation_rad, velocity_m_per_s, attribute })
            }
            _ => None,
        };
        if errors.is_some() != pairs[ERROR_DISTANCE].is_some() {
            return Err("errors belong to pairs at 2 m, and to no others".to_owned());
        }
        Ok(BoxKind::Detection { score, pairs, errors })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};

    /// A car that was labelled, and a detection half a metre and a little beside it.
    fn rows() -> [RankedBoxRow; 2] {
        let car = RankedBox {
            id: 0,
            name: "vehicle.car".to_owned(),
            class: "car",
            state: BoxState::Counts,
            center_m: [10.0, -0.0, 0.9],
            length_width_height_m: [4.0, 2.0, 1.5],
            yaw_rad: 0.1,
            velocity_m_per_s: Some([1.0, 0.0]),
            attribute: Some("vehicle.moving".to_owned()),
            n_points: Some(12),
            kind: BoxKind::Annotation,
        };
        let errors = PairErrors {
            translation_m: 0.6,
            scale: 0.25,
            orientation_rad: 0.0,
            velocity_m_per_s: None,
            attribute: Some(1.0),
        };
        let found = RankedBox {
            name: "car".to_owned(),
            velocity_m_per_s: None,
            attribute: None,
            n_points: None,
            kind: BoxKind::Detection {
                score: 0.1 + 0.2,
                pairs: [None, Some(0), Some(0), Some(0)],
                errors: Some(errors),
            },
            ..car.clone()
        };
        [car, found].map(|ranked_box| RankedBoxRow {
            scan: ScanName { dataset: "street".to_owned(), sequence: "0000".to_owned(), scan: 7 },
            detector: "pca".to_owned(),
            protocol: Protocol::Nuscenes,
            ranked_box,
        })
    }

    fn written() -> String {
        csv_text(&rows())
    }

    #[test]
    fn rows_read_back_as_they_were() {
        assert_eq!(rows_of::<RankedBoxRow>(&written()).unwrap(), rows());
        assert!(written().contains(",0.30000000000000004,"), "{}", written());
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, problem: &str) {
        let changed = written().replacen(from, to, 1);
        assert_ne!(changed, written());
        let error = rows_of::<RankedBoxRow>(&changed).unwrap_err();
        assert!(error.contains(problem), "{error}");
    }

    #[test]
    fn rows_that_contradict_each_other_are_refused() {
        check_refused(",car,counts,,", ",lorry,counts,,", "has no class \"lorry\"");
        check_refused(",car,counts,,", ",car,counts,0.5,", "an annotation has a score or a pair");
        check_refused(",0.30000000000000004,", ",,", "a detection has no score");
        check_refused(",4.0,2.0,1.5,", ",4.0,0.0,1.5,", "sides of [4.0, 0.0, 1.5] m");
        check_refused(",0.6,0.25,0.0,", ",,0.25,0.0,", "errors belong to pairs at 2 m");
        check_refused(",10.0,", ",inf,", "not a finite number");
    }
}
