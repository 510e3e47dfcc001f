//! A verdict as `JUnit` XML, which every CI server shows: one test case a gated number, and one a scan whose results
//! changed.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use crate::tables::formats::format::Format;
use crate::tables::verdict::summary::doubt;
use crate::tables::verdict::wording::{
    difference_text, interval_text, metric_text, tolerance_text, value_text,
};
use crate::verdicts::change::{in_words, n_of_kinds};
use crate::verdicts::changed_claims::ChangedClaim;
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{GatedMetric, about};
use crate::verdicts::tolerances::DriftRule;
use crate::verdicts::verdict::{SinceEarlier, Verdict};
use crate::vocabulary::metric::SPEED_REFERENCE;

/// The XML that `JUnit` writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JUnit;

impl Format<Verdict> for JUnit {
    /// The name that CI servers look for, whatever the stem.
    fn file_name(&self, _stem: &str) -> String {
        "junit.xml".to_owned()
    }

    fn text(&self, verdict: &Verdict) -> String {
        let doubt = doubt(verdict);
        let doubt = doubt.as_deref();
        let mut report = Report::new("scanbench gate");
        let suites: [(&str, Vec<TestCase>); 5] = [
            ("quality", verdict.metrics.iter().map(|it| of_metric(it, doubt)).collect()),
            ("speed", speed_cases(verdict, doubt)),
            ("drift", drift_cases(verdict)),
            ("claims", verdict.claims.iter().map(of_claim).collect()),
            ("since", verdict.since.iter().map(of_earlier).collect()),
        ];
        // Few runs have claims, or are held against an earlier one.
        for (name, cases) in
            suites.into_iter().filter(|it| !["claims", "since"].contains(&it.0) || !it.1.is_empty())
        {
            let mut suite = TestSuite::new(name);
            suite.add_test_cases(cases);
            report.add_test_suite(suite);
        }
        report.to_string().expect("memory takes all that is written")
    }
}

fn drift_cases(verdict: &Verdict) -> Vec<TestCase> {
    let class = "scanbench.drift";
    if verdict.drift.is_empty() {
        return vec![case(
            class,
            &format!("no result of a {} changed", verdict.unit),
            TestCaseStatus::success(),
        )];
    }
    let of_scan = verdict.drift.iter().map(|drift| {
        let message = format!("results changed: {}", in_words(&n_of_kinds(drift.changes.iter())));
        let changes: Vec<&str> = drift.changes.iter().map(|it| it.text.as_str()).collect();
        let status = match verdict.tolerances.drift {
            DriftRule::Fail => failed("drift", &message, &changes.join("\n")),
            DriftRule::Warn => skipped(&format!("allowed: {message}")),
        };
        case(class, &drift.subject.in_words(), status)
    });
    of_scan.collect()
}

fn of_earlier(since: &SinceEarlier) -> TestCase {
    let status = match since.n_worse {
        0 => TestCaseStatus::success(),
        _ => failed("regression", &since.lines[0], &since.lines[1..].join("\n")),
    };
    case("scanbench.since", "no number is worse than in an earlier run of the history", status)
}

fn of_claim(changed: &ChangedClaim) -> TestCase {
    let words = changed.in_words();
    let status =
        if changed.is_worse() { failed("regression", &words, "") } else { TestCaseStatus::success() };
    case("scanbench.claims", &changed.claim.says, status)
}

fn speed_cases(verdict: &Verdict, doubt: Option<&str>) -> Vec<TestCase> {
    let not_compared = verdict.speed_not_compared.iter().map(|reason| {
        let skipped = skipped(&format!("speed was not compared: {reason}"));
        case("scanbench.speed", "times of the baseline", skipped)
    });
    not_compared.chain(verdict.speeds.iter().map(|it| of_speed(it, doubt))).collect()
}

/// Test case of a gated number; `doubt` is why nothing is sure about these scans, if nothing is.
fn of_metric(gated: &GatedMetric, doubt: Option<&str>) -> TestCase {
    let metric = &gated.metric;
    let tolerance = tolerance_text(metric, gated.tolerance);
    let message = gated.difference.as_ref().map_or_else(
        |missing| format!("{}: {}", metric_text(metric), missing.in_words()),
        |it| {
            format!(
                "{}: {} before, {} after, {} (95 % {}), tolerance {tolerance}",
                metric_text(metric),
                value_text(metric, it.before),
                value_text(metric, it.after),
                difference_text(metric, it.difference()),
                interval_text(it)
            )
        },
    );
    let class = format!("scanbench.{}.{}", gated.task, gated.detector);
    let name = about(&format!("{} of {}", metric.id(), gated.slice), gated.on.as_deref());
    case(&class, &name, status(gated.finding, &message, doubt))
}

fn of_speed(speed: &GatedMetric, doubt: Option<&str>) -> TestCase {
    let numbers = match &speed.difference {
        Ok(it) => format!("{:.3} before, {:.3} after", it.before, it.after),
        Err(missing) => missing.in_words().to_owned(),
    };
    let (tolerated, what) = (100.0 * speed.tolerance, format!("time relative to {SPEED_REFERENCE}"));
    let message = format!("{what}: {numbers}, tolerance {tolerated:.0} %");
    let class = format!("scanbench.speed.{}", speed.detector);
    case(&class, &about(&what, speed.on.as_deref()), status(speed.finding, &message, doubt))
}

/// Status of a test case; `doubt` is why nothing is sure about these scans, if nothing is.
fn status(finding: Finding, message: &str, doubt: Option<&str>) -> TestCaseStatus {
    match finding {
        Finding::Pass => TestCaseStatus::success(),
        Finding::Inconclusive => skipped(&match doubt {
            Some(doubt) => format!("inconclusive, {doubt}: {message}"),
            None => format!("inconclusive: {message}"),
        }),
        Finding::Incomparable => {
            let mut error = TestCaseStatus::non_success(NonSuccessKind::Error);
            error.set_type("incomparable").set_message(message);
            error
        }
        Finding::Regression => failed("regression", message, message),
    }
}

/// `JUnit` knows no warning: a skipped test is what servers show without failing.
fn skipped(message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(message);
    status
}

fn failed(kind: &str, message: &str, details: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
    status.set_type(kind).set_message(message).set_description(details);
    status
}

fn case(class: &str, name: &str, status: TestCaseStatus) -> TestCase {
    let mut case = TestCase::new(name, status);
    case.set_classname(class);
    case
}
