//! From the rows of scans and matches to the numbers of a report, with how sure they are.

use std::collections::{BTreeMap, BTreeSet};

use crate::average_precision::{RankedDetection, average_precision};
use crate::bootstrap::{Distribution, Resamples, SCANS_PER_BLOCK};
use crate::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MatchOutcome};
use crate::match_row::MatchRow;
use crate::metric::{Metric, RecallPositions};
use crate::run_report::{MetricRow, OVERALL, Subject};
use crate::scan_row::{ScanOutcome, ScanRow};
use crate::slice::Slice;
use crate::sums::{FalseObjects, RATIOS, Sums, Term};

/// Numbers of a run, gathered row by row.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    // All three in the order in which they were first seen.
    datasets: Vec<String>,
    tasks: Vec<String>,
    detectors: Vec<String>,
    // The blocks of each of `datasets`.
    blocks: Vec<BTreeSet<Block>>,
    of_key: BTreeMap<Key, Gathered>,
}

/// Scans of one drive that are drawn together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Block {
    sequence: String,
    number: u32,
}

/// Places of data set, task and detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    dataset_idx: usize,
    task_idx: usize,
    detector_idx: usize,
}

/// What one detector made of one data set in one task.
#[derive(Debug, Clone)]
struct Gathered {
    n_scans: u64,
    false_objects: FalseObjects,
    slices: BTreeMap<Slice, BTreeMap<Block, Sums>>,
    // The detections that count, or nothing once one of them came without a score.
    ranked: Option<Vec<RankedDetection>>,
}

/// Sums of one subject, as they are and as they would be had other scans been drawn.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Number of scans.
    pub n_scans: u64,
    /// Number of blocks that were drawn from.
    pub n_blocks: usize,
    /// Whether all false objects are known.
    pub false_objects: FalseObjects,
    /// The sums themselves.
    pub total: Sums,
    /// Those of each resample.
    pub resampled: Vec<Sums>,
}

/// What a tally has been asked about: a data set or all of them, a task, a detector, a slice.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// Id of the data set; [`OVERALL`] for all together.
    pub dataset: &'a str,
    /// Name of the task.
    pub task: &'a str,
    /// Name of the detector.
    pub detector: &'a str,
    /// The slice.
    pub slice: &'a Slice,
}

impl Tally {
    /// Adds what one detector made of one scan in one task.
    pub fn add_scan(&mut self, row: &ScanRow) {
        let key = self.key(&row.dataset, &row.task, &row.detector);
        let block = block_of(&row.sequence, row.scan);
        self.blocks[key.dataset_idx].insert(block.clone());
        let ScanOutcome::Evaluated(numbers) = &row.outcome else { return };
        let gathered = self.of_key.entry(key).or_default();
        gathered.n_scans += 1;
        if numbers.counts.fo().is_none() {
            gathered.false_objects = FalseObjects::Unknown;
        }
        let sums = gathered.sums(Slice::All, &block);
        let segmentation = &numbers.segmentation;
        for (term, value) in [
            (Term::Annotations, numbers.counts.no() as f64),
            (Term::Matched, numbers.counts.tp() as f64),
            (Term::False, numbers.counts.fo().unwrap_or(0) as f64),
            (Term::IgnoredAnnotations, numbers.n_ignored_annotations as f64),
            (Term::IgnoredDetections, numbers.n_ignored_detections as f64),
            (Term::Unknowable, numbers.n_unknowable_detections as f64),
            (Term::Split, segmentation.n_split as f64),
            (Term::Holding, segmentation.n_holding as f64),
            (Term::Joining, segmentation.n_joining as f64),
            (Term::Touching, segmentation.n_touching as f64),
            (Term::OverEntropy, segmentation.over_entropy_nats),
            (Term::UnderEntropy, segmentation.under_entropy_nats),
        ] {
            sums.add(term, value);
        }
    }

    /// Adds what became of an annotation, a detection or a pair of them. Its scan is to be added too.
    pub fn add_match(&mut self, row: &MatchRow) {
        let key = self.key(&row.dataset, &row.task, &row.detector);
        let block = block_of(&row.sequence, row.scan);
        let gathered = self.of_key.entry(key).or_default();
        match &row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => {
                gathered.add_to_slices(&slices_of_annotation(annotation), &block, Term::Annotations);
                gathered.add_to_slices(&slices_of_annotation(annotation), &block, Term::Matched);
                gathered.rank(detection, true);
                if let Some(labelled) = &annotation.bounding_box {
                    add_box_errors(gathered.sums(Slice::All, &block), labelled, &detection.bounding_box);
                }
            }
            MatchOutcome::Missed { annotation, .. } => {
                gathered.add_to_slices(&slices_of_annotation(annotation), &block, Term::Annotations);
            }
            MatchOutcome::False { detection, .. } => {
                gathered.add_to_slices(&slices_of_detection(detection), &block, Term::False);
                gathered.rank(detection, false);
            }
            MatchOutcome::IgnoredAnnotation { .. }
            | MatchOutcome::IgnoredDetection { .. }
            | MatchOutcome::Unknowable { .. } => {}
        }
    }

    fn key(&mut self, dataset: &str, task: &str, detector: &str) -> Key {
        let dataset_idx = place_of(&mut self.datasets, dataset);
        self.blocks.resize(self.datasets.len(), BTreeSet::new());
        let (task_idx, detector_idx) =
            (place_of(&mut self.tasks, task), place_of(&mut self.detectors, detector));
        Key { dataset_idx, task_idx, detector_idx }
    }

    /// Ids of the data sets, in the order in which they were seen.
    pub fn datasets(&self) -> &[String] {
        &self.datasets
    }

    /// Names of the tasks, in the order in which they were seen.
    pub fn tasks(&self) -> &[String] {
        &self.tasks
    }

    /// Names of the detectors, in the order in which they were seen.
    pub fn detectors(&self) -> &[String] {
        &self.detectors
    }

    /// The draws for each data set, in order.
    pub fn draw(&self) -> Vec<Resamples> {
        let blocks = self.datasets.iter().zip(&self.blocks);
        blocks.map(|(dataset, blocks)| Resamples::draw(dataset, blocks.len())).collect()
    }

    /// Whether `other` is of the same blocks of scans, so that both may be drawn from in the same way.
    pub fn has_same_blocks(&self, other: &Self) -> bool {
        self.datasets == other.datasets && self.blocks == other.blocks
    }

    /// All slices that detector `detector` has an object in, in the task `task`.
    pub fn slices(&self, task: &str, detector: &str) -> BTreeSet<Slice> {
        let is_asked =
            |key: &Key| self.tasks[key.task_idx] == task && self.detectors[key.detector_idx] == detector;
        let gathered = self.of_key.iter().filter(|(key, _)| is_asked(key));
        gathered.flat_map(|(_, gathered)| gathered.slices.keys().cloned()).collect()
    }

    /// The sums that are asked for; `None` if nothing was seen of the kind.
    pub fn sample(&self, question: &Question<'_>, draws: &[Resamples]) -> Option<Sample> {
        let mut all: Option<Sample> = None;
        for dataset_idx in 0..self.datasets.len() {
            if question.dataset != OVERALL && question.dataset != self.datasets[dataset_idx] {
                continue;
            }
            let Some(sample) = self.sample_of(dataset_idx, question, &draws[dataset_idx]) else { continue };
            all = Some(match all {
                Some(sum) => sum.with(&sample),
                None => sample,
            });
        }
        all
    }

    fn sample_of(&self, dataset_idx: usize, question: &Question<'_>, draw: &Resamples) -> Option<Sample> {
        let gathered = self.gathered(dataset_idx, question.task, question.detector)?;
        let no_block = BTreeMap::new();
        let of_blocks = gathered.slices.get(question.slice).unwrap_or(&no_block);
        let place = |block: &Block| self.blocks[dataset_idx].iter().position(|it| it == block);
        let placed = of_blocks.iter().filter_map(|(block, sums)| Some((place(block)?, *sums)));
        let placed: Vec<(usize, Sums)> = placed.collect();
        let mut total = Sums::default();
        placed.iter().for_each(|(_, sums)| total.add_times(sums, 1.0));
        Some(Sample {
            n_scans: gathered.n_scans,
            n_blocks: draw.n_blocks(),
            false_objects: gathered.false_objects,
            total,
            resampled: draw.sums(&placed),
        })
    }

    fn gathered(&self, dataset_idx: usize, task: &str, detector: &str) -> Option<&Gathered> {
        let task_idx = self.tasks.iter().position(|it| it == task)?;
        let detector_idx = self.detectors.iter().position(|it| it == detector)?;
        self.of_key.get(&Key { dataset_idx, task_idx, detector_idx })
    }

    /// The numbers of each data set: data set by data set, task by task, detector by detector, slice by slice.
    pub fn metric_rows(&self) -> Vec<MetricRow> {
        let draws = self.draw();
        self.datasets.iter().flat_map(|dataset| self.rows_about(dataset, &draws)).collect()
    }

    /// The numbers of all data sets together; none if there is only one.
    pub fn overall_rows(&self) -> Vec<MetricRow> {
        if self.datasets.len() < 2 { Vec::new() } else { self.rows_about(OVERALL, &self.draw()) }
    }

    fn rows_about(&self, dataset: &str, draws: &[Resamples]) -> Vec<MetricRow> {
        let mut rows = Vec::new();
        for task in &self.tasks {
            for detector in &self.detectors {
                for slice in &self.slices(task, detector) {
                    let question = Question { dataset, task, detector, slice };
                    let Some(sample) = self.sample(&question, draws) else { continue };
                    if *slice != Slice::All && sample.total.is_zero() {
                        continue;
                    }
                    rows.extend(sample.rows(&question));
                    if *slice == Slice::All {
                        rows.extend(self.average_precision_rows(&question, &sample));
                    }
                }
            }
        }
        rows
    }

    fn average_precision_rows(&self, question: &Question<'_>, sample: &Sample) -> Vec<MetricRow> {
        let ranked = self.ranked(question).filter(|_| sample.false_objects == FalseObjects::Known);
        let no = sample.total.of(Term::Annotations) as u64;
        let row = |positions| {
            let value = average_precision(ranked.as_ref()?, no, positions);
            Some(MetricRow::new(question.subject(), Metric::AveragePrecision(positions), value, no))
        };
        [RecallPositions::Points101, RecallPositions::R40].into_iter().filter_map(row).collect()
    }

    /// The detections that count, with their scores; `None` if there are none or one of them has no score.
    pub fn ranked(&self, question: &Question<'_>) -> Option<Vec<RankedDetection>> {
        let mut all = Vec::new();
        for (dataset_idx, dataset) in self.datasets.iter().enumerate() {
            if question.dataset == OVERALL || question.dataset == dataset {
                let gathered = self.gathered(dataset_idx, question.task, question.detector)?;
                all.extend(gathered.ranked.as_ref()?);
            }
        }
        (!all.is_empty()).then_some(all)
    }
}

impl Question<'_> {
    fn subject(&self) -> Subject {
        let [dataset, task, detector] = [self.dataset, self.task, self.detector].map(str::to_owned);
        Subject { dataset, task, detector, slice: self.slice.name() }
    }
}

/// The metrics of everything, in the order of a report.
const OF_ALL: [Metric; 10] = [
    Metric::No,
    Metric::Tp,
    Metric::Mo,
    Metric::Fo,
    Metric::IgnoredAnnotations,
    Metric::IgnoredDetections,
    Metric::UnknowableDetections,
    Metric::OverSegmentationEntropy,
    Metric::UnderSegmentationEntropy,
    Metric::FRate,
];

impl Sample {
    /// Both together; false objects are known only where they are in both.
    fn with(mut self, other: &Self) -> Self {
        self.n_scans += other.n_scans;
        self.n_blocks += other.n_blocks;
        self.total.add_times(&other.total, 1.0);
        self.resampled.iter_mut().zip(&other.resampled).for_each(|(sum, it)| sum.add_times(it, 1.0));
        if other.false_objects == FalseObjects::Unknown {
            self.false_objects = FalseObjects::Unknown;
        }
        self
    }

    /// The value of `metric`.
    pub fn value(&self, metric: &Metric) -> Option<f64> {
        self.total.value(metric, self.false_objects)
    }

    /// The value of `metric` in each resample.
    pub fn resampled_values(&self, metric: &Metric) -> impl Iterator<Item = Option<f64>> {
        self.resampled.iter().map(move |sums| sums.value(metric, self.false_objects))
    }

    fn rows(&self, question: &Question<'_>) -> Vec<MetricRow> {
        let metrics: Vec<Metric> = match question.slice {
            Slice::All => {
                let mut all: Vec<Metric> = OF_ALL.into_iter().chain(RATIOS).collect();
                all.sort();
                all.dedup();
                all
            }
            slice if slice.has_false_detections() => {
                vec![Metric::No, Metric::Tp, Metric::Fo, Metric::Recall, Metric::FRate]
            }
            _ => vec![Metric::No, Metric::Tp, Metric::Recall],
        };
        metrics.into_iter().map(|metric| self.row(question, metric)).collect()
    }

    fn row(&self, question: &Question<'_>, metric: Metric) -> MetricRow {
        let value = self.value(&metric);
        let row = |n| MetricRow::new(question.subject(), metric.clone(), value, n);
        if !RATIOS.contains(&metric) {
            return row(self.n_scans);
        }
        let n = self.total.ratio(&metric, self.false_objects).map_or(0.0, |[_, denominator]| denominator);
        let distribution = Distribution::new(self.resampled_values(&metric), self.n_blocks);
        row(n as u64).within(distribution.filter(|_| value.is_some()).map(|it| it.interval()))
    }
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            n_scans: 0,
            false_objects: FalseObjects::Known,
            slices: BTreeMap::new(),
            ranked: Some(Vec::new()),
        }
    }
}

impl Gathered {
    fn sums(&mut self, slice: Slice, block: &Block) -> &mut Sums {
        self.slices.entry(slice).or_default().entry(block.clone()).or_default()
    }

    fn add_to_slices(&mut self, slices: &[Slice], block: &Block, term: Term) {
        for slice in slices {
            self.sums(slice.clone(), block).add(term, 1.0);
        }
    }

    fn rank(&mut self, detection: &DetectionFacts, is_match: bool) {
        match (detection.score, &mut self.ranked) {
            (Some(score), Some(ranked)) => ranked.push(RankedDetection { score, is_match }),
            (None, _) => self.ranked = None,
            (_, None) => {}
        }
    }
}

fn place_of(names: &mut Vec<String>, name: &str) -> usize {
    names.iter().position(|it| it == name).unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

fn block_of(sequence: &str, scan: u32) -> Block {
    Block { sequence: sequence.to_owned(), number: scan / SCANS_PER_BLOCK }
}

fn slices_of_annotation(annotation: &AnnotationFacts) -> Vec<Slice> {
    let mut slices = vec![Slice::Class(annotation.class.clone()), Slice::of_points(annotation.n_points)];
    slices.extend(annotation.bounding_box.and_then(|it| Slice::of_range(range_m(&it))));
    slices.extend(annotation.occlusion.clone().map(Slice::Occlusion));
    slices
}

fn slices_of_detection(detection: &DetectionFacts) -> Vec<Slice> {
    let mut slices = vec![Slice::of_points(detection.n_points)];
    slices.extend(Slice::of_range(range_m(&detection.bounding_box)));
    slices
}

fn range_m(bounding_box: &BoxFacts) -> f64 {
    let [x_m, y_m, _] = bounding_box.center_m.map(f64::from);
    x_m.hypot(y_m)
}

fn add_box_errors(sums: &mut Sums, labelled: &BoxFacts, found: &BoxFacts) {
    let off_m = |of: fn(&BoxFacts) -> f32| f64::from(of(found)) - f64::from(of(labelled));
    let along_x_m = off_m(|it| it.center_m[0]);
    let along_y_m = off_m(|it| it.center_m[1]);
    let turned_rad = off_m(|it| it.yaw_rad).rem_euclid(std::f64::consts::PI);
    let turned_rad = turned_rad.min(std::f64::consts::PI - turned_rad);
    for (term, value) in [
        (Term::BoxPairs, 1.0),
        (Term::CenterError, along_x_m.hypot(along_y_m)),
        (Term::LengthError, off_m(|it| it.length_width_height_m[0]).abs()),
        (Term::WidthError, off_m(|it| it.length_width_height_m[1]).abs()),
        (Term::YawError, turned_rad.to_degrees()),
    ] {
        sums.add(term, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Counts;
    use crate::metric::BoxDimension;
    use crate::run_report::SLICE_ALL;
    use crate::scan_row::{ScanNumbers, SegmentationNumbers};

    fn boxed(x_m: f32, length_m: f32, yaw_deg: f32) -> BoxFacts {
        let yaw_rad = yaw_deg.to_radians();
        BoxFacts { center_m: [x_m, 0.0, 0.0], length_width_height_m: [length_m, 2.0, 1.5], yaw_rad }
    }

    fn annotation(class: &str, n_points: u64, bounding_box: BoxFacts) -> AnnotationFacts {
        let (class, occlusion) = (class.to_owned(), Some("none".to_owned()));
        AnnotationFacts { id: 0, track: None, class, occlusion, n_points, bounding_box: Some(bounding_box) }
    }

    fn detection(score: Option<f32>, n_points: u64, bounding_box: BoxFacts) -> DetectionFacts {
        DetectionFacts { id: 0, class: "vehicle".to_owned(), score, n_points, bounding_box }
    }

    fn match_row(scan: u32, outcome: MatchOutcome) -> MatchRow {
        let [dataset, sequence, detector, task, criterion] =
            ["street", "0000", "pca", "vehicles", "points"].map(str::to_owned);
        MatchRow { dataset, sequence, scan, detector, task, criterion, outcome }
    }

    fn scan_row(scan: u32, no: u64, tp: u64, fo: Option<u64>) -> ScanRow {
        let [dataset, sequence, detector, task] = ["street", "0000", "pca", "vehicles"].map(str::to_owned);
        let numbers = ScanNumbers {
            n_points: 1000,
            latency_ms: Some(1.0),
            counts: Counts::new(no, tp, fo).unwrap(),
            n_ignored_annotations: 1,
            n_ignored_detections: 2,
            n_unknowable_detections: 0,
            segmentation: SegmentationNumbers {
                n_split: 1,
                n_holding: 4,
                n_joining: 1,
                n_touching: 5,
                over_entropy_nats: 0.5,
                under_entropy_nats: 1.0,
            },
            n_dropped_too_small: 0,
            n_dropped_too_large: 0,
        };
        ScanRow { dataset, sequence, scan, detector, task, outcome: ScanOutcome::Evaluated(numbers) }
    }

    /// Four annotations and three detections: a car found by a box half a metre off, 1 m too short and turned by 190°; a car
    /// found exactly but for 20°; a van missed; a truck 40 m away missed; one false detection 20 m away.
    fn scene() -> Tally {
        let mut tally = Tally::default();
        tally.add_scan(&scan_row(3, 4, 2, Some(1)));
        let outcomes = [
            MatchOutcome::Matched {
                annotation: annotation("car", 300, boxed(10.0, 4.0, 0.0)),
                detection: detection(Some(0.9), 250, boxed(10.5, 3.0, 190.0)),
                cost: 0.1,
            },
            MatchOutcome::Matched {
                annotation: annotation("car", 30, boxed(20.0, 4.0, 170.0)),
                detection: detection(Some(0.7), 30, boxed(20.0, 4.0, -30.0)),
                cost: 0.0,
            },
            MatchOutcome::Missed {
                annotation: annotation("van", 100, boxed(12.0, 5.0, 0.0)),
                reason: "split".to_owned(),
            },
            MatchOutcome::Missed {
                annotation: annotation("truck", 60, boxed(40.0, 8.0, 0.0)),
                reason: "split".to_owned(),
            },
            MatchOutcome::False {
                detection: detection(Some(0.8), 70, boxed(20.0, 1.0, 0.0)),
                reason: "nothing there".to_owned(),
            },
            MatchOutcome::IgnoredDetection {
                detection: detection(Some(0.99), 70, boxed(20.0, 1.0, 0.0)),
                reason: "beyond range".to_owned(),
            },
        ];
        outcomes.into_iter().for_each(|it| tally.add_match(&match_row(3, it)));
        tally
    }

    #[track_caller]
    fn check(tally: &Tally, slice: &str, expected: &[(Metric, f64)]) {
        let rows = tally.metric_rows();
        for (metric, value) in expected {
            let row = rows.iter().find(|it| it.subject.slice == slice && it.metric == *metric);
            let found = row.unwrap_or_else(|| panic!("no {} of {slice}", metric.id())).value();
            let found = found.unwrap_or_else(|| panic!("{} of {slice} is undefined", metric.id()));
            assert!((found - value).abs() < 1e-5, "{} of {slice}: {found} instead of {value}", metric.id());
        }
    }

    #[test]
    fn everything_about_four_objects_can_be_done_in_the_head() {
        check(
            &scene(),
            SLICE_ALL,
            &[
                (Metric::No, 4.0),
                (Metric::Tp, 2.0),
                (Metric::Mo, 2.0),
                (Metric::Fo, 1.0),
                (Metric::Precision, 2.0 / 3.0),
                (Metric::Recall, 0.5),
                (Metric::FRate, 4.0 / 7.0),
                (Metric::IgnoredAnnotations, 1.0),
                (Metric::IgnoredDetections, 2.0),
                (Metric::OverSegmentation, 0.25),
                (Metric::UnderSegmentation, 0.25),
                (Metric::OverSegmentationEntropy, 0.5),
                (Metric::OverSegmentationEntropyPerObject, 0.125),
                (Metric::UnderSegmentationEntropy, 1.0),
                (Metric::UnderSegmentationEntropyPerObject, 0.2),
                // Half a metre and none; 1 m and none; 190° is 10°, and 170° to -30° is 20°.
                (Metric::BoxError(BoxDimension::Center), 0.25),
                (Metric::BoxError(BoxDimension::Length), 0.5),
                (Metric::BoxError(BoxDimension::Width), 0.0),
                (Metric::BoxError(BoxDimension::Yaw), 15.0),
                // Right, false, right of four annotations: precision 1 up to 25 %, 2/3 up to 50 %, then none.
                (Metric::AveragePrecision(RecallPositions::Points101), (26.0 + 25.0 * 2.0 / 3.0) / 101.0),
                (Metric::AveragePrecision(RecallPositions::R40), (10.0 + 10.0 * 2.0 / 3.0) / 40.0),
            ],
        );
    }

    #[test]
    fn slices_are_of_the_annotation_or_of_the_false_detection() {
        let tally = scene();
        check(&tally, "class/car", &[(Metric::No, 2.0), (Metric::Recall, 1.0)]);
        check(&tally, "class/truck", &[(Metric::No, 1.0), (Metric::Recall, 0.0)]);
        check(&tally, "range/0-15", &[(Metric::No, 2.0), (Metric::Fo, 0.0), (Metric::FRate, 2.0 / 3.0)]);
        check(&tally, "range/15-30", &[(Metric::No, 1.0), (Metric::Fo, 1.0), (Metric::FRate, 2.0 / 3.0)]);
        check(&tally, "points/50-199", &[(Metric::No, 2.0), (Metric::Fo, 1.0), (Metric::FRate, 0.0)]);
        check(&tally, "occlusion/none", &[(Metric::No, 4.0), (Metric::Recall, 0.5)]);
        let has_false = |it: &MetricRow| it.subject.slice.starts_with("class/") && it.metric == Metric::Fo;
        assert!(!tally.metric_rows().iter().any(has_false));
    }

    #[test]
    fn a_detection_without_a_score_leaves_no_ranking() {
        let mut tally = scene();
        let detection = detection(None, 70, boxed(20.0, 1.0, 0.0));
        tally.add_match(&match_row(3, MatchOutcome::False { detection, reason: "fragment".to_owned() }));
        assert!(!tally.metric_rows().iter().any(|it| matches!(it.metric, Metric::AveragePrecision(_))));
    }

    #[test]
    fn scans_of_a_second_are_one_block_and_one_block_has_no_interval() {
        let f_rate = |scans: &[u32]| {
            let mut tally = Tally::default();
            for scan in scans {
                tally.add_scan(&scan_row(*scan, 4, 1 + u64::from(scan % 2), Some(1)));
            }
            let row = tally.metric_rows().into_iter().find(|it| it.metric == Metric::FRate);
            row.unwrap().interval()
        };
        assert_eq!(f_rate(&[0, 3, 9]), None);
        assert_eq!(f_rate(&[0, 3, 9, 10, 35]).map(|it| it.n_blocks), Some(3));
        // The two blocks reach 2 / 6 and 4 / 7: what is drawn lies between.
        let [low, high] = f_rate(&[0, 11]).unwrap().ends;
        assert_eq!([low, high], [2.0 / 6.0, 4.0 / 7.0]);
    }

    #[test]
    fn overall_numbers_are_those_of_the_sums() {
        let mut tally = scene();
        assert!(tally.overall_rows().is_empty());
        tally.add_scan(&ScanRow { dataset: "kitti".to_owned(), ..scan_row(3, 6, 1, Some(4)) });
        let overall = tally.overall_rows();
        let value = |metric| overall.iter().find(|it| it.metric == metric).unwrap().value();
        assert_eq!(
            (value(Metric::No), value(Metric::Tp), value(Metric::Fo)),
            (Some(10.0), Some(3.0), Some(5.0))
        );
        assert_eq!(value(Metric::FRate), Some(6.0 / 18.0));
        assert!(overall.iter().all(|it| it.subject.dataset == OVERALL));
    }

    #[test]
    fn unknown_false_objects_leave_recall() {
        let mut tally = Tally::default();
        tally.add_scan(&scan_row(3, 4, 2, None));
        let rows = tally.metric_rows();
        let value = |metric| rows.iter().find(|it| it.metric == metric).unwrap().value();
        assert_eq!([Metric::Fo, Metric::Precision, Metric::FRate].map(value), [None; 3]);
        assert_eq!(value(Metric::Recall), Some(0.5));
    }
}
