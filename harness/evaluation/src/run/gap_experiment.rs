//! Pairs of objects with growing gaps, and how often detectors separate them.
//!
//! Paper: HG section 3.2 and Fig. 7, separation of nearby objects.

use std::cell::RefCell;
use std::collections::BTreeMap;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::numbers::gap_curve::{GapBin, PairCounts};
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::checksum::sha256;
use scans::dataset::simulation::Simulation;
use scans::dataset::{AnnotatedClasses, Dataset, DatasetDescription, DatasetError, Listing};
use serde::Serialize;
use simulator::object_pair::{ObjectPair, PairKind, PairLayout, any_bearing_rad};
use simulator::sensor::SensorModel;
use simulator::staged_scene::staged_scan;

use crate::matching::assign::MatchingParams;
use crate::metrics::pair_separation::{PairOutcome, judge_pairs};
use crate::run::sink::{JudgedScan, RunSink};

/// Ranges of the nearer object of a pair, from and to in metres from the sensor.
pub const RANGES_M: [[f32; 2]; 3] = [[5.0, 10.0], [10.0, 20.0], [20.0, 30.0]];
/// The gaps, in decimetres.
pub const GAPS_DM: std::ops::RangeInclusive<u16> = 2..=12;
/// The tracks of the pair at each range.
const PAIRS: [[u32; 2]; 3] = [[0, 1], [2, 3], [4, 5]];

/// The scans of the experiment as a data set. A drive has a pair at each range, with one scan for each gap; the number of a
/// scan is its gap in decimetres.
#[derive(Debug, Clone)]
pub struct StagedPairs {
    listing: Listing,
    sensor: SensorModel,
    seed: u64,
    stagings: Vec<Staging>,
}

/// One scan of the experiment: a pair at each range, in three directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Staging {
    /// Kinds of the two objects.
    pub kind: PairKind,
    /// How the two objects stand to each other.
    pub layout: PairLayout,
    /// The gap of all of them, in decimetres.
    pub gap_dm: u16,
    /// Index among the drawn pairs.
    pub pair_idx: u32,
}

/// Inputs of the simulation.
#[derive(Serialize)]
struct StagedFrom<'a> {
    sensor: &'a str,
    n_pairs: u32,
    seed: u64,
}

impl StagedPairs {
    /// `n_pairs` pairs of each kind and layout at each range, each staged once with every gap, in front of `sensor`, called
    /// `sensor_name`. Everything is drawn from `seed`.
    pub fn new(sensor_name: &str, sensor: SensorModel, n_pairs: u32, seed: u64) -> Self {
        let of_kind = |kind| PairLayout::ALL.into_iter().map(move |layout| (kind, layout));
        let gaps = |(kind, layout)| {
            GAPS_DM.flat_map(move |gap_dm| {
                (0..n_pairs).map(move |pair_idx| Staging { kind, layout, gap_dm, pair_idx })
            })
        };
        let stagings: Vec<Staging> = PairKind::ALL.into_iter().flat_map(of_kind).flat_map(gaps).collect();
        let id = |it: &Staging| ScanId {
            sequence: format!("{}-{}-{}", it.kind.name(), it.layout.name(), it.pair_idx),
            index: it.gap_dm.into(),
        };
        let description = DatasetDescription {
            id: "pairs".to_owned(),
            format: "staged-pairs".to_owned(),
            root: None,
            annotated: AnnotatedClasses::EveryObject,
            sensor_height_m: sensor.height_above_road_m,
            sensor: sensor_name.to_owned(),
            licence: None,
            checksum: Some(sha256(format!("{n_pairs} pairs, seed {seed}, {sensor:?}"))),
            simulation: Some(Simulation::of(&StagedFrom { sensor: sensor_name, n_pairs, seed })),
        };
        let scan_ids = stagings.iter().map(id).collect();
        Self { listing: Listing { description, scan_ids }, sensor, seed, stagings }
    }

    /// All scans, in order.
    pub fn stagings(&self) -> &[Staging] {
        &self.stagings
    }

    /// The sensor.
    pub fn sensor(&self) -> &SensorModel {
        &self.sensor
    }

    /// Makes the scan of `staging`; the pair at range number r consists of the tracks 2r and 2r + 1. A pair stands at the
    /// same position whatever its gap.
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
        staged_scan(&objects, &self.sensor, rng.random())
    }
}

impl Dataset for StagedPairs {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let id = self.listing.scan_ids[scan_idx].clone();
        Ok(LabeledScan { id, ..self.scan(&self.stagings[scan_idx]) })
    }
}

/// Index of the detector, kind, layout, index of the range, gap.
type Key = (usize, PairKind, PairLayout, usize, u16);

/// Counts which pairs are separated.
#[derive(Debug, Clone)]
pub struct PairTally<'a> {
    stagings: &'a [Staging],
    matching: MatchingParams,
    detectors: Vec<&'static str>,
    counts: BTreeMap<Key, PairCounts>,
}

impl<'a> PairTally<'a> {
    /// An empty tally of the pairs of `stagings`, which are judged by `matching`.
    pub fn new(stagings: &'a [Staging], matching: MatchingParams) -> Self {
        Self { stagings, matching, detectors: Vec::new(), counts: BTreeMap::new() }
    }

    /// The counts.
    pub fn bins(&self) -> Vec<GapBin> {
        let bin = |(&(detector_idx, kind, layout, range_idx, gap_dm), &counts): (&Key, &PairCounts)| GapBin {
            detector: self.detectors[detector_idx].to_owned(),
            pair: kind.name().to_owned(),
            layout: layout.name().to_owned(),
            range_m: RANGES_M[range_idx].map(f64::from),
            gap_m: f64::from(gap_dm) / 10.0,
            counts,
        };
        self.counts.iter().map(bin).collect()
    }
}

impl<E> RunSink<E> for &RefCell<PairTally<'_>> {
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), E> {
        let mut tally = self.borrow_mut();
        let Staging { kind, layout, gap_dm, .. } = tally.stagings[judged.scan_idx()];
        tally.detectors = judged.results.results.iter().map(|it| it.detector).collect();
        for (detector_idx, result) in judged.results.results.iter().enumerate() {
            let detections = &result.output.detections;
            let outcomes = judge_pairs(judged.results.scan, detections, &PAIRS, &tally.matching);
            for (range_idx, outcome) in outcomes.into_iter().enumerate() {
                let key = (detector_idx, kind, layout, range_idx, gap_dm);
                *tally.counts.entry(key).or_default() += counted(outcome);
            }
        }
        Ok(())
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
    use std::num::NonZeroUsize;
    use std::sync::atomic::AtomicBool;

    use crate::run::compared_detector::ComparedDetector;
    use crate::run::config::RunConfig;
    use crate::run::detector_list::detectors_named;
    use crate::run::side_by_side::{OnDetectorFailure, RunError, SideBySide};
    use crate::run::sink::{Sinks, run_watched};
    use reports::numbers::gap_curve::gap_curves;

    #[test]
    fn every_scan_has_a_pair_at_each_range_whatever_the_gap() {
        let experiment = StagedPairs::new("hdl-64e-s2", SensorModel::hdl_64e_s2(), 2, 3);
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
        let (first, last) = (0, experiment.scan_ids().len() - 1);
        assert_eq!(experiment.scan_ids()[first].to_string(), "cars-beside-0/000002");
        for scan_idx in [first, last] {
            assert_eq!(experiment.read_scan(scan_idx).unwrap().id, experiment.scan_ids()[scan_idx]);
        }
    }

    #[test]
    fn wide_gaps_are_seen_by_all_and_narrow_ones_by_the_dense_level() {
        let config = RunConfig::load(None).unwrap();
        let names = ["simple-grid", "hierarchical"].map(str::to_owned);
        let compared_detectors =
            detectors_named(&names, &config).unwrap().into_iter().map(|it| ComparedDetector::of(it, &config));
        let pairs = StagedPairs::new("hdl-64e-s2", SensorModel::hdl_64e_s2(), 1, 1);
        let mut detectors: Vec<_> = compared_detectors.map(|it| it.begin(pairs.description())).collect();
        let tally = RefCell::new(PairTally::new(pairs.stagings(), config.matching));
        let is_beside = |it: &usize| pairs.scan_ids()[*it].sequence.contains("-beside-");
        let beside: Vec<usize> = (0..pairs.scan_ids().len()).filter(is_beside).collect();
        let side_by_side = SideBySide {
            dataset: &pairs,
            scan_indices: &beside,
            part: 0..beside.len(),
            n_before: 0,
            matching: config.matching,
            class_criteria: &config.class_criteria,
            n_warmup: 0,
            n_repeats: NonZeroUsize::MIN,
            counter: None,
            n_jobs: 2,
            on_failure: OnDetectorFailure::Stop,
            interrupted: &AtomicBool::new(false),
        };
        let mut sinks: Sinks<'_, RunError> = vec![Box::new(&tally)];
        run_watched(&side_by_side, &mut detectors, |_, error| Err(error), &mut sinks).unwrap();
        drop(sinks);
        let mut bins = tally.into_inner().bins();
        bins.retain(|it| it.layout == "beside" && it.range_m == [5.0, 10.0]);
        let curves = gap_curves(&bins);
        let separated = |detector: &str, gaps_m: std::ops::RangeInclusive<f64>| -> u64 {
            let curve = curves.iter().find(|it| it.detector == detector).unwrap();
            let of_gaps = curve.points.iter().filter(|(gap_m, _)| gaps_m.contains(gap_m));
            of_gaps.map(|(_, counts)| counts.n_separated).sum()
        };
        assert!(separated("simple-grid", 1.0..=1.2) > separated("simple-grid", 0.2..=0.4));
        assert!(separated("hierarchical", 0.4..=0.8) > separated("simple-grid", 0.4..=0.8));
    }
}
