//! All facts that are shown of a run: on its page, in `errors.csv` and on a terminal.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::gathered_run::{GatheredRun, Surroundings};
use super::of_some_runs::{agreement_of, protocols_of, read_given_classes, scored};
use super::seen_boxes::SeenBox;
use crate::files::archive::ArchiveError;
use crate::files::csv_rows::each_row;
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
use crate::rows::confusion_row::ConfusionRow;
use crate::rows::error_row::ErrorRow;
use crate::rows::match_row::MatchRow;
use crate::rows::scan_name::ScanName;
use crate::rows::scan_row::ScanRow;
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::run_folder::run_directory::{
    MATCHES_CSV, RECORDINGS_JSON, REPORT_JSON, SCANS_CSV, VIEWER, VIEWER_PLACES_JSON, WORST_POINTS_JSON,
    recordings_in,
};
use crate::run_folder::run_target::MANIFEST_JSON;
use crate::tables::class_table::{ClassTable, class_tables};
use crate::tables::protocol_in_short::ProtocolInShort;
use crate::tables::run_in_short::RunInShort;
use crate::tables::slice_table::{SliceTable, slice_tables};
use crate::tables::task_table::{TableError, TaskTable, task_tables};
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::task_ranking::{Speeds, TaskRanking, rankings, speeds};
use crate::verdicts::times_doubt::times_doubts;
use crate::vocabulary::formula::Term;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;
use crate::worst::objects::{MistakeList, ObjectName, WorstObject, WorstObjects};
use crate::worst::points::WorstPoints;
use crate::worst::recorded::{RecordedObject, Recordings};

/// Parts of a run beside its rows and numbers.
#[derive(Debug, Default)]
pub struct BesideRows {
    /// Points around the worst mistakes.
    pub points: Option<WorstPoints>,
    /// Where the worst mistakes are recorded, of a run that was made in parts.
    pub recordings: Option<Recordings>,
    /// Its numbers under protocols of others; `None` if it was evaluated under none.
    pub protocols: Option<ProtocolReport>,
    /// How far detectors agree where nothing is labelled.
    pub agreement: Vec<AgreementRow>,
    /// The folders of its recordings for the viewer.
    pub recording_folders: Vec<String>,
    /// Where the viewer of the page shows the worst mistakes, if there is one.
    pub in_viewer: Option<Recordings>,
}

/// Error of a directory that holds no readable run.
#[derive(Debug, thiserror::Error)]
pub enum FactsError {
    /// A file of the run cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The files of the run do not fit together.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// All facts that are shown of a run.
#[derive(Debug)]
pub struct RunFacts {
    /// Manifest of the run.
    pub manifest: Manifest,
    /// The sums.
    pub tally: Tally,
    /// The numbers.
    pub report: RunReport,
    /// A table of the numbers for each task.
    pub tables: Vec<TaskTable>,
    /// Rankings in the tasks, on data sets that have labels.
    pub(crate) rankings: Vec<TaskRanking>,
    pub(crate) speeds: Vec<Speeds>,
    /// Facts about the recorded data sets together, and about the simulated ones together.
    pub(crate) pools: Vec<PoolFacts>,
    /// Curves of each data set and task.
    pub(crate) curves: Vec<DatasetCurves>,
    pub(crate) worst: WorstObjects<Surroundings>,
    /// All boxes of the scans that a worst mistake is in.
    pub(crate) boxes: BTreeMap<ScanName, Vec<SeenBox>>,
    pub(crate) points: Option<WorstPoints>,
    /// Why detectors are wrong: the rows of `errors.csv`.
    pub errors: Vec<ErrorRow>,
    /// Detectors that gave no answer to some scans, in the order of the run.
    pub(crate) failures: Vec<FailedDetector>,
    /// Where the worst mistakes are recorded, of a run that was made in parts.
    pub(crate) recordings: Option<Recordings>,
    /// Its numbers under protocols of others; `None` if it was evaluated under none.
    pub(crate) protocols: Option<ProtocolReport>,
    /// Classes of these protocols that any detector gives.
    pub(crate) given: GivenClasses,
    /// Tables of the classes that detectors give, one for each data set, and for several together.
    pub classes: Vec<ClassTable>,
    /// Tables of the slices of the user, one for each data set, and for several together.
    pub slices: Vec<SliceTable>,
    /// Annotated classes by given classes: the rows of `confusion.csv`.
    pub confusion: Vec<ConfusionRow>,
    /// How far detectors agree where nothing is labelled.
    pub(crate) agreement: Vec<AgreementRow>,
    /// The folders of its recordings for the viewer.
    pub(crate) recording_folders: Vec<String>,
    /// Where the viewer of the page shows the worst mistakes, if there is one.
    pub(crate) in_viewer: Option<Recordings>,
}

/// Facts about all data sets of one origin together.
#[derive(Debug)]
pub(crate) struct PoolFacts {
    pub(crate) pool: Pool,
    /// Blocks of scans from which the resamples of the intervals are drawn.
    blocks: Option<BlockCount>,
    /// Rates over range, task by task.
    pub(crate) ranges: Vec<TaskRanges>,
    /// Times of all scans in milliseconds, ascending, of every detector.
    pub(crate) times_ms: Vec<(String, Vec<f64>)>,
    /// Median times of the stages in milliseconds, of every detector.
    pub(crate) stages_ms: Vec<(String, Vec<(String, f64)>)>,
}

/// A detector that gave no answer to some scans.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FailedDetector {
    pub(crate) detector: String,
    /// The first of these scans, and why.
    pub(crate) first: (ScanName, String),
    pub(crate) n_failed: u64,
    /// All its scans on the data sets that have such a scan.
    pub(crate) n_scans: u64,
}

/// Rates over range in one task.
#[derive(Debug)]
pub(crate) struct TaskRanges {
    pub(crate) task: Task,
    /// Names of the bins in metres, the nearest first.
    pub(crate) bins: Vec<String>,
    /// Number of annotations that count in each.
    pub(crate) n_annotations: Vec<u64>,
    /// Name of the rate, and its values in percent of every detector over the bins.
    pub(crate) rates: Vec<(&'static str, Vec<Series>)>,
}

/// Precision over recall on one data set.
#[derive(Debug)]
pub(crate) struct DatasetCurves {
    pub(crate) dataset: String,
    pub(crate) task: Task,
    /// Recall and precision, from the highest score on, of every detector.
    pub(crate) of_detectors: Vec<(String, Vec<(f64, f64)>)>,
    /// Matched and false detections at or above each score, of every detector.
    pub(crate) operating: Vec<(String, Vec<OperatingPoint>)>,
}

impl RunFacts {
    /// Reads the run in `directory`.
    ///
    /// # Errors
    ///
    /// [`FactsError`] if a file is missing or damaged, or files do not fit together.
    pub fn read(directory: &Path) -> Result<Self, FactsError> {
        let manifest = Manifest::read(&directory.join(MANIFEST_JSON))?;
        let report = RunReport::read(&directory.join(REPORT_JSON))?;
        let mut gathered = GatheredRun::of(&manifest);
        each_row(&directory.join(SCANS_CSV), |row: ScanRow| gathered.add_scan(&row))?;
        each_row(&directory.join(MATCHES_CSV), |row: MatchRow| {
            gathered.add_match(&row, Surroundings::default);
        })?;
        read_given_classes(directory, &manifest, &mut gathered)?;
        let beside = BesideRows {
            points: WorstPoints::read(&directory.join(WORST_POINTS_JSON))?,
            recordings: Recordings::read(&directory.join(RECORDINGS_JSON))?,
            protocols: protocols_of(directory, &manifest)?,
            agreement: agreement_of(directory)?,
            recording_folders: recordings_in(directory),
            in_viewer: Recordings::read(&directory.join(VIEWER).join(VIEWER_PLACES_JSON))?,
        };
        let draws = gathered.tally.draw();
        Ok(Self::of(gathered, beside, manifest, report, &draws)?)
    }

    /// Facts from `gathered` and from `report`, whose numbers were made of it with these `draws`.
    ///
    /// # Errors
    ///
    /// [`TableError`] if the numbers are not those of the run of `manifest`.
    pub fn of(
        gathered: GatheredRun,
        beside: BesideRows,
        manifest: Manifest,
        report: RunReport,
        draws: &[Draw],
    ) -> Result<Self, TableError> {
        let GatheredRun {
            tally, worst, pools, times_ms, mut failures, reasons, boxes, given, confusion, ..
        } = gathered;
        let confusion = confusion.rows();
        let detectors: Vec<String> = manifest.detectors.iter().map(|it| it.name.clone()).collect();
        let failed_detector = |name: &String| {
            let [n_failed, n_scans] = report.failed_scans(|_| true, report.first_task()?, name)?;
            Some(FailedDetector { detector: name.clone(), first: failures.remove(name)?, n_failed, n_scans })
        };
        let failures = detectors.iter().filter_map(failed_detector).collect();
        let of_pool = |(pool, times_ms)| PoolFacts::of(pool, times_ms, &tally, draws, &report);
        let BesideRows { points, recordings, protocols, agreement, recording_folders, in_viewer } = beside;
        Ok(Self {
            tables: task_tables(&report, &manifest)?,
            rankings: scored(rankings(&tally, draws, &manifest, &report), &agreement),
            speeds: speeds(&manifest, &report),
            pools: pools.into_iter().zip(times_ms).map(of_pool).collect(),
            curves: curves(&tally.precision_recall_rows(), &detectors),
            boxes: boxes.finish(&worst),
            points,
            errors: reasons.rows(&tally),
            failures,
            recordings,
            protocols,
            given,
            classes: class_tables(&report, &manifest, &confusion),
            slices: slice_tables(&report, &manifest),
            confusion,
            agreement,
            recording_folders,
            in_viewer,
            worst,
            tally,
            manifest,
            report,
        })
    }

    /// The worst mistakes, and the best matches, with their lists.
    pub fn worst(&self) -> impl Iterator<Item = (&MistakeList, &WorstObject<Surroundings>)> {
        self.worst.lists().flat_map(|(list, objects)| objects.iter().map(move |it| (list, it)))
    }

    /// Where one of these is recorded, if the run was made in parts.
    pub fn recorded(&self, object: &ObjectName) -> Option<&RecordedObject> {
        self.recordings.as_ref()?.of(object)
    }

    /// Whether any data set has labels.
    pub(crate) fn is_scored(&self) -> bool {
        let is_compared = |it: &DatasetEntry| self.agreement.iter().any(|row| row.dataset == it.id);
        !self.manifest.datasets.iter().all(is_compared)
    }

    /// Caveats of the intervals of all pools after the words `before`; empty if there are none.
    pub(crate) fn caveat(&self, before: &str) -> String {
        let caveats = self.pools.iter().filter_map(|it| {
            let on = if self.pools.len() > 1 { format!(" on {}", it.pool.in_words()) } else { String::new() };
            Some(format!("{}{on}", it.caveat_of_intervals()?))
        });
        let caveats: Vec<String> = caveats.collect();
        if caveats.is_empty() { String::new() } else { format!("{before} {}", caveats.join("; ")) }
    }

    /// Suffixes that name `pool` in file names and in titles; empty if it is the only pool.
    pub(crate) fn of_pool(&self, pool: &Pool) -> [String; 2] {
        if self.pools.len() > 1 {
            let origin = pool.origin.name();
            [format!("_{}", origin.replace(' ', "_")), format!(", {}", pool.in_words())]
        } else {
            Default::default()
        }
    }

    /// The summary for a terminal: tables of data sets that have labels, and which detector leads on these.
    pub fn in_short(&self) -> RunInShort {
        let verdict = self.rankings.iter().map(TaskRanking::short_sentence);
        RunInShort {
            tables: if self.is_scored() { self.tables.clone() } else { Vec::new() },
            classes: self.headline_classes().cloned().collect(),
            protocols: self
                .protocols
                .as_ref()
                .map_or_else(Vec::new, |it| ProtocolInShort::all(it, &self.manifest, &self.given)),
            agreement: self.agreement.clone(),
            verdict: verdict
                .chain(self.headline_classes().flat_map(ClassTable::sentences))
                .chain(self.speeds.iter().filter(|it| !it.is_doubted).filter_map(Speeds::sentence))
                .chain(times_doubts(&self.manifest, &self.report))
                .collect(),
        }
    }

    /// The tables of classes on all data sets of one origin together.
    fn headline_classes(&self) -> impl Iterator<Item = &ClassTable> {
        let pools = self.manifest.pools();
        self.classes.iter().filter(move |table| {
            let is_of_pool = |it: &Pool| {
                let is_only = it.datasets.len() == 1 && it.datasets[0] == table.dataset;
                is_only || it.extent.name() == table.dataset
            };
            pools.iter().any(is_of_pool)
        })
    }

    /// Index of `detector` in the order of the run.
    pub(crate) fn detector_idx(&self, detector: &str) -> usize {
        self.manifest.detectors.iter().position(|it| it.name == detector).unwrap_or(0)
    }

    /// Names of the detectors in the order of the run.
    pub(crate) fn detectors(&self) -> Vec<&str> {
        self.manifest.detectors.iter().map(|it| it.name.as_str()).collect()
    }
}

impl PoolFacts {
    /// Facts about `pool`; `times_ms` are the times of its scans by detector.
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
        let tasks = tally.tasks().iter().filter(|it| it.class().is_none());
        let ranges = tasks.filter_map(|it| task_ranges(tally, draws, &pool, *it, &detectors));
        Self {
            blocks: indices.map(|it| draws[it].blocks()).reduce(BlockCount::with),
            ranges: ranges.collect(),
            stages_ms: detectors.iter().map(|it| (it.clone(), stages_of(report, &pool, it))).collect(),
            times_ms,
            pool,
        }
    }

    /// Caveat of the intervals; `None` if there is none.
    pub(crate) fn caveat_of_intervals(&self) -> Option<String> {
        self.blocks.and_then(BlockCount::caveat_of_conclusions)
    }

    /// Caveat of the intervals after the words `before`; empty if there is none.
    pub(crate) fn caveat(&self, before: &str) -> String {
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
    // Annotations are the same for every detector.
    let n_annotations = |slice: &Slice| {
        let of_detectors = detectors.iter().filter_map(|it| sample(it, *slice));
        of_detectors.map(|it| it.total.of(Term::Annotations) as u64).max().unwrap_or(0)
    };
    let n_annotations: Vec<u64> = slices.iter().map(n_annotations).collect();
    let rate = |detector: &str, (bin, slice): (u32, &Slice), metric: &Metric| {
        // Without annotations, a single false detection would give a precision and an F-rate of 0.
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
    // A rate that is undefined in all bins is not drawn, such as precision where false objects are unknown.
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
