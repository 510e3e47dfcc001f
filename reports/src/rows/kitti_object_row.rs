//! `protocol_kitti_object.csv`: the objects of KITTI's evaluation of object detection, one row for every annotation, every
//! detection, every pair of them that overlaps enough to count somewhere, and every detection in a region that is not
//! labelled.
//!
//! Boxes are those of the files, in the rectified frame of the camera (x right, y down, z ahead) and in its image. Numbers
//! are written in full, since a result may hang on the last digit.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::exact_number::Exact;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::class::AnnotationClass;

/// A row of KITTI's evaluation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "KittiObjectRecord", try_from = "KittiObjectRecord")]
pub struct KittiObjectRow {
    /// The scan.
    pub scan: ScanName,
    /// Name of the detector.
    pub detector: String,
    /// Its content.
    pub fact: KittiFact,
}

/// Content of a row. Indices are those in the files of a scan, from 0; the evaluation of the makers depends on their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KittiFact {
    /// An annotated object.
    Annotation {
        /// Its index among the annotations.
        annotation: u32,
        /// Its class and its boxes.
        object: KittiBox,
        /// How much of it is hidden: 0 nothing, 1 a part, 2 most, 3 unknown.
        occlusion: i64,
        /// Share that the image cuts off, 0 to 1; −1 if unknown.
        truncation: f64,
    },
    /// A detection.
    Detection {
        /// Its index among the detections.
        detection: u32,
        /// Its class and its boxes.
        object: KittiBox,
        /// How sure the detector is.
        score: f64,
    },
    /// An annotation and a detection that overlap.
    Pair {
        /// Index of the annotation.
        annotation: u32,
        /// Index of the detection.
        detection: u32,
        /// Their overlap.
        overlap: KittiOverlap,
    },
    /// A detection in a region of the image in which nothing is labelled.
    DontCare {
        /// Index of the detection.
        detection: u32,
        /// The share of its box in the image that is in the region, 0 to 1.
        share: f64,
    },
}

/// Class and boxes of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiBox {
    /// The class.
    pub class: AnnotationClass,
    /// Left, top, right and bottom in the image, in pixels; −1 of what the image does not show.
    pub left_top_right_bottom_px: [f64; 4],
    /// Heading as the camera sees it, in radians; −10 if unknown.
    pub alpha_rad: f64,
    /// Centre of the bottom, in metres.
    pub bottom_center_m: [f64; 3],
    /// Height, width and length in metres.
    pub height_width_length_m: [f64; 3],
    /// Turn about the downward axis, in radians.
    pub rotation_y_rad: f64,
}

/// Intersection over union of two boxes, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiOverlap {
    /// Of the rectangles in the image.
    pub image: f64,
    /// Of the ground plans.
    pub birds_eye: f64,
    /// Of the volumes.
    pub volume: f64,
}

impl KittiBox {
    /// Height in the image, in pixels.
    pub fn height_px(&self) -> f64 {
        self.left_top_right_bottom_px[3] - self.left_top_right_bottom_px[1]
    }

    /// All its numbers, in the order of its fields.
    pub(crate) fn numbers(&self) -> [f64; 12] {
        let [left, top, right, bottom] = self.left_top_right_bottom_px;
        let ([x, y, z], [height, width, length]) = (self.bottom_center_m, self.height_width_length_m);
        [left, top, right, bottom, self.alpha_rad, x, y, z, height, width, length, self.rotation_y_rad]
    }

    fn of_numbers(class: AnnotationClass, numbers: [f64; 12]) -> Self {
        let [left, top, right, bottom, alpha_rad, x, y, z, height, width, length, rotation_y_rad] = numbers;
        Self {
            class,
            left_top_right_bottom_px: [left, top, right, bottom],
            alpha_rad,
            bottom_center_m: [x, y, z],
            height_width_length_m: [height, width, length],
            rotation_y_rad,
        }
    }
}

row! {
    for KittiObjectRow:
    #[derive(Default, Serialize, Deserialize)]
    struct KittiObjectRecord {
        scan: ScanName = ["dataset", "sequence", "scan"],
        detector: String,
        kind: Kind,
        annotation: Option<u32>,
        detection: Option<u32>,
        class: Option<AnnotationClass>,
        numbers: [Option<Exact>; 12] = [
            "left_px",
            "top_px",
            "right_px",
            "bottom_px",
            "alpha_rad",
            "bottom_center_x_m",
            "bottom_center_y_m",
            "bottom_center_z_m",
            "height_m",
            "width_m",
            "length_m",
            "rotation_y_rad",
        ],
        occlusion: Option<i64>,
        truncation: Option<Exact>,
        score: Option<Exact>,
        overlap: [Option<Exact>; 3] = ["overlap_image", "overlap_birds_eye", "overlap_volume"],
        dont_care_share: Option<Exact>,
    }
}

#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    #[default]
    Annotation,
    Detection,
    Pair,
    DontCare,
}

impl KittiObjectRecord {
    fn with_box(self, object: &KittiBox) -> Self {
        let numbers = object.numbers().map(|it| Some(Exact(it)));
        Self { class: Some(object.class), numbers, ..self }
    }

    /// The box of its columns; `None` if one of them is empty.
    fn object(&self) -> Option<KittiBox> {
        Some(KittiBox::of_numbers(self.class?, all(self.numbers)?))
    }

    fn overlap(&self) -> Option<KittiOverlap> {
        let [image, birds_eye, volume] = all(self.overlap)?;
        Some(KittiOverlap { image, birds_eye, volume })
    }

    fn fact(&self) -> Option<KittiFact> {
        Some(match self.kind {
            Kind::Annotation => KittiFact::Annotation {
                annotation: self.annotation?,
                object: self.object()?,
                occlusion: self.occlusion?,
                truncation: self.truncation?.0,
            },
            Kind::Detection => KittiFact::Detection {
                detection: self.detection?,
                object: self.object()?,
                score: self.score?.0,
            },
            Kind::Pair => KittiFact::Pair {
                annotation: self.annotation?,
                detection: self.detection?,
                overlap: self.overlap()?,
            },
            Kind::DontCare => {
                KittiFact::DontCare { detection: self.detection?, share: self.dont_care_share?.0 }
            }
        })
    }
}

/// The numbers of columns; `None` if one of them is empty.
fn all<const N: usize>(columns: [Option<Exact>; N]) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for (number, column) in numbers.iter_mut().zip(columns) {
        *number = column?.0;
    }
    Some(numbers)
}

impl From<KittiObjectRow> for KittiObjectRecord {
    fn from(row: KittiObjectRow) -> Self {
        let KittiObjectRow { scan, detector, fact } = row;
        let of_scan = Self { scan, detector, ..Self::default() };
        match fact {
            KittiFact::Annotation { annotation, object, occlusion, truncation } => Self {
                kind: Kind::Annotation,
                annotation: Some(annotation),
                occlusion: Some(occlusion),
                truncation: Some(Exact(truncation)),
                ..of_scan.with_box(&object)
            },
            KittiFact::Detection { detection, object, score } => Self {
                kind: Kind::Detection,
                detection: Some(detection),
                score: Some(Exact(score)),
                ..of_scan.with_box(&object)
            },
            KittiFact::Pair { annotation, detection, overlap } => Self {
                kind: Kind::Pair,
                annotation: Some(annotation),
                detection: Some(detection),
                overlap: [overlap.image, overlap.birds_eye, overlap.volume].map(|it| Some(Exact(it))),
                ..of_scan
            },
            KittiFact::DontCare { detection, share } => Self {
                kind: Kind::DontCare,
                detection: Some(detection),
                dont_care_share: Some(Exact(share)),
                ..of_scan
            },
        }
    }
}

impl TryFrom<KittiObjectRecord> for KittiObjectRow {
    type Error = &'static str;

    fn try_from(record: KittiObjectRecord) -> Result<Self, &'static str> {
        let fact = record.fact().ok_or("a column that its kind needs is empty")?;
        Ok(Self { scan: record.scan, detector: record.detector, fact })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};

    const CAR: KittiBox = KittiBox {
        class: AnnotationClass::Car,
        left_top_right_bottom_px: [100.5, 150.0, 200.25, 0.1 + 0.2],
        alpha_rad: -1.58,
        bottom_center_m: [1.84, 1.47, 8.41],
        height_width_length_m: [1.5, 1.6, 3.9],
        rotation_y_rad: 0.01,
    };

    fn rows() -> Vec<KittiObjectRow> {
        let facts = [
            KittiFact::Annotation { annotation: 3, object: CAR, occlusion: 1, truncation: 0.15 },
            KittiFact::Detection { detection: 0, object: CAR, score: -2.718_281_828_459_046 },
            KittiFact::Pair {
                annotation: 3,
                detection: 0,
                overlap: KittiOverlap { image: 1.0, birds_eye: 0.7, volume: 1.0 / 3.0 },
            },
            KittiFact::DontCare { detection: 0, share: 0.5 },
        ];
        let row = |fact| KittiObjectRow {
            scan: ScanName { dataset: "kitti-object".to_owned(), sequence: "training".to_owned(), scan: 7 },
            detector: "mine".to_owned(),
            fact,
        };
        facts.map(row).to_vec()
    }

    #[test]
    fn rows_come_back_to_the_last_digit() {
        assert_eq!(rows_of::<KittiObjectRow>(&csv_text(&rows())).unwrap(), rows());
    }

    #[test]
    fn a_row_without_what_its_kind_needs_is_refused_with_its_line() {
        let text = csv_text(&rows()).replace("-2.718281828459046", "");
        let causes = rows_of::<KittiObjectRow>(&text).expect_err("no score");
        assert!(causes.contains("line: 3") && causes.contains("a column that its kind needs"), "{causes}");
    }
}
