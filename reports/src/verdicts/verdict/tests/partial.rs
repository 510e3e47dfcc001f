//! Verdicts on results of `scanbench partial`.

use super::*;
use crate::files::texts::check_holds;
use crate::rows::partial_row::PartialRow;
use crate::run_folder::manifest::tests::partial_manifest;
use crate::tables::verdict::brief::{Brief, Purpose};
use crate::tables::verdict::comparison::{ComparedSlices, DifferenceRow, compare_runs};
use crate::verdicts::partial_differences::tests::rows;
use crate::vocabulary::partial_class::PartialClass;

/// Forty trees and forty poles, of each of which the first `n_right` are right.
fn result(n_right: usize) -> RunArchive {
    RunArchive::of_partial(partial_manifest(), rows(n_right))
}

fn verdict_on(n_before: usize, n_after: usize, drift: DriftRule) -> Verdict {
    let tolerances = Tolerances { drift, ..Tolerances::built_in(&result(n_before)) };
    judge(&result(n_before), &result(n_after), &tolerances).unwrap()
}

#[test]
fn a_sure_loss_is_a_regression_and_less_is_drift() {
    for (n_after, drift, conclusion) in [
        (38, DriftRule::Fail, Conclusion::Same),
        (30, DriftRule::Warn, Conclusion::Regression),
        (37, DriftRule::Fail, Conclusion::Drift),
        (40, DriftRule::Warn, Conclusion::AllowedDrift),
    ] {
        assert_eq!(verdict_on(38, n_after, drift).conclusion(), conclusion, "{n_after}");
    }
}

#[test]
fn a_verdict_names_what_is_worse_and_what_changed() {
    let verdict = verdict_on(40, 30, DriftRule::Fail);
    let purpose = Purpose::Gate { in_full: "gate" };
    let brief = Terminal::UNFOLDED.text(&Brief { verdict: &verdict, sides: ["a", "b"], purpose });
    check_holds(
        &brief,
        &[
            "FAILED: worse",
            "graphs trained on parts on 80 partial clouds of street",
            "1 worse, 0 inconclusive, 0 missing. Results changed on 20 partial clouds: 20 objects lost.",
            "mean_recall of step 1, graphs trained on parts, partial on street from below: 100.0 → 75.0 %",
            "mean_recall: 2.00 points",
            "pole-30 at step 1, street from below, graphs trained on parts",
        ],
    );
    check_holds(
        &Markdown.text(&verdict),
        &["tree-39 at step 1", "tree, and now pole", "of objects, each with all its"],
    );
    let json: serde_json::Value = serde_json::from_str(&Json.text(&verdict)).unwrap();
    assert_eq!((&json["conclusion"], json["drift"].as_array().unwrap().len()), (&"regression".into(), 20));
    assert_eq!(
        (&json["metrics"][0]["slice"], &json["metrics"][0]["tolerance"]),
        (&"step 1".into(), &0.02.into())
    );
    let same = Markdown.text(&verdict_on(40, 40, DriftRule::Fail));
    assert!(same.contains("PASSED") && !same.contains("step 1"), "{same}");
}

#[test]
fn a_loss_and_every_changed_class_are_cases() {
    for (n_after, drift, n_worse, n_failed, n_allowed) in
        [(40, DriftRule::Fail, 0, 0, 0), (30, DriftRule::Fail, 1, 20, 0), (30, DriftRule::Warn, 1, 0, 20)]
    {
        let xml = JUnit.text(&verdict_on(40, n_after, drift));
        for (part, n) in [
            ("type=\"regression\"", n_worse),
            ("type=\"drift\"", n_failed),
            ("<skipped message=\"allowed: ", n_allowed),
            ("mean_recall of step 1 on street from below", 1),
        ] {
            assert_eq!(xml.matches(part).count(), n, "{part} in {xml}");
        }
    }
}

#[test]
fn rules_may_be_about_single_steps_and_methods() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let judged_by = |rules: &str| {
        std::fs::write(file.path(), format!("drift = \"warn\"\n{rules}")).unwrap();
        judge(&result(40), &result(30), &Tolerances::read(file.path()).unwrap())
    };
    let all_steps = "mean_recall = 0.02\nstrangers_rejected = 1\nknown_rejected = 0.02\n";
    assert_eq!(judged_by(all_steps).unwrap().conclusion(), Conclusion::Regression);
    let step = "[[quality]]\nmetrics = [\"mean_recall\"]\nabsolute = 0.4\nrelative = 0.0\nslices = ";
    let lenient = judged_by(&format!("{all_steps}{step}[\"step 1\"]")).unwrap();
    assert_eq!(lenient.conclusion(), Conclusion::AllowedDrift);
    for (rules, problem) in [
        (format!("{step}[\"step 2\"]"), "the rule has no effect on mean_recall of \"step 2\""),
        (all_steps.replace("0.02", "2"), "mean_recall = 2 is not within 0 to 1"),
        ("mean_recall = 0.02".to_owned(), "there is no `known_rejected`"),
        (all_steps.replace("known", "knwon"), "unknown field `knwon_rejected`"),
    ] {
        let error = judged_by(&rules).unwrap_err().to_string();
        assert!(error.contains(problem), "{error}");
    }
}

#[test]
fn two_results_stand_side_by_side() {
    let comparison = compare_runs(&result(40), &result(35), ComparedSlices::All, None).unwrap();
    let text = Markdown.text(&comparison);
    check_holds(
        &text,
        &["(simulated)", "−12.50", "mean_recall \\[%]", "10 times (counted per partial cloud"],
    );
    let row = &DifferenceRow::all(&comparison)[0];
    let row =
        String::from_utf8(crate::files::csv_rows::to_csv_lines(std::slice::from_ref(row)).unwrap()).unwrap();
    let expected = "partial on street from below,graphs trained on parts,step 1,mean_recall,1.000000,0.875000,-0.125000,-0.";
    assert!(row.starts_with(expected), "{row}");
}

#[test]
fn other_objects_parts_and_methods_cannot_be_compared() {
    let check = |change: &dyn Fn(&mut RunArchive), message: &str| {
        let mut after = result(40);
        change(&mut after);
        let error = check_comparable(&result(40), &after).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    let every =
        |it: &mut RunArchive, change: &dyn Fn(&mut PartialRow)| it.objects.iter_mut().for_each(change);
    assert_eq!(check_comparable(&result(40), &result(3)), Ok(()));
    check(
        &|it| it.manifest.partial.as_mut().unwrap().sets[0].judged.id = "another".to_owned(),
        "objects that are judged are not the same",
    );
    check(&|it| it.objects.truncate(79), "step 1 of pole-39 is only in the earlier one");
    check(
        &|it| every(it, &|row| row.method = "other".to_owned()),
        "graphs trained on parts, street from below",
    );
    check(
        &|it| it.objects[0].true_class = PartialClass::Car,
        "tree-00 at step 1 was a tree of 9 points, and is not any more",
    );
    check(&|it| it.manifest = sample::manifest(), "one is a result of `partial`, and the other is not");
    let empty = RunArchive::of_partial(partial_manifest(), Vec::new());
    assert!(check_comparable(&empty, &result(40)).is_err());
}
