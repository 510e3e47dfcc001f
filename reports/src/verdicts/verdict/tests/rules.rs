//! Subjects of rules, and those that they leave open.

use super::*;
use crate::verdicts::rule_problems::RuleProblem;

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
    // Precision is not measured of classes, and over-segmentation is measured of everything alone.
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
    // In no named task, and nowhere else either: the rule is about nothing.
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
