//! `comparison.csv`: one row for every difference.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::tables::verdict::comparison::{Comparison, NamedDifference};

row! {
    /// A difference, with its interval where there are enough blocks for one.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct DifferenceRow {
        task: String,
        detector: String,
        slice: String,
        metric: String,
        before: Fixed<6>,
        after: Fixed<6>,
        difference: Fixed<6>,
        low: Option<Fixed<6>>,
        high: Option<Fixed<6>>,
        few_blocks: Option<bool>,
        least_effect: Option<Fixed<6>>,
    }
}

impl DifferenceRow {
    /// The rows of a comparison, in the order of its table.
    pub fn all(comparison: &Comparison) -> Vec<Self> {
        comparison.differences.iter().map(Self::of).collect()
    }

    fn of(NamedDifference { task, detector, slice, difference }: &NamedDifference) -> Self {
        Self {
            task: task.clone(),
            detector: detector.clone(),
            slice: slice.clone(),
            metric: difference.metric.id(),
            before: Fixed(difference.before),
            after: Fixed(difference.after),
            difference: Fixed(difference.difference()),
            low: difference.interval.map(|it| Fixed(it.ends[0])),
            high: difference.interval.map(|it| Fixed(it.ends[1])),
            few_blocks: difference.interval.map(|it| it.blocks.decide_nothing()),
            least_effect: difference.least_effect.map(Fixed),
        }
    }
}
