//! A small run that the tests of the tables share: three detectors on a simulated street and two KITTI data sets.

use crate::files::archive::SCHEMA;
use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
use crate::numbers::pools::pools;
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::rows::counts::Counts;
use crate::run_folder::manifest::{
    AnnotatedClasses, DatasetEntry, DetectorEntry, IgnoreRule, Machine, Manifest,
};
use crate::tables::task_table::{TaskTable, task_tables};
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

pub(crate) const DATASETS: [&str; 3] = ["main_road", "kitti_tracking", "kitti_object"];

pub(crate) fn manifest() -> Manifest {
    Manifest {
        schema: SCHEMA,
        scoring_version: 1,
        scanbench_version: "0.1.0".to_owned(),
        created: "2026-03-02T09:30:00Z".to_owned(),
        n_warmup_detections: 1,
        n_repeats: 1,
        matching_criterion: "points, IoU at least 0.5".to_owned(),
        ignored: IgnoreRule { min_points: 20, max_range_m: 80.0 },
        datasets: DATASETS.map(dataset).to_vec(),
        detectors: ["paper", "kd-tree", "pca"].map(detector).to_vec(),
        rustc_version: "1.95.0".to_owned(),
        machine: Machine { cpu_model: "Example CPU @ 2 GHz".to_owned(), n_cores: 2, os: "linux".to_owned() },
        ..Manifest::default()
    }
}

pub(crate) fn detector(name: &str) -> DetectorEntry {
    DetectorEntry { name: name.to_owned(), ..DetectorEntry::default() }
}

fn dataset(id: &str) -> DatasetEntry {
    let simulated = id == "main_road";
    let only_cars = AnnotatedClasses::Only(vec![AnnotationClass::Car]);
    DatasetEntry {
        id: id.to_owned(),
        format: if simulated { "simulated" } else { "kitti-tracking" }.to_owned(),
        simulated,
        annotated: if simulated { AnnotatedClasses::EveryObject } else { only_cars },
        n_scans: 20,
        sensor_height_m: 1.73,
        sensor: "hdl-64e-s2".to_owned(),
        ..DatasetEntry::default()
    }
}

/// Data set, task, detector, NO, TP, FO, scans per second.
type Numbers = (&'static str, Task, &'static str, u64, u64, Option<u64>, Option<f64>);

const NUMBERS: [Numbers; 18] = [
    ("main_road", Task::Objects, "paper", 412, 371, Some(52), Some(121.3)),
    ("main_road", Task::Objects, "kd-tree", 412, 340, Some(140), Some(8.04)),
    ("main_road", Task::Objects, "pca", 412, 318, Some(97), Some(46.0)),
    ("kitti_tracking", Task::Objects, "paper", 318, 290, None, Some(98.2)),
    ("kitti_tracking", Task::Objects, "kd-tree", 318, 271, None, Some(0.471)),
    ("kitti_tracking", Task::Objects, "pca", 318, 204, None, Some(39.9)),
    ("kitti_object", Task::Objects, "paper", 61, 55, None, Some(104.0)),
    ("kitti_object", Task::Objects, "kd-tree", 61, 61, None, Some(0.5)),
    ("kitti_object", Task::Objects, "pca", 61, 40, None, Some(41.0)),
    ("main_road", Task::Vehicles, "paper", 190, 181, Some(8), Some(121.3)),
    ("main_road", Task::Vehicles, "kd-tree", 190, 170, Some(44), Some(8.04)),
    ("main_road", Task::Vehicles, "pca", 190, 190, Some(0), Some(46.0)),
    ("kitti_tracking", Task::Vehicles, "paper", 240, 211, Some(33), Some(98.2)),
    ("kitti_tracking", Task::Vehicles, "kd-tree", 240, 199, Some(1040), Some(0.471)),
    ("kitti_tracking", Task::Vehicles, "pca", 240, 150, Some(29), Some(39.9)),
    ("kitti_object", Task::Vehicles, "paper", 0, 0, Some(0), None),
    ("kitti_object", Task::Vehicles, "kd-tree", 0, 0, Some(3), None),
    ("kitti_object", Task::Vehicles, "pca", 0, 0, Some(0), Some(41.0)),
];

fn rows() -> Vec<MetricRow> {
    let rows = NUMBERS.into_iter().flat_map(|(dataset, task, detector, no, tp, fo, fps)| {
        let subject = Subject::of_all(dataset, task, detector);
        let counts = Counts::new(no, tp, fo).unwrap();
        let n_scans = 20;
        [
            (Metric::No, Some(no as f64), n_scans),
            (Metric::Tp, Some(tp as f64), n_scans),
            (Metric::Mo, Some(counts.mo() as f64), n_scans),
            (Metric::Fo, fo.map(|it| it as f64), n_scans),
            (Metric::FRate, counts.f_rate(), no + counts.nd().unwrap_or(0)),
            (Metric::IgnoredAnnotations, Some(17.0), n_scans),
            (Metric::IgnoredDetections, Some(230.0), n_scans),
            (Metric::FpsMean, fps, n_scans - 1),
        ]
        .map(|(metric, value, n)| {
            // The vehicles come without intervals, as from a single block of scans.
            let has_interval = metric == Metric::FRate && subject.task == Task::Objects;
            let interval = value.filter(|_| has_interval).map(interval_around);
            MetricRow::new(subject.clone(), metric, value, n).within(interval)
        })
    });
    rows.collect()
}

fn interval_around(rate: f64) -> Interval {
    let blocks = BlockCount::of_dataset(20, BlockKind::Drives);
    Interval { ends: [rate - 0.0251, rate + 0.0149], blocks }
}

pub(crate) fn report() -> RunReport {
    report_where(|_| true)
}

pub(crate) fn report_where(is_kept: impl Fn(&MetricRow) -> bool) -> RunReport {
    with_overall(rows().into_iter().filter(|it| is_kept(it)).collect())
}

/// The report with `value` in the first row about this data set, detector and metric.
pub(crate) fn report_with(dataset: &str, detector: &str, metric: &Metric, value: Option<f64>) -> RunReport {
    let mut rows = rows();
    let row = rows
        .iter_mut()
        .find(|it| it.subject.dataset == dataset && it.subject.detector == detector && it.metric == *metric);
    let row = row.unwrap();
    *row = MetricRow::new(row.subject.clone(), metric.clone(), value, row.n);
    with_overall(rows)
}

/// The report of these rows and of their sums over data sets of one origin.
fn with_overall(rows: Vec<MetricRow>) -> RunReport {
    let mut ids: Vec<&str> = rows.iter().map(|it| it.subject.dataset.as_str()).collect();
    ids.dedup();
    let origin = |id: &str| if id == "main_road" { Origin::Simulated } else { Origin::Recorded };
    let pools = pools(DATASETS.into_iter().filter(|it| ids.contains(it)).map(|it| (it, origin(it))));
    let mut overall: Vec<MetricRow> = Vec::new();
    for pool in pools.iter().filter(|it| it.is_of_several()) {
        for row in
            rows.iter().filter(|it| it.metric != Metric::FRate && pool.datasets[0] == it.subject.dataset)
        {
            let is_of_same = |it: &&MetricRow| {
                let (subject, other) = (&it.subject, &row.subject);
                it.metric == row.metric
                    && (subject.task, &subject.detector) == (other.task, &other.detector)
                    && pool.datasets.contains(&subject.dataset)
            };
            let same: Vec<&MetricRow> = rows.iter().filter(is_of_same).collect();
            let (mut value, mut n) =
                (same.iter().map(|it| it.value()).sum(), same.iter().map(|it| it.n).sum());
            if row.metric == Metric::FpsMean {
                let timed = || same.iter().filter_map(|it| Some((it.n, it.value()?)));
                n = timed().map(|it| it.0).sum();
                let total_s: f64 = timed().map(|(n, fps)| n as f64 / fps).sum();
                value = (n > 0).then(|| n as f64 / total_s);
            }
            let subject = Subject::of_all(pool.extent.name(), row.subject.task, &row.subject.detector);
            overall.push(MetricRow::new(subject, row.metric.clone(), value, n));
        }
    }
    RunReport::with_overall(1, rows, overall).unwrap()
}

/// The table of objects and the table of vehicles.
pub(crate) fn tables() -> [TaskTable; 2] {
    task_tables(&report(), &manifest()).unwrap().try_into().unwrap()
}
