use super::*;
use crate::verdicts::rule_problems::RuleProblems;
use crate::verdicts::tolerances::GatedSubject;

const TOML: &str = r#"
    [[quality]]
    metrics = ["recall"]
    slices = ["class/*"]
    tasks = ["vehicles"]
    detectors = ["pca", "kd-tree"]
    absolute = 0.05
    relative = 0.0

    [[quality]]
    metrics = ["f_rate", "recall"]
    slices = ["all", "class/*"]
    absolute = 0.01
    relative = 0.1

    [speed]
    reference = "grid-write"
    relative = 0.5
"#;

fn read(text: &str) -> Result<Tolerances, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tolerances.toml");
    std::fs::write(&path, text).unwrap();
    let tolerances = Tolerances::read(&path).map_err(|error| error.to_string())?;
    RuleProblems::check(None, tolerances.problems.clone()).map_err(|error| error.to_string())?;
    Ok(tolerances)
}

#[test]
fn the_first_rule_that_is_about_it_decides() {
    let tolerances = read(TOML).unwrap();
    let about = |metric: &Metric, task: Task, detector, part| {
        tolerances.rule_about(metric, GatedSubject { task: task.name(), detector, part })
    };
    assert_eq!(about(&Metric::Recall, Task::Vehicles, "pca", "class/car"), Some(0));
    assert_eq!(about(&Metric::Recall, Task::Objects, "pca", "class/car"), Some(1));
    assert_eq!(about(&Metric::Recall, Task::Vehicles, "hierarchical", "class/car"), Some(1));
    assert_eq!(about(&Metric::Recall, Task::Objects, "pca", "range/0-15"), None);
    assert_eq!(about(&Metric::Precision, Task::Objects, "pca", "all"), None);
    assert_eq!(tolerances.metrics(), [Metric::Recall, Metric::FRate]);
    assert_eq!(
        [0.5, 0.02].map(|before| tolerances.quality[1].tolerance(&Metric::FRate, before)),
        [0.05, 0.01]
    );
}

#[test]
fn a_number_is_expected_where_slice_and_task_are_named() {
    let tolerances = read(&TOML.replacen("class/*", "class/car", 1)).unwrap();
    let names = |rule: usize, part, task: Task| {
        tolerances.quality[rule].names(GatedSubject { task: task.name(), detector: "pca", part })
    };
    assert!(names(0, "class/car", Task::Vehicles) && !names(0, "class/van", Task::Vehicles));
    assert!(!names(1, "all", Task::Vehicles) && !names(1, "class/car", Task::Vehicles));
}

/// The error of the file with its first `from` replaced by `to`.
fn problem(from: &str, to: &str) -> String {
    assert!(TOML.contains(from));
    read(&TOML.replacen(from, to, 1)).unwrap_err()
}

#[track_caller]
fn check_refused(cases: &[[&str; 3]]) {
    for [from, to, expected] in cases {
        let problem = problem(from, to);
        assert!(problem.contains(expected), "{problem}");
    }
}

#[test]
fn what_cannot_be_gated_is_refused() {
    let metric = "\"f_rate\"";
    check_refused(&[
        [metric, "\"f_rat\"", "[[quality]] 2: there is no metric \"f_rat\"; did you mean \"f_rate\"?"],
        [metric, "\"latency_p50_ms\"", "changes with every run; check times with [speed]"],
        [metric, "\"time_over_reference\"", "changes with every run; check times with [speed]"],
        [metric, "\"no\"", "has no direction that is better"],
        [metric, "\"ap_r40\"", "has no interval"],
        ["vehicles", "vehicle", "[[quality]] 1: there is no task \"vehicle\"; did you mean \"vehicles\"?"],
        ["absolute = 0.05", "absolut = 0.05", "unknown field `absolut`"],
        ["[\"class/*\"]", "[]", "[[quality]] 1: slices is empty"],
        ["[\"pca\", \"kd-tree\"]", "[]", "[[quality]] 1: detectors is empty"],
        ["grid-write", "kd-tree", "[speed]: the reference for times is \"grid-write\", not \"kd-tree\""],
    ]);
}

#[test]
fn tolerances_that_let_everything_pass_are_refused() {
    for size in ["absolute = 0.05", "relative = 0.1", "relative = 0.5"] {
        let name = size.split(' ').next().unwrap();
        for absurd in ["-0.05", "nan", "inf"] {
            check_refused(&[[size, &format!("{name} = {absurd}"), "is not a tolerance"]]);
        }
    }
    check_refused(&[
        ["relative = 0.1", "relative = 5.0", "relative = 5 tolerates 500 %; it must be less than 1"],
        ["relative = 0.5", "relative = 1.0", "[speed]: relative = 1 tolerates 100 %"],
        ["relative = 0.5", "relative = 0.5\ndetectors = []", "[speed]: detectors is empty"],
        ["absolute = 0.05", "absolute = 0.51", "the most is 0.5 of a rate, where 1 is 100 %"],
    ]);
    let of_boxes = |absolute: f64| {
        let text = TOML.replacen("[\"recall\"]", "[\"box_center_error_m\", \"box_yaw_error_deg\"]", 1);
        read(&text.replacen("absolute = 0.05", &format!("absolute = {absolute}"), 1))
    };
    assert!(of_boxes(2.0).is_ok());
    assert!(of_boxes(2.1).unwrap_err().contains("the most is 2 m"));
}

/// The line of a problem is that of the value, and that of the table where there is none.
#[test]
fn all_that_is_wrong_is_said_at_once_and_each_once() {
    let text = r#"
drift = "pass"
quality = [{ metrics = ["recal", "recal"], slices = "all", absolute = "much", relatve = 0.0 }]
sped = 1

[speed]
reference = "kd-tree"
detectors = []
relative = 2.0
"#;
    insta::assert_snapshot!(read(text).unwrap_err(), @r#"
    bad tolerances, 10 problems:
      line 2: drift = "pass" means nothing; it is "fail" or "warn"
      line 4: unknown field `sped`; did you mean "speed"?
      line 3, [[quality]] 1: there is no metric "recal"; did you mean "recall"?
      line 3, [[quality]] 1: slices = "all" is not a list of names
      line 3, [[quality]] 1: absolute = "much" is not a number
      line 3, [[quality]] 1: there is no `relative`
      line 3, [[quality]] 1: unknown field `relatve`; did you mean "relative"?
      line 7, [speed]: the reference for times is "grid-write", not "kd-tree"
      line 8, [speed]: detectors is empty
      line 9, [speed]: relative = 2 tolerates 200 %; it must be less than 1, which is 100 %
    "#);
    assert_eq!(
        read("quality = 3").unwrap_err(),
        "bad tolerances: line 1: 3 is not a list of tables, each below [[quality]]"
    );
    assert_eq!(read("").unwrap_err(), "bad tolerances: line 1: there is no `quality`");
    let drift = |rule: &str| read(&format!("drift = {rule}\n{TOML}")).map(|it| it.drift);
    assert_eq!(drift("\"warn\""), Ok(DriftRule::Warn));
    assert_eq!(drift("\"fail\""), Ok(DriftRule::Fail));
    assert_eq!(read(TOML).unwrap().drift, DriftRule::Fail);
    assert!(drift("true").unwrap_err().contains("line 1: drift = true is not a text"));
    let of_line_7 = TOML.replacen("absolute = 0.05", "absolute = 5", 1);
    assert!(read(&of_line_7).unwrap_err().contains("line 7, [[quality]] 1: absolute = 5 would pass"));
}
