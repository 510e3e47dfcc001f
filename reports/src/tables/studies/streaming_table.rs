//! Detectors on drives: scored per scan, and as they stream. Two tables, and `streaming.csv` with a row for every number.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::{Fixed, decimals_or_dash, fixed_decimals, percent_or_dash, three_digits};
use crate::rows::counts::Counts;
use crate::streaming::machine_speed::MachineSpeed;
use crate::streaming::streamed::{Streamed, StreamedSlice, headline};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{INTERVAL_TITLE, about_interval};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::tables::task_grids::interval_cell;
use crate::vocabulary::criterion::CriterionKind;
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
    /// What a reader has to know before the numbers.
    pub caveats: &'a [String],
    /// What else there is to know.
    pub notes: &'a [String],
    /// Whether it is for a terminal: data sets of one origin together, and fewer columns.
    pub is_short: bool,
}

impl Tabular for StreamingTable<'_> {
    fn sheet(&self) -> Sheet {
        let mut parts = Vec::new();
        for of_extent in self.of_tasks_and_extents() {
            let Streamed { task, extent, origin, .. } = of_extent[0];
            let on = format!("{}{}", extent.name(), origin.in_brackets());
            let title =
                format!("Task {task}, streaming on {on}. Rates in %. Matched by {}.", self.matched_by);
            parts.push(Part { title: Some(title), grid: rates(&of_extent, self.is_short) });
            if let Some(grid) = slices(&of_extent) {
                let title = format!(
                    "Task {task} on {on}, recall in % by speed over ground and by range: per scan → as it streams."
                );
                parts.push(Part { title: Some(title), grid });
            }
        }
        let mut sentences = vec![
            "ms: median time of detection. scans: each answer judged where things were when its scan was taken. streams: at \
             every moment the newest answer, moved on by the car's motion, judged where things are then."
                .to_owned(),
            "held: the same, not moved at all. tracked: moved on with the velocity of a small tracker. truth: what a detector \
             would reach that finds exactly the labels, answers as late, and forecasts nothing but the car's motion."
                .to_owned(),
            "age: of what is known, median and 95th percentile. dropped: scans that came while the detector was busy, in %."
                .to_owned(),
        ];
        if !self.is_short {
            sentences.push("AP: average precision as it streams.".to_owned());
        }
        if self.streamed.iter().any(|it| it.streamed.fo().is_none()) {
            sentences.push("Where false detections are unknown, rates are recalls.".to_owned());
        }
        sentences.extend(self.notes.iter().cloned());
        let kind = self.streamed.iter().find_map(|it| it.within.map(|it| it.blocks.kind));
        sentences.extend(kind.map(|it| format!("{INTERVAL_TITLE}: {}", about_interval(it))));
        let leaders = self.of_tasks_and_extents().into_iter().filter_map(|it| leaders(&it));
        let lead = leaders.chain(self.caveats.iter().cloned()).collect();
        Sheet { lead, ..Sheet::of_parts(parts, sentences).labelled("streaming") }
    }
}

impl StreamingTable<'_> {
    /// The numbers of each task on each extent: all data sets of an origin together before each of them.
    fn of_tasks_and_extents(&self) -> Vec<Vec<&Streamed>> {
        let mut groups: Vec<Vec<&Streamed>> = Vec::new();
        for it in self.streamed.iter().filter(|it| !self.is_short || !is_one_of_several(it, self.streamed)) {
            match groups.iter_mut().find(|group| (group[0].task, &group[0].extent) == (it.task, &it.extent)) {
                Some(group) => group.push(it),
                None => groups.push(vec![it]),
            }
        }
        groups.sort_by_key(|it| (is_one_of_several(it[0], self.streamed), it[0].task));
        groups
    }
}

/// Which detector has the highest rate on which computers; `None` if there are no others to beat, or no rates. Rates are not
/// compared beyond a tenth of a percent, and the caveat of their intervals is said.
fn leaders(of_extent: &[&Streamed]) -> Option<String> {
    let Streamed { task, extent, origin, within, .. } = of_extent.first()?;
    let best = |speed: MachineSpeed| {
        let rated = of_extent.iter().filter_map(|it| {
            let rate = it.by_machine().find(|it| it.0 == speed)?.1?;
            Some(((1000.0 * rate).round(), it.detector.as_str()))
        });
        let rated: Vec<(f64, &str)> = rated.filter(|it| it.0 > 0.0).collect();
        let highest = rated.iter().map(|it| it.0).reduce(f64::max)?;
        let best: Vec<&str> = rated.iter().filter(|it| it.0 == highest).map(|it| it.1).collect();
        Some((speed, best.join(" and ")))
    };
    let best: Vec<(MachineSpeed, String)> = of_extent[0].by_machine().filter_map(|it| best(it.0)).collect();
    let stretch = |it: &[(MachineSpeed, String)]| match it {
        [(speed, names)] => format!("{names} at {}", times(*speed)),
        [(first, names), .., (last, _)] => format!("{names} from {} to {}", times(*first), times(*last)),
        [] => String::new(),
    };
    let stretches: Vec<String> = best.chunk_by(|a, b| a.1 == b.1).map(stretch).collect();
    let on = format!("{}{}", extent.name(), origin.in_brackets());
    let caveat = within.and_then(|it| it.blocks.caveat_of_conclusions());
    let caveat = caveat.map_or_else(String::new, |it| format!(" ({it})"));
    (of_extent.len() > 1 && !stretches.is_empty()).then(|| {
        format!(
            "Task {task} on {on}: the highest rate, by speed of the computer (1 is as measured): {}{caveat}.",
            stretches.join("; ")
        )
    })
}

/// A factor of speed for a sentence: `1/4`, `2`, or with decimals between octaves.
fn times(speed: MachineSpeed) -> String {
    let octave = factor_in_words(speed);
    if octave.is_empty() { three_digits(speed.factor()) } else { octave }
}

/// Whether it is about a single data set of which others are judged together with it.
pub(crate) fn is_one_of_several(it: &Streamed, all: &[Streamed]) -> bool {
    !it.extent.is_overall() && all.iter().any(|other| other.extent.is_overall() && other.origin == it.origin)
}

fn percent(counts: Option<Counts>) -> String {
    percent_or_dash(counts.and_then(headline))
}

fn rates(of_extent: &[&Streamed], is_short: bool) -> Grid {
    let is_known = of_extent.iter().any(|it| it.streamed.fo().is_some());
    let rate = if is_known { "F-rate" } else { "recall" };
    let mut columns = vec![Column::left("detector"), Column::number("ms")];
    columns.extend(["scans", "streams"].map(|it| Column::number(it).within(rate)));
    columns.push(Column::left(INTERVAL_TITLE).within(rate));
    columns.extend(["held", "tracked", "truth"].map(|it| Column::number(it).within(rate)));
    let has_ap = of_extent.iter().any(|it| it.average_precision.is_some());
    // Precision and recall are in the file: a table has room for so much.
    let has_ap = !is_short && has_ap;
    columns.extend(has_ap.then(|| Column::number("AP")));
    columns.extend(["p50", "p95"].map(|it| Column::number(it).within("age [ms]")));
    columns.push(Column::number("dropped"));
    let line = |it: &&Streamed| {
        let ages = it.ages_ms();
        let age = |idx: usize| decimals_or_dash(ages.map(|it| it[idx]), 0);
        let others =
            [it.forecast(Forecast::Hold), it.forecast(Forecast::ConstantVelocity), it.sums.late_truth];
        let mut cells = vec![it.detector.clone(), decimals_or_dash(it.latency_ms(), 1)];
        cells.extend([it.per_scan, it.streamed].map(|it| percent(Some(it))));
        let mut cells: Vec<Cell> = cells.into_iter().map(Cell::new).collect();
        cells.push(interval_cell(it.within));
        cells.extend(others.map(|it| Cell::new(percent(it))));
        cells.extend(has_ap.then(|| Cell::new(percent_or_dash(it.average_precision))));
        cells.extend([age(0), age(1), percent_or_dash(it.dropped())].map(Cell::new));
        Line { kind: LineKind::Dataset, cells }
    };
    Grid { columns, lines: of_extent.iter().map(line).collect() }
}

/// Recall by speed and range of each detector; `None` if nothing is known of either.
fn slices(of_extent: &[&Streamed]) -> Option<Grid> {
    // An object at the edge may be beyond it between two scans alone.
    let of_scans = |it: &&StreamedSlice| it.per_scan.no() > 0;
    let names = of_extent.iter().flat_map(|it| it.slices.iter().filter(of_scans).map(|it| it.slice));
    let mut names: Vec<Slice> = names.collect();
    let is_range = |it: &Slice| matches!(it, Slice::Range(_));
    names.sort_by_key(|it| (is_range(it), *it));
    names.dedup();
    let column = |it: &Slice| {
        let name = it.name();
        let (group, bin) = name.split_once('/').unwrap_or(("", &name));
        let unit = if is_range(it) { "m" } else { "m/s" };
        Column::left(bin.to_owned()).within(format!("{group} [{unit}]"))
    };
    let columns = [Column::left("detector")].into_iter().chain(names.iter().map(column)).collect();
    let line = |it: &&Streamed| {
        let rates = names.iter().map(|name| {
            let found = it.slices.iter().find(|it| it.slice == *name);
            let [scans, streams] = [found.map(|it| it.per_scan), found.map(|it| it.streamed)]
                .map(|counts| percent_or_dash(counts.and_then(Counts::recall)));
            format!("{scans} → {streams}")
        });
        let cells = [it.detector.clone()].into_iter().chain(rates).map(Cell::new).collect();
        Line { kind: LineKind::Dataset, cells }
    };
    (!names.is_empty()).then(|| Grid { columns, lines: of_extent.iter().map(line).collect() })
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
        /// What boxes are compared by.
        criterion: CriterionKind,
        /// Time from one moment to the next.
        clock_ms: Fixed<3>,
        /// Median time of detection.
        latency_p50_ms: Option<Fixed<3>>,
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
    /// All rows of `streamed`, which was judged by `criterion` every `clock_ms`.
    pub fn all(streamed: &Streamed, criterion: CriterionKind, clock_ms: f64) -> Vec<Self> {
        let row = |judged: &str, forecast, speed: Option<MachineSpeed>, slice, counts: Counts| Self {
            dataset: streamed.extent.name().to_owned(),
            simulated: streamed.origin != Origin::Recorded,
            task: streamed.task,
            detector: streamed.detector.clone(),
            criterion,
            clock_ms: Fixed(clock_ms),
            latency_p50_ms: streamed.latency_ms().map(Fixed),
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
