//! How much a run lost since an earlier one of its history.

use super::history_file::{History, NumberName, RunOfHistory};
use super::trends::differences;
use crate::files::fixed_decimals::fixed_decimals;
use crate::verdicts::tolerances::{GatedSubject, Tolerances};
use crate::verdicts::verdict::SinceEarlier;
use crate::vocabulary::metric::{Direction, Metric};

/// Losses that are listed, at most.
const MOST_LISTED: usize = 10;

/// A number that became worse since an earlier run.
#[derive(Debug, Clone, PartialEq)]
pub struct LossSince {
    /// What it is about.
    pub name: NumberName,
    /// The values then and now.
    pub values: [f64; 2],
    /// How much worse it may become.
    pub tolerance: f64,
}

/// Numbers since an earlier run.
#[derive(Debug, Clone, PartialEq)]
pub struct Since {
    /// The earlier run: its time and its commit.
    pub run: String,
    /// Numbers that are gated, and in both runs.
    pub n_compared: usize,
    /// Those that are worse than tolerated.
    pub losses: Vec<LossSince>,
}

/// Nothing can be said about the time since.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum SinceError {
    /// No run is meant.
    #[error("no run of the history has a name or a commit that begins with {wanted:?}; it has {known}")]
    Unknown {
        /// What the user wrote.
        wanted: String,
        /// The first and last runs there are.
        known: String,
    },
    /// The runs answer different questions.
    #[error("the runs cannot be compared: {}", .reasons.join("; "))]
    NotComparable {
        /// Why.
        reasons: Vec<String>,
    },
}

impl History {
    /// The numbers of the run of the time `created` that became worse, by more than `tolerances` allow, since the run that `wanted` means: the
    /// beginning of its time or of its commit; of several runs the first.
    ///
    /// Times are left out: they are compared only beside each other. Differences are those of the scans themselves, without an
    /// interval: the rows of the earlier run are not there.
    ///
    /// # Errors
    ///
    /// [`SinceError`] if no run is meant, or it cannot be compared.
    pub fn since(&self, wanted: &str, created: &str, tolerances: &Tolerances) -> Result<Since, SinceError> {
        let runs = self.runs();
        let is_meant = |(name, run): &&(&str, &RunOfHistory)| {
            name.starts_with(wanted) || run.commit.as_deref().is_some_and(|it| it.starts_with(wanted))
        };
        let found = runs
            .iter()
            .find(is_meant)
            .filter(|_| !wanted.is_empty())
            .zip(runs.iter().rfind(|(_, it)| it.created == created));
        let Some(((_, before), (_, now))) = found else {
            let known = match (runs.first(), runs.last()) {
                (Some((first, _)), Some((last, _))) => format!("{} runs, from {first} to {last}", runs.len()),
                _ => "no runs".to_owned(),
            };
            return Err(SinceError::Unknown { wanted: wanted.to_owned(), known });
        };
        let reasons = differences(self.settings(before), self.settings(now));
        if !reasons.is_empty() {
            return Err(SinceError::NotComparable { reasons });
        }
        let (mut n_compared, mut losses) = (0, Vec::new());
        for (name, number) in now.numbers.iter().filter(|(name, _)| !name.metric.is_time()) {
            let Some(earlier) = before.numbers.get(name) else { continue };
            let part = name.subject.slice.name();
            let subject = GatedSubject {
                task: name.subject.task.name(),
                detector: &name.subject.detector,
                part: &part,
            };
            let Some(rule_idx) = tolerances.rule_about(&name.metric, subject) else { continue };
            n_compared += 1;
            let tolerance = tolerances.quality[rule_idx].tolerance(&name.metric, earlier.value);
            let values = [earlier.value, number.value];
            if worsening(&name.metric, values) > tolerance {
                losses.push(LossSince { name: name.clone(), values, tolerance });
            }
        }
        let run = format!("{}, commit {}", before.created, before.short_commit());
        Ok(Since { run, n_compared, losses })
    }
}

/// By how much a number became worse.
fn worsening(metric: &Metric, [before, now]: [f64; 2]) -> f64 {
    match metric.direction() {
        Direction::HigherIsBetter => before - now,
        Direction::LowerIsBetter => now - before,
        Direction::Neither => 0.0,
    }
}

impl Since {
    /// What it says, for a verdict.
    pub fn in_words(&self) -> SinceEarlier {
        SinceEarlier { n_worse: self.losses.len(), lines: self.lines() }
    }

    /// What it says, a line for each loss.
    fn lines(&self) -> Vec<String> {
        let Self { run, n_compared, losses } = self;
        let first = match losses.len() {
            0 => format!(
                "Since {run}: none of {n_compared} numbers is worse than tolerated; times are left out."
            ),
            n => format!(
                "Since {run}: {n} of {n_compared} numbers are worse than tolerated, step by step or at once; times are left out."
            ),
        };
        let line = |it: &LossSince| {
            let (subject, metric) = (&it.name.subject, it.name.metric.id());
            let is_share = it.name.metric.unit() == "ratio";
            let shown = |value: f64| {
                let decimals = if is_share { 1 } else { 3 };
                let text = fixed_decimals(if is_share { 100.0 * value } else { value }, decimals);
                if is_share { format!("{text} %") } else { text }
            };
            let [before, now] = it.values.map(shown);
            format!(
                "  {metric} of {}, {}, {}, {}: {before} → {now}; tolerated {}",
                subject.task,
                subject.slice,
                subject.detector,
                subject.dataset,
                shown(it.tolerance)
            )
        };
        let more = losses.len().saturating_sub(MOST_LISTED);
        let more = (more > 0).then(|| format!("  and {more} more"));
        [first].into_iter().chain(losses.iter().take(MOST_LISTED).map(line)).chain(more).collect()
    }
}
