//! The tables of classes: for each detector that gives classes, a line for each class and their means.

use std::collections::BTreeSet;

use super::grid::{Cell, Column, Grid, Line, LineKind};
use super::notes::about_interval;
use super::sheet::{Part, Sheet, Tabular};
use crate::files::fixed_decimals::{fixed_decimals, percent_or_dash};
use crate::files::new_file::file_stem_of;
use crate::numbers::blocks::{BlockKind, Interval};
use crate::numbers::pools::Pool;
use crate::numbers::run_report::{MetricRow, RunReport};
use crate::rows::confusion_row::{ConfusionRow, NONE};
use crate::run_folder::manifest::Manifest;
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::metric::{Metric, RecallPositions};
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Numbers of the classes on a data set, or on several together.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassTable {
    /// Id of the data set, or the name of several together.
    pub dataset: String,
    /// The same in words, and whether they are simulated.
    pub on: String,
    /// By what detections were matched with annotations, in words.
    pub matching_criterion: String,
    /// The lines, detector by detector, class by class.
    pub lines: Vec<ClassLine>,
    /// Annotated classes by given classes, on this data set.
    pub confusion: Vec<ConfusionRow>,
}

/// Numbers of a detector about a class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassLine {
    /// Name of the detector.
    pub detector: String,
    /// The class.
    pub class: AnnotationClass,
    /// NO, the annotations that count.
    pub no: u64,
    /// TP, the annotations that were found as objects of this class.
    pub tp: u64,
    /// FO, the detections of this class that are false; `None` if that is not known.
    pub fo: Option<u64>,
    /// Precision, recall, F-rate and average precision.
    pub rates: [Option<f64>; 4],
    /// The interval of the F-rate.
    pub within: Option<Interval>,
    /// Average precision by range, where there are annotations.
    pub ap_by_range: Vec<(Slice, f64)>,
}

/// The average precision of classes.
const AP: Metric = Metric::AveragePrecision(RecallPositions::R40);

/// The tables of the classes that the detectors of a run give: of each data set, then of several of one origin together.
/// Detectors that give none are in no table, and there is none without a line.
pub fn class_tables(report: &RunReport, manifest: &Manifest, confusion: &[ConfusionRow]) -> Vec<ClassTable> {
    let pools = manifest.pools();
    let datasets = manifest.datasets.iter().map(|it| {
        let on = format!("{}{}", it.id, it.origin().in_brackets());
        (it.id.clone(), on, vec![it.id.clone()])
    });
    let several = pools.into_iter().filter(Pool::is_of_several);
    let several = several.map(|it| (it.extent.name().to_owned(), it.in_words(), it.datasets));
    let tables = datasets.chain(several).map(|(dataset, on, ids)| {
        let lines = manifest.detectors.iter().flat_map(|it| lines_of(report, &dataset, &it.name));
        let of_classes = confusion.iter().filter(|it| ids.contains(&it.dataset));
        ClassTable {
            lines: lines.collect(),
            confusion: summed(of_classes),
            matching_criterion: manifest.matching_criterion.clone(),
            dataset,
            on,
        }
    });
    tables.filter(|it| !it.lines.is_empty()).collect()
}

/// The lines of `detector`; none if it gives no class.
fn lines_of(report: &RunReport, dataset: &str, detector: &str) -> Vec<ClassLine> {
    let all = || report.rows().iter().chain(report.overall());
    let is_ours = |it: &&MetricRow| it.subject.dataset == dataset && it.subject.detector == detector;
    let rows: Vec<&MetricRow> =
        all().filter(is_ours).filter(|it| it.subject.task.class().is_some()).collect();
    let mut classes: Vec<AnnotationClass> = rows.iter().filter_map(|it| it.subject.task.class()).collect();
    classes.sort_unstable();
    classes.dedup();
    let lines = classes.into_iter().map(|class| line_of(&rows, detector, class));
    let lines: Vec<ClassLine> = lines.filter(|it| it.no + it.tp + it.fo.unwrap_or(0) > 0).collect();
    if lines.iter().any(|it| it.tp > 0 || it.fo.is_some_and(|fo| fo > 0)) { lines } else { Vec::new() }
}

fn line_of(rows: &[&MetricRow], detector: &str, class: AnnotationClass) -> ClassLine {
    let of_class = || rows.iter().filter(|it| it.subject.task == Task::Class(class));
    let row = |metric: Metric| of_class().find(|it| it.subject.slice == Slice::All && it.metric == metric);
    let is_ap_of_range = |it: &&&MetricRow| it.metric == AP && matches!(it.subject.slice, Slice::Range(_));
    let value = |metric| row(metric).and_then(|it| it.value());
    let count = |metric| value(metric).map(|it| it as u64);
    ClassLine {
        detector: detector.to_owned(),
        class,
        no: count(Metric::No).unwrap_or(0),
        tp: count(Metric::Tp).unwrap_or(0),
        fo: count(Metric::Fo),
        rates: [Metric::Precision, Metric::Recall, Metric::FRate, AP].map(value),
        within: row(Metric::FRate).and_then(|it| it.interval()),
        ap_by_range: of_class()
            .filter(is_ap_of_range)
            .filter_map(|it| Some((it.subject.slice, it.value()?)))
            .collect(),
    }
}

/// The counts of several data sets together.
fn summed<'a>(rows: impl Iterator<Item = &'a ConfusionRow>) -> Vec<ConfusionRow> {
    let mut sums: Vec<ConfusionRow> = Vec::new();
    for row in rows {
        let is_same = |it: &&mut ConfusionRow| {
            (&it.detector, &it.annotated, &it.detected) == (&row.detector, &row.annotated, &row.detected)
        };
        match sums.iter_mut().find(is_same) {
            Some(sum) => sum.n += row.n,
            None => sums.push(row.clone()),
        }
    }
    sums
}

impl ClassTable {
    /// Name of the files it is written to, without the ending.
    pub fn file_stem(&self) -> String {
        format!("table_classes_{}", file_stem_of(&self.dataset))
    }

    /// The detectors, in the order of the run.
    fn detectors(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.lines.iter().map(|it| it.detector.as_str()).collect();
        names.dedup();
        names
    }

    /// For each detector the mistake about classes that it makes most often, in a sentence; none of detectors without one.
    pub fn sentences(&self) -> Vec<String> {
        let sentence = |detector: &&str| {
            let of_detector: Vec<&ConfusionRow> = self
                .confusion
                .iter()
                .filter(|it| it.detector == **detector && it.annotated != NONE)
                .collect();
            let is_wrong = |it: &&&ConfusionRow| it.detected != NONE && it.detected != it.annotated;
            let wrong =
                of_detector.iter().filter(is_wrong).filter(|it| AnnotationClass::met(&it.detected).is_some());
            let worst = wrong.max_by_key(|it| it.n)?;
            let found =
                of_detector.iter().filter(|it| it.annotated == worst.annotated && it.detected != NONE);
            let n_found: u64 = found.map(|it| it.n).sum();
            // Fewer than one in twenty are in the table alone.
            if 20 * worst.n < n_found {
                return None;
            }
            let objects = if n_found == 1 { "object" } else { "objects" };
            Some(format!(
                "Of {n_found} {objects} of the class {} that {detector} found, it calls {} {}.",
                worst.annotated, worst.n, worst.detected
            ))
        };
        self.detectors().iter().filter_map(sentence).collect()
    }

    fn rates(&self) -> Grid {
        let mut columns = vec![Column::left("detector"), Column::left("class")];
        columns.extend(
            ["NO", "ND", "TP", "MO", "FO", "precision", "recall", "F-rate", "95 %", "AP"].map(Column::number),
        );
        let mut lines = Vec::new();
        for detector in self.detectors() {
            let of_detector: Vec<&ClassLine> =
                self.lines.iter().filter(|it| it.detector == detector).collect();
            for (idx, line) in of_detector.iter().enumerate() {
                lines.push(line.line(idx == 0));
            }
            lines.push(mean_line(&of_detector));
        }
        Grid { columns, lines }
    }

    /// Average precision of each class by range; `None` if no class has any.
    fn ap_by_range(&self) -> Option<Grid> {
        let known = self.lines.iter().flat_map(|it| &it.ap_by_range).map(|(slice, _)| *slice);
        let ranges: BTreeSet<Slice> = known.collect();
        let mut columns = vec![Column::left("detector"), Column::left("class")];
        let name = |it: &Slice| it.name().trim_start_matches("range/").to_owned();
        columns.extend(ranges.iter().map(|it| Column::number(name(it)).within("range in m")));
        let line = |it: &ClassLine| {
            let ap =
                |range: &Slice| it.ap_by_range.iter().find(|(slice, _)| slice == range).map(|(_, ap)| *ap);
            let cells = ranges.iter().map(|range| Cell::new(percent_or_dash(ap(range))));
            let words = [it.detector.as_str(), it.class.name()].map(Cell::new);
            Line { kind: LineKind::Detail, cells: words.into_iter().chain(cells).collect() }
        };
        let lines = self.lines.iter().filter(|it| !it.ap_by_range.is_empty()).map(line).collect();
        (!ranges.is_empty()).then_some(Grid { columns, lines })
    }

    /// Annotated classes in lines, given classes in columns, of `detector`.
    fn confusion_of(&self, detector: &str) -> Grid {
        let rows: Vec<&ConfusionRow> = self.confusion.iter().filter(|it| it.detector == detector).collect();
        let names = |of: fn(&ConfusionRow) -> &str| {
            let mut names: Vec<&str> = rows.iter().map(|it| of(it)).collect();
            // Nothing comes last.
            names.sort_unstable_by_key(|it| (*it == NONE, Task::from_name(it), *it));
            names.dedup();
            names
        };
        let (annotated, detected) = (names(|it| &it.annotated), names(|it| &it.detected));
        let word = |it: &str, none: &str| if it == NONE { none.to_owned() } else { it.to_owned() };
        let mut columns = vec![Column::left("annotated")];
        columns.extend(detected.iter().map(|it| Column::number(word(it, "missed")).within("given")));
        let line = |class: &&str| {
            let n = |given: &&str| {
                let row =
                    rows.iter().find(|it| (it.annotated.as_str(), it.detected.as_str()) == (*class, *given));
                Cell::new(row.map_or_else(|| "·".to_owned(), |it| it.n.to_string()))
            };
            let cells = std::iter::once(Cell::new(word(class, "nothing"))).chain(detected.iter().map(n));
            Line { kind: LineKind::Detail, cells: cells.collect() }
        };
        Grid { columns, lines: annotated.iter().map(line).collect() }
    }
}

impl ClassLine {
    fn line(&self, is_first: bool) -> Line {
        let whole = |it: Option<u64>| it.map_or_else(|| "?".to_owned(), |it| it.to_string());
        let mut cells = vec![
            if is_first { Cell::new(self.detector.clone()) } else { Cell::default() },
            Cell::new(self.class.name()),
            Cell::new(self.no.to_string()),
            Cell::new(whole(self.fo.map(|it| it + self.tp))),
            Cell::new(self.tp.to_string()),
            Cell::new((self.no - self.tp).to_string()),
            Cell::new(whole(self.fo)),
        ];
        let [precision, recall, f_rate, ap] = self.rates.map(|it| Cell::new(percent_or_dash(it)));
        let ends = |it: Interval| it.ends.map(|end| fixed_decimals(100.0 * end, 1)).join(" to ");
        let within = self.within.map_or_else(|| Cell::new("–"), |it| Cell::interval(ends(it), it.blocks));
        cells.extend([precision, recall, f_rate, within, ap]);
        Line { kind: if is_first { LineKind::Dataset } else { LineKind::Detail }, cells }
    }
}

/// Means over the classes that are annotated.
fn mean_line(lines: &[&ClassLine]) -> Line {
    let annotated: Vec<&&ClassLine> = lines.iter().filter(|it| it.no > 0).collect();
    let mean = |rate_idx: usize| {
        let known: Option<Vec<f64>> = annotated.iter().map(|it| it.rates[rate_idx]).collect();
        known.filter(|it| !it.is_empty()).map(|it| it.iter().sum::<f64>() / it.len() as f64)
    };
    let mut cells = vec![Cell::default(), Cell::new(format!("mean of {}", annotated.len()))];
    cells.extend(vec![Cell::default(); 5]);
    let [precision, recall, f_rate, ap] = [0, 1, 2, 3].map(|it| Cell::new(percent_or_dash(mean(it))));
    cells.extend([precision, recall, f_rate, Cell::default(), ap]);
    Line { kind: LineKind::Detail, cells }
}

impl ClassTable {
    /// The table of rates alone.
    pub(crate) fn rates_sheet(&self) -> Sheet {
        Sheet::of(self.title(), self.rates(), self.about_rates())
    }

    fn title(&self) -> String {
        format!("Classes on {}.", self.on)
    }

    fn about_rates(&self) -> Vec<String> {
        let kinds = self.lines.iter().filter_map(|it| it.within).map(|it| it.blocks.kind);
        let about_interval = kinds.reduce(BlockKind::with).map(|it| format!("95 %: {}", about_interval(it)));
        let mut sentences = vec![format!(
            "Each class by itself, in %: annotations and detections of this class alone are matched, by {}. Detectors that give no \
             class are left out, and a detection has to be given this class. mean: over the classes that are annotated; no mean \
             where a class lacks the rate. FO is ? where the data set does not label the class. AP: average precision at 40 recalls.",
            self.matching_criterion
        )];
        sentences.extend(about_interval);
        sentences
    }
}

impl Tabular for ClassTable {
    fn sheet(&self) -> Sheet {
        let mut sentences = self.about_rates();
        sentences.push(
            "given: the class of the detection that found an object, whatever both are (task objects); nothing: false detections."
                .to_owned(),
        );
        let on = &self.on;
        let mut parts = vec![Part { title: Some(self.title()), grid: self.rates() }];
        let by_range = self.ap_by_range().map(|grid| Part {
            title: Some(format!("Average precision of classes by range on {on}.")),
            grid,
        });
        parts.extend(by_range);
        parts.extend(
            self.detectors()
                .into_iter()
                .filter(|it| self.confusion.iter().any(|row| row.detector == *it))
                .map(|it| Part {
                    title: Some(format!("Classes that {it} gives, on {on}.")),
                    grid: self.confusion_of(it),
                }),
        );
        let sheet = Sheet::of_parts(parts, sentences).labelled(&format!("classes-{}", self.dataset));
        Sheet { lead: self.sentences(), ..sheet }
    }
}
