//! Interface to the rows of one detector under any protocol.

use rayon::prelude::*;

use super::drawn_scans::{DrawnScans, N_LANES, Times, single_draw};
use super::protocol_number::ProtocolMetric;
use crate::numbers::blocks::Interval;
use crate::uncertainty::bootstrap::Distribution;

/// Rows of one detector on scans under one protocol, ready for their numbers: those of all scans once, and of every draw.
pub trait UnderProtocol: Sync {
    /// The metrics, in the order of [`Self::values`].
    fn metrics(&self) -> Vec<ProtocolMetric>;

    /// Values where scan *i* occurs `times[i]` times; `None` where one is undefined.
    fn values(&self, times: &[u16]) -> Vec<Option<f64>>;

    /// Values of several draws, each as [`Self::values`] has them, where scan *i* occurs `times[i]` times.
    fn values_of_draws(&self, times: &[Times<N_LANES>]) -> Vec<Vec<Option<f64>>> {
        let of_draw = |draw: usize| times.iter().map(|it| it[draw] as u16).collect::<Vec<u16>>();
        (0..N_LANES).map(|draw| self.values(&of_draw(draw))).collect()
    }
}

/// A protocol that ranks, and goes through its ranking once for several draws.
pub trait Ranking: Sync {
    /// As [`UnderProtocol::metrics`].
    fn metrics(&self) -> Vec<ProtocolMetric>;

    /// The values of each draw.
    fn of_draws<const N: usize>(&self, times: &[Times<N>]) -> [Vec<Option<f64>>; N];
}

impl<T: Ranking> UnderProtocol for T {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        Ranking::metrics(self)
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let [values] = self.of_draws(&single_draw(times));
        values
    }

    fn values_of_draws(&self, times: &[Times<N_LANES>]) -> Vec<Vec<Option<f64>>> {
        self.of_draws(times).into()
    }
}

/// Values of all scans once, and of every draw.
#[derive(Debug, Clone)]
pub struct DrawnValues {
    /// Values of all scans once.
    pub values: Vec<Option<f64>>,
    /// Values of each draw.
    pub resampled: Vec<Vec<Option<f64>>>,
}

impl DrawnValues {
    /// Values of `rows` on `scans`, and on every draw of them.
    pub fn new(rows: &dyn UnderProtocol, scans: &DrawnScans) -> Self {
        let values = rows.values(&vec![1; scans.names().len()]);
        let several = (0..scans.n_draws().div_ceil(N_LANES)).into_par_iter();
        let several = several.flat_map_iter(|it| rows.values_of_draws(&scans.times(it * N_LANES)));
        let mut resampled: Vec<Vec<Option<f64>>> = several.collect();
        resampled.truncate(scans.n_draws());
        Self { values, resampled }
    }

    /// Interval of the value at `index`; `None` if there is none.
    pub fn interval(&self, index: usize, scans: &DrawnScans) -> Option<Interval> {
        self.values[index]?;
        let resampled = self.resampled.iter().map(|it| it[index]);
        Distribution::new(resampled, scans.blocks()?).map(|it| it.interval())
    }
}
