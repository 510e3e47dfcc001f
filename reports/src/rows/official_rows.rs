//! The rows of protocols of others that come of one scan, or of several.

use std::path::Path;

use serde::ser::Error as _;
use serde::{Deserialize, Serialize, Serializer};

use crate::files::archive::ArchiveError;
use crate::files::causes::with_causes;
use crate::files::csv_rows::{CsvRow, csv_head, each_row_of, to_csv_lines};
use crate::rows::kitti_object_row::KittiObjectRow;
use crate::rows::label_score_row::LabelScoreRow;
use crate::rows::ranked_box_row::RankedBoxRow;

/// Rows of all kinds, each in the order of its file.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(try_from = "OfficialLines")]
pub struct OfficialRows {
    /// Of protocols that rank boxes by the distance of centres.
    pub boxes: Vec<RankedBoxRow>,
    /// Of KITTI's evaluation of objects.
    pub kitti: Vec<KittiObjectRow>,
    /// Of protocols that score labels of points.
    pub labels: Vec<LabelScoreRow>,
}

/// The same as lines of their files.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfficialLines {
    /// Those of `protocol_boxes.csv`.
    pub boxes: String,
    /// Those of `protocol_kitti_object.csv`.
    pub kitti: String,
    /// Those of `protocol_labels.csv`.
    pub labels: String,
}

impl OfficialRows {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.kitti.is_empty() && self.labels.is_empty()
    }

    /// Appends those of `other`.
    pub fn append(&mut self, other: Self) {
        self.boxes.extend(other.boxes);
        self.kitti.extend(other.kitti);
        self.labels.extend(other.labels);
    }

    /// The rows as lines.
    ///
    /// # Errors
    ///
    /// If a number of a row is not finite.
    pub fn to_lines(&self) -> Result<OfficialLines, csv::Error> {
        Ok(OfficialLines {
            boxes: lines(&self.boxes)?,
            kitti: lines(&self.kitti)?,
            labels: lines(&self.labels)?,
        })
    }
}

fn lines<Row: CsvRow>(rows: &[Row]) -> Result<String, csv::Error> {
    Ok(String::from_utf8(to_csv_lines(rows)?).expect("rows are text"))
}

fn rows<Row: CsvRow>(lines: &str, name: &str) -> Result<Vec<Row>, ArchiveError> {
    let mut text = csv_head::<Row>();
    text.extend(lines.as_bytes());
    let mut rows = Vec::new();
    each_row_of(&*text, Path::new(name), |row| rows.push(row))?;
    Ok(rows)
}

impl Serialize for OfficialRows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_lines().map_err(S::Error::custom)?.serialize(serializer)
    }
}

impl TryFrom<OfficialLines> for OfficialRows {
    type Error = String;

    fn try_from(it: OfficialLines) -> Result<Self, String> {
        let words = |error: ArchiveError| with_causes(&error);
        Ok(Self {
            boxes: rows(&it.boxes, "boxes").map_err(words)?,
            kitti: rows(&it.kitti, "kitti").map_err(words)?,
            labels: rows(&it.labels, "labels").map_err(words)?,
        })
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
