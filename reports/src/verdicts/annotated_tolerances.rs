//! Tolerances as a file for people to change: every rule with what it means.

use std::fmt::Write as _;

use crate::verdicts::built_in_tolerances::Sizes;
use crate::verdicts::tolerances::{ProtocolRule, QualityRule, SpeedRule, Tolerances};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

const HEAD: &str = "\
# How much worse than the accepted run a number may become before `scanbench gate` fails.
#
# A rule is about its metrics, in its slices (a * at the end stands for anything), tasks and detectors. The first rule
# that is about a number decides. Tolerated is the larger of `absolute`, in the unit of the metric, and `relative`, a
# share of the accepted value. A number fails only if its whole 95 % interval is worse than that. What no rule is about
# is not judged: delete what does not matter to you.

# Detection is deterministic. If the outcome of any object changed though no number is surely worse, \"fail\" ends with exit
# code 101, and \"warn\" passes and says what changed. `scanbench gate --allow-drift` has the last word.
";

impl Tolerances {
    /// The file of these tolerances, with what the built-in ones say of each metric.
    pub fn annotated(&self) -> String {
        let sizes = Sizes::built_in();
        let mut text = HEAD.to_owned();
        writeln!(text, "drift = {}", quoted(self.drift.name())).expect("a string takes all");
        for rule in &self.quality {
            text.push('\n');
            push_comment(&mut text, &meaning(rule, &sizes));
            push_quality(&mut text, rule);
        }
        for rule in &self.protocols {
            text.push('\n');
            push_comment(&mut text, &sizes.protocols.meaning);
            push_protocol(&mut text, rule);
        }
        if let Some(rule) = &self.speed {
            text.push('\n');
            push_comment(&mut text, &sizes.speed.meaning);
            push_speed(&mut text, rule);
        }
        text
    }
}

fn meaning(rule: &QualityRule, sizes: &Sizes) -> String {
    if !rule.slices.contains(&Slice::All.name()) {
        return sizes.slices.meaning.clone();
    }
    let meant = sizes.metric.iter().filter(|it| rule.metrics.contains(&it.metric()));
    meant.map(|it| it.meaning.as_str()).collect::<Vec<_>>().join("\n")
}

fn push_comment(text: &mut String, meaning: &str) {
    for line in meaning.trim().lines() {
        writeln!(text, "# {line}").expect("a string takes all");
    }
}

fn push_quality(text: &mut String, rule: &QualityRule) {
    text.push_str("[[quality]]\n");
    push_names(text, "metrics", &rule.metrics.iter().map(Metric::id).collect::<Vec<_>>());
    push_names(text, "slices", &rule.slices);
    if let Some(tasks) = &rule.tasks {
        push_names(text, "tasks", &tasks.iter().map(|it| it.name().to_owned()).collect::<Vec<_>>());
    }
    if let Some(detectors) = &rule.detectors {
        push_names(text, "detectors", detectors);
    }
    push_size(text, "absolute", rule.absolute);
    push_size(text, "relative", rule.relative);
}

fn push_protocol(text: &mut String, rule: &ProtocolRule) {
    writeln!(text, "[[protocol]]\nprotocol = {}", quoted(rule.protocol.name())).expect("a string takes all");
    push_names(text, "metrics", &rule.metrics);
    push_names(text, "classes", &rule.classes);
    if let Some(detectors) = &rule.detectors {
        push_names(text, "detectors", detectors);
    }
    push_size(text, "absolute", rule.absolute);
    push_size(text, "relative", rule.relative);
}

fn push_speed(text: &mut String, rule: &SpeedRule) {
    writeln!(text, "[speed]\nreference = {}", quoted(&rule.reference)).expect("a string takes all");
    if let Some(detectors) = &rule.detectors {
        push_names(text, "detectors", detectors);
    }
    push_size(text, "relative", rule.relative);
}

fn push_names(text: &mut String, field: &str, names: &[String]) {
    let names: Vec<String> = names.iter().map(|it| quoted(it)).collect();
    writeln!(text, "{field} = [{}]", names.join(", ")).expect("a string takes all");
}

fn push_size(text: &mut String, field: &str, size: f64) {
    writeln!(text, "{field} = {size:?}").expect("a string takes all");
}

fn quoted(name: &str) -> String {
    toml::Value::from(name).to_string()
}
