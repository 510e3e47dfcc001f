use super::*;
use crate::numbers::run_report::RunReport;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::rows::counts::Counts;
use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use crate::run_folder::manifest::{DetectorEntry, ForeignEntry};
use crate::tables::formats::format::Format as _;
use crate::tables::formats::json::Json;
use crate::tables::formats::junit::JUnit;
use crate::tables::formats::markdown::Markdown;
use crate::tables::formats::terminal::Terminal;
use crate::tables::sample;
use crate::tables::sheet::Tabular;
use crate::tables::verdict::brief::{Brief, Purpose};
use crate::tables::verdict::comparison::{ComparedSlices, compare_runs};
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::Question;
use crate::verdicts::gated_metrics::Missing;
use crate::verdicts::least_loss::{LeastLosses, least_losses};
use crate::verdicts::rule_problems::RuleProblem;
use crate::verdicts::tolerances::{DriftRule, Origin, Rule};
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::reason::MissReason;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// A run of the detectors `kd-tree`, which finds 5 of 10 cars in every scan in 100 ms, and `pca`.
struct SampleScans<'a> {
    /// Scans, each of a second of its own.
    n_scans: u32,
    /// How many of the 10 cars of a scan `pca` finds.
    tp_of: &'a dyn Fn(u32) -> u64,
    /// How long that takes in milliseconds; nothing is timed without it.
    ms_of: Option<&'a dyn Fn(u32) -> f64>,
    /// False detections of every scan, where they can be known.
    fo: Option<u64>,
}

/// Thirty scans on which `pca` finds 7 or 5 cars, turn by turn, in 10 ms.
const USUAL: SampleScans<'_> =
    SampleScans { n_scans: 30, tp_of: &seven_or_five, ms_of: Some(&|_| 10.0), fo: Some(2) };

fn seven_or_five(step: u32) -> u64 {
    7 - 2 * u64::from(step % 2 == 1)
}

impl SampleScans<'_> {
    fn archive(&self) -> RunArchive {
        let steps = 0..self.n_scans;
        let rows = steps.clone().flat_map(|step| {
            let ms = self.ms_of.map(|ms_of| ms_of(step));
            [self.row(step, "kd-tree", 5, ms.map(|_| 100.0)), self.row(step, "pca", (self.tp_of)(step), ms)]
        });
        let found = |detector: &str, step| if detector == "pca" { (self.tp_of)(step) } else { 5 };
        let matches = ["kd-tree", "pca"].into_iter().flat_map(|detector| {
            steps
                .clone()
                .flat_map(move |step| (found(detector, step)..10).map(move |id| missed(detector, step, id)))
        });
        RunArchive {
            protocols: ProtocolTally::default(),
            claims: Vec::new(),
            more_files: Vec::new(),
            manifest: sample::manifest(),
            report: RunReport::new(1, Vec::new()).unwrap(),
            scans: rows.collect(),
            matches: matches.collect(),
        }
    }

    fn row(&self, step: u32, detector: &str, tp: u64, ms: Option<f64>) -> ScanRow {
        let [dataset, sequence, detector] = ["main_road", "0000", detector].map(str::to_owned);
        let task = Task::Objects;
        let numbers = ScanNumbers {
            latency_ms: ms,
            least_latency_ms: ms,
            reference_ms: ms.map(|_| 0.5),
            ..ScanNumbers::of_counts(Counts::new(10, tp, self.fo).unwrap())
        };
        let (time_s, outcome) = (Some(f64::from(step)), ScanOutcome::Evaluated(numbers));
        ScanRow { dataset, sequence, scan: step, time_s, detector, task, outcome }
    }
}

/// A car 10 m away that `detector` has missed.
fn missed(detector: &str, scan: u32, id: u64) -> MatchRow {
    let bounding_box =
        BoxFacts { center_m: [10.0, 0.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
    let without_position = AnnotationFacts::without_position(AnnotationClass::Car, 100);
    let annotation = AnnotationFacts { id, bounding_box: Some(bounding_box), ..without_position };
    let [dataset, sequence, detector] = ["main_road", "0000", detector].map(str::to_owned);
    let (task, criterion) = (Task::Objects, CriterionKind::Points);
    let outcome = MatchOutcome::Missed { annotation, reason: MissReason::Split };
    MatchRow { dataset, sequence, scan, detector, task, criterion, outcome }
}

fn texts(names: &[&str]) -> Vec<String> {
    names.iter().map(|it| (*it).to_owned()).collect()
}

fn rule(metrics: &[&str], slices: &[&str]) -> Rule {
    let (metrics, parts) = (texts(metrics), texts(slices));
    Rule { line: None, metrics, parts, tasks: None, detectors: None, absolute: 0.02, relative: 0.0 }
}

/// About `task` alone.
fn rule_of(task: &str, metrics: &[&str]) -> Rule {
    Rule { tasks: Some(texts(&[task])), ..rule(metrics, &["all"]) }
}

/// These rules, without times.
fn held_to(quality: Vec<Rule>) -> Tolerances {
    let (protocols, problems, drift) = (Vec::new(), Vec::new(), DriftRule::Fail);
    Tolerances {
        origin: Origin::File("tolerances.toml".into()),
        quality,
        protocols,
        speed: None,
        drift,
        problems,
    }
}

/// Recall of everything may fall by 2 points, and times may grow by a quarter.
fn tolerances() -> Tolerances {
    Tolerances { speed: Some(Rule::of_times(0.25)), ..held_to(vec![rule(&["recall"], &["all"])]) }
}

/// `run` beside the usual one.
fn against_usual(run: &RunArchive) -> Result<Verdict, JudgeError> {
    judge(&USUAL.archive(), run, &tolerances())
}

fn judged(run: &SampleScans<'_>) -> Verdict {
    judge(&SampleScans { n_scans: run.n_scans, ..USUAL }.archive(), &run.archive(), &tolerances()).unwrap()
}

fn printed(subject: &impl Tabular) -> String {
    Terminal::UNFOLDED.text(subject)
}

#[track_caller]
fn check_holds(text: &str, part: &str) {
    assert!(text.contains(part), "no {part} in {text}");
}

/// The numbers of every scan of `run` that `is_meant`.
fn numbers_of(
    run: &mut RunArchive,
    is_meant: fn(&ScanRow) -> bool,
) -> impl Iterator<Item = &mut ScanNumbers> {
    run.scans.iter_mut().filter(move |it| is_meant(it)).filter_map(|it| match &mut it.outcome {
        ScanOutcome::Evaluated(numbers) => Some(numbers),
        ScanOutcome::Skipped { .. } => None,
    })
}

/// The usual run, whose only entry is `pca`, of others.
fn with_foreign(foreign: ForeignEntry) -> RunArchive {
    let mut run = USUAL.archive();
    run.manifest.detectors = vec![DetectorEntry { foreign: Some(foreign), ..sample::detector("pca") }];
    run
}

#[track_caller]
fn check_quality(tp_of: &dyn Fn(u32) -> u64, expected: Finding) {
    let verdict = judged(&SampleScans { tp_of, ..USUAL });
    let [_, pca] = verdict.metrics.as_slice() else { panic!("{verdict:?}") };
    assert_eq!((pca.detector.as_str(), pca.finding), ("pca", expected), "{pca:?}");
    assert!(verdict.speeds.iter().all(|it| it.finding == Finding::Pass));
}

#[test]
fn recorded_and_simulated_scans_are_judged_apart() {
    let beside_kitti = |tp_of_kitti: &dyn Fn(u32) -> u64| {
        let recorded = SampleScans { tp_of: tp_of_kitti, fo: None, ..USUAL }.archive();
        let (mut both, kitti) = (USUAL.archive(), || "kitti_tracking".to_owned());
        both.scans.extend(recorded.scans.into_iter().map(|it| ScanRow { dataset: kitti(), ..it }));
        both.matches.extend(recorded.matches.into_iter().map(|it| MatchRow { dataset: kitti(), ..it }));
        both
    };
    let of_pca = Rule { detectors: Some(texts(&["pca"])), ..rule_of("objects", &["recall", "f_rate"]) };
    let tolerances = held_to(vec![of_pca]);
    let (baseline, worse) = (beside_kitti(&seven_or_five), beside_kitti(&|step| seven_or_five(step) - 1));
    let found = |run: &RunArchive| {
        let verdict = judge(&baseline, run, &tolerances).unwrap();
        let metrics = verdict.metrics.iter();
        metrics.map(|it| (format!("{} {}", it.metric.id(), it.about()), it.finding)).collect::<Vec<_>>()
    };
    // False objects are not known on KITTI: no F-rate is missing there.
    let numbers = |of_kitti| {
        [
            ("recall objects on main_road".to_owned(), Finding::Pass),
            ("f_rate objects on main_road".to_owned(), Finding::Pass),
            ("recall objects on kitti_tracking".to_owned(), of_kitti),
        ]
    };
    assert_eq!(found(&baseline), numbers(Finding::Pass));
    // Not hidden behind what is as it was.
    assert_eq!(found(&worse), numbers(Finding::Regression));
}

#[test]
fn one_object_less_in_every_scan_is_surely_worse() {
    check_quality(&|step| seven_or_five(step) - 1, Finding::Regression);
}

#[test]
fn much_worse_in_two_scans_and_as_before_in_all_others_may_be_chance() {
    check_quality(&|step| if step < 2 { 0 } else { seven_or_five(step) }, Finding::Inconclusive);
}

#[test]
fn a_little_worse_is_tolerated_and_better_is_no_worse() {
    check_quality(&|step| if step == 0 { 6 } else { seven_or_five(step) }, Finding::Pass);
    check_quality(&|_| 10, Finding::Pass);
    assert_eq!(judged(&SampleScans { tp_of: &|_| 10, ..USUAL }).conclusion(), Conclusion::Drift);
}

/// One object less in every scan, of fewer and fewer scans.
#[test]
fn of_few_blocks_a_loss_is_inconclusive_and_only_drift_can_fail() {
    let worse = |n_scans| judged(&SampleScans { n_scans, tp_of: &|step| seven_or_five(step) - 1, ..USUAL });
    assert_eq!(worse(10).conclusion(), Conclusion::Regression);
    for n_scans in [9, 4, 1] {
        let verdict = worse(n_scans);
        assert_eq!(verdict.conclusion(), Conclusion::Drift);
        assert_eq!((verdict.n(Finding::Regression), verdict.n(Finding::Inconclusive)), (0, 1));
        let blocks = if n_scans == 1 { "block" } else { "blocks" };
        let text = printed(&verdict);
        let said = format!("Only {n_scans} {blocks} of scans: too few to show that anything is worse");
        assert!(text.lines().nth(2).unwrap().starts_with(&said), "{text}");
        for text in [&text, &Markdown.text(&verdict)] {
            check_holds(text, &format!("inconclusive: {n_scans} {blocks}"));
        }
        assert_eq!(n_scans > 1, text.contains('§'), "{text}");
    }
}

#[track_caller]
fn check_speed(ms_of: &dyn Fn(u32) -> f64, expected: Finding, expected_slowdown: f64) {
    let verdict = judged(&SampleScans { ms_of: Some(ms_of), ..USUAL });
    let speed = &verdict.speeds[1];
    assert_eq!((speed.detector.as_str(), speed.finding), ("pca", expected), "{speed:?}");
    let share = speed.difference.as_ref().unwrap().difference();
    assert!((share - expected_slowdown).abs() < 1e-9, "{speed:?}");
    assert!(verdict.drift.is_empty(), "times are no drift");
}

#[test]
fn a_half_more_time_is_a_regression_and_one_slow_scan_is_not() {
    check_speed(&|_| 10.0, Finding::Pass, 0.0);
    check_speed(&|_| 15.0, Finding::Regression, 0.5);
    check_speed(&|_| 5.0, Finding::Pass, -0.5);
    // One scan of thirty takes 2^30 times as long: the geometric mean doubles.
    check_speed(&|step| if step == 0 { 10.0 * 2_f64.powi(30) } else { 10.0 }, Finding::Inconclusive, 1.0);
}

#[test]
fn times_of_other_processors_are_not_compared_and_that_is_said() {
    let mut run = SampleScans { ms_of: Some(&|_| 1000.0), ..USUAL }.archive();
    run.manifest.machine.cpu_model = "Other CPU".to_owned();
    let verdict = against_usual(&run).unwrap();
    assert_eq!(verdict.conclusion(), Conclusion::Same);
    let said = "Speed was not compared: the processor changed from \"Example CPU @ 2 GHz\" to \"Other CPU\".";
    assert_eq!(printed(&verdict).lines().nth(2), Some(said));
    assert!(Markdown.text(&verdict).lines().take(5).any(|it| it == said));
}

#[test]
fn times_that_were_not_taken_are_missing() {
    for (before, after, missing) in [
        (USUAL, SampleScans { ms_of: None, ..USUAL }, Missing::InRun),
        (SampleScans { ms_of: None, ..USUAL }, USUAL, Missing::InBaseline),
        (SampleScans { ms_of: None, ..USUAL }, SampleScans { ms_of: None, ..USUAL }, Missing::InBoth),
    ] {
        let verdict = judge(&before.archive(), &after.archive(), &tolerances()).unwrap();
        assert_eq!(verdict.conclusion(), Conclusion::Incomparable);
        assert!(verdict.speeds.iter().all(|it| it.difference == Err(missing)));
        check_holds(
            &printed(&verdict),
            &format!("\nTime relative to grid-write, pca, main_road: {}.\n", missing.in_words()),
        );
    }
}

#[test]
fn a_detector_that_was_not_run_everywhere_is_not_comparable() {
    let mut run = USUAL.archive();
    run.scans.retain(|it| it.detector == "kd-tree" || it.scan > 0);
    let error = against_usual(&run).unwrap_err().to_string();
    check_holds(&error, "pca was evaluated on 30 scans of main_road in the task objects, and now on 29");
    run.scans.retain(|it| it.detector == "kd-tree");
    assert_eq!(
        against_usual(&run).unwrap_err().to_string(),
        "the runs cannot be compared: the detector pca is only in the earlier run, not in the later one"
    );

    // A new one has nothing to be judged by, and is named.
    let verdict = judge(&run, &USUAL.archive(), &tolerances()).unwrap();
    check_holds(&printed(&verdict), "Not judged, because only the later run has it: pca.");
    let comparison = compare_runs(&run, &USUAL.archive(), ComparedSlices::All).unwrap();
    check_holds(&printed(&comparison), "Not compared, because only the later run has it: pca.");
}

#[test]
fn a_changed_configuration_is_reported_with_both_values() {
    let with = |it: &str| with_foreign(ForeignEntry { vehicles: it.to_owned(), ..ForeignEntry::default() });
    let (before, after) = (with("size"), with("model"));
    let verdict = judge(&before, &after, &tolerances()).unwrap();
    let purpose = Purpose::Gate { in_full: "gate --full" };
    let brief = Brief { verdict: &verdict, sides: ["run", "baseline"], purpose };
    let comparison = compare_runs(&before, &after, ComparedSlices::All).unwrap();
    for text in [printed(&verdict), printed(&brief), printed(&comparison)] {
        check_holds(&text, "Configuration changed: pca: vehicles: size → model.");
    }
    check_holds(&Json.text(&verdict), "\"pca: vehicles: size → model\"");
    let same = judge(&before, &before, &tolerances()).unwrap();
    assert!(!printed(&same).contains("Configuration changed"));
}

#[test]
fn scans_of_which_points_or_labels_changed_are_not_gated() {
    let mut relabelled = USUAL.archive();
    numbers_of(&mut relabelled, |it| it.scan == 1).for_each(|it| it.checksum += 1);
    let error = against_usual(&relabelled).unwrap_err().to_string();
    let expected = "the runs cannot be compared: points or labels changed in 1 of ";
    assert!(error.starts_with(expected) && error.ends_with("their checksums differ"), "{error}");
}

#[test]
fn results_of_other_files_are_not_gated() {
    let with = |checksum: &str| {
        let [results, results_checksum] = ["found", checksum].map(|it| Some(it.to_owned()));
        with_foreign(ForeignEntry { results, results_checksum, ..ForeignEntry::default() })
    };
    assert!(judge(&with("a"), &with("a"), &tolerances()).is_ok());
    assert!(against_usual(&with("a")).is_ok());
    assert_eq!(
        judge(&with("a"), &with("b"), &tolerances()).unwrap_err().to_string(),
        "the runs cannot be compared: the results of pca changed: their checksums differ"
    );
    // What lies between the two is no secret.
    let comparison = compare_runs(&with("a"), &with("b"), ComparedSlices::All).unwrap();
    check_holds(&printed(&comparison), "The results of these changed before they were judged: pca.");
}

#[test]
fn speed_is_held_of_the_detectors_that_its_rule_names() {
    let slow = SampleScans { ms_of: Some(&|_| 100.0), ..USUAL }.archive();
    let speeds_of = |names: Option<&[&str]>| {
        let mut tolerances = tolerances();
        tolerances.speed.as_mut().unwrap().detectors = names.map(texts);
        judge(&USUAL.archive(), &slow, &tolerances)
    };
    let held = |names| -> Vec<String> {
        let verdict = speeds_of(names).unwrap();
        verdict.speeds.iter().map(|it| it.detector.clone()).collect()
    };
    let all = held(None);
    assert!(all.len() > 1 && all.iter().any(|it| it == "pca"), "{all:?}");
    assert_eq!(held(Some(&["pca"])), ["pca"]);
    let Err(JudgeError::Rules(problems)) = speeds_of(Some(&["pcaa"])) else { panic!("no such detector") };
    let said = "bad tolerances \"tolerances.toml\": [speed]: there is no detector \"pcaa\" in either run; did you mean \"pca\"?";
    assert_eq!(problems.to_string(), said);
}

/// `pca` has lost 15 points of F-rate, and rules that name it wrongly have to say so.
#[test]
fn rules_about_nothing_are_refused_all_at_once() {
    let worse = SampleScans { tp_of: &|step| seven_or_five(step) - 2, ..USUAL }.archive();
    let problem = |rules: Vec<Rule>| {
        let tolerances = held_to(rules);
        match judge(&USUAL.archive(), &worse, &tolerances) {
            Err(JudgeError::Rules(RuleProblems { problems, .. })) => {
                problems.iter().map(RuleProblem::to_string).collect::<Vec<_>>().join("; ")
            }
            other => panic!("{other:?}"),
        }
    };
    let of_detector = Rule { detectors: Some(texts(&["pcaa"])), ..rule(&["recall"], &["all"]) };
    assert_eq!(
        problem(vec![
            rule_of("vehicles", &["recall"]),
            rule(&["recall"], &["al"]),
            rule(&["recall"], &["range/0-20"]),
            of_detector
        ]),
        "[[quality]] 1: there is no task \"vehicles\" in either run; choose from objects; \
         [[quality]] 2: there is no slice \"al\" in either run; did you mean \"all\"?; \
         [[quality]] 3: there is no slice \"range/0-20\" in either run; did you mean \"range/0-15\"?; \
         [[quality]] 4: there is no detector \"pcaa\" in either run; did you mean \"pca\"?"
    );
    // A beginning that no slice has.
    check_holds(&problem(vec![rule(&["recall"], &["occlusion/*"])]), "there is no slice \"occlusion/*\"");
    // Precision is not measured of classes, and what is torn apart is measured of everything alone.
    for (metric, slice) in
        [("precision", "class/car"), ("over_segmentation", "range/*"), ("box_yaw_error_deg", "all")]
    {
        let problem = problem(vec![rule(&[metric, "recall"], &[slice, "all"])]);
        check_holds(&problem, &format!("no effect on {metric} of {slice:?}"));
        assert!(!problem.contains("on recall"), "{problem}");
    }
    // A rule before it decides about all that it is about.
    let shadowed = problem(vec![rule(&["recall"], &["class/*", "all"]), rule(&["recall"], &["class/car"])]);
    assert!(shadowed.starts_with("[[quality]] 2: the rule has no effect"), "{shadowed}");
}

#[test]
fn a_beginning_that_stands_for_some_slices_is_no_mistake() {
    let tolerances = held_to(vec![rule(&["recall", "f_rate"], &["all", "range/*"])]);
    let verdict = judge(&USUAL.archive(), &USUAL.archive(), &tolerances).unwrap();
    let of_pca: Vec<String> = verdict
        .metrics
        .iter()
        .filter(|it| it.detector == "pca")
        .map(|it| format!("{} of {}", it.metric.id(), it.slice))
        .collect();
    assert_eq!(of_pca, ["recall of all", "f_rate of all", "recall of range/0-15", "f_rate of range/0-15"]);
}

#[test]
fn a_number_that_is_missing_is_named_and_nothing_passes() {
    // False objects cannot be known in the run: no F-rate, which a rule is about.
    let unknown = SampleScans { fo: None, ..USUAL };
    let of_task = rule_of("objects", &["f_rate"]);
    for (before, after, named, missing) in [
        (&USUAL, &unknown, &of_task, Missing::InRun),
        (&unknown, &USUAL, &of_task, Missing::InBaseline),
        (&unknown, &USUAL, &rule(&["f_rate"], &["a*"]), Missing::InBaseline),
        (&unknown, &unknown, &of_task, Missing::InBoth),
    ] {
        let tolerances = held_to(vec![named.clone()]);
        let verdict = judge(&before.archive(), &after.archive(), &tolerances).unwrap();
        assert_eq!(verdict.conclusion(), Conclusion::Incomparable);
        assert!(verdict.metrics.iter().all(|it| it.difference == Err(missing)), "{verdict:?}");
        check_holds(
            &printed(&verdict),
            &format!("\nf_rate of all, pca, objects, main_road: {}.\n", missing.in_words()),
        );
    }
    // Of no named task, and nowhere else either: the rule is about nothing.
    let tolerances = held_to(vec![rule(&["f_rate"], &["all"])]);
    let error = judge(&unknown.archive(), &unknown.archive(), &tolerances).unwrap_err().to_string();
    check_holds(&error, "no effect on f_rate of \"all\"");
}

#[test]
fn a_missing_number_is_no_regression_but_a_regression_goes_first() {
    let worse = SampleScans { fo: None, tp_of: &|step| seven_or_five(step) - 2, ..USUAL };
    let mut tolerances = tolerances();
    tolerances.quality.push(rule(&["f_rate"], &["all"]));
    let verdict = judge(&USUAL.archive(), &worse.archive(), &tolerances).unwrap();
    assert_eq!(verdict.conclusion(), Conclusion::Regression);
    assert_eq!((verdict.n(Finding::Incomparable), verdict.n(Finding::Regression)), (2, 1));
    let metrics = verdict.metrics.iter().map(|it| it.metric.clone()).collect::<Vec<_>>();
    assert_eq!(metrics, [Metric::Recall, Metric::FRate, Metric::Recall, Metric::FRate]);
}

fn read_back(text: &str) -> Tolerances {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tolerances.toml");
    std::fs::write(&path, text).unwrap();
    Tolerances::read(&path).unwrap()
}

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

/// Unknown entries of the file, names missing in the runs, and rules without effect are reported together. A rule that is
/// wrong in one way is not reported to have no effect as well.
#[test]
fn problems_of_the_file_and_of_the_runs_are_reported_together() {
    let tolerances = read_back(
        r#"
[[quality]]
metrics = ["recal"]
slices = ["all"]
tasks = ["vehicles"]
absolute = 2.0
relative = 0.0

[[quality]]
metrics = ["recall"]
slices = ["al"]
detectors = ["pcaa"]
absolute = 0.01
relative = 0.0

[[quality]]
metrics = ["precision", "recall"]
slices = ["class/*"]
absolute = 0.01
relative = 0.0

[speed]
reference = "grid-write"
detectors = ["nobody"]
relative = 1.5
"#,
    );
    let error = judge(&USUAL.archive(), &USUAL.archive(), &tolerances).unwrap_err().to_string();
    let said = error.lines().skip(1).collect::<Vec<_>>().join("\n");
    insta::assert_snapshot!(said, @r#"
    line 2, [[quality]] 1: there is no task "vehicles" in either run; choose from objects
    line 3, [[quality]] 1: there is no metric "recal"; did you mean "recall"?
    line 9, [[quality]] 2: there is no detector "pcaa" in either run; did you mean "pca"?
    line 9, [[quality]] 2: there is no slice "al" in either run; did you mean "all"?
    line 16, [[quality]] 3: the rule has no effect on precision of "class/*": neither run has it, or an earlier rule applies
    line 22, [speed]: there is no detector "nobody" in either run; choose from kd-tree, pca
    line 25, [speed]: relative = 1.5 tolerates 150 %; it must be less than 1, which is 100 %
    "#);
}

/// What changed is counted by scans, and what it comes to is up to the tolerances.
#[test]
fn changed_results_fail_unless_they_are_allowed() {
    let run =
        SampleScans { tp_of: &|step| if step < 5 { 8 } else { seven_or_five(step) }, ..USUAL }.archive();
    for (drift, conclusion, name, headline) in [
        (DriftRule::Fail, Conclusion::Drift, "drift", "FAILED: results changed"),
        (
            DriftRule::Warn,
            Conclusion::AllowedDrift,
            "allowed-drift",
            "PASSED, results changed on 5 scans (allowed)",
        ),
    ] {
        let mut verdict = judge(&USUAL.archive(), &run, &Tolerances { drift, ..tolerances() }).unwrap();
        // As if the first scan had changed of another detector, too.
        let mut another = verdict.drift[0].clone();
        "kd-tree".clone_into(&mut another.subject.detector);
        verdict.drift.push(another);
        assert_eq!((verdict.conclusion(), verdict.n_changed_scans()), (conclusion, 5));
        assert_eq!(printed(&verdict).lines().next(), Some(headline));
        assert!(Markdown.text(&verdict).starts_with(&format!("**{headline}**\n")));
        let json: serde_json::Value = serde_json::from_str(&Json.text(&verdict)).unwrap();
        assert_eq!((&json["conclusion"], &json["drift_rule"]), (&name.into(), &drift.name().into()));
        let xml = JUnit.text(&verdict);
        let n = |part: &str| xml.matches(part).count();
        let expected = if conclusion.is_pass() { (0, 6) } else { (6, 0) };
        assert_eq!((n("type=\"drift\""), n("<skipped message=\"allowed: ")), expected, "{xml}");
    }
    // A loss is one, whatever is allowed.
    let worse = SampleScans { tp_of: &|step| seven_or_five(step) - 1, ..USUAL }.archive();
    let tolerances = Tolerances { drift: DriftRule::Warn, ..tolerances() };
    let verdict = judge(&USUAL.archive(), &worse, &tolerances).unwrap();
    assert_eq!(verdict.conclusion(), Conclusion::Regression);
    assert!(Markdown.text(&verdict).starts_with("**FAILED: worse**\n"));
}

fn brief(verdict: &Verdict) -> String {
    let in_full = "scanbench gate runs/after --baseline runs/before --full";
    let sides = ["runs/after", "runs/before"];
    Terminal { width: Some(80) }.text(&Brief { verdict, sides, purpose: Purpose::Gate { in_full } })
}

#[test]
fn a_verdict_in_brief_names_losses_and_gains_with_their_intervals() {
    let run = SampleScans { tp_of: &|step| seven_or_five(step) - 1, ms_of: Some(&|_| 20.0), ..USUAL };
    let verdict = judge(&USUAL.archive(), &run.archive(), &Tolerances::built_in(&USUAL.archive())).unwrap();
    insta::assert_snapshot!(brief(&verdict), @r"
    FAILED: worse
    Judged: runs/after against runs/before, kd-tree, pca on 30 scans of main_road.
    18 numbers: 4 worse, 0 inconclusive, 0 missing. Results changed on 30 scans.
    4 numbers changed; of these up to 0.1 are called worse by chance, on average.
    Tolerances: built in, because the baseline has no tolerances.toml. rates: 1.00
      points; entropies: 0.02 nats or 10 %; recall of slices: 2.00 points; time: 50
      %.

    All losses:
    - recall, pca, objects: 60.0 → 50.0 %, −10.00 (95 % −10.00 to −10.00, tolerated
      1.00): worse
    - f_rate, pca, objects: 66.7 → 58.8 %, −7.84 (95 % −8.21 to −7.50, tolerated
      1.00): worse
    - precision, pca, objects: 75.0 → 71.4 %, −3.57 (95 % −3.99 to −3.22, tolerated
      1.00): worse
    - time, pca: 20.00 → 40.00 times grid-write, 100 % slower (95 % 100 to 100 %
      slower, tolerated 50 %): worse
    Most results changed on main_road 0000/000000, pca, objects: 1 object.
    In full: scanbench gate runs/after --baseline runs/before --full
    ");
    assert_eq!((verdict.n_worse(), verdict.n_at_risk()), (4, 4));
    // The other way round all of it is gained.
    let before = run.archive();
    let better = judge(&before, &USUAL.archive(), &Tolerances::built_in(&before)).unwrap();
    let text = brief(&better);
    let (_, gains) = text.split_once("\nAll gains:\n").unwrap();
    assert!(gains.starts_with("- recall, pca, objects: 50.0 → 60.0 %, +10.00 (95 % +10.00 to +10.00, tolerated\n  1.00): better\n"), "{gains}");
    assert!(!text.contains("losses:"), "{text}");
    assert!(Markdown.text(&better).contains("| better |"), "{}", Markdown.text(&better));
    let same = judged(&USUAL);
    assert_eq!((same.n_worse(), same.n_at_risk()), (0, 0), "what is the same is no matter of chance");
    insta::assert_snapshot!(brief(&same), @r"
    PASSED
    Judged: runs/after against runs/before, kd-tree, pca on 30 scans of main_road.
    4 numbers: 0 worse, 0 inconclusive, 0 missing. No result changed.
    Tolerances: tolerances.toml.

    In full: scanbench gate runs/after --baseline runs/before --full
    ");
}

/// However much is changed or missing.
#[test]
fn a_verdict_in_brief_has_thirty_lines_of_eighty_characters_at_most() {
    let run = SampleScans { tp_of: &|step| u64::from(step % 3), fo: None, ms_of: None, n_scans: 9 };
    let after = run.archive();
    let before = SampleScans { n_scans: 9, ..USUAL }.archive();
    let tolerances = Tolerances::built_in(&before);
    let verdict = judge(&before, &after, &tolerances).unwrap();
    let text = brief(&verdict);
    assert!(verdict.n(Finding::Incomparable) > 3, "{text}");
    assert!(text.lines().count() <= 30, "{}\n{text}", text.lines().count());
    assert!(text.lines().all(|it| it.chars().count() <= 80), "{text}");
    assert!(text.contains("more numbers are missing."), "{text}");
}

/// Scans of which nobody knows when they were taken: however large a loss is, it is not sure.
#[test]
fn scans_that_may_be_neighbours_show_no_loss() {
    let without_times = |mut archive: RunArchive| {
        archive.scans.iter_mut().for_each(|it| it.time_s = None);
        archive
    };
    let run = SampleScans { tp_of: &|step| seven_or_five(step) - 4, ..USUAL };
    let [before, after] = [USUAL.archive(), run.archive()].map(without_times);
    let verdict = judge(&before, &after, &tolerances()).unwrap();
    assert_eq!((verdict.conclusion(), verdict.n_at_risk()), (Conclusion::Drift, 0));
    assert!(verdict.n(Finding::Inconclusive) > 0 && verdict.n_worse() == verdict.n(Finding::Inconclusive));
    let text = brief(&verdict);
    check_holds(&text, "These scans may be neighbours, because their times are not known");
    check_holds(&Markdown.text(&verdict), "inconclusive: scans may be neighbours");
    check_holds(&JUnit.text(&verdict), "inconclusive, scans may be neighbours: ");
    // The same scans with times are no others, but their intervals would be.
    let reasons = against_usual(&after).unwrap_err().to_string();
    check_holds(&reasons, "the time of scan 0000/000000 of main_road changed");
    let said = "No loss will be sure: scans without known times, which may be neighbours, are not enough to show one.";
    assert_eq!(least_losses(&before, &tolerances()).lines(), [said]);
}

#[test]
fn the_least_loss_is_what_is_tolerated_and_half_of_the_interval() {
    let run = USUAL.archive();
    let LeastLosses::Above(losses) = least_losses(&run, &Tolerances::built_in(&run)) else {
        panic!("30 blocks")
    };
    // Every scan has the same F-rate of kd-tree; those of pca lie around 66.7 %.
    assert_eq!((losses[0].detector.as_str(), losses[0].loss), ("kd-tree", 0.01));
    let tally = run.tally();
    let question = Question { dataset: OVERALL, task: Task::Objects, detector: "pca", slice: Slice::All };
    let sample = tally.sample(&question, &tally.draw()).unwrap();
    let rates = Distribution::new(sample.resampled_values(&Metric::FRate), sample.blocks).unwrap();
    let [low, high] = rates.interval().ends;
    assert!(
        (losses[1].loss - 0.01 - (high - low) / 2.0).abs() < 1e-12 && losses[1].loss > 0.03,
        "{losses:?}"
    );
}

#[test]
fn a_list_of_changes_fits_into_the_columns_there_are() {
    let run = SampleScans { tp_of: &|step| seven_or_five(step) - 1, ..USUAL }.archive();
    let verdict = against_usual(&run).unwrap();
    let text = Terminal { width: Some(40) }.text(&verdict);
    let changes = text.lines().skip_while(|it| !it.starts_with("main_road 0000/000000, pca"));
    let changes: Vec<&str> = changes.take_while(|it| !it.is_empty()).collect();
    assert!(changes.len() > 60 && changes.iter().all(|it| it.chars().count() <= 40), "{text}");
    assert!(changes[1].starts_with("  ") && changes[2].starts_with("    "), "{text}");
}
