//! What the table of a task says, before it is printed anywhere.

use crate::numbers::blocks::{BlockKind, Interval};
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::rows::counts::Counts;
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::tables::paper_figures::{PAPER_TABLES, PaperRow, PaperTable, Recordings};
use crate::tables::table_error::TableError;
use crate::vocabulary::extent::{Extent, OVERALL};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// The table of one task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskTable {
    /// The task.
    pub task: Task,
    /// By what detections were matched with annotations, in words.
    pub matching_criterion: String,
    /// The processor that all times are for.
    pub cpu_model: String,
    /// Names of the detectors, in the order of the columns.
    pub detectors: Vec<String>,
    /// What some of them do beside finding clusters, with the names of those that do.
    pub rules: Vec<(String, Vec<String>)>,
    /// Detectors that are not built in, with where their results were read if they did not run here. Nobody knows their rules.
    pub foreign: Vec<(String, Option<String>)>,
    /// Detectors that gave no answer to some scans, with the numbers of these and of all scans.
    pub failures: Vec<(String, [u64; 2])>,
    /// The paper whose figures stand beside ours, if it is about this task and one of the detectors.
    pub paper: Option<&'static PaperTable>,
    /// The rows, in order: data sets, what they add up to, and then the paper's rows.
    pub rows: Vec<TableRow>,
}

/// A row of [`TaskTable`].
#[derive(Debug, Clone, PartialEq)]
pub enum TableRow {
    /// Ours.
    Measured(MeasuredRow),
    /// A paper's.
    Paper(&'static PaperRow),
}

/// What was measured on a data set, or on all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredRow {
    /// Of what.
    pub extent: Extent,
    /// Whether a simulator made it.
    pub origin: Origin,
    /// NO, the annotations that count.
    pub no: u64,
    /// One for each of [`TaskTable::detectors`].
    pub scores: Vec<Score>,
}

/// What a detector reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Number of scans evaluated.
    pub n_scans: u64,
    /// What was found, missed and false.
    pub counts: Counts,
    /// How sure precision, recall and F-rate are.
    pub intervals: RateIntervals,
    /// Annotations that are neither found nor missed.
    pub n_ignored_annotations: u64,
    /// Detections that are neither right nor false.
    pub n_ignored_detections: u64,
    /// Number of scans whose times count.
    pub n_timed_scans: u64,
    /// Time of detection of those, in seconds.
    pub total_time_s: f64,
}

/// How sure rates are, where that is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RateIntervals {
    /// Of TP / ND.
    pub precision: Option<Interval>,
    /// Of TP / NO.
    pub recall: Option<Interval>,
    /// Of 2 TP / (NO + ND).
    pub f_rate: Option<Interval>,
}

impl Score {
    /// Scans per second; `None` if no scan was timed.
    pub fn fps(&self) -> Option<f64> {
        (self.n_timed_scans > 0).then(|| self.n_timed_scans as f64 / self.total_time_s)
    }

    fn add(&mut self, other: &Self) {
        self.n_scans += other.n_scans;
        self.counts += other.counts;
        self.n_ignored_annotations += other.n_ignored_annotations;
        self.n_ignored_detections += other.n_ignored_detections;
        self.n_timed_scans += other.n_timed_scans;
        self.total_time_s += other.total_time_s;
    }
}

impl TaskTable {
    /// What its intervals were drawn from; `None` if it has none.
    pub fn block_kind(&self) -> Option<BlockKind> {
        let scores = self.rows.iter().flat_map(|it| match it {
            TableRow::Measured(row) => row.scores.as_slice(),
            TableRow::Paper(_) => &[],
        });
        let intervals = scores.flat_map(|it| [it.intervals.f_rate, it.intervals.recall]).flatten();
        let kinds = intervals.map(|it| it.blocks.kind);
        kinds.reduce(BlockKind::with)
    }

    /// Name of the files it is written to, without the ending.
    pub fn file_stem(&self) -> String {
        format!("table_{}", self.task)
    }
}

/// The tables of all tasks of a run, in the order in which the report first mentions them.
///
/// Data sets and detectors are in the order of the manifest. Where there are several data sets, the last rows are about
/// all of them.
///
/// ```
/// use std::path::Path;
///
/// use reports::numbers::run_report::RunReport;
/// use reports::run_folder::manifest::Manifest;
/// use reports::tables::formats::lists::TABLE_FORMATS;
/// use reports::tables::task_table::task_tables;
///
/// let manifest = Manifest::read(Path::new("golden/run/manifest.json"))?;
/// let report = RunReport::read(Path::new("golden/run/report.json"))?;
/// for table in task_tables(&report, &manifest)? {
///     for format in TABLE_FORMATS {
///         assert!(format.text(&table).contains("hierarchical"), "{}", format.file_name(&table.file_stem()));
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`TableError`] if the report and the manifest do not fit together, or the report misses a number.
///
/// Paper: HG section 5, table 1; VM section 6, table 1.
pub fn task_tables(report: &RunReport, manifest: &Manifest) -> Result<Vec<TaskTable>, TableError> {
    let mut tasks: Vec<Task> = Vec::new();
    for Subject { dataset, task, detector, .. } in report.rows().iter().map(|it| &it.subject) {
        if !manifest.datasets.iter().any(|it| it.id == *dataset) {
            return Err(TableError::UnknownDataset(dataset.clone()));
        }
        if !manifest.detectors.iter().any(|it| it.name == *detector) {
            return Err(TableError::UnknownDetector(detector.clone()));
        }
        if !tasks.contains(task) {
            tasks.push(*task);
        }
    }
    tasks.into_iter().map(|task| task_table(report, manifest, task)).collect()
}

fn task_table(report: &RunReport, manifest: &Manifest, task: Task) -> Result<TaskTable, TableError> {
    let is_about = |field: fn(&Subject) -> &str, name: &str| {
        report.rows().iter().any(|it| it.subject.task == task && field(&it.subject) == name)
    };
    let names = manifest.detectors.iter().map(|it| it.name.clone());
    let detectors: Vec<String> = names.filter(|it| is_about(|subject| &subject.detector, it)).collect();
    let entries = manifest.datasets.iter().filter(|it| is_about(|subject| &subject.dataset, &it.id));
    let datasets = entries
        .map(|entry| Ok((entry, measured_row(report, entry, task, &detectors)?)))
        .collect::<Result<Vec<_>, TableError>>()?;
    let measured: Vec<&MeasuredRow> = datasets.iter().map(|(_, row)| row).collect();
    let overall = (measured.len() > 1).then(|| overall_row(report, task, &detectors, &measured));
    let paper = PAPER_TABLES.iter().find(|it| {
        it.task == task && it.methods.iter().any(|method| detectors.iter().any(|our| our == method.detector))
    });
    Ok(TaskTable {
        task,
        matching_criterion: manifest.matching_criterion.clone(),
        cpu_model: manifest.machine.cpu_model.clone(),
        rules: rules(manifest, &detectors),
        foreign: foreign(manifest, &detectors),
        failures: failures(report, task, &detectors),
        detectors,
        paper,
        rows: in_order(datasets, overall, paper),
    })
}

/// The rules of `detectors` in the order in which these have them, each with those that do.
fn rules(manifest: &Manifest, detectors: &[String]) -> Vec<(String, Vec<String>)> {
    let mut rules: Vec<(String, Vec<String>)> = Vec::new();
    for entry in manifest.detectors.iter().filter(|it| detectors.contains(&it.name)) {
        for rule in &entry.rules {
            match rules.iter_mut().find(|(name, _)| name == rule) {
                Some((_, names)) => names.push(entry.name.clone()),
                None => rules.push((rule.clone(), vec![entry.name.clone()])),
            }
        }
    }
    rules
}

/// Those of `detectors` that are not built in, with where their results were read.
fn foreign(manifest: &Manifest, detectors: &[String]) -> Vec<(String, Option<String>)> {
    let entries = manifest.detectors.iter().filter(|it| detectors.contains(&it.name));
    entries.filter_map(|it| Some((it.name.clone(), it.foreign.as_ref()?.results.clone()))).collect()
}

/// Those of `detectors` that gave no answer to some scans of all data sets.
fn failures(report: &RunReport, task: Task, detectors: &[String]) -> Vec<(String, [u64; 2])> {
    let of_detector = |it: &String| Some((it.clone(), report.failed_scans(task, it)?));
    detectors.iter().filter_map(of_detector).collect()
}

/// Puts the rows of the paper whose recordings a data set is to be compared with after all of ours, which they are none of.
fn in_order(
    datasets: Vec<(&DatasetEntry, MeasuredRow)>,
    overall: Option<MeasuredRow>,
    paper: Option<&'static PaperTable>,
) -> Vec<TableRow> {
    let paper_rows = |recordings| {
        let rows = paper.map_or(&[][..], |it| it.rows).iter();
        rows.filter(move |it| recordings == Some(it.recordings)).map(TableRow::Paper)
    };
    let counterparts: Vec<_> = datasets.iter().map(|(entry, _)| counterpart(entry)).collect();
    let of_both = overall.is_some().then_some(Recordings::Both);
    let measured = datasets.into_iter().map(|(_, row)| row).chain(overall);
    let mut rows: Vec<TableRow> = measured.map(TableRow::Measured).collect();
    for recordings in [Recordings::Budapest, Recordings::Kitti] {
        if counterparts.contains(&Some(recordings)) {
            rows.extend(paper_rows(Some(recordings)));
        }
    }
    rows.extend(paper_rows(of_both));
    rows
}

/// The papers' recordings that a data set is to be compared with, if any: KITTI with KITTI, and simulated streets with
/// those of Budapest, which are not public.
fn counterpart(entry: &DatasetEntry) -> Option<Recordings> {
    if entry.simulated {
        Some(Recordings::Budapest)
    } else {
        entry.format.contains("kitti").then_some(Recordings::Kitti)
    }
}

fn measured_row(
    report: &RunReport,
    entry: &DatasetEntry,
    task: Task,
    detectors: &[String],
) -> Result<MeasuredRow, TableError> {
    let scores = detectors
        .iter()
        .map(|detector| score(report, entry, task, detector))
        .collect::<Result<Vec<_>, _>>()?;
    // A task in the report has at least one row, which has a detector.
    let no = scores[0].counts.no();
    if let Some(other) = scores.iter().position(|it| it.counts.no() != no) {
        return Err(TableError::DifferentAnnotations {
            dataset: entry.id.clone(),
            first: detectors[0].clone(),
            n_first: no,
            second: detectors[other].clone(),
            n_second: scores[other].counts.no(),
        });
    }
    Ok(MeasuredRow { extent: Extent::Dataset(entry.id.clone()), origin: entry.origin(), no, scores })
}

/// Sums counts and times, so that every object and every scan weighs the same; `datasets` is not empty.
fn overall_row(
    report: &RunReport,
    task: Task,
    detectors: &[String],
    datasets: &[&MeasuredRow],
) -> MeasuredRow {
    let mut overall = MeasuredRow { extent: Extent::Overall, ..(*datasets[0]).clone() };
    for dataset in &datasets[1..] {
        overall.no += dataset.no;
        for (sum, score) in overall.scores.iter_mut().zip(&dataset.scores) {
            sum.add(score);
        }
        overall.origin = overall.origin.with(dataset.origin);
    }
    for (score, detector) in overall.scores.iter_mut().zip(detectors) {
        score.intervals = rate_intervals(report, &Subject::of_all(OVERALL, task, detector));
    }
    overall
}

fn rate_intervals(report: &RunReport, subject: &Subject) -> RateIntervals {
    let interval = |metric| report.row(subject, &metric).and_then(MetricRow::interval);
    RateIntervals {
        precision: interval(Metric::Precision),
        recall: interval(Metric::Recall),
        f_rate: interval(Metric::FRate),
    }
}

/// The numbers of one data set, task and detector.
fn score(report: &RunReport, entry: &DatasetEntry, task: Task, detector: &str) -> Result<Score, TableError> {
    let subject = Subject::of_all(&entry.id, task, detector);
    let row = |metric: Metric| {
        report.row(&subject, &metric).ok_or_else(|| {
            let Subject { dataset, task, detector, .. } = subject.clone();
            TableError::Missing { dataset, task, detector, metric: metric.id() }
        })
    };
    let bad = |metric: Metric, value| {
        let Subject { dataset, task, detector, .. } = subject.clone();
        TableError::BadCount { dataset, task, detector, metric: metric.id(), value }
    };
    let known_count = |metric: Metric| {
        let value = row(metric.clone())?.value();
        value.and_then(as_count).ok_or_else(|| bad(metric, value))
    };
    let fo = match row(Metric::Fo)?.value() {
        None => None,
        Some(_) => Some(known_count(Metric::Fo)?),
    };
    let tp = known_count(Metric::Tp)?;
    let counts =
        Counts::new(known_count(Metric::No)?, tp, fo).ok_or_else(|| bad(Metric::Tp, Some(tp as f64)))?;
    let fps = row(Metric::FpsMean)?;
    let (n_timed_scans, total_time_s) = match fps.value() {
        Some(value) if value > 0.0 => (fps.n, fps.n as f64 / value),
        Some(value) => return Err(bad(Metric::FpsMean, Some(value))),
        None => (0, 0.0),
    };
    Ok(Score {
        n_scans: row(Metric::No)?.n,
        counts,
        intervals: rate_intervals(report, &subject),
        n_ignored_annotations: known_count(Metric::IgnoredAnnotations)?,
        n_ignored_detections: known_count(Metric::IgnoredDetections)?,
        n_timed_scans,
        total_time_s,
    })
}

/// A count that was written as a number.
fn as_count(value: f64) -> Option<u64> {
    // Beyond 2^53 neighbouring counts are the same number.
    let is_count = value >= 0.0 && value.fract() == 0.0 && value <= 9_007_199_254_740_992.0;
    is_count.then_some(value as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::sample;

    fn tables(report: &RunReport, manifest: &Manifest) -> Result<Vec<TaskTable>, TableError> {
        task_tables(report, manifest)
    }

    fn names(table: &TaskTable) -> Vec<&str> {
        let name = |row: &'_ TableRow| match row {
            TableRow::Measured(MeasuredRow { extent: Extent::Dataset(id), .. }) => {
                sample::DATASETS.into_iter().find(|it| it == id).unwrap()
            }
            TableRow::Measured(_) => "OVERALL",
            TableRow::Paper(row) => row.name,
        };
        table.rows.iter().map(name).collect()
    }

    #[test]
    fn paper_rows_stand_apart_from_ours() {
        let [objects, vehicles] = tables(&sample::report(), &sample::manifest()).unwrap().try_into().unwrap();
        assert_eq!(
            names(&objects),
            [
                "main_road",
                "kitti_tracking",
                "kitti_object",
                "OVERALL",
                "Budapest #1",
                "Budapest #2",
                "KITTI",
                "overall"
            ]
        );
        assert_eq!(names(&vehicles)[4..7], ["Budapest #1", "Budapest #2", "Budapest #3"]);
    }

    #[test]
    fn a_paper_about_other_detectors_is_left_out() {
        let manifest = sample::manifest();
        let pca_only = sample::report_where(|it| it.subject.detector == "pca");
        let [objects, vehicles] = tables(&pca_only, &manifest).unwrap().try_into().unwrap();
        assert_eq!((objects.paper.is_some(), vehicles.paper.is_some()), (false, true));
        assert_eq!(names(&objects), ["main_road", "kitti_tracking", "kitti_object", "OVERALL"]);
    }

    #[test]
    fn one_data_set_has_no_overall_row() {
        let one = sample::report_where(|it| it.subject.dataset == "kitti_object");
        let table = &tables(&one, &sample::manifest()).unwrap()[0];
        assert_eq!(names(table), ["kitti_object", "KITTI"]);
    }

    #[test]
    fn overall_rates_are_those_of_the_sums() {
        let vehicles = &tables(&sample::report(), &sample::manifest()).unwrap()[1];
        let measured: Vec<_> = vehicles
            .rows
            .iter()
            .filter_map(|it| match it {
                TableRow::Measured(row) => Some(row),
                TableRow::Paper(_) => None,
            })
            .collect();
        let (overall, datasets) = measured.split_last().unwrap();
        assert_eq!(overall.origin, Origin::PartlySimulated);
        let sum = |of: fn(&Score) -> f64| datasets.iter().map(|it| of(&it.scores[0])).sum::<f64>();
        let score = overall.scores[0];
        let f_rate = 2.0 * sum(|it| it.counts.tp() as f64)
            / sum(|it| (it.counts.no() + it.counts.nd().unwrap()) as f64);
        assert_eq!(score.counts.f_rate(), Some(f_rate));
        assert_eq!(score.fps(), Some(sum(|it| it.n_timed_scans as f64) / sum(|it| it.total_time_s)));
    }

    #[test]
    fn false_objects_unknown_on_one_data_set_are_unknown_overall() {
        let objects = &tables(&sample::report(), &sample::manifest()).unwrap()[0];
        let overall = objects.rows.iter().find_map(|it| match it {
            TableRow::Measured(row) if row.extent == Extent::Overall => Some(row),
            _ => None,
        });
        assert_eq!(overall.unwrap().scores[0].counts.f_rate(), None);
        assert!(overall.unwrap().scores[0].counts.recall().is_some());
    }

    #[track_caller]
    fn check_refused(report: &RunReport, manifest: &Manifest, expected: &str) {
        assert_eq!(tables(report, manifest).unwrap_err().to_string(), expected);
    }

    #[test]
    fn a_data_set_without_entry_is_an_error() {
        let mut manifest = sample::manifest();
        manifest.datasets.remove(1);
        let expected = "the report has the data set \"kitti_tracking\", but the manifest does not";
        check_refused(&sample::report(), &manifest, expected);
    }

    #[test]
    fn a_detector_without_entry_is_an_error() {
        let mut manifest = sample::manifest();
        manifest.detectors.remove(1);
        let expected = "the report has the detector \"kd-tree\", but the manifest does not";
        check_refused(&sample::report(), &manifest, expected);
    }

    #[test]
    fn a_missing_number_is_an_error() {
        let report = sample::report_where(|it| {
            it.metric != Metric::Fo || it.subject.detector != "pca" || it.subject.dataset != "main_road"
        });
        let expected = "the report has no fo of pca on main_road in the task objects";
        check_refused(&report, &sample::manifest(), expected);
    }

    #[test]
    fn different_annotations_are_an_error() {
        let report = sample::report_with("kitti_object", "pca", &Metric::No, Some(99.0));
        let expected = "on kitti_object, hierarchical has 61 annotations that count, but pca has 99";
        check_refused(&report, &sample::manifest(), expected);
    }

    #[test]
    fn a_count_that_is_none_is_an_error() {
        let report = sample::report_with("main_road", "pca", &Metric::Tp, Some(2.5));
        let expected = "tp of pca on main_road in the task objects is Some(2.5), which is not a count";
        check_refused(&report, &sample::manifest(), expected);
    }

    #[test]
    fn more_matches_than_annotations_are_an_error() {
        let report = sample::report_with("main_road", "pca", &Metric::Tp, Some(1e6));
        let expected = "tp of pca on main_road in the task objects is Some(1000000.0), which is not a count";
        check_refused(&report, &sample::manifest(), expected);
    }
}
