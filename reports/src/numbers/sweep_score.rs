//! Scores and times of detectors at the points of a sweep: `sweep.csv` and `times.csv`.

use crate::files::csv_rows::csv_of_cells;
use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::BlockCount;
use crate::rows::counts::Counts;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// The columns of times, after those of the subject.
const TIME_COLUMNS: [&str; 7] =
    ["n_scans", "n_detections", "p50_of_shortest_ms", "min_ms", "p50_ms", "p90_ms", "max_ms"];

/// All numbers of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepScores {
    /// Full names of the parameters that differ from point to point: first the axis of plots, then the other swept ones,
    /// then those that are tied to these.
    pub parameters: Vec<String>,
    /// Number of these that are swept.
    pub n_swept: usize,
    /// The configured value of the first parameter, which it has without a sweep.
    pub configured: Option<String>,
    /// Data set by data set and then overall, within these detector by detector, task by task, point by point.
    pub scores: Vec<SweepScore>,
    /// Times in the order of the scores, without the tasks.
    pub times: Vec<SweepTime>,
}

/// Subject of a score or a time: the point of the sweep, the scans and the detector.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepSubject {
    // First, because subjects are compared: most differ in it.
    /// Index of the point in the sweep.
    pub point_idx: usize,
    /// Data set, or several together.
    pub extent: Extent,
    /// Where the scans come from.
    pub origin: Origin,
    /// The sensor; several joined by `+`.
    pub sensor: String,
    /// The detector.
    pub detector: String,
    /// The values of [`SweepScores::parameters`].
    pub values: Vec<String>,
}

/// Score of a detector at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepScore {
    /// Point, scans and detector.
    pub subject: SweepSubject,
    /// The task.
    pub task: Task,
    /// Number of scans.
    pub n_scans: u64,
    /// The blocks of scans from which intervals are estimated.
    pub blocks: BlockCount,
    /// Counts of found, missed and false objects.
    pub counts: Counts,
    /// 95 % interval of the F-rate.
    pub f_rate_within: Option<[f64; 2]>,
    /// 95 % interval of the recall.
    pub recall_within: Option<[f64; 2]>,
    /// The cells of the detector's grid, if it starts from one.
    pub cells: Option<CellScore>,
}

/// Fitness of the cells of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct CellScore {
    /// Side of a cell in metres.
    pub cell_size_m: f64,
    /// Dense, sparse and empty cells, summed over the scans.
    pub n_dense_sparse_empty: [u64; 3],
    /// The readings of the fitness.
    pub readings: Vec<FitnessValue>,
}

/// One reading of the fitness.
#[derive(Debug, Clone, PartialEq)]
pub struct FitnessValue {
    /// Its name.
    pub name: &'static str,
    /// Its value, of sums over the scans; `None` if it is undefined.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub within: Option<[f64; 2]>,
    /// Ends that the value has to lie within; `None` if it has no bounds.
    pub range: Option<[f64; 2]>,
}

/// Times of a detector at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepTime {
    /// Point, scans and detector.
    pub subject: SweepSubject,
    /// Number of scans that were timed.
    pub n_scans: u64,
    /// Number of detections in these scans.
    pub n_detections: u64,
    /// Median over the scans of the shortest time of each, in milliseconds: the time least disturbed by other programs on
    /// the machine.
    pub typical_ms: f64,
    /// Shortest time in milliseconds.
    pub min_ms: f64,
    /// Median time in milliseconds.
    pub p50_ms: f64,
    /// 90th percentile of the times, in milliseconds.
    pub p90_ms: f64,
    /// Longest time in milliseconds.
    pub max_ms: f64,
}

impl FitnessValue {
    /// The value; `None` if it is undefined or out of [`Self::range`].
    pub fn in_range(&self) -> Option<f64> {
        let is_within = |value: &f64| self.range.is_none_or(|[low, high]| (low..=high).contains(value));
        self.value.filter(is_within)
    }

    /// Whether the value is undefined, in range or out of range, as `sweep.csv` names it.
    fn state(&self) -> &'static str {
        match (self.value, self.in_range()) {
            (None, _) => "undefined",
            (_, None) => "out of range",
            _ => "in range",
        }
    }
}

impl SweepScore {
    /// The F-rate, or the recall if false objects are unknown. `None` without annotations.
    pub fn rate(&self) -> Option<f64> {
        match self.counts.fo() {
            Some(_) => self.counts.drawn(Counts::f_rate),
            None => self.counts.recall(),
        }
    }

    /// The 95 % interval of [`Self::rate`].
    pub fn rate_within(&self) -> Option<[f64; 2]> {
        if self.counts.fo().is_some() { self.f_rate_within } else { self.recall_within }
    }

    /// Metric of [`Self::rate`].
    pub fn rate_metric(&self) -> Metric {
        if self.counts.fo().is_some() { Metric::FRate } else { Metric::Recall }
    }

    /// Name of [`Self::rate`].
    pub fn rate_name(&self) -> &'static str {
        if self.counts.fo().is_some() { "F-rate" } else { "recall" }
    }
}

impl SweepScores {
    /// The content of `sweep.csv`: the same sweep gives the same bytes.
    pub fn to_csv(&self) -> Vec<u8> {
        let mut columns = subject_columns(&self.parameters);
        columns.extend(texts(["task", "n_scans", "n_blocks", "blocks", "few_blocks"]));
        columns.extend(texts(["no", "tp", "mo", "fo", "nd", "precision"]));
        columns.extend(["recall", "f_rate"].into_iter().flat_map(with_interval));
        columns.extend(texts(["n_dense", "n_sparse", "n_empty", "fitness_cell_size_m"]));
        let with_cells = self.scores.iter().find_map(|it| it.cells.as_ref());
        let readings: Vec<&FitnessValue> = with_cells.iter().flat_map(|it| &it.readings).collect();
        for reading in &readings {
            let name = format!("fitness_{}", reading.name.replace('-', "_"));
            columns.push(format!("{name}_state"));
            columns.extend(with_interval(&name));
        }
        csv_of_cells(columns, self.scores.iter().map(|it| it.cells_of_row(readings.len())))
    }

    /// The content of `times.csv`.
    pub fn times_to_csv(&self) -> Vec<u8> {
        let mut columns = subject_columns(&self.parameters);
        columns.extend(texts(TIME_COLUMNS));
        csv_of_cells(columns, self.times.iter().map(SweepTime::cells_of_row))
    }

    /// The content of `times_of_processors.csv`: times on each of `unlike` processors.
    pub fn times_of_processors_to_csv(&self, unlike: &[(String, Vec<SweepTime>)]) -> Vec<u8> {
        let mut columns = vec!["processor".to_owned()];
        columns.extend(subject_columns(&self.parameters));
        columns.extend(texts(TIME_COLUMNS));
        let rows = unlike.iter().flat_map(|(processor, times)| {
            times.iter().map(|it| [vec![processor.clone()], it.cells_of_row()].concat())
        });
        csv_of_cells(columns, rows)
    }
}

impl SweepTime {
    fn cells_of_row(&self) -> Vec<String> {
        let mut row = self.subject.cells_of_row();
        row.extend([self.n_scans, self.n_detections].map(|it| it.to_string()));
        let times_ms = [self.typical_ms, self.min_ms, self.p50_ms, self.p90_ms, self.max_ms];
        row.extend(times_ms.map(|it| fixed_decimals(it, 4)));
        row
    }
}

/// The columns of a [`SweepSubject`] in a sweep of `parameters`.
pub(crate) fn subject_columns(parameters: &[String]) -> Vec<String> {
    let mut columns = vec!["point".to_owned()];
    columns.extend(parameters.iter().cloned());
    columns.extend(texts(["dataset", "origin", "sensor", "detector"]));
    columns
}

impl SweepSubject {
    /// The cells of the subject, in the order of [`subject_columns`].
    pub(crate) fn cells_of_row(&self) -> Vec<String> {
        let mut row = vec![self.point_idx.to_string()];
        row.extend(self.values.iter().cloned());
        row.extend(texts([self.extent.name(), self.origin.name(), &self.sensor, &self.detector]));
        row
    }
}

impl SweepScore {
    fn cells_of_row(&self, n_readings: usize) -> Vec<String> {
        let counts = self.counts;
        let whole = |it: Option<u64>| it.map(|it| it.to_string()).unwrap_or_default();
        let mut row = self.subject.cells_of_row();
        row.push(self.task.name().to_owned());
        row.extend([self.n_scans, self.blocks.n_blocks].map(|it| it.to_string()));
        row.extend([self.blocks.kind.name().to_owned(), self.blocks.decide_nothing().to_string()]);
        let counted = [Some(counts.no()), Some(counts.tp()), Some(counts.mo()), counts.fo(), counts.nd()];
        row.extend(counted.map(whole));
        row.push(rate(counts.precision(), 6));
        row.extend(rate_with_interval(counts.recall(), self.recall_within, 6));
        row.extend(rate_with_interval(counts.f_rate(), self.f_rate_within, 6));
        match &self.cells {
            Some(cells) => {
                row.extend(cells.n_dense_sparse_empty.map(|it| it.to_string()));
                row.push(format!("{}", cells.cell_size_m));
                for reading in &cells.readings {
                    row.push(reading.state().to_owned());
                    row.extend(rate_with_interval(reading.value, reading.within, 8));
                }
            }
            None => row.extend(vec![String::new(); 4 + 4 * n_readings]),
        }
        row
    }
}

fn texts<const N: usize>(names: [&str; N]) -> [String; N] {
    names.map(str::to_owned)
}

fn with_interval(name: &str) -> [String; 3] {
    ["", "_low", "_high"].map(|it| format!("{name}{it}"))
}

fn rate(value: Option<f64>, decimals: usize) -> String {
    value.map(|it| fixed_decimals(it, decimals)).unwrap_or_default()
}

fn rate_with_interval(value: Option<f64>, within: Option<[f64; 2]>, decimals: usize) -> [String; 3] {
    [value, within.map(|it| it[0]), within.map(|it| it[1])].map(|it| rate(it, decimals))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::numbers::blocks::BlockKind;

    fn subject(values: &[&str], point_idx: usize, dataset: &str) -> SweepSubject {
        SweepSubject {
            extent: Extent::Dataset(dataset.to_owned()),
            origin: Origin::Simulated,
            sensor: "vlp-16".to_owned(),
            detector: "hierarchical".to_owned(),
            point_idx,
            values: values.iter().map(|it| (*it).to_owned()).collect(),
        }
    }

    /// TP, FO, and two readings.
    type Found = (u64, Option<u64>, Option<f64>, f64);

    pub(crate) fn street() -> Extent {
        Extent::Dataset("street".to_owned())
    }

    /// A sweep of the cell size over 0.2, 0.4 and so on, with the numbers that were found of ten annotations and false, and
    /// with a printed fitness and a share at each.
    pub(crate) fn cell_sizes(found: &[Found]) -> SweepScores {
        let score = |(point_idx, &(tp, fo, printed, share)): (usize, &Found)| {
            let size_m = format!("{:.1}", 0.2 * (point_idx + 1) as f64);
            let reading = |name, value: Option<f64>| FitnessValue {
                name,
                value,
                within: value.map(|it| [it - 0.01, it + 0.01]),
                range: Some([0.0, 1.0]),
            };
            SweepScore {
                cells: Some(CellScore {
                    cell_size_m: size_m.parse().unwrap(),
                    n_dense_sparse_empty: [3, 4, 5],
                    readings: vec![reading("printed", printed), reading("dense-share", Some(share))],
                }),
                subject: subject(&[&size_m], point_idx, "street"),
                task: Task::Objects,
                n_scans: 2,
                blocks: BlockCount::of_dataset(2, BlockKind::Seconds),
                counts: Counts::new(10, tp, fo).unwrap(),
                f_rate_within: fo.map(|_| [0.1, 0.9]),
                recall_within: Some([0.2, 0.8]),
            }
        };
        let scores: Vec<SweepScore> = found.iter().enumerate().map(score).collect();
        let time = |it: &SweepScore| SweepTime {
            subject: it.subject.clone(),
            n_scans: 1,
            n_detections: 3,
            typical_ms: 2.2 + it.subject.point_idx as f64,
            min_ms: 2.0 + it.subject.point_idx as f64,
            p50_ms: 2.5 + it.subject.point_idx as f64,
            p90_ms: 3.0,
            max_ms: 3.5,
        };
        let parameters = vec!["hierarchical.grid.cell_size_m".to_owned()];
        SweepScores {
            parameters,
            n_swept: 1,
            configured: Some("0.40".to_owned()),
            times: scores.iter().map(time).collect(),
            scores,
        }
    }

    /// Four sizes, of which the second is best; the printed fitness has a pole between it and the third.
    pub(crate) fn four_cell_sizes() -> SweepScores {
        cell_sizes(&[
            (4, Some(6), Some(-0.1), 0.1),
            (8, Some(2), Some(-0.4), 0.3),
            (6, Some(4), Some(3.0), 0.4),
            (5, Some(5), Some(0.9), 0.2),
        ])
    }

    #[test]
    fn rows_stand_alone_and_say_what_is_undefined() {
        let sweep = cell_sizes(&[(5, Some(5), Some(-0.5), 0.25), (8, None, None, 0.5)]);
        insta::assert_snapshot!(String::from_utf8(sweep.to_csv()).unwrap(), @r"
        point,hierarchical.grid.cell_size_m,dataset,origin,sensor,detector,task,n_scans,n_blocks,blocks,few_blocks,no,tp,mo,fo,nd,precision,recall,recall_low,recall_high,f_rate,f_rate_low,f_rate_high,n_dense,n_sparse,n_empty,fitness_cell_size_m,fitness_printed_state,fitness_printed,fitness_printed_low,fitness_printed_high,fitness_dense_share_state,fitness_dense_share,fitness_dense_share_low,fitness_dense_share_high
        0,0.2,street,simulated,vlp-16,hierarchical,objects,2,2,seconds,true,10,5,5,5,10,0.500000,0.500000,0.200000,0.800000,0.500000,0.100000,0.900000,3,4,5,0.2,out of range,-0.50000000,-0.51000000,-0.49000000,in range,0.25000000,0.24000000,0.26000000
        1,0.4,street,simulated,vlp-16,hierarchical,objects,2,2,seconds,true,10,8,2,,,,0.800000,0.200000,0.800000,,,,3,4,5,0.4,undefined,,,,in range,0.50000000,0.49000000,0.51000000
        ");
        insta::assert_snapshot!(String::from_utf8(sweep.times_to_csv()).unwrap(), @r"
        point,hierarchical.grid.cell_size_m,dataset,origin,sensor,detector,n_scans,n_detections,p50_of_shortest_ms,min_ms,p50_ms,p90_ms,max_ms
        0,0.2,street,simulated,vlp-16,hierarchical,1,3,2.2000,2.0000,2.5000,3.0000,3.5000
        1,0.4,street,simulated,vlp-16,hierarchical,1,3,3.2000,3.0000,3.5000,3.0000,3.5000
        ");
    }
}
