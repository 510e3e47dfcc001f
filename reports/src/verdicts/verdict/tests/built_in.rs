//! The built-in tolerances.

use super::*;

/// `kd-tree` and `pca` have one task and no boxes, and `pca` was not timed.
fn half_timed() -> RunArchive {
    let mut run = USUAL.archive();
    numbers_of(&mut run, |it| it.detector == "pca").for_each(|it| it.least_latency_ms = None);
    run
}

#[test]
fn built_in_tolerances_are_about_exactly_what_the_baseline_has() {
    let tolerances = Tolerances::built_in(&half_timed());
    insta::assert_snapshot!(tolerances.annotated(), @r#"
    # How much worse than the accepted run a number may become before `scanbench gate` fails.
    #
    # A rule is about its metrics, in its slices (a * at the end stands for anything), tasks and detectors. The first rule
    # that is about a number decides. Tolerated is the larger of `absolute`, in the unit of the metric, and `relative`, a
    # share of the accepted value. A number fails only if its whole 95 % interval is worse than that. What no rule is about
    # is not judged: delete what does not matter to you.

    # Detection is deterministic. If the outcome of any object changed though no number is surely worse, "fail" ends with exit
    # code 101, and "warn" passes and says what changed. `scanbench gate --allow-drift` has the last word.
    drift = "fail"

    # F-rate, 2 TP / (NO + ND): one number for how much is found and how much of it is right. 1 is perfect.
    # TP: found, NO: annotations that count, ND: detections that count. absolute = 0.01 is one point of a hundred.
    [[quality]]
    metrics = ["f_rate"]
    slices = ["all"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.01
    relative = 0.0

    # Recall, TP / NO: the share of the annotated objects that is found.
    [[quality]]
    metrics = ["recall"]
    slices = ["all"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.01
    relative = 0.0

    # Precision, TP / ND: the share of the detections that is right.
    [[quality]]
    metrics = ["precision"]
    slices = ["all"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.01
    relative = 0.0

    # The share of the annotated objects that is torn into several detections.
    [[quality]]
    metrics = ["over_segmentation"]
    slices = ["all"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.01
    relative = 0.0

    # How far the points of an object are spread over several detections: an entropy, in nats. 0 is not at all.
    [[quality]]
    metrics = ["ose_per_object"]
    slices = ["all"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.02
    relative = 0.1

    # Recall of parts of the objects: by class, by distance in metres, by number of points, by what hides them.
    [[quality]]
    metrics = ["recall"]
    slices = ["class/*", "range/*", "points/*"]
    tasks = ["objects"]
    detectors = ["kd-tree", "pca"]
    absolute = 0.02
    relative = 0.0

    # Time: that of a detector divided by that of `grid-write`, a plain write of a grid on the same scans, timed in turns with it.
    # relative = 0.5 is half as slow again. It can be 0.1 if both runs are made with --repeats 5 on a machine with nothing else to do.
    # Times are compared only between runs on the same processor.
    [speed]
    reference = "grid-write"
    detectors = ["kd-tree"]
    relative = 0.5
    "#);
}

#[test]
fn built_in_tolerances_are_printed_and_written() {
    let run = half_timed();
    let tolerances = Tolerances::built_in(&run);
    let verdict = judge(&run, &run, &tolerances).unwrap();
    assert_eq!(verdict.conclusion(), Conclusion::Same);
    // They are printed.
    insta::assert_snapshot!(printed(&verdict).lines().nth(2).unwrap(), @r"
    Tolerances: built in, because the baseline has no tolerances.toml. rates: 1.00 points; entropies: 0.02 nats or 10 %; recall of slices: 2.00 points; time: 50 %.
    ");
    // The file says the same.
    let mut read = read_back(&tolerances.annotated());
    assert!(read.problems.is_empty(), "{:?}", read.problems);
    read.origin = Origin::BuiltIn;
    read.speed.as_mut().unwrap().line = None;
    read.quality.iter_mut().for_each(|it| it.line = None);
    assert_eq!(read, tolerances);
}

#[test]
fn built_in_tolerances_leave_out_what_cannot_be_known() {
    // Nothing false can be known: there is no rule about precision, and nothing is missing.
    let unknown = SampleScans { fo: None, ms_of: None, ..USUAL }.archive();
    let tolerances = Tolerances::built_in(&unknown);
    assert!(!tolerances.metrics().contains(&Metric::Precision) && tolerances.speed.is_none());
    assert_eq!(judge(&unknown, &unknown, &tolerances).unwrap().conclusion(), Conclusion::Same);
}
