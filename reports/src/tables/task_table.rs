//! The content of the table of a task, before it is printed anywhere.

use crate::numbers::blocks::{BlockKind, Interval};
use crate::numbers::pools::{Pool, pools};
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::rows::counts::Counts;
use crate::run_folder::manifest::{DatasetEntry, DetectorEntry, Manifest};
use crate::tables::paper_figures::{PAPER_DETECTOR, PAPER_TABLES, PaperRow, PaperTable, Recordings};
use crate::verdicts::times_doubt::share_on_busy_machine;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// Why a report makes no table.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct TableError(String);

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
    /// Rules of some of them beside finding clusters, with the names of the detectors that have them.
    pub rules: Vec<(String, Vec<String>)>,
    /// Vehicle classifiers, in words, with the names of the detectors; empty for runs that do not say.
    pub vehicles: Vec<(String, Vec<String>)>,
    /// Detectors that are not built in, with where their results were read if they did not run here. Their rules are not all
    /// known.
    pub foreign: Vec<(String, Option<String>)>,
    /// Detectors that gave no answer to some scans, with the numbers of these and of all scans.
    pub failures: Vec<(String, [u64; 2])>,
    /// The paper whose figures stand beside ours, if it is about this task and its method is one of the detectors.
    pub paper: Option<&'static PaperTable>,
    /// Whether there would be such figures if that method were one of the detectors.
    pub lacks_paper: bool,
    /// The rows, in order: data sets, what those of one origin add up to, and then the paper's rows.
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

/// Scores on a data set, or on several together.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredRow {
    /// Data set, or several together.
    pub extent: Extent,
    /// Whether a simulator made it.
    pub origin: Origin,
    /// NO, the annotations that count.
    pub no: u64,
    /// One for each of [`TaskTable::detectors`].
    pub scores: Vec<Score>,
}

/// The score of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Score {
    /// Number of scans evaluated.
    pub n_scans: u64,
    /// Found, missed and false objects.
    pub counts: Counts,
    /// Intervals of precision, recall and F-rate.
    pub intervals: RateIntervals,
    /// Annotations that are neither found nor missed.
    pub n_ignored_annotations: u64,
    /// Detections that are neither right nor false.
    pub n_ignored_detections: u64,
    /// Number of scans whose times count.
    pub n_timed_scans: u64,
    /// Scans per second; `None` if no scan was timed.
    pub fps: Option<f64>,
    /// Whether a busy machine kept the detector waiting on some of these, so that its times are unreliable.
    pub on_busy_machine: bool,
}

/// Intervals of rates, where they are known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RateIntervals {
    /// Of TP / ND.
    pub precision: Option<Interval>,
    /// Of TP / NO.
    pub recall: Option<Interval>,
    /// Of 2 TP / (NO + ND).
    pub f_rate: Option<Interval>,
}

impl TaskTable {
    /// The kind of blocks that its intervals were drawn from; `None` if it has none.
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
/// Data sets and detectors are in the order of the manifest. Where there are several data sets of one origin, rows about all
/// of these follow. Recorded and simulated data sets are never put together.
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
            return Err(not_in_manifest("data set", dataset));
        }
        if !manifest.detectors.iter().any(|it| it.name == *detector) {
            return Err(not_in_manifest("detector", detector));
        }
        if !tasks.contains(task) && task.class().is_none() {
            tasks.push(*task);
        }
    }
    tasks.into_iter().map(|task| task_table(report, manifest, task)).collect()
}

fn not_in_manifest(what: &str, name: &str) -> TableError {
    TableError(format!("the report has the {what} {name:?}, but the manifest does not"))
}

fn task_table(report: &RunReport, manifest: &Manifest, task: Task) -> Result<TaskTable, TableError> {
    let is_about = |field: fn(&Subject) -> &str, name: &str| {
        report.rows().iter().any(|it| it.subject.task == task && field(&it.subject) == name)
    };
    let is_asked = |it: &&DetectorEntry| is_about(|subject| &subject.detector, &it.name);
    let of_task: Vec<&DetectorEntry> = manifest.detectors.iter().filter(is_asked).collect();
    let detectors: Vec<String> = of_task.iter().map(|it| it.name.clone()).collect();
    let entries = manifest.datasets.iter().filter(|it| is_about(|subject| &subject.dataset, &it.id));
    let row_of = |extent, origin, ids: &[String]| measured_row(report, extent, origin, ids, task, &of_task);
    let datasets = entries
        .map(|it| {
            let row = row_of(Extent::Dataset(it.id.clone()), it.origin(), std::slice::from_ref(&it.id))?;
            Ok((it, row))
        })
        .collect::<Result<Vec<_>, TableError>>()?;
    let pools = pools(datasets.iter().map(|(entry, row)| (entry.id.as_str(), row.origin)));
    let several = pools.into_iter().filter(Pool::is_of_several);
    let overall = several.map(|it| row_of(it.extent, it.origin, &it.datasets));
    let overall = overall.collect::<Result<Vec<_>, TableError>>()?;
    let published = PAPER_TABLES.iter().find(|it| it.task == task);
    let published_rows = published.map_or_else(Vec::new, |it| rows_beside(it, &datasets));
    let has_paper = detectors.iter().any(|it| it == PAPER_DETECTOR);
    let measured = datasets.into_iter().map(|(_, row)| row).chain(overall).map(TableRow::Measured);
    Ok(TaskTable {
        task,
        matching_criterion: manifest.matching_criterion.clone(),
        cpu_model: manifest.machine.cpu_model.clone(),
        rules: rules(manifest, &detectors),
        vehicles: vehicles(manifest, &detectors),
        foreign: foreign(manifest, &detectors),
        failures: failures(report, task, &detectors),
        detectors,
        paper: published.filter(|_| has_paper),
        lacks_paper: !has_paper && !published_rows.is_empty(),
        // Rows of a paper come after all of ours.
        rows: measured.chain(published_rows.into_iter().filter(|_| has_paper).map(TableRow::Paper)).collect(),
    })
}

/// The rules of `detectors` in the order in which these have them, each with the detectors that have it.
fn rules(manifest: &Manifest, detectors: &[String]) -> Vec<(String, Vec<String>)> {
    by_word(manifest, detectors, |it| it.rules.iter())
}

/// Vehicle classifiers of `detectors`, each with the names of those that have it.
fn vehicles(manifest: &Manifest, detectors: &[String]) -> Vec<(String, Vec<String>)> {
    by_word(manifest, detectors, |it| it.vehicles.iter())
}

/// The words that `words_of` gives for the entries of `detectors`, in this order, each with the names of those detectors.
fn by_word<'a, I: Iterator<Item = &'a String>>(
    manifest: &'a Manifest,
    detectors: &[String],
    words_of: impl Fn(&'a DetectorEntry) -> I,
) -> Vec<(String, Vec<String>)> {
    let mut words: Vec<(String, Vec<String>)> = Vec::new();
    for entry in manifest.detectors.iter().filter(|it| detectors.contains(&it.name)) {
        for word in words_of(entry) {
            match words.iter_mut().find(|(name, _)| name == word) {
                Some((_, names)) => names.push(entry.name.clone()),
                None => words.push((word.clone(), vec![entry.name.clone()])),
            }
        }
    }
    words
}

/// Those of `detectors` that are not built in, with where their results were read.
fn foreign(manifest: &Manifest, detectors: &[String]) -> Vec<(String, Option<String>)> {
    let entries = manifest.detectors.iter().filter(|it| detectors.contains(&it.name));
    entries.filter_map(|it| Some((it.name.clone(), it.foreign.as_ref()?.results.clone()))).collect()
}

/// Those of `detectors` that gave no answer to some scans of all data sets.
fn failures(report: &RunReport, task: Task, detectors: &[String]) -> Vec<(String, [u64; 2])> {
    let of_detector = |it: &String| Some((it.clone(), report.failed_scans(|_| true, task, it)?));
    detectors.iter().filter_map(of_detector).collect()
}

/// The rows of `paper` whose recordings a data set is to be compared with, and its last one beside several.
fn rows_beside(
    paper: &'static PaperTable,
    datasets: &[(&DatasetEntry, MeasuredRow)],
) -> Vec<&'static PaperRow> {
    let counterparts: Vec<Recordings> = datasets.iter().filter_map(|(entry, _)| counterpart(entry)).collect();
    let is_beside = |it: &&PaperRow| match it.recordings {
        Recordings::Both => counterparts.len() > 1,
        recordings => counterparts.contains(&recordings),
    };
    paper.rows.iter().filter(is_beside).collect()
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

/// The row of `extent`, which is about the data sets with these `ids`.
fn measured_row(
    report: &RunReport,
    extent: Extent,
    origin: Origin,
    ids: &[String],
    task: Task,
    detectors: &[&DetectorEntry],
) -> Result<MeasuredRow, TableError> {
    let score_of = |detector: &&DetectorEntry| {
        let on_busy_machine = ids.iter().any(|it| share_on_busy_machine(report, it, detector).is_some());
        Ok(Score { on_busy_machine, ..score(report, extent.name(), task, detector)? })
    };
    let scores = detectors.iter().map(score_of).collect::<Result<Vec<_>, _>>()?;
    // A task in the report has at least one row, which has a detector.
    let no = scores[0].counts.no();
    if let Some(other) = scores.iter().position(|it| it.counts.no() != no) {
        let (dataset, first, second) = (extent.name(), &detectors[0].name, &detectors[other].name);
        let n_second = scores[other].counts.no();
        return Err(TableError(format!(
            "on {dataset}, {first} has {no} annotations that count, but {second} has {n_second}"
        )));
    }
    Ok(MeasuredRow { extent, origin, no, scores })
}

fn rate_intervals(report: &RunReport, subject: &Subject) -> RateIntervals {
    let interval = |metric| report.row(subject, &metric).and_then(MetricRow::interval);
    RateIntervals {
        precision: interval(Metric::Precision),
        recall: interval(Metric::Recall),
        f_rate: interval(Metric::FRate),
    }
}

/// The numbers of one data set, or of several, in a task by a detector.
fn score(
    report: &RunReport,
    extent: &str,
    task: Task,
    detector: &DetectorEntry,
) -> Result<Score, TableError> {
    let subject = Subject::of_all(extent, task, &detector.name);
    let what =
        |metric: Metric| format!("{} of {} on {extent} in the task {task}", metric.id(), detector.name);
    let row = |metric: Metric| {
        let found = report.row(&subject, &metric);
        found.ok_or_else(|| TableError(format!("the report has no {}", what(metric))))
    };
    let bad = |metric: Metric, value: Option<f64>| {
        TableError(format!("{} is {value:?}, which is not a count", what(metric)))
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
    if let Some(value) = fps.value().filter(|it| *it <= 0.0) {
        return Err(bad(Metric::FpsMean, Some(value)));
    }
    Ok(Score {
        n_scans: row(Metric::No)?.n,
        counts,
        intervals: rate_intervals(report, &subject),
        n_ignored_annotations: known_count(Metric::IgnoredAnnotations)?,
        n_ignored_detections: known_count(Metric::IgnoredDetections)?,
        n_timed_scans: fps.value().map_or(0, |_| fps.n),
        fps: fps.value(),
        on_busy_machine: false,
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
    fn without_their_own_method_the_papers_are_left_out() {
        let mut manifest = sample::manifest();
        let others = sample::report_where(|it| it.subject.detector != PAPER_DETECTOR);
        for table in tables(&others, &manifest).unwrap() {
            assert_eq!(table.paper, None);
            assert_eq!(names(&table), ["main_road", "kitti_tracking", "kitti_object", "OVERALL"]);
            assert!(table.lacks_paper);
        }
        // Nothing is published about scans like these.
        manifest.datasets.iter_mut().for_each(|it| it.format = "folder".to_owned());
        let of_others = |it: &Subject| it.detector != PAPER_DETECTOR && it.dataset != "main_road";
        let others = sample::report_where(|it| of_others(&it.subject));
        assert!(tables(&others, &manifest).unwrap().iter().all(|it| !it.lacks_paper));
    }

    #[test]
    fn nothing_published_stands_beside_a_detector_of_which_there_is_no_paper() {
        let is_of =
            |name: &str| PAPER_TABLES.iter().any(|it| it.methods.iter().any(|it| it.detector == name));
        assert_eq!([PAPER_DETECTOR, "kd-tree", "pca", "hierarchical"].map(is_of), [true, true, true, false]);
    }

    #[test]
    fn one_data_set_has_no_overall_row() {
        let one = sample::report_where(|it| it.subject.dataset == "kitti_object");
        let table = &tables(&one, &sample::manifest()).unwrap()[0];
        assert_eq!(names(table), ["kitti_object", "KITTI"]);
    }

    #[test]
    fn the_overall_row_is_that_of_the_report() {
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
        // The simulated one stands alone.
        assert_eq!(overall.extent, Extent::OverallOf(Origin::Recorded));
        let datasets: Vec<_> = datasets.iter().filter(|it| it.origin == Origin::Recorded).collect();
        assert_eq!(datasets.len(), 2);
        let sum = |of: fn(&Score) -> f64| datasets.iter().map(|it| of(&it.scores[0])).sum::<f64>();
        let score = overall.scores[0];
        let f_rate = 2.0 * sum(|it| it.counts.tp() as f64)
            / sum(|it| (it.counts.no() + it.counts.nd().unwrap()) as f64);
        assert_eq!(score.counts.f_rate(), Some(f_rate));
        let total_s = sum(|it| it.fps.map_or(0.0, |fps| it.n_timed_scans as f64 / fps));
        assert_eq!(score.fps, Some(sum(|it| it.n_timed_scans as f64) / total_s));
    }

    #[test]
    fn false_objects_unknown_on_one_data_set_are_unknown_overall() {
        let objects = &tables(&sample::report(), &sample::manifest()).unwrap()[0];
        let overall = objects.rows.iter().find_map(|it| match it {
            TableRow::Measured(row) if row.extent.is_overall() => Some(row),
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
    fn a_report_that_does_not_fit_the_manifest_or_itself_is_an_error() {
        let mut manifest = sample::manifest();
        manifest.datasets.remove(1);
        let expected = "the report has the data set \"kitti_tracking\", but the manifest does not";
        check_refused(&sample::report(), &manifest, expected);
        let mut manifest = sample::manifest();
        manifest.detectors.remove(1);
        let expected = "the report has the detector \"kd-tree\", but the manifest does not";
        check_refused(&sample::report(), &manifest, expected);
        let manifest = sample::manifest();
        let report = sample::report_where(|it| {
            it.metric != Metric::Fo || it.subject.detector != "pca" || it.subject.dataset != "main_road"
        });
        check_refused(&report, &manifest, "the report has no fo of pca on main_road in the task objects");
        let report = sample::report_with("kitti_object", "pca", &Metric::No, Some(99.0));
        let expected = "on kitti_object, paper has 61 annotations that count, but pca has 99";
        check_refused(&report, &manifest, expected);
        // A part of an object, and more matches than annotations.
        for (tp, said) in [(2.5, "2.5"), (1e6, "1000000.0")] {
            let report = sample::report_with("main_road", "pca", &Metric::Tp, Some(tp));
            let what = "tp of pca on main_road in the task objects";
            check_refused(&report, &manifest, &format!("{what} is Some({said}), which is not a count"));
        }
    }
}
