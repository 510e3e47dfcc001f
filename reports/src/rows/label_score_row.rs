//! `protocol_labels.csv`: scores of labelled instances, things and ground points, under protocols that score labels of
//! points.
//!
//! Numbers have all digits, so that those of the makers' own programs can be made of this file alone.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::exact_number::Exact;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::ground_definition::GroundDefinition;
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::thing_class::ThingClass;

/// A score of a detector for something labelled in a scan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "ScoreRecord", try_from = "ScoreRecord")]
pub struct LabelScoreRow {
    /// The scan.
    pub scan: ScanName,
    /// Name of the detector.
    pub detector: String,
    /// The score.
    pub score: LabelScore,
}

/// The score of an instance, of things, or of a whole scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LabelScore {
    /// A labelled instance.
    Instance(InstanceScore),
    /// The segments of a class, of a detector that predicts classes.
    Things(ThingClass, ThingCounts),
    /// The whole scan: how objects are torn apart and run together.
    Entropies(SegmentationEntropies),
    /// The whole scan: which points were classified as ground.
    Ground(GroundDefinition, GroundCounts),
}

/// One labelled instance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstanceScore {
    /// Its whole label: the class in the lower half, the instance in the upper.
    pub label: u32,
    /// Number of its points.
    pub n_points: u64,
    /// Its association, 0 to 1: Σ |p ∩ g| · IoU(p, g) / |g| over all segments p that were found.
    pub association: f64,
    /// The overlap with the segment that found it, if there is one: they share more than half of the points of either.
    pub matched_iou: Option<f64>,
}

/// Counts of the segments of one class.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ThingCounts {
    /// Labelled segments that match a found one: they share more than half of the points of either.
    pub n_matched: u64,
    /// Labelled segments of enough points that match none.
    pub n_missed: u64,
    /// Found segments of enough points that match none.
    pub n_false: u64,
    /// The overlaps of the matched ones, summed.
    pub iou_sum: f64,
}

/// How far the objects of a scan are torn apart and run together.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SegmentationEntropies {
    /// Objects.
    pub n_objects: u64,
    /// OSE: −Σ p ln p of the shares p of the segments in each object, summed over objects.
    pub over_nats: f64,
    /// Segments that hold a point of an object.
    pub n_segments: u64,
    /// USE: −Σ p ln p of the shares p of the objects in each of these segments, summed over segments.
    pub under_nats: f64,
}

/// Points by their true and their predicted class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GroundCounts {
    /// Ground that was classified as ground.
    pub n_found: u64,
    /// Others that were classified as ground.
    pub n_false: u64,
    /// Ground that was not classified as ground.
    pub n_missed: u64,
    /// Others that were not classified as ground.
    pub n_others: u64,
}

impl LabelScore {
    /// The protocol that it belongs to.
    pub fn protocol(&self) -> Protocol {
        match self {
            Self::Instance(_) | Self::Things(..) | Self::Entropies(_) => Protocol::SemanticKitti,
            Self::Ground(..) => Protocol::Ground,
        }
    }
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum KindName {
    #[default]
    Instance,
    Things,
    Entropies,
    Ground,
}

row! {
    for LabelScoreRow:
    /// `class` is the number of the class of an instance, the name of that of things, or that of a definition of ground.
    /// `iou` is of the match of an instance, or the sum of those of things; `n_matched` is of things or points.
    #[derive(Default, Serialize, Deserialize)]
    struct ScoreRecord {
        scan: ScanName = ["dataset", "sequence", "scan"],
        detector: String,
        kind: KindName,
        class: Option<String>,
        instance: Option<u16>,
        n_points: Option<u64>,
        association: Option<Exact>,
        iou: Option<Exact>,
        n_matched: Option<u64>,
        n_missed: Option<u64>,
        n_false: Option<u64>,
        n_others: Option<u64>,
        n_objects: Option<u64>,
        ose_nats: Option<Exact>,
        n_segments: Option<u64>,
        use_nats: Option<Exact>,
    }
}

impl ScoreRecord {
    fn score(&self) -> Option<LabelScore> {
        let class = self.class.as_deref();
        Some(match self.kind {
            KindName::Instance => LabelScore::Instance(InstanceScore {
                label: u32::from(class?.parse::<u16>().ok()?) | u32::from(self.instance?) << 16,
                n_points: self.n_points?,
                association: self.association?.0,
                matched_iou: self.iou.map(|it| it.0),
            }),
            KindName::Things => LabelScore::Things(
                ThingClass::ALL.into_iter().find(|it| Some(it.name()) == class)?,
                ThingCounts {
                    n_matched: self.n_matched?,
                    n_missed: self.n_missed?,
                    n_false: self.n_false?,
                    iou_sum: self.iou?.0,
                },
            ),
            KindName::Entropies => LabelScore::Entropies(SegmentationEntropies {
                n_objects: self.n_objects?,
                over_nats: self.ose_nats?.0,
                n_segments: self.n_segments?,
                under_nats: self.use_nats?.0,
            }),
            KindName::Ground => LabelScore::Ground(
                GroundDefinition::ALL.into_iter().find(|it| Some(it.name()) == class)?,
                GroundCounts {
                    n_found: self.n_matched?,
                    n_false: self.n_false?,
                    n_missed: self.n_missed?,
                    n_others: self.n_others?,
                },
            ),
        })
    }
}

impl From<LabelScoreRow> for ScoreRecord {
    fn from(row: LabelScoreRow) -> Self {
        let LabelScoreRow { scan, detector, score } = row;
        let of_kind = |kind| Self { scan, detector, kind, ..Self::default() };
        match score {
            LabelScore::Instance(it) => Self {
                class: Some((it.label as u16).to_string()),
                instance: Some((it.label >> 16) as u16),
                n_points: Some(it.n_points),
                association: Some(Exact(it.association)),
                iou: it.matched_iou.map(Exact),
                ..of_kind(KindName::Instance)
            },
            LabelScore::Things(class, it) => Self {
                class: Some(class.name().to_owned()),
                n_matched: Some(it.n_matched),
                n_missed: Some(it.n_missed),
                n_false: Some(it.n_false),
                iou: Some(Exact(it.iou_sum)),
                ..of_kind(KindName::Things)
            },
            LabelScore::Entropies(it) => Self {
                n_objects: Some(it.n_objects),
                ose_nats: Some(Exact(it.over_nats)),
                n_segments: Some(it.n_segments),
                use_nats: Some(Exact(it.under_nats)),
                ..of_kind(KindName::Entropies)
            },
            LabelScore::Ground(definition, it) => Self {
                class: Some(definition.name().to_owned()),
                n_matched: Some(it.n_found),
                n_false: Some(it.n_false),
                n_missed: Some(it.n_missed),
                n_others: Some(it.n_others),
                ..of_kind(KindName::Ground)
            },
        }
    }
}

impl TryFrom<ScoreRecord> for LabelScoreRow {
    type Error = String;

    fn try_from(record: ScoreRecord) -> Result<Self, String> {
        let score = record.score();
        let ScoreRecord { scan, detector, class, .. } = record;
        let score = score.ok_or_else(|| format!("a row of class {class:?} lacks a value of its kind"))?;
        Ok(Self { scan, detector, score })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::files::csv_rows::CsvRow;
    use crate::files::csv_rows::tests::{csv_text, rows_of};

    /// A row of the detector `grid` on a scan of drive 08.
    pub(crate) fn row(scan: u32, score: LabelScore) -> LabelScoreRow {
        let scan = ScanName { dataset: "semantic-kitti".to_owned(), sequence: "08".to_owned(), scan };
        LabelScoreRow { scan, detector: "grid".to_owned(), score }
    }

    #[test]
    fn rows_read_back_as_they_were() {
        let car = InstanceScore {
            label: 10 + (7 << 16),
            n_points: 51,
            association: 0.1 + 0.2,
            matched_iou: Some(0.75),
        };
        let counts = ThingCounts { n_matched: 2, n_missed: 1, n_false: 3, iou_sum: 1.75 };
        let nats = SegmentationEntropies { n_objects: 9, over_nats: 1.5, n_segments: 8, under_nats: 0.25 };
        let ground = GroundCounts { n_found: 40, n_false: 2, n_missed: 3, n_others: 55 };
        let rows = [
            row(3, LabelScore::Instance(car)),
            row(3, LabelScore::Instance(InstanceScore { matched_iou: None, ..car })),
            row(3, LabelScore::Things(ThingClass::OtherVehicle, counts)),
            row(3, LabelScore::Entropies(nats)),
            row(4, LabelScore::Ground(GroundDefinition::GroundGrid, ground)),
        ];
        let text = csv_text(&rows);
        let second = "semantic-kitti,08,3,grid,instance,10,7,51,0.30000000000000004,0.75,,,,,,,,";
        assert_eq!(text.lines().nth(1), Some(second), "{text}");
        assert_eq!(rows_of::<LabelScoreRow>(&text).unwrap(), rows);
    }

    #[test]
    fn a_row_without_a_value_of_its_kind_is_refused() {
        for line in
            ["d,08,3,grid,instance,10,7,51,,,,,,,,,,", "d,08,3,grid,things,spaceship,,,,1.0,1,0,0,,,,,"]
        {
            let text = format!("{}\n{line}\n", LabelScoreRow::COLUMNS.join(","));
            let problem = rows_of::<LabelScoreRow>(&text).unwrap_err();
            assert!(problem.contains("lacks a value of its kind"), "{problem}");
        }
    }
}
