//! `robustness.csv`: one row for every condition, task and detector.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::condition_scores::{ConditionScores, DetectorRates, RateOfTask};
use crate::vocabulary::task::Task;

row! {
    /// What one detector found under one condition, with what the rates are made of.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct ConditionRow {
        data: String,
        group: String,
        condition: String,
        trained: bool,
        task: Task,
        detector: String,
        n_scans: u64,
        no: u64,
        tp: u64,
        mo: u64,
        fo: Option<u64>,
        precision: Option<Fixed<4>>,
        recall: Option<Fixed<4>>,
        f_rate: Option<Fixed<4>>,
        f_rate_low: Option<Fixed<4>>,
        f_rate_high: Option<Fixed<4>>,
        few_blocks: Option<bool>,
    }
}

impl ConditionRow {
    /// The rows of a condition that was simulated.
    pub fn simulated(scores: &ConditionScores) -> Vec<Self> {
        let row = |detector: &str, task: Task, RateOfTask { counts, f_rate_within }: RateOfTask| Self {
            data: "simulated".to_owned(),
            group: scores.group.clone(),
            condition: scores.condition.clone(),
            trained: scores.trained,
            task,
            detector: detector.to_owned(),
            n_scans: scores.n_scans,
            no: counts.no(),
            tp: counts.tp(),
            mo: counts.mo(),
            fo: counts.fo(),
            precision: counts.precision().map(Fixed),
            recall: counts.recall().map(Fixed),
            f_rate: counts.f_rate().map(Fixed),
            f_rate_low: f_rate_within.map(|it| Fixed(it.ends[0])),
            f_rate_high: f_rate_within.map(|it| Fixed(it.ends[1])),
            few_blocks: f_rate_within.map(|it| it.blocks.decide_nothing()),
        };
        let of_detector = |it: &DetectorRates| it.tasks().map(|(task, rate)| row(&it.detector, task, rate));
        scores.detectors.iter().flat_map(of_detector).collect()
    }
}
