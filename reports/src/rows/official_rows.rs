//! The rows of protocols of others for one scan, or for several.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::csv_text;
use crate::rows::kitti_object_row::KittiObjectRow;
use crate::rows::label_score_row::LabelScoreRow;
use crate::rows::ranked_box_row::RankedBoxRow;

/// Rows of all kinds, each in the order of its file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfficialRows {
    /// Of protocols that rank boxes by the distance of centres.
    #[serde(with = "csv_text")]
    pub boxes: Vec<RankedBoxRow>,
    /// Of KITTI's evaluation of objects.
    #[serde(with = "csv_text")]
    pub kitti: Vec<KittiObjectRow>,
    /// Of protocols that score labels of points.
    #[serde(with = "csv_text")]
    pub labels: Vec<LabelScoreRow>,
}

impl OfficialRows {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.kitti.is_empty() && self.labels.is_empty()
    }

    /// Appends the rows of `other`.
    pub fn append(&mut self, other: Self) {
        self.boxes.extend(other.boxes);
        self.kitti.extend(other.kitti);
        self.labels.extend(other.labels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::kitti_object_row::KittiFact;
    use crate::rows::label_score_row::{LabelScore, SegmentationEntropies};
    use crate::rows::scan_name::ScanName;

    fn rows_of_scan(scan: u32) -> OfficialRows {
        let scan = ScanName { dataset: "a, \"b\"".to_owned(), sequence: "08".to_owned(), scan };
        let detector = "mine".to_owned();
        let fact = KittiFact::DontCare { detection: 3, share: 1.0 / 3.0 };
        let entropies = SegmentationEntropies { over_nats: 0.1 + 0.2, ..SegmentationEntropies::default() };
        OfficialRows {
            boxes: Vec::new(),
            kitti: vec![KittiObjectRow { scan: scan.clone(), detector: detector.clone(), fact }],
            labels: vec![LabelScoreRow { scan, detector, score: LabelScore::Entropies(entropies) }],
        }
    }

    #[test]
    fn rows_read_back_as_they_were() {
        let mut rows = rows_of_scan(1);
        rows.append(rows_of_scan(2));
        assert_eq!((rows.kitti.len(), rows.labels.len(), rows.is_empty()), (2, 2, false));
        let json = serde_json::to_string(&rows).unwrap();
        assert_eq!(serde_json::from_str::<OfficialRows>(&json).unwrap(), rows);
        let nothing = OfficialRows::default();
        assert!(nothing.is_empty());
        assert_eq!(
            serde_json::from_str::<OfficialRows>(&serde_json::to_string(&nothing).unwrap()).unwrap(),
            nothing
        );
    }

    #[test]
    fn damage_is_refused() {
        let json = serde_json::to_string(&rows_of_scan(1)).unwrap();
        for (from, to) in [("entropies", "entropy"), ("dont-care", "care"), ("\"labels\"", "\"tables\"")] {
            assert!(json.contains(from), "{json}");
            assert!(serde_json::from_str::<OfficialRows>(&json.replacen(from, to, 1)).is_err(), "{to}");
        }
    }
}
