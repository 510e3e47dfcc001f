//! Labels that several detectors contradict: objects that all of them miss, that stand elsewhere, are larger or of another
//! class for all of them, and things that all find where nothing is labelled.
//!
//! Each is ranked by how unusual it is: the sum over the detectors of −ln p in nats, where p is how often the detector does
//! such a thing on objects with as many points. Detectors that have stages in common err together, so this is no probability.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::files::fixed_decimals::Fixed;
use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::suspect_row::{SuspectKind, SuspectRow};
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::reason::FalseReason;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;
use crate::worst::mistakes::scan_address;

/// The address of its scan.
fn address_of(it: &SuspectRow) -> String {
    scan_address(&it.dataset, &it.sequence, it.scan)
}

/// The first of the suspects as lines of text with a head; there are `n_all`.
pub fn suspects_to_terminal(listed: &[SuspectRow], n_all: usize) -> String {
    let width = |head: &str, of: &dyn Fn(&SuspectRow) -> usize| {
        listed.iter().map(of).max().unwrap_or(0).max(head.len())
    };
    let addresses = width("data set/drive/scan", &|it| address_of(it).chars().count());
    let classes = width("class", &|it| it.class.chars().count());
    let mut text = format!(
        "{:>4}  {:>5}  {:<13}  {:<addresses$}  {:<classes$}  {:>7}  {:>8}  {:>8}  reason\n",
        "", "nats", "suspect", "data set/drive/scan", "class", "points", "x m", "y m"
    );
    for (rank, it) in (1..).zip(listed) {
        let [x, y] =
            it.position_m().map_or(["–", "–"].map(str::to_owned), |it| it.map(|at| format!("{at:.1}")));
        let SuspectRow { surprise_nats: Fixed(nats), kind, class, n_points, reason, .. } = it;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{rank:>4}  {nats:>5.1}  {:<13}  {:<addresses$}  {class:<classes$}  {n_points:>7}  {x:>8}  {y:>8}  {reason}",
            kind.name(),
            address_of(it),
        );
    }
    if n_all > listed.len() {
        let _ = writeln!(text, "And {} more, in suspects.csv.", n_all - listed.len());
    }
    text
}

/// Least distance, in metres, and angle, in degrees, by which a box is off if it is suspect at all.
const LEAST_OFF_M: f32 = 0.4;
const LEAST_TURN_DEG: f32 = 15.0;

type ScanKey<'a> = (&'a str, &'a str, u32);

/// The outcomes of one scan, each list by detector.
#[derive(Default)]
struct ScanOutcomes<'a> {
    annotations: BTreeMap<u64, Vec<Found<'a>>>,
    false_detections: BTreeMap<usize, Vec<&'a DetectionFacts>>,
}

/// What a detector has of an annotation.
struct Found<'a> {
    detector: usize,
    annotation: &'a AnnotationFacts,
    detection: Option<&'a DetectionFacts>,
}

/// The suspects of `rows` of `task`, as these `detectors` see them: the most unusual first.
pub fn suspects(rows: &[MatchRow], task: Task, detectors: &[&str]) -> Vec<SuspectRow> {
    let mut scans: BTreeMap<ScanKey<'_>, ScanOutcomes<'_>> = BTreeMap::new();
    let mut habits: Vec<Habits> = detectors.iter().map(|_| Habits::default()).collect();
    for row in rows.iter().filter(|it| it.task == task) {
        let Some(detector) = detectors.iter().position(|it| *it == row.detector) else { continue };
        let scan = scans.entry((&row.dataset, &row.sequence, row.scan)).or_default();
        let mut found = |annotation, detection| {
            let found = Found { detector, annotation, detection };
            scan.annotations.entry(found.annotation.id).or_default().push(found);
        };
        match &row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => {
                habits[detector].add_pair(annotation, detection);
                found(annotation, Some(detection));
            }
            MatchOutcome::Missed { annotation, .. } => {
                habits[detector].add_missed(annotation);
                found(annotation, None);
            }
            MatchOutcome::False { detection, reason } => {
                habits[detector].add_false(detection);
                // Others lie on something that is labelled.
                if *reason == FalseReason::NothingThere {
                    scan.false_detections.entry(detector).or_default().push(detection);
                }
            }
            _ => {}
        }
    }
    habits.iter_mut().for_each(Habits::sort);
    let mut suspects = Vec::new();
    for (key, outcomes) in &scans {
        for of_one in outcomes.annotations.values().filter(|it| it.len() == detectors.len()) {
            suspects.extend(of_annotation(*key, of_one, &habits));
        }
        suspects.extend(unlabelled(*key, &outcomes.false_detections, &habits));
    }
    let order = |a: &SuspectRow, b: &SuspectRow| b.surprise_nats.0.total_cmp(&a.surprise_nats.0);
    suspects.sort_by(order);
    suspects
}

/// What a detector usually does.
#[derive(Default)]
struct Habits {
    // By number of points: annotations, and those that were missed; detections, and those that were false.
    annotations: BTreeMap<Slice, [u32; 2]>,
    detections: BTreeMap<Slice, [u32; 2]>,
    // By annotated class: pairs whose detection has a class, and those where it is another one.
    classes: BTreeMap<AnnotationClass, [u32; 2]>,
    // Errors of the boxes of pairs, ascending: of the centre, the length and the heading.
    errors: [Vec<f32>; 3],
}

impl Habits {
    fn add_pair(&mut self, annotation: &AnnotationFacts, detection: &DetectionFacts) {
        self.annotations.entry(Slice::of_points(annotation.n_points)).or_default()[0] += 1;
        self.detections.entry(Slice::of_points(detection.n_points)).or_default()[0] += 1;
        if let Some(given) = detection.class.given() {
            let [n, n_other] = self.classes.entry(annotation.class).or_default();
            *n += 1;
            *n_other += u32::from(!given.includes(annotation.class));
        }
        if let Some(labelled) = &annotation.bounding_box {
            for (errors, error) in
                self.errors.iter_mut().zip(Errors::of(labelled, &detection.bounding_box).sizes())
            {
                errors.push(error);
            }
        }
    }

    fn add_missed(&mut self, annotation: &AnnotationFacts) {
        let [n, n_missed] = self.annotations.entry(Slice::of_points(annotation.n_points)).or_default();
        *n += 1;
        *n_missed += 1;
    }

    fn add_false(&mut self, detection: &DetectionFacts) {
        let [n, n_false] = self.detections.entry(Slice::of_points(detection.n_points)).or_default();
        *n += 1;
        *n_false += 1;
    }

    fn sort(&mut self) {
        self.errors.iter_mut().for_each(|it| it.sort_by(f32::total_cmp));
    }

    /// −ln of how often an error of this kind is as large as `size`.
    fn surprise_of_error(&self, kind: usize, size: f32) -> f64 {
        let errors = &self.errors[kind];
        let n_smaller = errors.partition_point(|it| *it < size);
        surprise([errors.len() as u32, (errors.len() - n_smaller) as u32])
    }
}

/// −ln of the share of the second number in the first one, each with one more case of either kind.
fn surprise([n, n_such]: [u32; 2]) -> f64 {
    -(f64::from(n_such + 1) / f64::from(n + 2)).ln()
}

fn of(counts: &BTreeMap<Slice, [u32; 2]>, n_points: u64) -> f64 {
    surprise(counts.get(&Slice::of_points(n_points)).copied().unwrap_or_default())
}

/// How a box that was found differs from the labelled one.
#[derive(Clone, Copy)]
struct Errors {
    forward_m: f32,
    left_m: f32,
    length_m: f32,
    turned_deg: f32,
}

impl Errors {
    /// Along the axes of the labelled box; front and back are the same.
    fn of(labelled: &BoxFacts, found: &BoxFacts) -> Self {
        let [x_m, y_m] = [0, 1].map(|axis| found.center_m[axis] - labelled.center_m[axis]);
        let (sin, cos) = labelled.yaw_rad.sin_cos();
        let turned = (found.yaw_rad - labelled.yaw_rad).to_degrees().rem_euclid(180.0);
        Self {
            forward_m: cos * x_m + sin * y_m,
            left_m: cos * y_m - sin * x_m,
            length_m: found.length_width_height_m[0] - labelled.length_width_height_m[0],
            turned_deg: if turned > 90.0 { turned - 180.0 } else { turned },
        }
    }

    fn sizes(self) -> [f32; 3] {
        [self.forward_m.hypot(self.left_m), self.length_m.abs(), self.turned_deg.abs()]
    }
}

/// The most unusual suspicion of an annotation that all detectors were asked for.
fn of_annotation(key: ScanKey<'_>, found: &[Found<'_>], habits: &[Habits]) -> Option<SuspectRow> {
    let annotation = found[0].annotation;
    let mut all: Vec<(SuspectKind, f64, String)> = Vec::new();
    if found.iter().all(|it| it.detection.is_none()) {
        let nats = found.iter().map(|it| of(&habits[it.detector].annotations, annotation.n_points)).sum();
        all.push((SuspectKind::FoundByNone, nats, format!("none of {} detectors finds it", found.len())));
    }
    let pairs: Vec<(usize, &DetectionFacts)> =
        found.iter().filter_map(|it| Some((it.detector, it.detection?))).collect();
    if pairs.len() == found.len() {
        if let Some(labelled) = &annotation.bounding_box {
            all.extend(of_boxes(labelled, &pairs, habits));
        }
        all.extend(of_class(annotation.class, &pairs, habits));
    }
    let (kind, nats, reason) = all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let first = pairs.first().map(|(_, it)| &it.bounding_box);
    let id = Some(annotation.id);
    Some(suspect(
        key,
        kind,
        nats,
        (id, annotation.class.name(), annotation.n_points),
        reason,
        [annotation.center_m(), None],
        first,
    ))
}

/// Suspicions of the box: all detectors are off in the same direction.
fn of_boxes(
    labelled: &BoxFacts,
    pairs: &[(usize, &DetectionFacts)],
    habits: &[Habits],
) -> Vec<(SuspectKind, f64, String)> {
    let errors: Vec<(usize, Errors)> =
        pairs.iter().map(|(detector, it)| (*detector, Errors::of(labelled, &it.bounding_box))).collect();
    let nats = |kind: usize| -> f64 {
        errors.iter().map(|(detector, it)| habits[*detector].surprise_of_error(kind, it.sizes()[kind])).sum()
    };
    let same_way = |of: fn(&Errors) -> f32, least: f32| {
        let least_off = errors.iter().map(|(_, it)| of(it)).min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let is_same = errors.iter().all(|(_, it)| of(it).signum() == least_off.signum());
        (is_same && least_off.abs() >= least).then_some(least_off)
    };
    let mut all = Vec::new();
    let side = |off_m: f32, [more, less]: [&str; 2]| {
        format!("{:.1} m {}", off_m.abs(), if off_m > 0.0 { more } else { less })
    };
    let along =
        same_way(|it| it.forward_m, LEAST_OFF_M).map(|it| side(it, ["farther ahead", "farther back"]));
    let across = same_way(|it| it.left_m, LEAST_OFF_M).map(|it| side(it, ["farther left", "farther right"]));
    if let Some(off) = along.or(across) {
        all.push((
            SuspectKind::Place,
            nats(0),
            format!("all detectors find it at least {off} than labelled"),
        ));
    }
    if let Some(off_m) = same_way(|it| it.length_m, LEAST_OFF_M) {
        let off = side(off_m, ["longer", "shorter"]);
        all.push((
            SuspectKind::Size,
            nats(1),
            format!("for all detectors it is at least {off} than labelled"),
        ));
    }
    if let Some(turned_deg) = same_way(|it| it.turned_deg, LEAST_TURN_DEG) {
        let way = if turned_deg > 0.0 { "left" } else { "right" };
        let reason = format!("all detectors turn it by at least {:.0}° to the {way}", turned_deg.abs());
        all.push((SuspectKind::Heading, nats(2), reason));
    }
    all
}

/// The suspicion of the class: all detectors give the same other one.
fn of_class(
    annotated: AnnotationClass,
    pairs: &[(usize, &DetectionFacts)],
    habits: &[Habits],
) -> Option<(SuspectKind, f64, String)> {
    let given = pairs.first()?.1.class.given().filter(|it| !it.includes(annotated))?;
    if !pairs.iter().all(|(_, it)| it.class.given() == Some(given)) {
        return None;
    }
    let of_detector = |detector: usize| habits[detector].classes.get(&annotated).copied().unwrap_or_default();
    let nats = pairs.iter().map(|(detector, _)| surprise(of_detector(*detector))).sum();
    Some((SuspectKind::Class, nats, format!("all detectors call it {given}")))
}

/// Things that all detectors find, each of them falsely.
fn unlabelled(
    key: ScanKey<'_>,
    by_detector: &BTreeMap<usize, Vec<&DetectionFacts>>,
    habits: &[Habits],
) -> Vec<SuspectRow> {
    let Some(first) = by_detector.get(&0).filter(|_| by_detector.len() == habits.len()) else {
        return Vec::new();
    };
    let of_first = first.iter().filter_map(|seen| {
        let others = (1..habits.len()).map(|it| nearest(seen, &by_detector[&it]));
        let others = others.collect::<Option<Vec<_>>>()?;
        let all = [*seen].into_iter().chain(others).zip(habits);
        let nats = all.map(|(it, habits)| of(&habits.detections, it.n_points)).sum();
        let reason = format!("all {} detectors find an object here, and none is labelled", habits.len());
        let about = (None, seen.class.name(), seen.n_points);
        let found = &seen.bounding_box;
        Some(suspect(
            key,
            SuspectKind::NotLabelled,
            nats,
            about,
            reason,
            [None, Some(found.center_m)],
            Some(found),
        ))
    });
    of_first.collect()
}

/// The nearest of `others` that stands where `seen` does: nearer than half the shorter of both lengths.
fn nearest<'a>(seen: &DetectionFacts, others: &[&'a DetectionFacts]) -> Option<&'a DetectionFacts> {
    let apart = |it: &DetectionFacts| {
        let [x_m, y_m] = [0, 1].map(|axis| it.bounding_box.center_m[axis] - seen.bounding_box.center_m[axis]);
        let [a_m, b_m] = [it, seen].map(|it| it.bounding_box.length_width_height_m[0]);
        let apart_m = x_m.hypot(y_m);
        (apart_m < a_m.min(b_m) / 2.0).then_some(apart_m)
    };
    let near = others.iter().filter_map(|it| Some((apart(it)?, *it)));
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, it)| it)
}

fn suspect(
    (dataset, sequence, scan): ScanKey<'_>,
    kind: SuspectKind,
    surprise_nats: f64,
    (annotation_id, class, n_points): (Option<u64>, &str, u64),
    reason: String,
    [labelled_m, found_m]: [Option<[f32; 3]>; 2],
    found: Option<&BoxFacts>,
) -> SuspectRow {
    let at = |axis: usize| labelled_m.or(found_m).map(|it| Fixed::rounded(f64::from(it[axis])));
    let side = |axis: usize| found.map(|it| Fixed::rounded(f64::from(it.length_width_height_m[axis])));
    SuspectRow {
        dataset: dataset.to_owned(),
        sequence: sequence.to_owned(),
        scan,
        kind,
        surprise_nats: Fixed::rounded(surprise_nats),
        annotation_id,
        class: class.to_owned(),
        n_points,
        reason,
        center_x_m: at(0),
        center_y_m: at(1),
        center_z_m: at(2),
        found_length_m: side(0),
        found_width_m: side(1),
        found_height_m: side(2),
        found_yaw_rad: found.map(|it| Fixed::rounded(f64::from(it.yaw_rad))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::match_outcome::MotionFacts;
    use crate::vocabulary::class::DetectionClass;
    use crate::vocabulary::criterion::CriterionKind;
    use crate::vocabulary::reason::MissReason;

    fn car(x_m: f32, length_m: f32, yaw_rad: f32) -> BoxFacts {
        BoxFacts { center_m: [x_m, 0.0, 0.0], length_width_height_m: [length_m, 2.0, 1.5], yaw_rad }
    }

    fn labelled(id: u64) -> AnnotationFacts {
        let bounding_box = Some(car(10.0 * id as f32, 4.0, 0.0));
        AnnotationFacts { id, bounding_box, ..AnnotationFacts::without_position(AnnotationClass::Car, 300) }
    }

    fn found(bounding_box: BoxFacts, class: AnnotationClass) -> DetectionFacts {
        DetectionFacts {
            id: 0,
            class: DetectionClass::Given(class),
            score: None,
            n_points: 300,
            bounding_box,
            motion: MotionFacts::default(),
        }
    }

    /// Rows of a detector: each of twenty cars as `of_car` says, and false detections.
    fn rows(
        detector: &str,
        of_car: impl Fn(u64) -> Option<DetectionFacts>,
        false_at_m: &[f32],
    ) -> Vec<MatchRow> {
        let of_cars = (0..20).map(|id| match of_car(id) {
            Some(detection) => MatchOutcome::Matched { annotation: labelled(id), detection, cost: 0.0 },
            None => MatchOutcome::Missed { annotation: labelled(id), reason: MissReason::NothingThere },
        });
        let of_false = false_at_m.iter().map(|x_m| MatchOutcome::False {
            detection: found(car(*x_m, 4.0, 0.0), AnnotationClass::Car),
            reason: FalseReason::NothingThere,
        });
        let row = |outcome| MatchRow {
            dataset: "street".to_owned(),
            sequence: "0000".to_owned(),
            scan: 3,
            detector: detector.to_owned(),
            task: Task::Objects,
            criterion: CriterionKind::Points,
            outcome,
        };
        of_cars.chain(of_false).map(row).collect()
    }

    #[test]
    fn what_all_detectors_contradict_is_suspect_and_what_one_does_is_not() {
        use AnnotationClass::{Car, Truck};
        let detector = |name: &str, own: u64, off_m: f32| {
            let of_car = move |id: u64| match id {
                // Each has a miss, a shift and a class of its own.
                0 => None,
                1 => Some(found(car(10.0 + off_m, 4.0, 0.0), Car)),
                2 => Some(found(car(20.0, 4.0 + off_m, 0.0), Car)),
                3 => Some(found(car(30.0, 4.0, 0.5 * off_m), Car)),
                4 => Some(found(car(40.0, 4.0, 0.0), Truck)),
                _ if id == own => None,
                _ if id == own + 1 => Some(found(car(10.0 * id as f32 + 1.5, 4.0, 0.0), Truck)),
                _ => Some(found(car(10.0 * id as f32 + 0.01, 4.0, 0.0), Car)),
            };
            rows(name, of_car, &[505.0 + off_m, 700.0 + 40.0 * own as f32])
        };
        let all = [detector("a", 10, 0.9), detector("b", 15, 1.1)].concat();
        let found = suspects(&all, Task::Objects, &["a", "b"]);
        let kinds: BTreeMap<Option<u64>, SuspectKind> =
            found.iter().map(|it| (it.annotation_id, it.kind)).collect();
        let expected = [
            (None, SuspectKind::NotLabelled),
            (Some(0), SuspectKind::FoundByNone),
            (Some(1), SuspectKind::Place),
            (Some(2), SuspectKind::Size),
            (Some(3), SuspectKind::Heading),
            (Some(4), SuspectKind::Class),
        ];
        assert_eq!(kinds, BTreeMap::from(expected));
        assert_eq!(found.len(), expected.len());
        assert!(found.windows(2).all(|pair| pair[0].surprise_nats.0 >= pair[1].surprise_nats.0));
        // Of twenty cars each misses two: (2 + 1) / (20 + 2) for each of both.
        let missed = found.iter().find(|it| it.kind == SuspectKind::FoundByNone).unwrap();
        assert!((missed.surprise_nats.0 - 2.0 * (22.0_f64 / 3.0).ln()).abs() < 1e-3, "{missed:?}");
        let reason = |kind| found.iter().find(|it| it.kind == kind).unwrap().reason.clone();
        assert_eq!(
            reason(SuspectKind::Place),
            "all detectors find it at least 0.9 m farther ahead than labelled"
        );
        assert_eq!(reason(SuspectKind::Size), "for all detectors it is at least 0.9 m longer than labelled");
        assert_eq!(reason(SuspectKind::Class), "all detectors call it truck");
        // Parts of something labelled are no sign of a missing label.
        let mut parts = all.clone();
        for row in &mut parts {
            if let MatchOutcome::False { reason, .. } = &mut row.outcome {
                *reason = FalseReason::Fragment;
            }
        }
        let found = suspects(&parts, Task::Objects, &["a", "b"]);
        assert!(found.iter().all(|it| it.kind != SuspectKind::NotLabelled));
        // A third detector that is right about everything takes all of that back.
        let right = rows("c", |id| Some(self::found(car(10.0 * id as f32, 4.0, 0.0), Car)), &[]);
        assert_eq!(suspects(&[all, right].concat(), Task::Objects, &["a", "b", "c"]), []);
    }
}
