//! What tolerances come to, in a sentence.

use crate::files::fixed_decimals::fixed_decimals;
use crate::verdicts::tolerances::{Origin, Rule, Tolerances};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// Where tolerances come from; of the built-in ones, which are in no file, what they are.
pub(crate) fn about_tolerances(tolerances: &Tolerances) -> String {
    match &tolerances.origin {
        Origin::File(path) => format!("Tolerances: {}.", path.display()),
        Origin::BuiltIn => format!(
            "Tolerances: built in, because the baseline has no tolerances.toml. {}.",
            sizes(tolerances).join("; ")
        ),
    }
}

/// What is tolerated, each size with the kinds of numbers that it is of.
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

/// What kind of number a metric of a rule is.
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
        "m" => "sizes and places of boxes".to_owned(),
        "deg" => "their headings".to_owned(),
        _ => metric.id(),
    }
}

/// `unit` is that of the metric.
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
