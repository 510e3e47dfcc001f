//! A verdict on partial clouds as `JUnit` XML: one test case for each number, and one for each object whose predicted class
//! changed.

use quick_junit::{Report, TestCase, TestCaseStatus, TestSuite};

use crate::files::fixed_decimals::fixed_decimals;
use crate::tables::formats::format::Format;
use crate::tables::formats::junit::{JUnit, case, failed, skipped, status};
use crate::verdicts::finding::Finding;
use crate::verdicts::partial_difference::{ChangedPrediction, CurveName, PartialDifference};
use crate::verdicts::partial_verdict::PartialVerdict;
use crate::verdicts::tolerances::DriftRule;

impl Format<PartialVerdict> for JUnit {
    /// The name that CI servers look for, whatever the stem.
    fn file_name(&self, _stem: &str) -> String {
        "junit.xml".to_owned()
    }

    fn text(&self, verdict: &PartialVerdict) -> String {
        let mut report = Report::new("scanbench gate");
        let of_number = |(it, finding): &(PartialDifference, Finding)| of_number(verdict, it, *finding);
        for (name, cases) in
            [("quality", verdict.findings.iter().map(of_number).collect()), ("drift", drift_cases(verdict))]
        {
            let mut suite = TestSuite::new(name);
            suite.add_test_cases(cases);
            report.add_test_suite(suite);
        }
        report.to_string().expect("memory takes all that is written")
    }
}

fn of_number(verdict: &PartialVerdict, it: &PartialDifference, finding: Finding) -> TestCase {
    let percent = |share: f64| fixed_decimals(100.0 * share, 1);
    let within = it.interval.map_or_else(String::new, |it| {
        let [low, high] = it.ends.map(percent);
        format!(" (95 % {low} to {high})")
    });
    let message = format!(
        "{}: {} before, {} after, {}{within}, tolerance {}; in %",
        it.metric.in_words(),
        percent(it.before),
        percent(it.after),
        percent(it.difference()),
        percent(verdict.tolerances.of(it.metric))
    );
    let doubt = it.interval.and_then(|it| it.blocks.caveat());
    let name = format!("{} at step {} of {}", it.metric.id(), it.step, seen(&it.curve));
    case(&class("quality", &it.curve), &name, status(finding, &message, doubt.as_deref()))
}

/// One for each object of a curve, with all its steps.
fn drift_cases(verdict: &PartialVerdict) -> Vec<TestCase> {
    if verdict.drift.is_empty() {
        let name = "no prediction changed";
        return vec![case("scanbench.partial.drift", name, TestCaseStatus::success())];
    }
    let is_of_same =
        |a: &ChangedPrediction, b: &ChangedPrediction| a.curve == b.curve && a.object == b.object;
    let of_object = |steps: &[ChangedPrediction]| {
        let step = |it: &ChangedPrediction| {
            format!("step {}: {}, and now {}", it.step, it.before.name(), it.after.name())
        };
        let details: Vec<String> = steps.iter().map(step).collect();
        let message = format!("predicted class changed at {} steps", steps.len());
        let status = match verdict.tolerances.drift {
            DriftRule::Fail => failed("drift", &message, &details.join("\n")),
            DriftRule::Warn => skipped(&format!("allowed: {message}")),
        };
        let (curve, object) = (&steps[0].curve, &steps[0].object);
        case(&class("drift", curve), &format!("{object} of {}", seen(curve)), status)
    };
    verdict.drift.chunk_by(is_of_same).map(of_object).collect()
}

fn seen(CurveName { data, direction, .. }: &CurveName) -> String {
    format!("{data} from {direction}")
}

fn class(suite: &str, CurveName { method, trained_on, .. }: &CurveName) -> String {
    format!("scanbench.partial.{suite}.{method} trained on {trained_on}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdicts::partial_difference::tests::archive;
    use crate::verdicts::partial_verdict::{PartialTolerances, judge_partial};

    #[track_caller]
    fn check(n_right: usize, drift: DriftRule, expected: [(&str, usize); 4]) {
        let tolerances = PartialTolerances { drift, ..PartialTolerances::built_in() };
        let verdict = judge_partial(&archive(40), &archive(n_right), &tolerances).unwrap();
        let xml = JUnit.text(&verdict);
        for (part, n) in expected {
            assert_eq!(xml.matches(part).count(), n, "{part} in {xml}");
        }
    }

    #[test]
    fn a_loss_and_every_object_whose_predicted_class_changed_are_cases() {
        let [regression, drift] = ["type=\"regression\"", "type=\"drift\""];
        let (allowed, number) =
            ("<skipped message=\"allowed: ", "mean_recall at step 1 of street from below");
        check(40, DriftRule::Fail, [(regression, 0), (drift, 0), (allowed, 0), (number, 1)]);
        // Of forty trees and forty poles, ten each.
        check(30, DriftRule::Fail, [(regression, 1), (drift, 20), (allowed, 0), (number, 1)]);
        check(30, DriftRule::Warn, [(regression, 1), (drift, 0), (allowed, 20), (number, 1)]);
        check(
            30,
            DriftRule::Fail,
            [
                ("100.0 before, 75.0 after, -25.0 (95 % -", 2),
                ("tree-30 of street", 1),
                ("step 1: tree, and now pole", 10),
                ("tolerance 2.0", 2),
            ],
        );
    }
}
