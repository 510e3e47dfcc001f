//! The criterion of a single class, as the user or a benchmark gives it.

use reports::vocabulary::criterion::CriterionKind;
use serde::Deserialize;

use super::criterion::Criterion;

/// The table `[matching.class.NAME]`: what it leaves out is as in the run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassRule {
    /// The measure that is compared.
    pub(super) criterion: Option<CriterionKind>,
    /// Least intersection over union.
    pub(super) min_iou: Option<f64>,
    /// Greatest distance of the centres, in metres.
    pub(super) max_centre_distance_m: Option<f64>,
}

impl ClassRule {
    /// The problem of a value that is no criterion, with its name; `None` if all are.
    pub(super) fn problem(&self) -> Option<String> {
        let wrong = |name: &str, value: Option<f64>, most: f64| {
            let value = value.filter(|it| !(0.01..=most).contains(it))?;
            Some(format!("{name} = {value} is not within 0.01 to {most}"))
        };
        wrong("min_iou", self.min_iou, 1.0)
            .or_else(|| wrong("max_centre_distance_m", self.max_centre_distance_m, 100.0))
    }

    /// The criterion, over that of the run.
    pub(super) fn over(&self, of_run: Criterion) -> Criterion {
        let kind = self.criterion.unwrap_or(of_run.kind());
        let usual = Criterion::ALL.into_iter().find(|it| it.kind() == kind).unwrap_or(of_run);
        match if kind == of_run.kind() { of_run } else { usual } {
            Criterion::Points { min_iou } => Criterion::Points { min_iou: self.min_iou.unwrap_or(min_iou) },
            Criterion::BevIou { min_iou } => Criterion::BevIou { min_iou: self.min_iou.unwrap_or(min_iou) },
            Criterion::Iou3d { min_iou } => Criterion::Iou3d { min_iou: self.min_iou.unwrap_or(min_iou) },
            Criterion::Centre { max_distance_m } => {
                Criterion::Centre { max_distance_m: self.max_centre_distance_m.unwrap_or(max_distance_m) }
            }
        }
    }
}
