use super::*;
use crate::numbers::run_report::RunReport;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::rows::counts::Counts;
use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use crate::tables::formats::format::Format as _;
use crate::tables::formats::json::Json;
use crate::tables::formats::junit::JUnit;
use crate::tables::formats::markdown::Markdown;
use crate::tables::formats::terminal::Terminal;
use crate::tables::sample;
use crate::tables::sheet::Tabular;
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::Question;
use crate::verdicts::gated_metrics::Missing;
use crate::verdicts::least_loss::{LeastLosses, least_losses};
use crate::verdicts::tolerances::{DriftRule, Origin, Rule};
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::reason::MissReason;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

mod built_in;
mod changes;
mod comparable;
mod in_brief;
mod partial;
mod rules;

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
            objects: Vec::new(),
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

/// A rule about `task` alone.
fn rule_of(task: &str, metrics: &[&str]) -> Rule {
    Rule { tasks: Some(texts(&[task])), ..rule(metrics, &["all"]) }
}

/// Tolerances of these rules, without times.
fn held_to(quality: Vec<Rule>) -> Tolerances {
    let (protocols, problems, drift) = (Vec::new(), Vec::new(), DriftRule::Fail);
    Tolerances {
        origin: Origin::File("tolerances.toml".into()),
        quality,
        protocols,
        streams: Vec::new(),
        speed: None,
        drift,
        problems,
    }
}

/// Recall of everything may fall by 2 points, and times may grow by a quarter.
fn tolerances() -> Tolerances {
    Tolerances { speed: Some(Rule::of_times(0.25)), ..held_to(vec![rule(&["recall"], &["all"])]) }
}

/// Judges `run` by the usual one.
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
    // The worse numbers are not hidden behind the unchanged ones.
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

fn read_back(text: &str) -> Tolerances {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tolerances.toml");
    std::fs::write(&path, text).unwrap();
    Tolerances::read(&path).unwrap()
}

/// Changed results are counted by scans, and the tolerances decide the conclusion.
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
    let changes = text.lines().skip_while(|it| !it.starts_with("30 objects that count"));
    let changes: Vec<&str> = changes.take_while(|it| !it.is_empty()).collect();
    assert!(changes.len() > 60 && changes.iter().all(|it| it.chars().count() <= 40), "{text}");
    assert!(changes[1].starts_with("  ") && changes[2].starts_with("    "), "{text}");
}
