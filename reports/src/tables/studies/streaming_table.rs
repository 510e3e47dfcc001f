//! Detectors on drives: scored per scan, and as they stream. Two tables, and `streaming.csv` with a row for every number.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::{Fixed, decimals_or_dash, fixed_decimals, percent_or_dash};
use crate::rows::counts::Counts;
use crate::streaming::machine_speed::MachineSpeed;
use crate::streaming::streamed::{Streamed, headline};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{INTERVAL_TITLE, about_interval};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::tables::task_grids::{extent_cell, interval_cell};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::forecast::Forecast;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// The numbers of a study, with what they rest on.
#[derive(Debug, Clone, Copy)]
pub struct StreamingTable<'a> {
    /// The numbers.
    pub streamed: &'a [Streamed],
    /// How boxes were matched, such as `centres closer than 2 m`.
    pub matched_by: &'a str,
    /// What else a reader has to know.
    pub notes: &'a [String],
}

impl Tabular for StreamingTable<'_> {
    fn sheet(&self) -> Sheet {
        let mut parts = Vec::new();
        for of_task in self.of_tasks() {
            let task = of_task[0].task;
            let title = format!("Task {task}, streaming. Rates in %. Matched by {}.", self.matched_by);
            parts.push(Part { title: Some(title), grid: rates(&of_task) });
            let slices = slices(&of_task);
            if !slices.lines.is_empty() {
                let title = format!(
                    "Task {task}: recall in % by speed over ground and by range, per scan → as it streams."
                );
                parts.push(Part { title: Some(title), grid: slices });
            }
        }
        let mut sentences = vec![
            "scans: each answer judged where things were when its scan was taken. streams: at every moment the newest answer, \
             moved on by the car's motion, judged where things are then."
                .to_owned(),
            "held: the same, not moved at all. tracked: moved on with the velocity of a small tracker. truth: what a detector \
             would reach that finds exactly the labels and is as late."
                .to_owned(),
            "P, R, AP: precision, recall and average precision as it streams. age: of what is known, median and 95th percentile. \
             dropped: scans that came while the detector was busy."
                .to_owned(),
        ];
        if self.streamed.iter().any(|it| it.streamed.fo().is_none()) {
            sentences.push("Where false detections are unknown, rates are recalls.".to_owned());
        }
        sentences.extend(self.notes.iter().cloned());
        let kind = self.streamed.iter().find_map(|it| it.within.map(|it| it.blocks.kind));
        sentences.extend(kind.map(|it| format!("{INTERVAL_TITLE}: {}", about_interval(it))));
        Sheet::of_parts(parts, sentences).labelled("streaming")
    }
}

impl StreamingTable<'_> {
    /// The numbers of each task.
    fn of_tasks(&self) -> Vec<Vec<&Streamed>> {
        let mut tasks: Vec<Vec<&Streamed>> = Vec::new();
        for it in self.streamed {
            match tasks.iter_mut().find(|of_task| of_task[0].task == it.task) {
                Some(of_task) => of_task.push(it),
                None => tasks.push(vec![it]),
            }
        }
        tasks
    }
}

fn percent(counts: Option<Counts>) -> String {
    percent_or_dash(counts.and_then(headline))
}

fn rates(of_task: &[&Streamed]) -> Grid {
    let is_known = of_task.iter().any(|it| it.streamed.fo().is_some());
    let rate = if is_known { "F-rate" } else { "recall" };
    let mut columns = vec![Column::left("data set"), Column::left("detector"), Column::number("ms")];
    columns.extend(["scans", "streams"].map(|it| Column::number(it).within(rate)));
    columns.push(Column::left(INTERVAL_TITLE).within(rate));
    columns.extend(["held", "tracked", "truth"].map(|it| Column::number(it).within(rate)));
    let has_ap = of_task.iter().any(|it| it.average_precision.is_some());
    let more = ["P", "R", "AP"].into_iter().filter(|it| match *it {
        "AP" => has_ap,
        "P" => is_known,
        _ => is_known,
    });
    let more: Vec<&str> = more.collect();
    columns.extend(more.iter().map(|it| Column::number(*it)));
    columns.extend(["p50", "p95"].map(|it| Column::number(it).within("age [ms]")));
    columns.push(Column::number("dropped"));
    let mut before: Option<&Extent> = None;
    let lines = of_task.iter().map(|it| {
        let is_first = before != Some(&it.extent);
        before = Some(&it.extent);
        let label = if is_first { extent_cell(&it.extent, it.origin) } else { Cell::default() };
        let kind = if is_first { LineKind::of(&it.extent) } else { LineKind::Detail };
        let ages = it.ages_ms();
        let age = |idx: usize| Cell::new(decimals_or_dash(ages.map(|it| it[idx]), 0));
        let mut cells =
            vec![label, Cell::new(&*it.detector), Cell::new(decimals_or_dash(it.latency_ms(), 1))];
        cells.extend([it.per_scan, it.streamed].map(|it| Cell::new(percent(Some(it)))));
        cells.push(interval_cell(it.within));
        let others =
            [it.forecast(Forecast::Hold), it.forecast(Forecast::ConstantVelocity), it.sums.late_truth];
        cells.extend(others.map(|it| Cell::new(percent(it))));
        cells.extend(more.iter().map(|name| {
            Cell::new(percent_or_dash(match *name {
                "P" => it.streamed.precision(),
                "R" => it.streamed.recall(),
                _ => it.average_precision,
            }))
        }));
        cells.extend([age(0), age(1), Cell::new(percent_or_dash(it.dropped()))]);
        Line { kind, cells }
    });
    let lines = lines.collect();
    Grid { columns, lines }
}

/// Recall by speed and range of each detector, on all data sets of one origin together.
fn slices(of_task: &[&Streamed]) -> Grid {
    let has_several = of_task.iter().any(|it| it.extent.is_overall());
    let shown: Vec<&&Streamed> = of_task.iter().filter(|it| !has_several || it.extent.is_overall()).collect();
    let mut names: Vec<Slice> = shown.iter().flat_map(|it| it.slices.iter().map(|it| it.slice)).collect();
    let is_speed = |it: &Slice| matches!(it, Slice::Speed(_));
    names.sort_by(|a, b| is_speed(b).cmp(&is_speed(a)).then(a.cmp(b)));
    names.dedup();
    if names.is_empty() {
        return Grid { columns: Vec::new(), lines: Vec::new() };
    }
    let column = |it: &Slice| {
        let name = it.name();
        let (group, bin) = name.split_once('/').unwrap_or(("", &name));
        let unit = if group == "speed" { "m/s" } else { "m" };
        Column::left(bin.to_owned()).within(format!("{group} [{unit}]"))
    };
    let mut columns = vec![Column::left("data set"), Column::left("detector")];
    columns.extend(names.iter().map(column));
    let mut before: Option<&Extent> = None;
    let lines = shown.iter().map(|it| {
        let is_first = before != Some(&it.extent);
        before = Some(&it.extent);
        let label = if is_first { extent_cell(&it.extent, it.origin) } else { Cell::default() };
        let mut cells = vec![label, Cell::new(&*it.detector)];
        cells.extend(names.iter().map(|name| {
            let found = it.slices.iter().find(|it| it.slice == *name);
            Cell::new(found.map_or_else(
                || "–".to_owned(),
                |it| {
                    format!(
                        "{} → {}",
                        percent_or_dash(it.per_scan.recall()),
                        percent_or_dash(it.streamed.recall())
                    )
                },
            ))
        }));
        Line { kind: if is_first { LineKind::of(&it.extent) } else { LineKind::Detail }, cells }
    });
    let lines = lines.collect();
    Grid { columns, lines }
}

row! {
    /// Counts and rates of one detector in one task.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct StreamingRow {
        /// Id of the data set, or the name of several together.
        dataset: String,
        /// Whether it is simulated.
        simulated: bool,
        /// The task.
        task: Task,
        /// Name of the detector.
        detector: String,
        /// `scans`: each answer at the time of its scan. `streams`: the newest answer at every moment. `late-truth`: labels as
        /// answers, as late as those of the detector.
        judged: String,
        /// How answers are moved on; empty for `scans`.
        forecast: Option<Forecast>,
        /// How many times as fast as the machine of the times a computer is.
        machine_speed: Option<Fixed<4>>,
        /// The part of the objects.
        slice: Slice,
        /// Annotations that count, over all scans or moments.
        no: u64,
        /// Those that were found.
        tp: u64,
        /// False detections; empty where they are unknown.
        fo: Option<u64>,
        /// TP / (TP + FO).
        precision: Option<Fixed<6>>,
        /// TP / NO.
        recall: Option<Fixed<6>>,
        /// 2 TP / (2 TP + MO + FO).
        f_rate: Option<Fixed<6>>,
        /// Lower end of the 95 % interval of the F-rate, or of the recall where false detections are unknown.
        low: Option<Fixed<6>>,
        /// Its upper end.
        high: Option<Fixed<6>>,
        /// Average precision at 101 recalls.
        ap_101_points: Option<Fixed<6>>,
        /// Median age of what was known.
        age_p50_ms: Option<Fixed<3>>,
        /// 95th percentile of the age.
        age_p95_ms: Option<Fixed<3>>,
        /// Share of scans that were dropped.
        dropped: Option<Fixed<6>>,
    }
}

impl StreamingRow {
    /// All rows of `streamed`.
    pub fn all(streamed: &Streamed) -> Vec<Self> {
        let row = |judged: &str, forecast, speed: Option<MachineSpeed>, slice, counts: Counts| Self {
            dataset: streamed.extent.name().to_owned(),
            simulated: streamed.origin != Origin::Recorded,
            task: streamed.task,
            detector: streamed.detector.clone(),
            judged: judged.to_owned(),
            forecast,
            machine_speed: speed.map(|it| Fixed(it.factor())),
            slice,
            no: counts.no(),
            tp: counts.tp(),
            fo: counts.fo(),
            precision: counts.precision().map(Fixed),
            recall: counts.recall().map(Fixed),
            f_rate: counts.f_rate().map(Fixed),
            low: None,
            high: None,
            ap_101_points: None,
            age_p50_ms: None,
            age_p95_ms: None,
            dropped: None,
        };
        let (moved, this) = (Some(Forecast::CarMotion), Some(MachineSpeed::THIS));
        let ages = streamed.ages_ms();
        let headline = Self {
            low: streamed.within.map(|it| Fixed(it.ends[0])),
            high: streamed.within.map(|it| Fixed(it.ends[1])),
            ap_101_points: streamed.average_precision.map(Fixed),
            age_p50_ms: ages.map(|it| Fixed(it[0])),
            age_p95_ms: ages.map(|it| Fixed(it[1])),
            dropped: streamed.dropped().map(Fixed),
            ..row("streams", moved, this, Slice::All, streamed.streamed)
        };
        let mut rows = vec![row("scans", None, None, Slice::All, streamed.per_scan), headline];
        let forecasts = streamed.sums.forecasts.iter();
        rows.extend(
            forecasts.map(|(forecast, counts)| row("streams", Some(*forecast), this, Slice::All, *counts)),
        );
        rows.extend(streamed.sums.late_truth.map(|it| row("late-truth", moved, this, Slice::All, it)));
        for it in &streamed.slices {
            rows.push(row("scans", None, None, it.slice, it.per_scan));
            rows.push(row("streams", moved, this, it.slice, it.streamed));
        }
        let others = streamed.sums.by_machine.iter().filter(|(speed, _)| *speed != MachineSpeed::THIS);
        rows.extend(others.map(|(speed, counts)| row("streams", moved, Some(*speed), Slice::All, *counts)));
        rows
    }
}

/// A factor of speed as people say it, such as `1/4` or `2`; empty between octaves.
pub(crate) fn factor_in_words(speed: MachineSpeed) -> String {
    let octave = speed.factor().log2();
    match octave.round() {
        rounded if (octave - rounded).abs() > 0.1 => String::new(),
        rounded if rounded < 0.0 => format!("1/{}", fixed_decimals((-rounded).exp2(), 0)),
        rounded => fixed_decimals(rounded.exp2(), 0),
    }
}
