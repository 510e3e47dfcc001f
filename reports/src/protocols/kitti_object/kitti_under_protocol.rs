//! KITTI's numbers as those of any protocol.

use std::collections::BTreeMap;

use super::measures::Measure;
use super::numbers::KittiMatches;
use super::scan::KittiScan;
use crate::protocols::drawn_scans::{N_LANES, Times};
use crate::protocols::protocol_number::ProtocolMetric;
use crate::protocols::under_protocol::UnderProtocol;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;

/// What one detector made of scans.
pub struct KittiUnderProtocol {
    matches: KittiMatches,
}

impl KittiUnderProtocol {
    /// Of those of `scans` that are among `names`, which ascend.
    pub fn new(names: &[ScanName], scans: &BTreeMap<ScanName, KittiScan>) -> Self {
        let placed = scans.iter().filter_map(|(name, scan)| {
            let place = names.binary_search(name).ok()?;
            Some((place as u32, scan))
        });
        Self { matches: KittiMatches::of(&placed.collect::<Vec<_>>()) }
    }
}

impl UnderProtocol for KittiUnderProtocol {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let metric = |(measure, n): (Measure, u64)| ProtocolMetric {
            class: measure.question.class.name().to_owned(),
            id: measure.id(),
            unit: "ratio",
            direction: Direction::HigherIsBetter,
            n,
        };
        self.matches.measures().into_iter().map(metric).collect()
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        self.matches.values(times)
    }

    fn values_of_draws(&self, times: &[Times<N_LANES>]) -> Vec<Vec<Option<f64>>> {
        self.matches.of_draws(times).into()
    }
}
