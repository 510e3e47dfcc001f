//! Pairs of objects with growing gaps, and which detectors tell them apart.
//!
//! Paper: HG section 3.2 and Fig. 7, separation of nearby objects.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use detector::{Detector, DetectorOutput};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use reports::numbers::gap_curve::{GapBin, PairCounts};
use scans::annotation::LabeledScan;
use simulator::object_pair::{ObjectPair, PairKind, PairLayout, any_bearing_rad};
use simulator::sensor::SensorModel;
use simulator::staged_scene::staged_scan;

use crate::metrics::pair_separation::{PairOutcome, judge_pairs};
use crate::run::config::RunConfig;
use crate::run::detector_list::ListedDetector;
use crate::run::side_by_side::RunError;

/// Where the nearer object of a pair stands, from and to in metres from the sensor.
pub const RANGES_M: [[f32; 2]; 3] = [[5.0, 10.0], [10.0, 20.0], [20.0, 30.0]];
/// The gaps, in decimetres.
pub const GAPS_DM: std::ops::RangeInclusive<u16> = 2..=12;

/// What is put up, and who looks at it.
pub struct GapExperiment<'a> {
    /// The detectors.
    pub detectors: &'a [ListedDetector],
    /// Their parameters.
    pub config: &'a RunConfig,
    /// The sensor.
    pub sensor: &'a SensorModel,
    /// Pairs of each kind and layout at each range, each put up once with every gap.
    pub n_pairs: u32,
    /// What everything is drawn from.
    pub seed: u64,
}

/// One scan of the experiment: a pair at each range, in three directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Staging {
    /// What the pairs consist of.
    pub kind: PairKind,
    /// How they stand.
    pub layout: PairLayout,
    /// The gap of all of them, in decimetres.
    pub gap_dm: u16,
    /// Which of the drawn pairs.
    pub pair_idx: u32,
}

type Key = (usize, PairKind, PairLayout, usize, u16);

impl GapExperiment<'_> {
    /// All scans, in order.
    pub fn stagings(&self) -> Vec<Staging> {
        let n_pairs = self.n_pairs;
        let of_kind = |kind| PairLayout::ALL.into_iter().map(move |layout| (kind, layout));
        let gaps = |(kind, layout)| {
            GAPS_DM.flat_map(move |gap_dm| {
                (0..n_pairs).map(move |pair_idx| Staging { kind, layout, gap_dm, pair_idx })
            })
        };
        PairKind::ALL.into_iter().flat_map(of_kind).flat_map(gaps).collect()
    }

    /// Makes the scan of `staging`; the pair at range number r consists of the tracks 2r and 2r + 1. The same pair
    /// stands at the same place whatever its gap.
    pub fn scan(&self, staging: &Staging) -> LabeledScan {
        let number = PairKind::ALL.iter().position(|it| *it == staging.kind).unwrap_or(0) as u64 * 2
            + u64::from(staging.layout == PairLayout::Behind);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number << 32 | u64::from(staging.pair_idx));
        let first_bearing_rad = any_bearing_rad(&mut rng);
        let gap_m = f32::from(staging.gap_dm) / 10.0;
        let objects = RANGES_M.iter().zip(0_u16..).flat_map(|([from_m, to_m], range_idx)| {
            let pair = ObjectPair::any(staging.kind, staging.layout, &mut rng);
            let range_m = rng.random_range(*from_m..*to_m);
            // A third of a turn apart, so that no pair hides another.
            let bearing_rad = first_bearing_rad + f32::from(range_idx) * std::f32::consts::TAU / 3.0;
            pair.placed(gap_m, range_m, bearing_rad)
        });
        let objects: Vec<_> = objects.collect();
        staged_scan(&objects, self.sensor, rng.random())
    }

    /// The detectors, ready to detect.
    pub fn build_detectors(&self) -> Vec<Box<dyn Detector>> {
        self.detectors.iter().map(|it| it.build(self.config, self.sensor.height_above_road_m)).collect()
    }

    /// What became of the pairs of `scan`, by range, for each detector.
    pub fn judge(&self, scan: &LabeledScan, detectors: &mut [Box<dyn Detector>]) -> Vec<Vec<PairOutcome>> {
        let pairs = [0, 1, 2].map(|range_idx: u32| [2 * range_idx, 2 * range_idx + 1]);
        let mut output = DetectorOutput::default();
        let judge = |detector: &mut Box<dyn Detector>| {
            detector.detect(&scan.cloud, &mut output);
            judge_pairs(scan, &output.detections, &pairs, &self.config.matching)
        };
        detectors.iter_mut().map(judge).collect()
    }

    /// Runs all detectors on all scans, several at once, and counts; `on_scan` is told of each.
    ///
    /// # Errors
    ///
    /// [`RunError::Interrupted`] once `interrupted` is set.
    pub fn run(&self, interrupted: &AtomicBool, on_scan: impl Fn() + Sync) -> Result<Vec<GapBin>, RunError> {
        let stagings = self.stagings();
        let look = |detectors: &mut Vec<Box<dyn Detector>>, staging: &Staging| {
            (!interrupted.load(Ordering::Relaxed)).then(|| {
                let outcomes = self.judge(&self.scan(staging), detectors);
                on_scan();
                outcomes
            })
        };
        let judged: Vec<_> = stagings.par_iter().map_init(|| self.build_detectors(), look).collect();
        let mut counts: BTreeMap<Key, PairCounts> = BTreeMap::new();
        let n_done = judged.iter().flatten().count();
        if n_done < stagings.len() {
            return Err(RunError::Interrupted { n_done, n_scans: stagings.len() });
        }
        for (staging, by_detector) in stagings.iter().zip(judged.into_iter().flatten()) {
            for (detector_idx, outcomes) in by_detector.into_iter().enumerate() {
                for (range_idx, outcome) in outcomes.into_iter().enumerate() {
                    let key = (detector_idx, staging.kind, staging.layout, range_idx, staging.gap_dm);
                    *counts.entry(key).or_default() += counted(outcome);
                }
            }
        }
        Ok(counts.into_iter().map(|(key, counts)| self.bin(key, counts)).collect())
    }

    fn bin(&self, (detector_idx, kind, layout, range_idx, gap_dm): Key, counts: PairCounts) -> GapBin {
        GapBin {
            detector: self.detectors[detector_idx].name.to_owned(),
            pair: kind.name().to_owned(),
            layout: layout.name().to_owned(),
            range_m: RANGES_M[range_idx].map(f64::from),
            gap_m: f64::from(gap_dm) / 10.0,
            counts,
        }
    }
}

fn counted(outcome: PairOutcome) -> PairCounts {
    let is = |it| u64::from(outcome == it);
    PairCounts {
        n_pairs: 1,
        n_seen: 1 - is(PairOutcome::NotSeen),
        n_separated: is(PairOutcome::Separated),
        n_joined: is(PairOutcome::Joined),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::detector_list::detectors_named;
    use reports::numbers::gap_curve::gap_curves;

    #[test]
    fn every_scan_has_a_pair_at_each_range_whatever_the_gap() {
        let config = RunConfig::load(None).unwrap();
        let sensor = SensorModel::hdl_64e_s2();
        let experiment =
            GapExperiment { detectors: &[], config: &config, sensor: &sensor, n_pairs: 2, seed: 3 };
        assert_eq!(experiment.stagings().len(), 5 * 2 * 11 * 2);
        let staging = Staging { kind: PairKind::Cars, layout: PairLayout::Beside, gap_dm: 2, pair_idx: 1 };
        let scans = [2, 12].map(|gap_dm| experiment.scan(&Staging { gap_dm, ..staging }));
        for scan in &scans {
            assert_eq!(
                scan.annotations.iter().map(|it| it.track.unwrap()).collect::<Vec<_>>(),
                [0, 1, 2, 3, 4, 5]
            );
        }
        let sizes = scans.each_ref().map(|scan| {
            scan.annotations
                .iter()
                .map(|it| it.bounding_box.unwrap().length_width_height_m)
                .collect::<Vec<_>>()
        });
        let alike =
            sizes[0].iter().flatten().zip(sizes[1].iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(alike, "the same cars: {sizes:?}");
        assert_ne!(experiment.scan(&Staging { pair_idx: 0, ..staging }), scans[0]);
    }

    #[test]
    fn wide_gaps_are_seen_by_all_and_narrow_ones_by_the_dense_level() {
        let config = RunConfig::load(None).unwrap();
        let names = ["simple-grid", "hierarchical"].map(str::to_owned);
        let detectors = detectors_named(&names).unwrap();
        let sensor = SensorModel::hdl_64e_s2();
        let experiment =
            GapExperiment { detectors: &detectors, config: &config, sensor: &sensor, n_pairs: 1, seed: 1 };
        let mut bins = experiment.run(&AtomicBool::new(false), || ()).unwrap();
        bins.retain(|it| it.layout == "beside" && it.range_m == [5.0, 10.0]);
        let curves = gap_curves(&bins);
        let separated = |detector: &str, gaps_m: std::ops::RangeInclusive<f64>| -> u64 {
            let curve = curves.iter().find(|it| it.detector == detector).unwrap();
            let of_gaps = curve.points.iter().filter(|(gap_m, _)| gaps_m.contains(gap_m));
            of_gaps.map(|(_, counts)| counts.n_separated).sum()
        };
        assert!(separated("simple-grid", 1.0..=1.2) > separated("simple-grid", 0.2..=0.4));
        assert!(separated("hierarchical", 0.4..=0.8) > separated("simple-grid", 0.4..=0.8));
        let error = experiment.run(&AtomicBool::new(true), || ()).unwrap_err();
        assert!(matches!(error, RunError::Interrupted { n_done: 0, .. }), "{error}");
    }
}
