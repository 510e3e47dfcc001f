//! Texts about results that changed.

use super::*;
use crate::rows::match_outcome::{DetectionFacts, MotionFacts};
use crate::verdicts::change::ChangeKind;
use crate::vocabulary::class::DetectionClass;
use crate::vocabulary::reason::FalseReason;

/// One object of a scan, `x_m` forward, with `n_points`.
fn row(scan: u32, outcome: MatchOutcome) -> MatchRow {
    MatchRow { scan, outcome, ..missed("pca", scan, 0) }
}

fn annotation(id: u64, n_points: u64) -> AnnotationFacts {
    let without_position = AnnotationFacts::without_position(AnnotationClass::Car, n_points);
    AnnotationFacts { id, bounding_box: Some(at(10.0)), ..without_position }
}

fn at(x_m: f32) -> BoxFacts {
    BoxFacts { center_m: [x_m, 0.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 }
}

fn detection(x_m: f32, n_points: u64) -> DetectionFacts {
    let class = DetectionClass::Vehicle;
    DetectionFacts {
        id: 0,
        class,
        score: Some(0.5),
        n_points,
        bounding_box: at(x_m),
        motion: MotionFacts::default(),
    }
}

fn found(scan: u32, annotation: AnnotationFacts, detection: DetectionFacts, cost: f64) -> MatchRow {
    row(scan, MatchOutcome::Matched { annotation, detection, cost })
}

fn lost(scan: u32, annotation: AnnotationFacts) -> MatchRow {
    row(scan, MatchOutcome::Missed { annotation, reason: MissReason::Split })
}

fn false_one(scan: u32, detection: DetectionFacts) -> MatchRow {
    row(scan, MatchOutcome::False { detection, reason: FalseReason::NothingThere })
}

fn with_matches(matches: Vec<MatchRow>) -> RunArchive {
    RunArchive { matches, ..USUAL.archive() }
}

fn verdict_of(before: Vec<MatchRow>, now: Vec<MatchRow>) -> Verdict {
    judge(&with_matches(before), &with_matches(now), &tolerances()).unwrap()
}

#[track_caller]
fn check(before: MatchRow, now: MatchRow, kind: ChangeKind, text: &str) {
    let verdict = verdict_of(vec![before], vec![now]);
    let [drift] = &verdict.drift[..] else { panic!("{:?}", verdict.drift) };
    let [change] = &drift.changes[..] else { panic!("{drift:?}") };
    assert_eq!((change.kind, change.text.as_str()), (kind, text));
}

#[test]
fn each_change_has_a_kind() {
    let pair = |detection, cost| found(0, annotation(3, 50), detection, cost);
    let object = "car 3, 50 points at (10.0, 0.0) m";
    let [as_object, surer] = [
        DetectionFacts { class: DetectionClass::Object, ..detection(10.0, 40) },
        DetectionFacts { score: Some(0.6), ..detection(10.0, 40) },
    ];
    check(
        pair(detection(10.0, 40), 0.2),
        lost(0, annotation(3, 50)),
        ChangeKind::Lost,
        &format!("{object}: found before, now missed (split)"),
    );
    check(
        pair(detection(10.0, 40), 0.2),
        pair(as_object.clone(), 0.2),
        ChangeKind::OtherClass,
        &format!("{object}: found before as vehicle, now as object"),
    );
    check(
        pair(detection(10.0, 40), 0.2),
        pair(detection(10.0, 39), 0.2),
        ChangeKind::Otherwise,
        &format!(
            "{object}: still found, but at cost 0.200 with 39 points, before at cost 0.200 with 40 points"
        ),
    );
    // The printed lines of these would not differ.
    let text = "box, score or cost of 1 object, by less than is shown";
    check(pair(detection(10.0, 40), 0.2), pair(surer.clone(), 0.2), ChangeKind::NotShown, text);
    check(pair(detection(10.0, 40), 0.2), pair(detection(10.0, 40), 0.2001), ChangeKind::NotShown, text);
    check(false_one(0, detection(10.0, 40)), false_one(0, surer), ChangeKind::NotShown, text);
    check(
        false_one(0, detection(10.0, 40)),
        false_one(0, detection(10.5, 40)),
        ChangeKind::Otherwise,
        "detection of 40 points at (10.5, 0.0) m: still false (nothing there), before detection of 40 points at \
         (10.0, 0.0) m",
    );
    check(
        row(0, MatchOutcome::Unknowable { detection: detection(10.0, 40), agreement: None }),
        false_one(0, as_object),
        ChangeKind::NewFalse,
        "detection of 40 points at (10.0, 0.0) m: before unknowable, now false (nothing there)",
    );
}

#[test]
fn another_number_of_the_same_detection_is_no_change() {
    let renumbered = DetectionFacts { id: 7, ..detection(10.0, 40) };
    let [before, now] = [detection(10.0, 40), renumbered].map(|it| {
        let other = DetectionFacts { bounding_box: at(30.0), ..it.clone() };
        vec![found(0, annotation(3, 50), it, 0.2), false_one(0, other)]
    });
    assert!(verdict_of(before, now).drift.is_empty());
}

#[test]
fn what_stands_somewhere_else_is_new_and_the_earlier_one_gone() {
    let verdict =
        verdict_of(vec![false_one(0, detection(10.0, 40))], vec![false_one(0, detection(12.1, 40))]);
    let kinds: Vec<ChangeKind> = verdict.drift[0].changes.iter().map(|it| it.kind).collect();
    assert_eq!(kinds, [ChangeKind::NewFalse, ChangeKind::NoLongerFalse]);
}

/// As with walls switched off: among hundreds of objects with another cost, some are lost.
#[test]
fn what_is_lost_comes_first_in_every_format() {
    let (mut before, mut now) = (Vec::new(), Vec::new());
    for scan in 0..30 {
        for id in 0..20 {
            before.push(found(scan, annotation(id, 50), detection(10.0, 40), 0.2));
            // Equal to three digits, but not the same.
            let cost = if id < 10 { 0.2001 } else { 0.3 };
            now.push(found(scan, annotation(id, 50), detection(10.0, 40), cost));
        }
        for id in 20..22 {
            let n_points = u64::from(scan) + 100 * id;
            before.push(found(scan, annotation(id, n_points), detection(10.0, 40), 0.2));
            now.push(lost(scan, annotation(id, n_points)));
        }
    }
    now.push(false_one(29, detection(40.0, 12)));
    let verdict = verdict_of(before, now);
    let counts = "60 objects lost, 1 new false detection, 300 same outcomes for another reason, at another cost or with other \
        points, 300 changes of less than is shown";
    let said = format!("Results changed on 30 scans: {counts}.");

    let markdown = Markdown.text(&verdict);
    check_holds(&markdown, &said);
    let listing: Vec<&str> = markdown.lines().skip_while(|it| *it != "- 60 objects lost").collect();
    assert!(
        listing[1].starts_with("  - main_road/0000/000029, pca, objects: car 21, 2129 points"),
        "{markdown}"
    );
    assert_eq!(listing[21], "  - and 40 more; gate.json lists all");
    assert_eq!(listing[22], "- 1 new false detection");
    let n_lines = |part: &str| markdown.lines().filter(|it| it.contains(part)).count();
    assert_eq!((n_lines("still found"), n_lines("now missed")), (20, 20), "{markdown}");

    let json: serde_json::Value = serde_json::from_str(&Json.text(&verdict)).unwrap();
    assert_eq!(json["n_changes"]["lost"], 60);
    let changes = json["drift"].as_array().unwrap().iter().flat_map(|it| it["changes"].as_array().unwrap());
    let n_of = |kind: &str| changes.clone().filter(|it| it["kind"] == kind).count();
    assert_eq!([n_of("lost"), n_of("otherwise"), n_of("not-shown")], [60, 300, 30]);
    assert_eq!(json["drift"][0]["changes"][0]["kind"], "lost");

    let xml = JUnit.text(&verdict);
    let first = xml.lines().find(|it| it.contains("type=\"drift\"")).unwrap();
    assert!(first.contains("results changed: 2 objects lost, 10 same outcomes"), "{first}");
    let text = printed(&verdict);
    let position =
        |part: &str| text.lines().position(|it| it.contains(part)).unwrap_or_else(|| panic!("{text}"));
    assert!(position(": found before, now missed") < position("still found, but"));
}
