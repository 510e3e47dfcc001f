//! All that a page says about a run, gathered from its directory without holding all rows at once.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::of_some_runs::{agreement_of, given_classes, protocols_of, scored};
use crate::files::archive::ArchiveError;
use crate::files::csv_rows::{each_row, read_rows};
use crate::numbers::average_precision::OperatingPoint;
use crate::numbers::blocks::BlockCount;
use crate::numbers::pools::Pool;
use crate::numbers::precision_recall_row::PrecisionRecallRow;
use crate::numbers::run_report::{RunReport, Subject};
use crate::numbers::tally::Tally;
use crate::plots::marks::SeriesMark;
use crate::plots::series::{Position, Series};
use crate::protocols::given_classes::GivenClasses;
use crate::protocols::protocol_report::ProtocolReport;
use crate::rows::agreement_row::AgreementRow;
use crate::rows::error_row::ErrorRow;
use crate::rows::match_outcome::{BoxFacts, MatchOutcome};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_name::ScanName;
use crate::rows::scan_row::{ScanOutcome, ScanRow};
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::run_folder::run_directory::{
    MATCHES_CSV, PRECISION_RECALL_CSV, RECORDINGS_JSON, REPORT_JSON, SCANS_CSV, WORST_POINTS_JSON,
};
use crate::run_folder::run_target::MANIFEST_JSON;
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::reason_gains::ReasonTally;
use crate::verdicts::task_ranking::{Speeds, TaskRanking, rankings, speeds};
use crate::vocabulary::formula::Term;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;
use crate::worst::objects::{WorstObject, WorstObjects};
use crate::worst::points::WorstPoints;
use crate::worst::recorded::Recordings;

/// What a page is made of.
#[derive(Debug)]
pub(super) struct RunFacts {
    pub(super) manifest: Manifest,
    pub(super) report: RunReport,
    /// In the tasks on data sets that have labels.
    pub(super) rankings: Vec<TaskRanking>,
    pub(super) speeds: Vec<Speeds>,
    /// What is shown of the recorded data sets, and of the simulated ones.
    pub(super) pools: Vec<PoolFacts>,
    /// Data set by data set.
    pub(super) curves: Vec<DatasetCurves>,
    pub(super) worst: WorstObjects<()>,
    /// All boxes of the scans that a worst mistake is in.
    pub(super) boxes: BTreeMap<ScanName, Vec<SeenBox>>,
    pub(super) points: Option<WorstPoints>,
    /// Why detectors are wrong.
    pub(super) errors: Vec<ErrorRow>,
    /// Detectors that gave no answer to some scans, in the order of the run.
    pub(super) failures: Vec<FailedDetector>,
    /// Where the worst mistakes are recorded, of a run that was made in parts.
    pub(super) recordings: Option<Recordings>,
    /// Its numbers under protocols of others; `None` if it was evaluated under none.
    pub(super) protocols: Option<ProtocolReport>,
    /// Which of their classes any detector gives.
    pub(super) given: GivenClasses,
    /// How far detectors agree where nothing is labelled.
    pub(super) agreement: Vec<AgreementRow>,
    /// Whether there is a recording for the viewer.
    pub(super) has_recording: bool,
}

/// What is shown of all data sets of one origin together.
#[derive(Debug)]
pub(super) struct PoolFacts {
    pub(super) pool: Pool,
    /// The blocks of scans that their intervals are drawn from.
    blocks: Option<BlockCount>,
    /// Task by task.
    pub(super) ranges: Vec<TaskRanges>,
    /// Times of all scans in milliseconds, ascending, of every detector.
    pub(super) times_ms: Vec<(String, Vec<f64>)>,
    /// Median times of the stages in milliseconds, of every detector.
    pub(super) stages_ms: Vec<(String, Vec<(String, f64)>)>,
}

/// A detector that gave no answer to some scans.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FailedDetector {
    pub(super) detector: String,
    /// The first of these scans, and why.
    pub(super) first: (ScanName, String),
    pub(super) n_failed: u64,
    /// All its scans.
    pub(super) n_scans: u64,
}

/// Rates over range in one task.
#[derive(Debug)]
pub(super) struct TaskRanges {
    pub(super) task: Task,
    /// Names of the bins in metres, the nearest first.
    pub(super) bins: Vec<String>,
    /// Number of annotations that count in each.
    pub(super) n_annotations: Vec<u64>,
    /// Name of the rate, and its values in percent of every detector over the bins.
    pub(super) rates: Vec<(&'static str, Vec<Series>)>,
}

/// Precision over recall on one data set.
#[derive(Debug)]
pub(super) struct DatasetCurves {
    pub(super) dataset: String,
    pub(super) task: Task,
    /// Recall and precision, from the highest score on, of every detector.
    pub(super) of_detectors: Vec<(String, Vec<(f64, f64)>)>,
    /// What remains from each score on, of every detector.
    pub(super) operating: Vec<(String, Vec<OperatingPoint>)>,
}

/// A box in a scan.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SeenBox {
    pub(super) task: Task,
    /// Whose detection; `None` for an annotation.
    pub(super) detector: Option<String>,
    pub(super) id: u64,
    pub(super) bounding_box: BoxFacts,
}

impl RunFacts {
    /// Reads the run in `directory`.
    pub(super) fn read(directory: &Path) -> Result<Self, ArchiveError> {
        let manifest = Manifest::read(&directory.join(MANIFEST_JSON))?;
        let report = RunReport::read(&directory.join(REPORT_JSON))?;
        let detectors: Vec<String> = manifest.detectors.iter().map(|it| it.name.clone()).collect();
        let mut tally = manifest.tally();
        let pools = manifest.pools();
        let no_times: Vec<(String, Vec<f64>)> = detectors.iter().map(|it| (it.clone(), Vec::new())).collect();
        let mut times_ms = vec![no_times; pools.len()];
        let mut first_task = None;
        let mut failures: BTreeMap<String, (ScanName, String)> = BTreeMap::new();
        each_row(&directory.join(SCANS_CSV), |row: ScanRow| {
            tally.add_scan(&row);
            // Every task has a row about the same detection.
            let is_first = *first_task.get_or_insert(row.task) == row.task;
            if let Some(reason) = row.numbers().and_then(|it| it.failure.clone()) {
                failures.entry(row.detector.clone()).or_insert_with(|| (row.scan_name(), reason));
            }
            let is_timed = is_first && manifest.is_of_like_processors();
            let pool_idx = pools.iter().position(|it| it.datasets.contains(&row.dataset));
            let of_pool = pool_idx.filter(|_| is_timed).map(|it| &mut times_ms[it]);
            let times = of_pool.and_then(|it| it.iter_mut().find(|(name, _)| *name == row.detector));
            if let (Some((_, times)), ScanOutcome::Evaluated(numbers)) = (times, &row.outcome) {
                times.extend(numbers.latency_ms.filter(|it| *it > 0.0));
            }
        })?;
        let failed_detector = |name: &String| {
            let [n_failed, n_scans] = report.failed_scans(|_| true, report.first_task()?, name)?;
            Some(FailedDetector { detector: name.clone(), first: failures.remove(name)?, n_failed, n_scans })
        };
        let failures = detectors.iter().filter_map(failed_detector).collect();
        let matches = directory.join(MATCHES_CSV);
        let (mut worst, mut reasons) = (WorstObjects::default(), ReasonTally::default());
        each_row(&matches, |row: MatchRow| {
            tally.add_match(&row);
            worst.add(&row, |_| ());
            reasons.add_match(&row);
        })?;
        let draws = tally.draw();
        let of_pool = |(pool, times_ms)| PoolFacts::of(pool, times_ms, &tally, &draws, &report);
        let agreement = agreement_of(directory)?;
        let rankings = rankings(&tally, &manifest, &report);
        Ok(Self {
            rankings: scored(rankings, &agreement),
            speeds: speeds(&manifest, &report),
            pools: pools.into_iter().zip(times_ms).map(of_pool).collect(),
            curves: curves(&read_rows(&directory.join(PRECISION_RECALL_CSV))?, &detectors),
            boxes: boxes_of(&matches, &worst)?,
            points: WorstPoints::read(&directory.join(WORST_POINTS_JSON))?,
            errors: reasons.rows(&tally),
            failures,
            recordings: Recordings::read(&directory.join(RECORDINGS_JSON))?,
            protocols: protocols_of(directory, &manifest)?,
            given: given_classes(directory, &manifest)?,
            agreement,
            has_recording: directory.join("run.rrd").is_file(),
            worst,
            manifest,
            report,
        })
    }

    /// Whether any data set has labels.
    pub(super) fn is_scored(&self) -> bool {
        let is_compared = |it: &DatasetEntry| self.agreement.iter().any(|row| row.dataset == it.id);
        !self.manifest.datasets.iter().all(is_compared)
    }

    /// What is to be said of intervals, after `before`; nothing if there is nothing to be said.
    pub(super) fn caveat(&self, before: &str) -> String {
        let caveats = self.pools.iter().filter_map(|it| {
            let on = if self.pools.len() > 1 { format!(" on {}", it.pool.in_words()) } else { String::new() };
            Some(format!("{}{on}", it.caveat_of_intervals()?))
        });
        let caveats: Vec<String> = caveats.collect();
        if caveats.is_empty() { String::new() } else { format!("{before} {}", caveats.join("; ")) }
    }

    /// The name of `pool` in file names and in titles: nothing if there is no other.
    pub(super) fn of_pool(&self, pool: &Pool) -> [String; 2] {
        if self.pools.len() > 1 {
            let origin = pool.origin.name();
            [format!("_{}", origin.replace(' ', "_")), format!(", {}", pool.in_words())]
        } else {
            Default::default()
        }
    }

    /// Index of `detector` in the order of the run.
    pub(super) fn detector_idx(&self, detector: &str) -> usize {
        self.manifest.detectors.iter().position(|it| it.name == detector).unwrap_or(0)
    }

    /// Names of the detectors in the order of the run.
    pub(super) fn detectors(&self) -> Vec<&str> {
        self.manifest.detectors.iter().map(|it| it.name.as_str()).collect()
    }
}

impl PoolFacts {
    /// What is shown of `pool`, whose scans took the detectors `times_ms`.
    fn of(
        pool: Pool,
        mut times_ms: Vec<(String, Vec<f64>)>,
        tally: &Tally,
        draws: &[Draw],
        report: &RunReport,
    ) -> Self {
        for (_, times) in &mut times_ms {
            times.sort_by(f64::total_cmp);
        }
        let detectors: Vec<String> = times_ms.iter().map(|(name, _)| name.clone()).collect();
        let indices = tally.datasets_in(pool.extent.name()).into_iter();
        let ranges = tally.tasks().iter().filter_map(|it| task_ranges(tally, draws, &pool, *it, &detectors));
        Self {
            blocks: indices.map(|it| draws[it].blocks()).reduce(BlockCount::with),
            ranges: ranges.collect(),
            stages_ms: detectors.iter().map(|it| (it.clone(), stages_of(report, &pool, it))).collect(),
            times_ms,
            pool,
        }
    }

    /// What is to be said of intervals; `None` if nothing is.
    pub(super) fn caveat_of_intervals(&self) -> Option<String> {
        self.blocks.and_then(BlockCount::caveat_of_conclusions)
    }

    /// The same after `before`; nothing if there is nothing to be said.
    pub(super) fn caveat(&self, before: &str) -> String {
        self.caveat_of_intervals().map_or_else(String::new, |it| format!("{before} {it}"))
    }
}

fn task_ranges(
    tally: &Tally,
    draws: &[Draw],
    pool: &Pool,
    task: Task,
    detectors: &[String],
) -> Option<TaskRanges> {
    let is_range = |it: &Slice| matches!(it, Slice::Range(_));
    let slices: BTreeSet<Slice> =
        detectors.iter().flat_map(|it| tally.slices(task, it)).filter(is_range).collect();
    let dataset = pool.extent.name();
    let sample =
        |detector: &str, slice: Slice| tally.sample(&Question { dataset, task, detector, slice }, draws);
    // They are the same for every detector.
    let n_annotations = |slice: &Slice| {
        let of_detectors = detectors.iter().filter_map(|it| sample(it, *slice));
        of_detectors.map(|it| it.total.of(Term::Annotations) as u64).max().unwrap_or(0)
    };
    let n_annotations: Vec<u64> = slices.iter().map(n_annotations).collect();
    let rate = |detector: &str, (bin, slice): (u32, &Slice), metric: &Metric| {
        // Where nothing is annotated a single false detection would be a precision and an F-rate of 0.
        let sample = sample(detector, *slice).filter(|_| n_annotations[bin as usize] > 0)?;
        let within = Distribution::new(sample.resampled_values(metric), sample.blocks)
            .map(|it| it.interval().ends.map(|it| 100.0 * it));
        Some(Position { x: bin.into(), y: 100.0 * sample.value(metric)?, within })
    };
    let of_detectors = |metric: &Metric| {
        let of_detector = |(detector_idx, it): (usize, &String)| {
            let rates = (0..).zip(&slices).map(|bin| rate(it, bin, metric));
            Series { name: it.clone(), mark: SeriesMark(detector_idx), positions: rates.collect() }
        };
        detectors.iter().enumerate().map(of_detector).collect::<Vec<_>>()
    };
    let rates = [("precision", Metric::Precision), ("recall", Metric::Recall), ("F-rate", Metric::FRate)];
    let rates = rates.into_iter().map(|(name, metric)| (name, of_detectors(&metric)));
    // What is undefined everywhere, as precision where false objects are unknown, is not drawn.
    let is_defined =
        |(_, rates): &(_, Vec<Series>)| rates.iter().flat_map(|it| &it.positions).any(Option::is_some);
    let rates: Vec<_> = rates.filter(is_defined).collect();
    let bins = slices.iter().map(|it| it.name().trim_start_matches("range/").to_owned()).collect();
    (!rates.is_empty()).then_some(TaskRanges { task, bins, n_annotations, rates })
}

fn curves(rows: &[PrecisionRecallRow], detectors: &[String]) -> Vec<DatasetCurves> {
    let mut all: Vec<DatasetCurves> = Vec::new();
    for row in rows {
        let (dataset, task, detector) = row.subject();
        let Some(position) = row.position() else { continue };
        let known = all.iter().position(|it| it.dataset == dataset && it.task == task);
        let curves_idx = known.unwrap_or_else(|| {
            let of_detectors = detectors.iter().map(|it| (it.clone(), Vec::new())).collect();
            let operating = detectors.iter().map(|it| (it.clone(), Vec::new())).collect();
            all.push(DatasetCurves { dataset: dataset.to_owned(), task, of_detectors, operating });
            all.len() - 1
        });
        let curves = &mut all[curves_idx];
        if let Some((_, positions)) = curves.of_detectors.iter_mut().find(|(name, _)| name == detector) {
            positions.push(position);
        }
        if let Some((_, points)) = curves.operating.iter_mut().find(|(name, _)| name == detector) {
            points.push(row.point());
        }
    }
    all
}

fn stages_of(report: &RunReport, pool: &Pool, detector: &str) -> Vec<(String, f64)> {
    let subject = report.first_task().map(|task| Subject::of_all(pool.extent.name(), task, detector));
    let rows = report.rows().iter().chain(report.overall());
    let rows = rows.filter(|it| subject.as_ref() == Some(&it.subject));
    let stage = rows.filter_map(|it| match &it.metric {
        Metric::StageP50(stage) => Some((stage.clone(), it.value()?)),
        _ => None,
    });
    stage.collect()
}

/// The boxes of all scans that a mistake of `worst` is in; each once for every task.
fn boxes_of(
    matches: &Path,
    worst: &WorstObjects<()>,
) -> Result<BTreeMap<ScanName, Vec<SeenBox>>, ArchiveError> {
    let objects = worst.lists().flat_map(|(_, objects)| objects);
    let mut boxes: BTreeMap<ScanName, Vec<SeenBox>> = objects.map(|it| (scan_name(it), Vec::new())).collect();
    each_row(matches, |row: MatchRow| {
        let name = ScanName { dataset: row.dataset.clone(), sequence: row.sequence.clone(), scan: row.scan };
        let Some(boxes) = boxes.get_mut(&name) else { return };
        let (annotation, detection) = match row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => (Some(annotation), Some(detection)),
            MatchOutcome::Missed { annotation, .. } | MatchOutcome::IgnoredAnnotation { annotation, .. } => {
                (Some(annotation), None)
            }
            MatchOutcome::Tall { annotation, found_by } => {
                (Some(annotation), found_by.map(|it| it.detection))
            }
            MatchOutcome::False { detection, .. }
            | MatchOutcome::IgnoredDetection { detection, .. }
            | MatchOutcome::Unknowable { detection } => (None, Some(detection)),
        };
        if let Some((id, bounding_box)) = annotation.and_then(|it| Some((it.id, it.bounding_box?))) {
            // Every detector has a row about it.
            let seen = SeenBox { task: row.task, detector: None, id, bounding_box };
            if !boxes.contains(&seen) {
                boxes.push(seen);
            }
        }
        if let Some(detection) = detection {
            let (id, bounding_box) = (detection.id, detection.bounding_box);
            boxes.push(SeenBox { task: row.task, detector: Some(row.detector), id, bounding_box });
        }
    })?;
    Ok(boxes)
}

/// The scan of a mistake.
pub(super) fn scan_name(worst: &WorstObject<()>) -> ScanName {
    let object = &worst.object;
    ScanName { dataset: object.dataset.clone(), sequence: object.sequence.clone(), scan: object.scan }
}
