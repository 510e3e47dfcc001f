//! The worst mistakes of a detector.

use std::fmt::Write as _;

use crate::rows::match_outcome::{DetectionFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::vocabulary::reason::{Agreement, ShownKind};
use crate::vocabulary::task::Task;

/// The mistakes that are asked for.
#[derive(Debug, Clone, Copy)]
pub struct MistakeChoice<'a> {
    /// The detector.
    pub detector: &'a str,
    /// The task.
    pub task: Task,
    /// The kind; any if not given.
    pub kind: Option<ShownKind>,
    /// The class of the annotation, or of the detection; any if not given.
    pub class: Option<&'a str>,
    /// The [`address`](ListedMistake::address) of the mistake, or of its scan; any if not given.
    pub at: Option<&'a str>,
}

/// A mistake, by what the sensor saw of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedMistake<'a> {
    /// Its row.
    pub row: &'a MatchRow,
    /// Its kind.
    pub kind: ShownKind,
    /// The annotated class, or the class it was taken for.
    pub class: &'static str,
    /// Why.
    pub reason: &'static str,
    /// Number of its points.
    pub n_points: u64,
    /// Where it is on the ground plan, in metres: the middle of its box or of its points.
    pub position_m: Option<[f32; 2]>,
}

impl ListedMistake<'_> {
    /// Its address: data set, drive, scan and object, such as `street/0003/000012/missed-4`.
    pub fn address(&self) -> String {
        let id = match &self.row.outcome {
            MatchOutcome::Missed { annotation, .. } => annotation.id,
            MatchOutcome::False { detection, .. } | MatchOutcome::Unknowable { detection, .. } => {
                detection.id
            }
            _ => unreachable!("no other outcome is listed"),
        };
        format!("{}/{}-{id}", scan_address(&self.row.dataset, &self.row.sequence, self.row.scan), self.kind)
    }

    fn is_at(&self, address: &str) -> bool {
        let own = self.address();
        own == address || own.strip_prefix(address).is_some_and(|it| it.starts_with('/'))
    }
}

/// The address of a scan: data set, drive and number, such as `street/0003/000012`.
pub fn scan_address(dataset: &str, sequence: &str, scan: u32) -> String {
    format!("{dataset}/{sequence}/{scan:06}")
}

/// The `most` mistakes of `rows` with the most points, in the order of the rows where these are equal: the better an object
/// was seen, the worse is the mistake.
pub fn worst<'a>(rows: &'a [MatchRow], choice: &MistakeChoice<'_>, most: usize) -> Vec<ListedMistake<'a>> {
    let asked = rows.iter().filter(|row| row.detector == choice.detector && row.task == choice.task);
    let mut listed: Vec<ListedMistake<'a>> = asked
        .filter_map(listed)
        .filter(|it| choice.kind.is_none_or(|kind| it.kind == kind))
        .filter(|it| choice.class.is_none_or(|class| it.class == class))
        .filter(|it| choice.at.is_none_or(|address| it.is_at(address)))
        .collect();
    listed.sort_by_key(|it| std::cmp::Reverse(it.n_points));
    listed.truncate(most);
    listed
}

fn listed(row: &MatchRow) -> Option<ListedMistake<'_>> {
    let position_m = |center_m: [f32; 3]| [center_m[0], center_m[1]];
    let of_detection = |kind, it: &DetectionFacts, reason| {
        let (class, n_points) = (it.class.name(), it.n_points);
        let position_m = Some(position_m(it.bounding_box.center_m));
        Some(ListedMistake { row, kind, class, reason, n_points, position_m })
    };
    match &row.outcome {
        MatchOutcome::Missed { annotation, reason } => Some(ListedMistake {
            row,
            kind: ShownKind::Missed,
            class: annotation.class.name(),
            reason: reason.name(),
            n_points: annotation.n_points,
            position_m: annotation.center_m().map(position_m),
        }),
        MatchOutcome::False { detection, reason } => of_detection(ShownKind::False, detection, reason.name()),
        MatchOutcome::Unknowable { detection, agreement: Some(agreement @ Agreement::Alone) } => {
            of_detection(ShownKind::Alone, detection, agreement.name())
        }
        _ => None,
    }
}

/// The mistakes as lines of text with a head.
pub fn worst_to_terminal(mistakes: &[ListedMistake<'_>]) -> String {
    let width = |head: &str, of: &dyn Fn(&ListedMistake<'_>) -> usize| {
        mistakes.iter().map(of).max().unwrap_or(0).max(head.len())
    };
    let addresses = width("data set/drive/scan/object", &|it| it.address().chars().count());
    let classes = width("class", &|it| it.class.chars().count());
    let mut text = format!(
        "{:>4}  {:<addresses$}  {:<classes$}  {:>7}  {:>8}  {:>8}  {:>8}  reason\n",
        "", "data set/drive/scan/object", "class", "points", "range m", "x m", "y m"
    );
    for (rank, it) in (1..).zip(mistakes) {
        let position = it.position_m.map_or_else(
            || format!("{:>8}  {:>8}  {:>8}", "–", "–", "–"),
            |[x, y]| format!("{:>8.1}  {x:>8.1}  {y:>8.1}", x.hypot(y)),
        );
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{rank:>4}  {:<addresses$}  {:<classes$}  {:>7}  {position}  {}",
            it.address(),
            it.class,
            it.n_points,
            it.reason
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MotionFacts};
    use crate::vocabulary::class::{AnnotationClass, DetectionClass};
    use crate::vocabulary::criterion::CriterionKind;
    use crate::vocabulary::reason::{FalseReason, MissReason};

    fn row(detector: &str, outcome: MatchOutcome) -> MatchRow {
        let [dataset, sequence, detector] = ["street", "drive", detector].map(str::to_owned);
        let (task, criterion) = (Task::Vehicles, CriterionKind::Points);
        MatchRow { dataset, sequence, scan: 3, detector, task, criterion, outcome }
    }

    const BOX: BoxFacts =
        BoxFacts { center_m: [3.0, 4.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };

    fn missed(class: AnnotationClass, n_points: u64) -> MatchOutcome {
        let centroid_m = Some([6.0, -8.0, 0.0]);
        let annotation = AnnotationFacts { centroid_m, ..AnnotationFacts::without_position(class, n_points) };
        MatchOutcome::Missed { annotation, reason: MissReason::NothingThere }
    }

    fn false_one(n_points: u64) -> MatchOutcome {
        let class = DetectionClass::Vehicle;
        let detection = DetectionFacts {
            id: 0,
            class,
            score: None,
            n_points,
            bounding_box: BOX,
            motion: MotionFacts::default(),
        };
        MatchOutcome::False { detection, reason: FalseReason::WrongClass }
    }

    const ANY: MistakeChoice<'_> =
        MistakeChoice { detector: "grid", task: Task::Vehicles, kind: None, class: None, at: None };

    #[test]
    fn what_was_seen_best_comes_first() {
        let rows = [missed(AnnotationClass::Car, 30), missed(AnnotationClass::Van, 500), false_one(90)]
            .map(|it| row("grid", it));
        let points: Vec<u64> = worst(&rows, &ANY, 10).iter().map(|it| it.n_points).collect();
        assert_eq!(points, [500, 90, 30]);
        assert_eq!(worst(&rows, &ANY, 1).len(), 1);
    }

    #[test]
    fn only_what_is_asked_for_is_listed() {
        let mut rows = [missed(AnnotationClass::Car, 30), missed(AnnotationClass::Van, 500), false_one(90)]
            .map(|it| row("grid", it))
            .to_vec();
        rows.push(row("tree", missed(AnnotationClass::Car, 1000)));
        let points = |choice: MistakeChoice<'_>| -> Vec<u64> {
            worst(&rows, &choice, 10).iter().map(|it| it.n_points).collect()
        };
        assert_eq!(points(MistakeChoice { kind: Some(ShownKind::False), ..ANY }), [90]);
        assert_eq!(points(MistakeChoice { kind: Some(ShownKind::Missed), ..ANY }), [500, 30]);
        assert_eq!(points(MistakeChoice { class: Some("car"), ..ANY }), [30]);
        assert_eq!(points(MistakeChoice { task: Task::Objects, ..ANY }), [0; 0]);
        assert_eq!(points(MistakeChoice { at: Some("street/drive/000003"), ..ANY }), [500, 90, 30]);
        assert_eq!(points(MistakeChoice { at: Some("street/drive/000003/false-0"), ..ANY }), [90]);
        assert_eq!(points(MistakeChoice { at: Some("street/drive/00000"), ..ANY }), [0; 0]);
    }

    #[test]
    fn a_line_says_where_what_and_why() {
        let rows = [missed(AnnotationClass::Car, 30), false_one(90)].map(|it| row("grid", it));
        insta::assert_snapshot!(worst_to_terminal(&worst(&rows, &ANY, 10)), @r"
              data set/drive/scan/object    class     points   range m       x m       y m  reason
           1  street/drive/000003/false-0   vehicle       90       5.0       3.0       4.0  wrong class
           2  street/drive/000003/missed-0  car           30      10.0       6.0      -8.0  nothing there
        ");
    }
}
