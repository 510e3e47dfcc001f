//! What lies between two numbers that were measured on the same scans, and how surely.

use crate::numbers::blocks::Interval;
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::Sample;
use crate::vocabulary::metric::{Direction, Metric};

/// A number before and after, or of one detector and of another.
#[derive(Debug, Clone, PartialEq)]
pub struct PairedDifference {
    /// What was measured.
    pub metric: Metric,
    /// The number that is compared with.
    pub before: f64,
    /// The number that is compared.
    pub after: f64,
    /// How sure `after` - `before` is: both are of the same resamples. `None` where a data set has one block of scans only.
    pub interval: Option<Interval>,
    /// The least difference that scans like these would show, see [`Distribution::least_effect`].
    pub least_effect: Option<f64>,
}

/// What lies between `before` and `after`, samples of the same draws of the same scans.
///
/// `None` if the metric is undefined in one of them.
pub fn paired_difference(before: &Sample, after: &Sample, metric: &Metric) -> Option<PairedDifference> {
    let [value_before, value_after] = [before.value(metric)?, after.value(metric)?];
    let of_resamples = before.resampled_values(metric).zip(after.resampled_values(metric));
    let differences = of_resamples.map(|(before, after)| Some(after? - before?));
    let distribution = Distribution::new(differences, before.blocks);
    Some(PairedDifference {
        metric: metric.clone(),
        before: value_before,
        after: value_after,
        interval: distribution.as_ref().map(Distribution::interval),
        least_effect: distribution.as_ref().map(Distribution::least_effect),
    })
}

impl PairedDifference {
    /// `after` - `before`.
    pub fn difference(&self) -> f64 {
        self.after - self.before
    }

    /// How much worse it has become: positive is worse, whichever way is better. A metric that has no better way is never
    /// worse.
    pub fn worsening(&self) -> f64 {
        self.sign() * self.difference()
    }

    /// How much worse it has become at least: the lower end of the 95 % interval of [`Self::worsening`]. `None` where there is no
    /// interval, or nothing may rest on the blocks of scans that it is of.
    pub fn sure_worsening(&self) -> Option<f64> {
        let interval = self.interval.filter(|it| !it.blocks.decide_nothing())?;
        interval.ends.map(|it| self.sign() * it).into_iter().reduce(f64::min)
    }

    /// Whether `after` is surely larger than `before`.
    pub fn is_surely_larger(&self) -> bool {
        self.interval.is_some_and(|it| !it.blocks.decide_nothing() && it.ends[0] > 0.0)
    }

    fn sign(&self) -> f64 {
        match self.metric.direction() {
            Direction::HigherIsBetter => -1.0,
            Direction::LowerIsBetter => 1.0,
            Direction::Neither => 0.0,
        }
    }
}
