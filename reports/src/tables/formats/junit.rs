//! A verdict as `JUnit` XML, which every CI server shows: one test case a gated number, and one a scan whose results changed.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use crate::tables::formats::format::Format;
use crate::tables::verdict::summary::scan_name;
use crate::tables::verdict::wording::{difference_text, interval_text, metric_text, value_text};
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::GatedMetric;
use crate::verdicts::gated_speeds::{GatedSpeed, SpeedComparison};
use crate::verdicts::verdict::Verdict;

/// What a test case came to.
enum Outcome {
    Passed,
    /// `JUnit` knows no warning: a skipped test is what servers show without failing.
    Skipped(String),
    Failed {
        kind: &'static str,
        message: String,
        details: String,
    },
    Error(String),
}

struct TestCase {
    class: String,
    name: String,
    outcome: Outcome,
}

/// The XML that `JUnit` writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JUnit;

impl Format<Verdict> for JUnit {
    /// The name that CI servers look for, whatever the stem.
    fn file_name(&self, _stem: &str) -> String {
        "junit.xml".to_owned()
    }

    fn text(&self, verdict: &Verdict) -> String {
        let about_blocks = verdict.blocks.are_too_few().then_some(verdict.blocks.n_blocks);
        let suites = [
            ("quality", verdict.metrics.iter().map(|it| of_metric(it, about_blocks)).collect::<Vec<_>>()),
            ("speed", speed_cases(verdict, about_blocks)),
            ("drift", drift_cases(verdict)),
        ];
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        write_suites(&mut writer, &suites).expect("memory takes all that is written");
        let mut bytes = writer.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).expect("text was written")
    }
}

fn drift_cases(verdict: &Verdict) -> Vec<TestCase> {
    let class = "scanbench.drift".to_owned();
    if verdict.drift.is_empty() {
        return vec![TestCase {
            class,
            name: "no result of a scan changed".to_owned(),
            outcome: Outcome::Passed,
        }];
    }
    let of_scan = verdict.drift.iter().map(|drift| TestCase {
        class: class.clone(),
        name: scan_name(drift),
        outcome: Outcome::Failed {
            kind: "drift",
            message: format!("results of {} objects changed", drift.changes.len()),
            details: drift.changes.join("\n"),
        },
    });
    of_scan.collect()
}

fn speed_cases(verdict: &Verdict, n_few_blocks: Option<u64>) -> Vec<TestCase> {
    match &verdict.speed {
        SpeedComparison::NotAsked => Vec::new(),
        SpeedComparison::NotCompared { reason } => vec![TestCase {
            class: "scanbench.speed".to_owned(),
            name: "times of the baseline".to_owned(),
            outcome: Outcome::Skipped(format!("speed was not compared: {reason}")),
        }],
        SpeedComparison::Compared(speeds) => speeds.iter().map(|it| of_speed(it, n_few_blocks)).collect(),
    }
}

/// `n_few_blocks` are the blocks of scans, where they are too few.
fn of_metric(gated: &GatedMetric, n_few_blocks: Option<u64>) -> TestCase {
    let metric = &gated.metric;
    let tolerance = difference_text(metric, gated.tolerance).trim_start_matches('+').to_owned();
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
    TestCase {
        class: format!("scanbench.{}.{}", gated.task, gated.detector),
        name: format!("{} of {}", metric.id(), gated.slice),
        outcome: outcome(gated.finding, message, n_few_blocks),
    }
}

fn of_speed(speed: &GatedSpeed, n_few_blocks: Option<u64>) -> TestCase {
    let numbers = match &speed.slowdown {
        Ok(it) => format!("{:.3} before, {:.3} after", it.before, it.after),
        Err(missing) => missing.in_words().to_owned(),
    };
    let tolerated = 100.0 * speed.tolerance;
    let message = format!("time relative to {}: {numbers}, tolerance {tolerated:.0} %", speed.reference);
    TestCase {
        class: format!("scanbench.speed.{}", speed.detector),
        name: format!("time relative to {}", speed.reference),
        outcome: outcome(speed.finding, message, n_few_blocks),
    }
}

fn outcome(finding: Finding, message: String, n_few_blocks: Option<u64>) -> Outcome {
    match finding {
        Finding::Pass => Outcome::Passed,
        Finding::Inconclusive => Outcome::Skipped(match n_few_blocks {
            Some(n) => format!("inconclusive, only {n} blocks of scans: {message}"),
            None => format!("inconclusive: {message}"),
        }),
        Finding::Incomparable => Outcome::Error(message),
        Finding::Regression => Outcome::Failed { kind: "regression", details: message.clone(), message },
    }
}

fn write_suites(writer: &mut Writer<Vec<u8>>, suites: &[(&str, Vec<TestCase>)]) -> io::Result<()> {
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let all = || suites.iter().flat_map(|(_, cases)| cases);
    let counts = counts(all());
    writer
        .create_element("testsuites")
        .with_attribute(("name", "scanbench gate"))
        .with_attributes(counts.iter().map(|(name, n)| (*name, n.as_str())))
        .write_inner_content(|writer| {
            suites.iter().try_for_each(|(name, cases)| write_suite(writer, name, cases))
        })?;
    Ok(())
}

fn write_suite(writer: &mut Writer<Vec<u8>>, name: &str, cases: &[TestCase]) -> io::Result<()> {
    let counts = counts(cases.iter());
    writer
        .create_element("testsuite")
        .with_attribute(("name", name))
        .with_attributes(counts.iter().map(|(name, n)| (*name, n.as_str())))
        .write_inner_content(|writer| cases.iter().try_for_each(|it| write_case(writer, it)))?;
    Ok(())
}

fn counts<'a>(cases: impl Iterator<Item = &'a TestCase>) -> [(&'static str, String); 4] {
    let [mut n, mut failures, mut errors, mut skipped] = [0; 4];
    for case in cases {
        n += 1;
        match case.outcome {
            Outcome::Passed => {}
            Outcome::Skipped(_) => skipped += 1,
            Outcome::Failed { .. } => failures += 1,
            Outcome::Error(_) => errors += 1,
        }
    }
    [("tests", n), ("failures", failures), ("errors", errors), ("skipped", skipped)]
        .map(|(name, n): (_, u32)| (name, n.to_string()))
}

fn write_case(writer: &mut Writer<Vec<u8>>, case: &TestCase) -> io::Result<()> {
    let (class, name) = (printable(&case.class), printable(&case.name));
    let element = writer
        .create_element("testcase")
        .with_attribute(("classname", class.as_str()))
        .with_attribute(("name", name.as_str()));
    match &case.outcome {
        Outcome::Passed => element.write_empty()?,
        Outcome::Skipped(message) => element.write_inner_content(|writer| {
            let message = printable(message);
            writer.create_element("skipped").with_attribute(("message", message.as_str())).write_empty()?;
            Ok(())
        })?,
        Outcome::Error(message) => element.write_inner_content(|writer| {
            let message = printable(message);
            let error = writer.create_element("error").with_attribute(("message", message.as_str()));
            error.with_attribute(("type", "incomparable")).write_empty()?;
            Ok(())
        })?,
        Outcome::Failed { kind, message, details } => element.write_inner_content(|writer| {
            let (message, details) = (printable(message), printable(details));
            let failure = writer.create_element("failure").with_attribute(("message", message.as_str()));
            failure.with_attribute(("type", *kind)).write_text_content(BytesText::new(&details))?;
            Ok(())
        })?,
    };
    Ok(())
}

/// XML cannot hold control characters, not even escaped.
fn printable(text: &str) -> String {
    text.chars().map(|it| if it.is_control() && it != '\n' { ' ' } else { it }).collect()
}
