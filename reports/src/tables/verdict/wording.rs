//! Numbers of a comparison as people read them.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::BlockKind;
use crate::tables::grid::Cell;
use crate::tables::notes::about_interval;
use crate::verdicts::finding::Finding;
use crate::verdicts::paired_difference::PairedDifference;
use crate::vocabulary::metric::Metric;

/// Changes of a configuration that are named.
const MOST_CHANGES: usize = 12;

/// A value: rates in %, all else in the unit of the metric.
pub(crate) fn value_text(metric: &Metric, value: f64) -> String {
    match metric.unit() {
        "ratio" => fixed_decimals(100.0 * value, 1),
        "count" => fixed_decimals(value, 0),
        _ => fixed_decimals(value, 3),
    }
}

/// A difference of two values, with a sign and a digit more.
pub(crate) fn difference_text(metric: &Metric, difference: f64) -> String {
    let text = match metric.unit() {
        "ratio" => fixed_decimals(100.0 * difference, 2),
        "count" => fixed_decimals(difference, 0),
        _ => fixed_decimals(difference, 4),
    };
    if text.starts_with('-') { text.replacen('-', "−", 1) } else { format!("+{text}") }
}

/// A tolerance, in the unit and with the digits of a difference.
pub(crate) fn tolerance_text(metric: &Metric, tolerance: f64) -> String {
    difference_text(metric, tolerance).trim_start_matches('+').to_owned()
}

/// Name of a change: a number that is not worse than tolerated may be better, surely or not.
pub(crate) fn change_in_words(finding: Finding, difference: &PairedDifference) -> &'static str {
    match finding {
        Finding::Pass if difference.is_surely_better() => "better",
        Finding::Pass if difference.worsening() < 0.0 => "better, but not surely",
        Finding::Pass => "tolerated",
        Finding::Regression | Finding::Incomparable | Finding::Inconclusive => finding.in_words(),
    }
}

/// The interval of a difference; a dash where there is none.
pub(crate) fn interval_text(difference: &PairedDifference) -> String {
    difference.interval.map_or_else(
        || "–".to_owned(),
        |it| it.ends.map(|end| difference_text(&difference.metric, end)).join(" to "),
    )
}

/// The interval as a cell of a table, with a sign where nothing rests on it.
pub(crate) fn interval_cell(difference: &PairedDifference) -> Cell {
    let text = interval_text(difference);
    difference.interval.map_or_else(|| Cell::new(text.clone()), |it| Cell::interval(text.clone(), it.blocks))
}

/// The least difference that would have shown; a dash where that is unknown.
pub(crate) fn least_effect_text(difference: &PairedDifference) -> String {
    let metric = &difference.metric;
    difference.least_effect.map_or_else(|| "–".to_owned(), |it| tolerance_text(metric, it))
}

/// Changes in the configuration of detectors, as one sentence; `None` if there are none.
pub(crate) fn about_configuration(changes: &[String]) -> Option<String> {
    let n_more = changes.len().saturating_sub(MOST_CHANGES);
    let more = if n_more > 0 { format!("; and {n_more} more") } else { String::new() };
    let named = changes[..changes.len() - n_more].join("; ");
    (!changes.is_empty()).then(|| format!("Configuration changed: {named}{more}."))
}

/// A metric with its unit.
pub(crate) fn metric_text(metric: &Metric) -> String {
    match metric.unit() {
        "ratio" => format!("{} [%]", metric.id()),
        "count" => metric.id(),
        unit if metric.id().ends_with(&format!("_{unit}")) => metric.id(),
        unit => format!("{} [{unit}]", metric.id()),
    }
}

/// The title of the column of [`least_effect_text`].
pub(crate) const DETECTABLE: &str = "detectable";

/// The notes on the numbers of a comparison: `difference` says what is subtracted from what; intervals are drawn from blocks
/// of this kind.
pub(crate) fn about_differences(difference: &str, kind: BlockKind) -> String {
    format!(
        "difference: {difference}. 95 %: its interval, by {} Both sides use the same resamples. {DETECTABLE}: smallest \
         detectable difference (80 % power, 5 % level) on such scans.",
        about_interval(kind)
    )
}
