//! The figures of studies: a line for each variant, condition or difference, with its interval.

use super::ranking_plot::{RankingRow, study_plot};
use crate::reproduction::sensitivity::{Sensitivity, SetRate, quantiles};
use crate::tables::studies::ablation_table::AblationTable;
use crate::tables::studies::robustness_table::ConditionScores;
use crate::tables::verdict::comparison::Comparison;
use crate::vocabulary::metric::{Metric, PartialMetric};
use crate::vocabulary::task::Task;

const F_RATE: &str = "F-rate, % (bars: 95 % interval)";

/// The F-rate of each variant of a method, data set by data set.
pub fn ablation_plot(table: &AblationTable) -> String {
    let of_extents = table.scores.chunk_by(|left, right| left.extent == right.extent);
    let parts = of_extents.map(|scores| {
        let rows = scores.iter().enumerate().map(|(index, it)| {
            row(
                it.variant.clone(),
                usize::from(index > 0),
                it.counts.f_rate(),
                it.f_rate_within.map(|it| it.ends),
            )
        });
        (scores[0].extent.name().to_owned(), rows.collect())
    });
    let title = format!("Ablation of {}, task {}", table.method, table.task);
    study_plot(&title, F_RATE, &parts.collect::<Vec<_>>())
}

/// The F-rate of every detector under each condition, task by task.
pub fn robustness_plot(conditions: &[ConditionScores]) -> String {
    let parts = Task::ALL.map(|task| {
        let rows = conditions.iter().flat_map(|condition| {
            let of_task = condition.scores().filter(move |(_, of_task, _)| *of_task == task);
            of_task.enumerate().map(|(detector_idx, (detector, _, it))| {
                let name = format!("{}: {}, {detector}", condition.named.group, condition.named.condition);
                row(name, detector_idx, it.counts.f_rate(), it.intervals.f_rate.map(|it| it.ends))
            })
        });
        (format!("Task {task}"), rows.collect())
    });
    study_plot("F-rate under each condition (simulated)", F_RATE, &parts)
}

/// The differences of F-rates, or of recalls where that is undefined; of partly seen objects those of the mean recall.
pub fn comparison_plot(comparison: &Comparison) -> String {
    let mean_recall = Metric::Partial(PartialMetric::MeanRecall);
    let drawn = if comparison.differences.iter().any(|it| it.difference.metric == mean_recall) {
        vec![(mean_recall, "mean of recalls")]
    } else {
        vec![(Metric::FRate, "F-rate"), (Metric::Recall, "recall")]
    };
    let parts = drawn.into_iter().map(|(metric, name)| {
        let of_metric = comparison.differences.iter().filter(|it| it.difference.metric == metric);
        let rows = of_metric.map(|it| {
            let name = format!("{}, {}, {}", it.task, it.detector, it.slice);
            row(name, 0, Some(it.difference.difference()), it.difference.interval.map(|it| it.ends))
        });
        (format!("After minus before, {name}"), rows.collect())
    });
    let parts: Vec<_> = parts.collect();
    study_plot(&comparison.title, "difference, percentage points (bars: 95 % interval)", &parts)
}

/// The rates of method and rivals over all joint settings of open values: the median, and the range of nine in ten.
pub fn settings_plot(sensitivity: &Sensitivity) -> String {
    let over = |name: &str, idx: usize, rates: &[Option<f64>]| {
        let [low, middle, high] = quantiles(rates, [0.05, 0.5, 0.95])?;
        Some(row(name.to_owned(), idx, Some(middle), Some([low, high])))
    };
    let part = |rate: &SetRate| {
        let rows = [over(&rate.method, 0, &rate.of_method), over(&rate.rival, 1, &rate.of_rival)];
        (rate.name.clone(), rows.into_iter().flatten().collect())
    };
    let parts: Vec<_> = sensitivity.rates.iter().map(part).collect();
    let title =
        format!("F-rates under {} joint settings of what the papers leave open", sensitivity.settings.len());
    study_plot(&title, "F-rate, % (bars: nine in ten settings)", &parts)
}

fn row(name: String, colour_idx: usize, rate: Option<f64>, within: Option<[f64; 2]>) -> RankingRow {
    RankingRow {
        name,
        detector_idx: colour_idx,
        percent: rate.map(|it| 100.0 * it),
        interval_percent: within.map(|it| it.map(|end| 100.0 * end)),
        published: None,
    }
}
