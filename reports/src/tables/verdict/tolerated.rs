//! What tolerances come to, in a sentence.

use crate::files::fixed_decimals::fixed_decimals;
use crate::verdicts::tolerances::{Origin, QualityRule, Tolerances};
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

/// What is tolerated, each size with all metrics that it is of.
fn sizes(tolerances: &Tolerances) -> Vec<String> {
    let mut sizes: Vec<(String, Vec<String>)> = Vec::new();
    for rule in &tolerances.quality {
        let is_of_all = rule.slices.contains(&Slice::All.name());
        let of_slices = if is_of_all { String::new() } else { format!(" of {}", rule.slices.join(", ")) };
        for metric in &rule.metrics {
            let (name, size) = (format!("{}{of_slices}", metric.id()), size_text(rule, metric.unit()));
            match sizes.iter_mut().find(|it| it.0 == size) {
                Some((_, names)) if names.contains(&name) => {}
                Some((_, names)) => names.push(name),
                None => sizes.push((size, vec![name])),
            }
        }
    }
    let of_speed = tolerances.speed.as_ref().map(|it| format!("time: {}", percent(it.relative)));
    sizes.into_iter().map(|(size, names)| format!("{}: {size}", names.join(", "))).chain(of_speed).collect()
}

/// `unit` is that of the metric.
fn size_text(rule: &QualityRule, unit: &str) -> String {
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
