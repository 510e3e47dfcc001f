//! Losses that the scans of an accepted run can show, before there is a second run.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::BlockCount;
use crate::run_folder::run_archive::RunArchive;
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::tolerances::{GatedSubject, Tolerances};
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// The largest loss of a rate that is too small to be sure.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastLoss {
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: String,
    /// The F-rate; recall where that is undefined.
    pub metric: Metric,
    /// The tolerance plus half of the 95 % interval of the rate: that of a difference is as wide if a change varies from
    /// block to block as the rate does.
    pub loss: f64,
}

/// The losses that the scans of a run can show.
#[derive(Debug, Clone, PartialEq)]
pub enum LeastLosses {
    /// None, however large; these are the blocks of scans.
    NoneIsSure(BlockCount),
    /// Losses above these, task by task and detector by detector.
    Above(Vec<LeastLoss>),
}

/// The losses that the scans of `run` can show under `tolerances`.
pub fn least_losses(run: &RunArchive, tolerances: &Tolerances) -> LeastLosses {
    let tally = run.tally();
    let draws = tally.draw();
    if let Some(blocks) = draws.iter().map(Draw::blocks).reduce(BlockCount::with)
        && blocks.decide_nothing()
    {
        return LeastLosses::NoneIsSure(blocks);
    }
    let mut losses = Vec::new();
    for &task in tally.tasks() {
        for detector in tally.detectors() {
            let question = Question { dataset: OVERALL, task, detector, slice: Slice::All };
            let Some(sample) = tally.sample(&question, &draws) else { continue };
            let rates = [Metric::FRate, Metric::Recall].into_iter();
            let Some((metric, value)) = { rates }.find_map(|it| Some((it.clone(), sample.value(&it)?)))
            else {
                continue;
            };
            let Some(rates) = Distribution::new(sample.resampled_values(&metric), sample.blocks) else {
                continue;
            };
            let [low, high] = rates.interval().ends;
            let part = Slice::All.name();
            let subject = GatedSubject { task: task.name(), detector, part: &part };
            let rule = tolerances.rule_about(&metric, subject);
            let tolerated = rule.map_or(0.0, |it| tolerances.quality[it].tolerance(&metric, value));
            let loss = tolerated + (high - low) / 2.0;
            losses.push(LeastLoss { task, detector: detector.clone(), metric, loss });
        }
    }
    LeastLosses::Above(losses)
}

impl LeastLosses {
    /// For people, line by line.
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::NoneIsSure(blocks) => {
                vec![format!("No loss will be sure: {} to show one.", blocks.shortfall().unwrap_or_default())]
            }
            Self::Above(losses) if losses.is_empty() => Vec::new(),
            Self::Above(losses) => {
                let head = "These scans cannot show a loss smaller than about this; `detectable` in a verdict is the same for a change:";
                let line = |it: &LeastLoss| {
                    let name = if it.metric == Metric::FRate { "F-rate" } else { "recall" };
                    let points = fixed_decimals(100.0 * it.loss, 1);
                    format!("  {}, {}: {points} points of {name}", it.detector, it.task)
                };
                [head.to_owned()].into_iter().chain(losses.iter().map(line)).collect()
            }
        }
    }
}
