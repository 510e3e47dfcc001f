//! Tolerances in a sentence.

use crate::files::fixed_decimals::fixed_decimals;
use crate::verdicts::tolerances::{Origin, Rule, Tolerances};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// Where tolerances come from; for the built-in ones, which are in no file, their sizes.
pub(crate) fn about_tolerances(tolerances: &Tolerances) -> String {
    match &tolerances.origin {
        Origin::File(path) => format!("Tolerances: {}.", path.display()),
        Origin::BuiltIn => format!(
            "Tolerances: built in, because the baseline has no tolerances.toml. {}.",
            sizes(tolerances).join("; ")
        ),
    }
}

/// The sizes of tolerances, each with its kind of numbers.
fn sizes(tolerances: &Tolerances) -> Vec<String> {
    let mut sizes: Vec<String> = Vec::new();
    for rule in &tolerances.quality {
        for metric in rule.metrics.iter().filter_map(|it| Metric::from_id(it)) {
            let size = format!("{}: {}", kind(rule, &metric), size_text(rule, metric.unit()));
            if !sizes.contains(&size) {
                sizes.push(size);
            }
        }
    }
    let of_speed = tolerances.speed.as_ref().map(|it| format!("time: {}", percent(it.relative)));
    sizes.into_iter().chain(of_speed).collect()
}

/// The kind of numbers that a metric of a rule belongs to.
fn kind(rule: &Rule, metric: &Metric) -> String {
    if matches!(metric, Metric::Partial(_)) {
        return metric.id();
    }
    if !rule.parts.contains(&Slice::All.name()) {
        return format!("{} of slices", metric.id());
    }
    match metric.unit() {
        "ratio" => "rates".to_owned(),
        "nats" => "entropies".to_owned(),
        "m" => "sizes and positions of boxes".to_owned(),
        "deg" => "headings of boxes".to_owned(),
        _ => metric.id(),
    }
}

/// The size that a rule tolerates; `unit` is that of the metric.
fn size_text(rule: &Rule, unit: &str) -> String {
    let absolute = match unit {
        "ratio" => format!("{} points", fixed_decimals(100.0 * rule.absolute, 2)),
        unit => format!("{} {unit}", rule.absolute),
    };
    let sizes = [(rule.absolute, absolute), (rule.relative, percent(rule.relative))];
    let sizes: Vec<String> = sizes.into_iter().filter(|it| it.0 > 0.0).map(|it| it.1).collect();
    if sizes.is_empty() { "nothing".to_owned() } else { sizes.join(" or ") }
}

fn percent(share: f64) -> String {
    format!("{} %", fixed_decimals(100.0 * share, 0))
}
