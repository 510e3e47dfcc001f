//! The worst mistakes of every detector and its best matches, gathered row by row, each object once: a page shows them from
//! above.

use std::collections::BTreeMap;

use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::vocabulary::reason::{Agreement, ShownKind};
use crate::vocabulary::task::Task;

/// Scans whose numbers begin alike when divided by this are taken for scans of one second.
const SCANS_PER_SECOND: u32 = 10;
/// Mistakes of a kind that are kept for each detector and task.
const MOST_OF_A_KIND: usize = 4;
/// Matches that are kept for each detector and task.
const MOST_MATCHES: usize = 2;
/// Half the side of the smallest window around an object, in metres, and of the widest.
const HALF_WINDOW_M: [f32; 2] = [5.0, 12.0];
/// Margin that a window has around an object, in metres.
const SURROUNDINGS_M: f32 = 2.5;

/// The worst mistakes and the best matches so far, each with a value that the caller keeps.
#[derive(Debug, Clone)]
pub struct WorstObjects<T> {
    lists: BTreeMap<MistakeList, Vec<WorstObject<T>>>,
}

/// The name of a list of mistakes or matches: task, detector and kind.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct MistakeList {
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: String,
    /// What they are.
    pub kind: ShownKind,
}

/// Which object of which scan.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ObjectName {
    /// Id of the data set.
    pub dataset: String,
    /// The drive the scan belongs to.
    pub sequence: String,
    /// Number of the scan within the drive.
    pub scan: u32,
    /// Whose detection; `None` for an annotation.
    pub detector: Option<String>,
    /// Its index among the annotations, or detections, of the scan.
    pub id: u64,
}

impl ObjectName {
    /// The object of `row` if it is a mistake, a match or what one detector alone has, else `None`.
    pub fn shown_of(row: &MatchRow) -> Option<Self> {
        let (detector, id) = match &row.outcome {
            MatchOutcome::Missed { annotation, .. } | MatchOutcome::Matched { annotation, .. } => {
                (None, annotation.id)
            }
            MatchOutcome::False { detection, .. }
            | MatchOutcome::Unknowable { detection, agreement: Some(Agreement::Alone) } => {
                (Some(row.detector.clone()), detection.id)
            }
            _ => return None,
        };
        Some(Self {
            dataset: row.dataset.clone(),
            sequence: row.sequence.clone(),
            scan: row.scan,
            detector,
            id,
        })
    }
}

/// A mistake or a match with a position.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstObject<T> {
    /// The object.
    pub object: ObjectName,
    /// The annotated class, or the class it was taken for.
    pub class: &'static str,
    /// Why it is a mistake, or that it is none.
    pub reason: &'static str,
    /// Number of its points.
    pub n_points: u64,
    /// Where it is; without extent, at the centroid of its points, where no box is labelled.
    pub bounding_box: BoxFacts,
    /// The square that is shown around it.
    pub window: PlanWindow,
    /// Higher comes first: how close a match is, and then the number of points.
    rank: (i64, u64),
    /// The object within its drive, where that is known.
    track: Option<u32>,
    /// The value that the caller keeps with it.
    pub kept: T,
}

/// A square seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanWindow {
    /// Its middle in metres, x forward and y left of the sensor.
    pub center_m: [f32; 2],
    /// Half its side in metres.
    pub half_m: f32,
}

impl PlanWindow {
    /// The window around a box.
    fn around(bounding_box: &BoxFacts) -> Self {
        let [x_m, y_m, _] = bounding_box.center_m;
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let half_m = length_m.max(width_m) / 2.0 + SURROUNDINGS_M;
        Self { center_m: [x_m, y_m], half_m: half_m.clamp(HALF_WINDOW_M[0], HALF_WINDOW_M[1]) }
    }

    /// Whether a position is inside.
    pub fn holds(&self, x_m: f32, y_m: f32) -> bool {
        (x_m - self.center_m[0]).abs() <= self.half_m && (y_m - self.center_m[1]).abs() <= self.half_m
    }
}

impl<T> Default for WorstObjects<T> {
    fn default() -> Self {
        Self { lists: BTreeMap::new() }
    }
}

impl<T> WorstObjects<T> {
    /// Adds `row` if it is a mistake with a position and worse than those in the list, which is seen by more points; or a
    /// closer match. `kept` is called only then.
    pub fn add(&mut self, row: &MatchRow, kept: impl FnOnce(&PlanWindow) -> T) {
        let annotated = |it: &AnnotationFacts| (it.class.name(), it.n_points, subject_of(it), it.track);
        let detected = |it: &DetectionFacts| (it.class.name(), it.n_points, Some(it.bounding_box), None);
        let (kind, (class, n_points, bounding_box, track), reason, closeness) = match &row.outcome {
            MatchOutcome::Missed { annotation, reason } => {
                (ShownKind::Missed, annotated(annotation), reason.name(), 0)
            }
            MatchOutcome::False { detection, reason } => {
                (ShownKind::False, detected(detection), reason.name(), 0)
            }
            MatchOutcome::Unknowable { detection, agreement: Some(Agreement::Alone) } => {
                (ShownKind::Alone, detected(detection), Agreement::Alone.name(), 0)
            }
            MatchOutcome::Matched { annotation, cost, .. } => {
                let closeness = -(100.0 * cost).round() as i64;
                (ShownKind::Matched, annotated(annotation), "one of the best matches", closeness)
            }
            _ => return,
        };
        let rank = (closeness, n_points);
        let most = if kind == ShownKind::Matched { MOST_MATCHES } else { MOST_OF_A_KIND };
        let (Some(bounding_box), Some(object)) = (bounding_box, ObjectName::shown_of(row)) else { return };
        let list = MistakeList { task: row.task, detector: row.detector.clone(), kind };
        let list = self.lists.entry(list).or_default();
        let same = list.iter().position(|it| it.is_same_object(&object, track));
        let is_first = match same {
            Some(index) => list[index].rank < rank,
            None => list.len() < most || list.last().is_some_and(|it| it.rank < rank),
        };
        if !is_first {
            return;
        }
        if let Some(index) = same {
            list.remove(index);
        }
        let window = PlanWindow::around(&bounding_box);
        let kept = kept(&window);
        let worst = WorstObject { object, class, reason, n_points, bounding_box, window, rank, track, kept };
        list.insert(list.partition_point(|it| it.rank >= rank), worst);
        list.truncate(most);
    }

    /// The lists, each with the worst first.
    pub fn lists(&self) -> impl Iterator<Item = (&MistakeList, &[WorstObject<T>])> {
        self.lists.iter().map(|(name, objects)| (name, objects.as_slice()))
    }

    /// The mistakes of one list, the worst first.
    pub fn of(&self, list: &MistakeList) -> &[WorstObject<T>] {
        self.lists.get(list).map_or(&[], Vec::as_slice)
    }
}

impl<T> WorstObject<T> {
    /// Whether `other`, on this track, shows it once more: the same track or, where both have none, another scan within a
    /// second. So the worst of a run are among the worst of its parts.
    fn is_same_object(&self, other: &ObjectName, track: Option<u32>) -> bool {
        let ours = &self.object;
        let is_same_drive = ours.dataset == other.dataset && ours.sequence == other.sequence;
        is_same_drive
            && match (self.track, track) {
                (None, None) if ours.scan == other.scan => ours.id == other.id,
                (None, None) => ours.scan / SCANS_PER_SECOND == other.scan / SCANS_PER_SECOND,
                (ours, theirs) => ours == theirs,
            }
    }
}

/// Its box, or one without extent where it stands.
fn subject_of(annotation: &AnnotationFacts) -> Option<BoxFacts> {
    let without_extent = |center_m| BoxFacts { center_m, length_width_height_m: [0.0; 3], yaw_rad: 0.0 };
    annotation.bounding_box.or_else(|| annotation.center_m().map(without_extent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::match_outcome::MotionFacts;
    use crate::vocabulary::class::{AnnotationClass, DetectionClass};
    use crate::vocabulary::criterion::CriterionKind;
    use crate::vocabulary::reason::{FalseReason, MissReason};

    fn row(scan: u32, outcome: MatchOutcome) -> MatchRow {
        let [dataset, sequence, detector] = ["street", "drive", "grid"].map(str::to_owned);
        let (task, criterion) = (Task::Vehicles, CriterionKind::Points);
        MatchRow { dataset, sequence, scan, detector, task, criterion, outcome }
    }

    const BOX: BoxFacts =
        BoxFacts { center_m: [30.0, 4.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };

    fn missed(track: Option<u32>, n_points: u64, bounding_box: Option<BoxFacts>) -> MatchOutcome {
        let annotation = AnnotationFacts::without_position(AnnotationClass::Car, n_points);
        let annotation = AnnotationFacts { track, bounding_box, ..annotation };
        MatchOutcome::Missed { annotation, reason: MissReason::NothingThere }
    }

    fn false_one(n_points: u64) -> MatchOutcome {
        let class = DetectionClass::Vehicle;
        let detection = DetectionFacts {
            id: 7,
            class,
            score: None,
            n_points,
            bounding_box: BOX,
            motion: MotionFacts::default(),
        };
        MatchOutcome::False { detection, reason: FalseReason::NothingThere }
    }

    fn kept(rows: &[MatchRow], kind: ShownKind) -> Vec<(u32, u64)> {
        let mut objects = WorstObjects::default();
        for row in rows {
            objects.add(row, |_| ());
        }
        let (task, detector) = (Task::Vehicles, "grid".to_owned());
        let list = objects.of(&MistakeList { task, detector, kind });
        list.iter().map(|it| (it.object.scan, it.n_points)).collect()
    }

    #[test]
    fn each_track_is_shown_where_it_was_seen_best() {
        let rows = [(0, Some(1), 30), (1, Some(1), 50), (2, Some(1), 40), (2, Some(2), 45)];
        let rows = rows.map(|(scan, track, n)| row(scan, missed(track, n, Some(BOX))));
        assert_eq!(kept(&rows, ShownKind::Missed), [(1, 50), (2, 45)]);
    }

    #[test]
    fn the_worst_are_kept_and_no_more() {
        let rows: Vec<_> = (0..20).map(|it| row(it * 10, false_one(u64::from(it * 7 % 20)))).collect();
        assert_eq!(kept(&rows, ShownKind::False).iter().map(|it| it.1).collect::<Vec<_>>(), [19, 18, 17, 16]);
        assert_eq!(kept(&rows, ShownKind::Missed), []);
    }

    #[test]
    fn the_closest_matches_are_kept() {
        let found = |scan: u32, n_points: u64, cost: f64| {
            let MatchOutcome::False { detection, .. } = false_one(9) else { unreachable!() };
            let MatchOutcome::Missed { annotation, .. } = missed(Some(scan), n_points, Some(BOX)) else {
                unreachable!()
            };
            row(scan, MatchOutcome::Matched { annotation, detection, cost })
        };
        let rows = [found(1, 900, 0.3), found(2, 20, 0.001), found(3, 70, 0.0), found(4, 40, 0.01)];
        assert_eq!(kept(&rows, ShownKind::Matched), [(3, 70), (2, 20)]);
        assert_eq!(kept(&rows, ShownKind::Missed), []);
    }

    #[test]
    fn false_ones_of_one_second_are_one() {
        assert_eq!(
            kept(&[row(3, false_one(5)), row(4, false_one(6)), row(13, false_one(1))], ShownKind::False),
            [(4, 6), (13, 1)]
        );
    }

    #[test]
    fn of_a_scan_each_is_one() {
        let of = |id: u64, outcome: MatchOutcome| {
            let MatchOutcome::False { detection, .. } = outcome else { unreachable!() };
            DetectionFacts { id, ..detection }
        };
        let reason = FalseReason::NothingThere;
        let rows = [(1, 50), (2, 40), (1, 30)]
            .map(|(id, n)| row(3, MatchOutcome::False { detection: of(id, false_one(n)), reason }));
        assert_eq!(kept(&rows, ShownKind::False), [(3, 50), (3, 40)]);
    }

    #[test]
    fn what_one_alone_has_is_a_list_of_its_own() {
        let unlabelled = |agreement| {
            let MatchOutcome::False { detection, .. } = false_one(9) else { unreachable!() };
            row(0, MatchOutcome::Unknowable { detection, agreement })
        };
        let rows = [Some(Agreement::Some), Some(Agreement::Alone), None].map(unlabelled);
        assert_eq!(kept(&rows, ShownKind::Alone), [(0, 9)]);
        assert_eq!(kept(&rows, ShownKind::False), []);
    }

    #[test]
    fn what_has_no_position_is_not_shown() {
        assert_eq!(kept(&[row(0, missed(None, 5, None))], ShownKind::Missed), []);
    }

    #[test]
    fn without_a_box_it_is_where_its_points_are() {
        let MatchOutcome::Missed { annotation, reason } = missed(None, 5, None) else { unreachable!() };
        let annotation = AnnotationFacts { centroid_m: Some([9.0, -2.0, 0.5]), ..annotation };
        let mut objects = WorstObjects::default();
        objects.add(&row(0, MatchOutcome::Missed { annotation, reason }), |window| *window);
        let (_, [worst]) = objects.lists().next().unwrap() else { panic!("one object") };
        assert_eq!(worst.kept, PlanWindow { center_m: [9.0, -2.0], half_m: 5.0 });
        assert_eq!(worst.bounding_box.length_width_height_m, [0.0; 3]);
    }

    #[test]
    fn a_window_is_around_the_box() {
        let window = PlanWindow::around(&BOX);
        assert_eq!(window, PlanWindow { center_m: [30.0, 4.0], half_m: 5.0 });
        assert!(window.holds(34.9, 4.0) && !window.holds(35.1, 4.0) && !window.holds(30.0, -1.1));
    }
}
