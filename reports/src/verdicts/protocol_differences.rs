//! Differences between two detectors, or two runs of one, under protocols of others.

use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::ProtocolMetric;
use crate::protocols::protocol_tally::{ProtocolQuestion, ProtocolTally};
use crate::protocols::under_protocol::DrawnValues;
use crate::verdicts::paired_difference::PairedDifference;
use crate::vocabulary::metric::{Metric, ProtocolMetricName};
use crate::vocabulary::protocol::Protocol;

/// All values of one detector under one protocol, over some scans together.
#[derive(Debug, Clone)]
pub struct ProtocolSide {
    metrics: Vec<ProtocolMetric>,
    drawn: DrawnValues,
}

/// A number of two sides.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolPair {
    /// The class.
    pub class: String,
    /// The metric.
    pub metric: Metric,
    /// Whether either side has the number: before, after.
    pub is_there: [bool; 2],
    /// The difference; `None` unless both have the number.
    pub difference: Option<PairedDifference>,
}

impl ProtocolSide {
    /// The values of `detector` under `protocol`, on the draws of `scans`; `None` if it was not evaluated.
    pub fn of(rows: &ProtocolTally, protocol: Protocol, detector: &str, scans: &DrawnScans) -> Option<Self> {
        let rows = rows.rows(ProtocolQuestion { protocol, detector }, scans)?;
        Some(Self { metrics: rows.metrics(), drawn: DrawnValues::new(&*rows, scans) })
    }

    /// The index of a metric, and its value there; `None` if it has none.
    fn value(&self, ProtocolMetric { class, id, .. }: &ProtocolMetric) -> Option<(usize, f64)> {
        let index = self.metrics.iter().position(|it| it.class == *class && it.id == *id)?;
        Some((index, self.drawn.values[index]?))
    }
}

/// The protocols that both have rows of, in the order of tables.
pub fn common_protocols(before: &ProtocolTally, after: &ProtocolTally) -> Vec<Protocol> {
    let after = after.protocols();
    before.protocols().into_iter().filter(|it| after.contains(it)).collect()
}

/// Every number of either side, first those of `before`.
pub fn pairs(before: &ProtocolSide, after: &ProtocolSide, scans: &DrawnScans) -> Vec<ProtocolPair> {
    let is_same = |a: &ProtocolMetric, b: &ProtocolMetric| a.class == b.class && a.id == b.id;
    let is_new = |it: &&ProtocolMetric| !before.metrics.iter().any(|known| is_same(known, it));
    let metrics = before.metrics.iter().chain(after.metrics.iter().filter(is_new));
    let pair = |of: &ProtocolMetric| {
        let values = [before, after].map(|it| it.value(of));
        let ProtocolMetric { class, id, unit, direction, .. } = of.clone();
        let metric = Metric::OfProtocol(ProtocolMetricName { id, unit, direction });
        let difference =
            values[0].zip(values[1]).map(|((index_before, before_it), (index_after, after_it))| {
                let of_draws = before.drawn.resampled.iter().zip(&after.drawn.resampled);
                let of_draws = of_draws.map(|(before, after)| (before[index_before], after[index_after]));
                PairedDifference::new(&metric, [before_it, after_it], of_draws, scans.blocks())
            });
        ProtocolPair { class, metric, is_there: values.map(|it| it.is_some()), difference }
    };
    metrics.map(pair).collect()
}
