//! What lies between two detectors, or two runs of one, under protocols of others.

use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::ProtocolMetric;
use crate::protocols::protocol_tally::{ProtocolQuestion, ProtocolTally};
use crate::protocols::under_protocol::DrawnValues;
use crate::uncertainty::bootstrap::Distribution;
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
    /// What was measured.
    pub metric: Metric,
    /// Whether either side has the number: before, after.
    pub is_there: [bool; 2],
    /// What lies between them; `None` unless both have it.
    pub difference: Option<PairedDifference>,
}

impl ProtocolSide {
    /// Of `detector` under `protocol`, on the draws of `scans`; `None` if it was not evaluated.
    pub fn of(rows: &ProtocolTally, protocol: Protocol, detector: &str, scans: &DrawnScans) -> Option<Self> {
        let rows = rows.rows(ProtocolQuestion { protocol, detector }, scans)?;
        Some(Self { metrics: rows.metrics(), drawn: DrawnValues::new(&*rows, scans) })
    }

    fn place_of(&self, class: &str, id: &str) -> Option<usize> {
        self.metrics.iter().position(|it| it.class == class && it.id == id)
    }

    fn value(&self, place: Option<usize>) -> Option<f64> {
        self.drawn.values[place?]
    }
}

/// The protocols that both have rows of, in the order of tables.
pub fn common_protocols(before: &ProtocolTally, after: &ProtocolTally) -> Vec<Protocol> {
    let after = after.protocols();
    before.protocols().into_iter().filter(|it| after.contains(it)).collect()
}

/// Every number of either side, first those of `before`.
pub fn pairs(before: &ProtocolSide, after: &ProtocolSide, scans: &DrawnScans) -> Vec<ProtocolPair> {
    let is_new = |it: &&ProtocolMetric| before.place_of(&it.class, &it.id).is_none();
    let metrics = before.metrics.iter().chain(after.metrics.iter().filter(is_new));
    metrics.map(|it| pair(it, before, after, scans)).collect()
}

fn pair(
    metric: &ProtocolMetric,
    before: &ProtocolSide,
    after: &ProtocolSide,
    scans: &DrawnScans,
) -> ProtocolPair {
    let places = [before, after].map(|it| it.place_of(&metric.class, &metric.id));
    let values = [before.value(places[0]), after.value(places[1])];
    let ProtocolMetric { class, id, unit, direction, .. } = metric.clone();
    let metric = Metric::OfProtocol(ProtocolMetricName { id, unit, direction });
    let difference = match (values, places) {
        ([Some(value_before), Some(value_after)], [Some(place_before), Some(place_after)]) => {
            let of_draws = before.drawn.resampled.iter().zip(&after.drawn.resampled);
            let differences =
                of_draws.map(|(before, after)| Some(after[place_after]? - before[place_before]?));
            let distribution = scans.blocks().and_then(|it| Distribution::new(differences, it));
            Some(PairedDifference {
                metric: metric.clone(),
                before: value_before,
                after: value_after,
                interval: distribution.as_ref().map(Distribution::interval),
                least_effect: distribution.as_ref().map(Distribution::least_effect),
            })
        }
        _ => None,
    };
    ProtocolPair { class, metric, is_there: values.map(|it| it.is_some()), difference }
}
