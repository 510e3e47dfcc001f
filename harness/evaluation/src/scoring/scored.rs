//! The rows of detections that are judged in memory.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use reports::numbers::tally::Tally;
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::ScanRow;
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::own_slice::{OwnSlice, SliceBounds};
use scans::dataset::Dataset as _;
use scans::foreign::foreign_results::ForeignResults;

use super::request::{ReadRequest, ScoreRequest};
use super::scans_in_memory::ScansInMemory;
use crate::matching::criterion::Criterion;
use crate::metrics::counts::scoring_version;
use crate::run::compared_detector::ComparedDetector;
use crate::run::config::RunConfig;
use crate::run::detector_list::ChosenDetector;
use crate::run::foreign_detector::{ForeignDetector, ForeignWork, VehicleRule};
use crate::run::kept_names::kept;
use crate::run::side_by_side::{OnDetectorFailure, RunError, SideBySide};
use crate::run::sink::{JudgedScan, WatchedDataset};

/// Rows of scans that were judged in memory, with their sums.
pub struct Scored {
    /// Version of the rules that judged.
    pub scoring_version: u32,
    /// One row for every scan and task.
    pub scans: Vec<ScanRow>,
    /// One row for every pair, and for every annotation and detection that is in none.
    pub matches: Vec<MatchRow>,
    /// The sums.
    pub tally: Tally,
}

/// The reason that nothing was scored.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    /// The request is wrong.
    #[error("{0}")]
    Request(String),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Judges `request`, whose points are `payload`, as `run --detections` judges the same scans and boxes.
///
/// # Errors
///
/// [`ScoreError`] if the request is wrong.
pub fn score(request: &ScoreRequest, payload: &[u8], mut config: RunConfig) -> Result<Scored, ScoreError> {
    let criterion = Criterion::ALL.into_iter().find(|it| it.kind() == request.criterion);
    config.choose_criterion(criterion.expect("there is a criterion of every kind"));
    let of_run = config.matching.criterion;
    let criteria = config.class_criteria.all(of_run).map(|(_, it)| it.kind());
    let criteria: Vec<CriterionKind> = criteria.chain([of_run.kind()]).collect();
    let enough = config.matching.eligibility.min_points;
    let by_points = criteria.contains(&CriterionKind::Points);
    let ReadRequest { scans, times_s, detections, annotated, has_points } =
        request.read(payload, enough, by_points).map_err(ScoreError::Request)?;
    let dataset = ScansInMemory::new(&request.dataset, annotated, request.sensor_height_m, scans, times_s);
    let results = ForeignResults::in_memory(&dataset, detections);
    let foreign = detector_of(request, has_points);
    let compared = ComparedDetector::of(ChosenDetector::Foreign(foreign), &config);
    let mut detectors = vec![compared.begin_with_results(dataset.description(), results)];
    let scan_indices: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let side_by_side = SideBySide {
        dataset: &dataset,
        scan_indices: &scan_indices,
        part: 0..scan_indices.len(),
        n_before: 0,
        matching: config.matching,
        class_criteria: &config.class_criteria,
        n_warmup: 0,
        n_repeats: NonZeroUsize::MIN,
        n_jobs: 1,
        counter: None,
        on_failure: OnDetectorFailure::Stop,
        interrupted: &AtomicBool::new(false),
    };
    let watched = WatchedDataset {
        dataset: &dataset,
        scan_indices: &scan_indices,
        n_scans: scan_indices.len(),
        n_before: 0,
        criterion: config.matching.criterion,
    };
    let slice = |(name, bounds): (String, SliceBounds)| Some((OwnSlice::named(&name)?, bounds));
    let mut scored = Scored {
        scoring_version: scoring_version(criteria, true),
        scans: Vec::new(),
        matches: Vec::new(),
        tally: Tally::default().with_slices(config.slices.all().into_iter().filter_map(slice).collect()),
    };
    side_by_side.run(&mut detectors, |results| {
        for task in JudgedScan::new(watched, &results).rows.into_iter().flat_map(|it| it.tasks) {
            scored.tally.add_scan(&task.scan);
            task.matches.iter().for_each(|row| scored.tally.add_match(row));
            scored.scans.push(task.scan);
            scored.matches.extend(task.matches);
        }
        Ok::<(), RunError>(())
    })?;
    Ok(scored)
}

/// The detector whose results are in `request`.
fn detector_of(request: &ScoreRequest, has_points: bool) -> ForeignDetector {
    ForeignDetector {
        name: kept(&request.detector),
        folder: PathBuf::new(),
        work: ForeignWork::Results(PathBuf::new()),
        // Without points there is nothing that a model could look at.
        vehicles: if has_points { VehicleRule::Model } else { VehicleRule::Size },
    }
}
