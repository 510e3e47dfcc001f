//! Tolerances as a file for people to change: every rule with its meaning.

use std::fmt::Write as _;

use crate::run_folder::run_archive::RunArchive;
use crate::verdicts::built_in_tolerances::{OF_OBJECTS, Sizes};
use crate::verdicts::tolerances::{Lateness, Rule, StreamRule, Tolerances};
use crate::vocabulary::metric::SPEED_REFERENCE;
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

const STREAMS: &str = "\
Rates of the newest answer at every moment, as `scanbench streaming` has them. With `latency_ms` every detector takes that long,
on every machine; without, it takes what was measured, scaled to the machine of the baseline.";

impl Tolerances {
    /// The file of these tolerances, with the built-in meaning of each metric.
    pub fn annotated(&self) -> String {
        let sizes = Sizes::built_in();
        let mut text = HEAD.to_owned();
        writeln!(text, "drift = {}", quoted(self.drift.name())).expect("a string takes all");
        for rule in &self.quality {
            push_head(&mut text, &meaning(rule, &sizes), "[[quality]]");
            push_names(&mut text, "metrics", Some(&rule.metrics));
            push_names(&mut text, "slices", Some(&rule.parts));
            push_names(&mut text, "tasks", rule.tasks.as_ref());
            push_sizes(&mut text, rule);
        }
        for rule in &self.protocols {
            let protocol = rule.tasks.iter().flatten().map(|it| quoted(it)).collect::<String>();
            push_head(&mut text, &sizes.protocols.meaning, &format!("[[protocol]]\nprotocol = {protocol}"));
            push_names(&mut text, "metrics", Some(&rule.metrics));
            push_names(&mut text, "classes", Some(&rule.parts));
            push_sizes(&mut text, rule);
        }
        for StreamRule { rule, criterion, lateness } in &self.streams {
            push_head(&mut text, STREAMS, "[[streaming]]");
            writeln!(text, "criterion = {}", quoted(criterion.name())).expect("a string takes all");
            if let Lateness::Fixed(latency_ms) = lateness {
                push_size(&mut text, "latency_ms", *latency_ms);
            }
            push_names(&mut text, "tasks", rule.tasks.as_ref());
            push_sizes(&mut text, rule);
        }
        if let Some(rule) = &self.speed {
            let head = format!("[speed]\nreference = {}", quoted(SPEED_REFERENCE));
            push_head(&mut text, &sizes.speed.meaning, &head);
            push_names(&mut text, "detectors", rule.detectors.as_ref());
            push_size(&mut text, "relative", rule.relative);
        }
        text
    }
}

/// The built-in tolerances for `baseline` as a file for people to change.
pub fn built_in_file(baseline: &RunArchive) -> String {
    if baseline.manifest.partial.is_some() {
        return OF_OBJECTS.to_owned();
    }
    Tolerances::built_in(baseline).annotated()
}

fn meaning(rule: &Rule, sizes: &Sizes) -> String {
    if !rule.parts.contains(&Slice::All.name()) {
        return sizes.slices.meaning.clone();
    }
    let of_negatives = (&sizes.negatives.metric, &sizes.negatives.meaning);
    let meanings = sizes.metric.iter().map(|it| (&it.id, &it.meaning)).chain([of_negatives]);
    let meant = meanings.filter(|(id, _)| rule.metrics.contains(id));
    meant.map(|(_, meaning)| meaning.as_str()).collect::<Vec<_>>().join("\n")
}

/// Writes the meaning of a rule, and the head of its table.
fn push_head(text: &mut String, meaning: &str, head: &str) {
    text.push('\n');
    for line in meaning.trim().lines() {
        writeln!(text, "# {line}").expect("a string takes all");
    }
    writeln!(text, "{head}").expect("a string takes all");
}

/// Writes a list of names; nothing where names are left out.
fn push_names(text: &mut String, field: &str, names: Option<&Vec<String>>) {
    if let Some(names) = names {
        let names: Vec<String> = names.iter().map(|it| quoted(it)).collect();
        writeln!(text, "{field} = [{}]", names.join(", ")).expect("a string takes all");
    }
}

/// Writes the detectors of a rule, and its sizes.
fn push_sizes(text: &mut String, rule: &Rule) {
    push_names(text, "detectors", rule.detectors.as_ref());
    push_size(text, "absolute", rule.absolute);
    push_size(text, "relative", rule.relative);
}

fn push_size(text: &mut String, field: &str, size: f64) {
    writeln!(text, "{field} = {size:?}").expect("a string takes all");
}

fn quoted(name: &str) -> String {
    toml::Value::from(name).to_string()
}
