//! Numbers and their intervals, made of the tally of a run.

use crate::numbers::average_precision::{RankedDetection, average_precision, operating_points};
use crate::numbers::pools::Pool;
use crate::numbers::precision_recall_row::PrecisionRecallRow;
use crate::numbers::run_report::{MetricRow, Subject};
use crate::numbers::sums::FalseObjects;
use crate::numbers::tally::Tally;
use crate::uncertainty::sample::{Draw, Question, Sample};
use crate::vocabulary::formula::Term;
use crate::vocabulary::metric::{Metric, RecallPositions};
use crate::vocabulary::slice::Slice;

impl Tally {
    /// The numbers of each data set: data set by data set, task by task, detector by detector, slice by slice.
    pub fn metric_rows(&self) -> Vec<MetricRow> {
        self.metric_rows_of(&self.draw())
    }

    /// The numbers of each data set, with intervals of these draws.
    pub(crate) fn metric_rows_of(&self, draws: &[Draw]) -> Vec<MetricRow> {
        self.datasets().iter().flat_map(|dataset| self.rows_about(dataset, draws)).collect()
    }

    /// The numbers of all data sets of one origin together, where there are several.
    pub fn overall_rows(&self, draws: &[Draw]) -> Vec<MetricRow> {
        let pools = self.pools().into_iter().filter(Pool::is_of_several);
        pools.flat_map(|it| self.rows_about(it.extent.name(), draws)).collect()
    }

    fn rows_about(&self, dataset: &str, draws: &[Draw]) -> Vec<MetricRow> {
        let mut rows = Vec::new();
        for &task in self.tasks() {
            for detector in self.detectors() {
                for slice in self.slices(task, detector) {
                    let question = Question { dataset, task, detector, slice };
                    let Some(sample) = self.sample(&question, draws) else { continue };
                    if slice != Slice::All && sample.total.is_zero() {
                        continue;
                    }
                    rows.extend(sample.rows(&question));
                    if slice.ranks_detections() {
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

    /// Precision over recall of each data set, task and detector whose detections are ranked, from the highest score.
    pub fn precision_recall_rows(&self) -> Vec<PrecisionRecallRow> {
        let mut rows = Vec::new();
        for (dataset_idx, dataset) in self.datasets().iter().enumerate() {
            for &task in self.tasks() {
                for detector in self.detectors() {
                    let Some(gathered) = self.gathered(dataset_idx, task, detector) else { continue };
                    let is_known = gathered.false_objects == FalseObjects::Known;
                    let Some(ranked) = gathered.ranked(Slice::All).filter(|_| is_known) else { continue };
                    let no = gathered.total(Term::Annotations) as u64;
                    let points = operating_points(ranked);
                    rows.extend(
                        points.iter().map(|it| PrecisionRecallRow::new(dataset, task, detector, no, it)),
                    );
                }
            }
        }
        rows
    }

    /// The detections that count, with their scores; empty if nothing was found. `None` if one of them has no score, the
    /// task does not rank them, rows of matches are not kept, or no data set of the question has an evaluated scan.
    pub fn ranked(&self, question: &Question<'_>) -> Option<Vec<RankedDetection>> {
        let mut all = None;
        for dataset_idx in self.datasets_in(question.dataset) {
            // As for every other number, a data set without evaluated scans is left out.
            if let Some(gathered) = self.gathered(dataset_idx, question.task, question.detector) {
                all.get_or_insert_with(Vec::new).extend(gathered.ranked(question.slice)?);
            }
        }
        all
    }
}

impl Question<'_> {
    fn subject(&self) -> Subject {
        let [dataset, detector] = [self.dataset, self.detector].map(str::to_owned);
        Subject { dataset, task: self.task, detector, slice: self.slice }
    }
}

impl Sample {
    fn rows(&self, question: &Question<'_>) -> Vec<MetricRow> {
        let slice = question.slice;
        let is_timed = self.total.of(Term::TimedScans) > 0.0;
        let is_counted = self.total.of(Term::CountedScans) > 0.0;
        let is_listed = |it: &Metric| match it {
            Metric::ReferenceTime | Metric::TimeRatio => is_timed,
            Metric::Instructions | Metric::PeakMemory => is_counted,
            // For slices these follow from the others.
            Metric::Mo | Metric::Precision => slice == Slice::All,
            _ => true,
        };
        let listed = Metric::of_sums().filter(|it| slice.measures(it)).filter(is_listed);
        listed.map(|metric| self.row(question, &metric)).collect()
    }

    fn row(&self, question: &Question<'_>, metric: &Metric) -> MetricRow {
        let value = self.value(metric);
        let row = |n| MetricRow::new(question.subject(), metric.clone(), value, n);
        let n = match metric {
            Metric::TimeRatio => self.total.of(Term::TimedScans),
            Metric::ReferenceTime => return row(self.total.of(Term::TimedScans) as u64),
            ratio if ratio.is_ratio() => {
                self.total.ratio(ratio, self.false_objects).map_or(0.0, |[_, denominator]| denominator)
            }
            _ => return row(self.n_scans),
        };
        row(n as u64).within(value.and_then(|_| self.interval(metric)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::csv_text;
    use crate::numbers::blocks::{BlockKind, Interval};
    use crate::numbers::tally::Processors;
    use crate::rows::counts::Counts;
    use crate::rows::match_outcome::{
        AnnotationFacts, BoxFacts, DetectionFacts, FoundBy, MatchOutcome, MotionFacts,
    };
    use crate::rows::match_row::MatchRow;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow, SegmentationNumbers};
    use crate::vocabulary::class::{AnnotationClass, DetectionClass, Occlusion};
    use crate::vocabulary::criterion::CriterionKind;
    use crate::vocabulary::extent::OVERALL;
    use crate::vocabulary::reason::{FalseReason, IgnoredDetection, MissReason};
    use crate::vocabulary::task::Task;

    fn boxed(x_m: f32, length_m: f32, yaw_deg: f32) -> BoxFacts {
        let yaw_rad = yaw_deg.to_radians();
        BoxFacts { center_m: [x_m, 0.0, 0.0], length_width_height_m: [length_m, 2.0, 1.5], yaw_rad }
    }

    fn annotation(class: AnnotationClass, n_points: u64, bounding_box: BoxFacts) -> AnnotationFacts {
        let (occlusion, bounding_box) = (Some(Occlusion::None), Some(bounding_box));
        AnnotationFacts { occlusion, bounding_box, ..AnnotationFacts::without_position(class, n_points) }
    }

    fn detection(score: Option<f32>, n_points: u64, bounding_box: BoxFacts) -> DetectionFacts {
        DetectionFacts {
            id: 0,
            class: DetectionClass::Vehicle,
            score,
            n_points,
            bounding_box,
            motion: MotionFacts::default(),
        }
    }

    fn match_row(scan: u32, outcome: MatchOutcome) -> MatchRow {
        let [dataset, sequence, detector] = ["street", "0000", "pca"].map(str::to_owned);
        let (task, criterion) = (Task::Vehicles, CriterionKind::Points);
        MatchRow { dataset, sequence, scan, detector, task, criterion, outcome }
    }

    fn scan_row(scan: u32, no: u64, tp: u64, fo: Option<u64>) -> ScanRow {
        let [dataset, sequence, detector] = ["street", "0000", "pca"].map(str::to_owned);
        let task = Task::Vehicles;
        let numbers = ScanNumbers {
            latency_ms: Some(1.0),
            least_latency_ms: Some(0.8),
            reference_ms: Some(0.2),
            n_ignored_annotations: 1,
            n_ignored_detections: 2,
            segmentation: SegmentationNumbers {
                n_split: 1,
                n_holding: 4,
                n_joining: 1,
                n_touching: 5,
                over_entropy_nats: 0.5,
                under_entropy_nats: 1.0,
            },
            ..ScanNumbers::of_counts(Counts::new(no, tp, fo).unwrap())
        };
        let (time_s, outcome) = (Some(f64::from(scan) / 10.0), ScanOutcome::Evaluated(numbers));
        ScanRow { dataset, sequence, scan, time_s, detector, task, outcome }
    }

    /// Tally of a scan with these outcomes.
    fn seen(scan: &ScanRow, outcomes: impl IntoIterator<Item = MatchOutcome>) -> Tally {
        let mut tally = Tally::default();
        tally.add_scan(scan);
        for outcome in outcomes {
            tally.add_match(&MatchRow { task: scan.task, ..match_row(scan.scan, outcome) });
        }
        tally
    }

    fn missed(class: AnnotationClass, n_points: u64, bounding_box: BoxFacts) -> MatchOutcome {
        let annotation = annotation(class, n_points, bounding_box);
        MatchOutcome::Missed { annotation, reason: MissReason::Split }
    }

    /// Four annotations and three detections: a car found by a box half a metre off, 1 m too short and turned by 190°; a car
    /// found exactly but for 20°; a van missed; a truck 40 m away missed; one false detection 20 m away.
    fn scene() -> Tally {
        let outcomes = [
            MatchOutcome::Matched {
                annotation: annotation(AnnotationClass::Car, 300, boxed(10.0, 4.0, 0.0)),
                detection: detection(Some(0.9), 250, boxed(10.5, 3.0, 190.0)),
                cost: 0.1,
            },
            MatchOutcome::Matched {
                annotation: annotation(AnnotationClass::Car, 30, boxed(20.0, 4.0, 170.0)),
                detection: detection(Some(0.7), 30, boxed(20.0, 4.0, -30.0)),
                cost: 0.0,
            },
            missed(AnnotationClass::Van, 100, boxed(12.0, 5.0, 0.0)),
            missed(AnnotationClass::Truck, 60, boxed(40.0, 8.0, 0.0)),
            MatchOutcome::False {
                detection: detection(Some(0.8), 70, boxed(20.0, 1.0, 0.0)),
                reason: FalseReason::NothingThere,
            },
            MatchOutcome::IgnoredDetection {
                detection: detection(Some(0.99), 70, boxed(20.0, 1.0, 0.0)),
                reason: IgnoredDetection::BeyondRange,
            },
        ];
        seen(&scan_row(3, 4, 2, Some(1)), outcomes)
    }

    #[track_caller]
    fn check(tally: &Tally, slice: &str, expected: &[(Metric, f64)]) {
        let rows = tally.metric_rows();
        let slice = Slice::from_name(slice).unwrap();
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
            "all",
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
                (Metric::BoxCenterError, 0.25),
                (Metric::BoxLengthError, 0.5),
                (Metric::BoxWidthError, 0.0),
                (Metric::BoxYawError, 15.0),
                (Metric::ReferenceTime, 0.2),
                (Metric::TimeRatio, 4.0),
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
        let has_false =
            |it: &MetricRow| matches!(it.subject.slice, Slice::Class(_)) && it.metric == Metric::Fo;
        assert!(!tally.metric_rows().iter().any(has_false));
    }

    #[test]
    fn what_the_labelled_region_cuts_has_a_slice_and_counts_as_any_other() {
        let cut = |n_points_outside| AnnotationFacts {
            n_points_outside,
            ..annotation(AnnotationClass::Car, 100, boxed(10.0, 4.0, 0.0))
        };
        let reason = MissReason::Split;
        let detection = detection(Some(0.9), 100, boxed(10.0, 4.0, 0.0));
        let outcomes = [
            MatchOutcome::Matched { annotation: cut(50), detection, cost: 0.1 },
            MatchOutcome::Missed { annotation: cut(100), reason },
            MatchOutcome::Missed { annotation: cut(49), reason },
        ];
        let tally = seen(&scan_row(3, 3, 1, Some(0)), outcomes);
        check(&tally, "truncated", &[(Metric::No, 2.0), (Metric::Tp, 1.0), (Metric::Recall, 0.5)]);
        check(&tally, "class/car", &[(Metric::No, 3.0)]);
        check(&tally, "range/0-15", &[(Metric::No, 3.0)]);
        let of_truncated =
            |it: &MetricRow| it.subject.slice == Slice::Truncated && it.metric == Metric::Precision;
        assert!(!tally.metric_rows().iter().any(of_truncated));
    }

    #[test]
    fn what_is_tall_is_counted_apart_and_in_nothing_else() {
        let plain = scene();
        let mut with_tall = scene();
        let tree = || annotation(AnnotationClass::Tree, 300, boxed(10.0, 4.0, 0.0));
        let found = FoundBy { detection: detection(Some(0.95), 250, boxed(10.5, 3.0, 0.0)), cost: 0.1 };
        for found_by in [Some(found), None, None] {
            with_tall.add_match(&match_row(3, MatchOutcome::Tall { annotation: tree(), found_by }));
        }
        check(&with_tall, "tall", &[(Metric::No, 3.0), (Metric::Tp, 1.0), (Metric::Recall, 1.0 / 3.0)]);
        let mut rows = with_tall.metric_rows();
        rows.retain(|it| it.subject.slice != Slice::Tall);
        assert_eq!(rows, plain.metric_rows());
    }

    /// Annotations without a box are in the range of their centroid, so that the ranges add up.
    #[test]
    fn ranges_add_up_without_boxes() {
        let unboxed = |x_m| AnnotationFacts {
            bounding_box: None,
            centroid_m: Some([x_m, 3.0, 0.0]),
            ..annotation(AnnotationClass::Car, 100, boxed(0.0, 4.0, 0.0))
        };
        let found = |x_m| MatchOutcome::Matched {
            annotation: unboxed(x_m),
            detection: detection(Some(0.9), 100, boxed(x_m, 4.0, 0.0)),
            cost: 0.1,
        };
        let missed = |x_m| MatchOutcome::Missed { annotation: unboxed(x_m), reason: MissReason::Split };
        let detection = detection(Some(0.9), 100, boxed(20.0, 4.0, 0.0));
        let false_one = MatchOutcome::False { detection, reason: FalseReason::Fragment };
        let outcomes = [found(10.0), found(40.0), missed(10.0), missed(70.0), false_one];
        let tally = seen(&scan_row(3, 4, 2, Some(1)), outcomes);
        let rows = tally.metric_rows();
        for metric in [Metric::No, Metric::Tp, Metric::Fo] {
            let sum = |is_asked: &dyn Fn(Slice) -> bool| -> f64 {
                let asked = rows.iter().filter(|it| it.metric == metric && is_asked(it.subject.slice));
                asked.filter_map(MetricRow::value).sum()
            };
            assert_eq!(
                sum(&|it| matches!(it, Slice::Range(_))),
                sum(&|it| it == Slice::All),
                "{}",
                metric.id()
            );
        }
        check(&tally, "range/30-50", &[(Metric::No, 1.0), (Metric::Recall, 1.0), (Metric::FRate, 1.0)]);
        check(&tally, "range/50-80", &[(Metric::No, 1.0), (Metric::Recall, 0.0)]);
    }

    #[test]
    fn a_detector_that_found_nothing_has_an_average_precision_of_zero() {
        let missed = || missed(AnnotationClass::Car, 100, boxed(10.0, 4.0, 0.0));
        let average_precision = |scan: ScanRow, outcomes: Vec<MatchOutcome>| -> Vec<Option<f64>> {
            let rows = seen(&scan, outcomes).metric_rows().into_iter();
            rows.filter(|it| matches!(it.metric, Metric::AveragePrecision(_))).map(|it| it.value()).collect()
        };
        // Of all, and of its range.
        assert_eq!(average_precision(scan_row(3, 1, 0, Some(0)), vec![missed()]), [Some(0.0); 4]);
        assert_eq!(average_precision(scan_row(3, 1, 0, Some(0)), vec![]), [Some(0.0); 2]);
        // No annotations, unknown false objects, and a task without a ranking.
        assert_eq!(average_precision(scan_row(3, 0, 0, Some(0)), vec![]), [None; 2]);
        assert_eq!(average_precision(scan_row(3, 1, 0, None), vec![missed()]), []);
        let objects = ScanRow { task: Task::Objects, ..scan_row(3, 1, 0, Some(0)) };
        assert_eq!(average_precision(objects, vec![missed()]), []);
    }

    #[test]
    fn average_precision_is_that_of_a_range_too() {
        let at = |x: f32, score: f32| detection(Some(score), 70, boxed(x, 4.0, 0.0));
        let matched = |x: f32, score: f32| MatchOutcome::Matched {
            annotation: annotation(AnnotationClass::Car, 100, boxed(x, 4.0, 0.0)),
            detection: at(x, score),
            cost: 0.25,
        };
        let far = MatchOutcome::False { detection: at(40.0, 0.9), reason: FalseReason::NothingThere };
        let outcomes = vec![matched(10.0, 0.5), far, matched(40.0, 0.4)];
        let rows = seen(&scan_row(3, 2, 2, Some(1)), outcomes).metric_rows();
        let ap = |slice: &str| {
            let is_asked = |it: &&MetricRow| {
                it.metric == Metric::AveragePrecision(RecallPositions::R40)
                    && it.subject.slice.name() == slice
            };
            rows.iter().find(is_asked).and_then(MetricRow::value)
        };
        // The surest detection is false, and far away: nothing near is.
        assert_eq!([ap("range/0-15"), ap("range/30-50"), ap("range/15-30")], [Some(1.0), Some(0.5), None]);
        assert!((ap("all").unwrap() - 2.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn average_precision_does_not_depend_on_the_order_of_equal_scores() {
        let outcome = |is_match: bool| {
            let detection = detection(Some(0.5), 70, boxed(20.0, 1.0, 0.0));
            let annotation = annotation(AnnotationClass::Car, 100, boxed(20.0, 4.0, 0.0));
            if is_match {
                MatchOutcome::Matched { annotation, detection, cost: 0.25 }
            } else {
                MatchOutcome::False { detection, reason: FalseReason::Fragment }
            }
        };
        let rows = |order: [bool; 4]| {
            let tally = seen(&scan_row(3, 4, 2, Some(2)), order.map(outcome));
            (tally.metric_rows(), tally.precision_recall_rows())
        };
        assert_eq!(rows([true, true, false, false]), rows([false, true, false, true]));
    }

    #[test]
    fn precision_over_recall_begins_with_the_highest_score() {
        insta::assert_snapshot!(csv_text(&scene().precision_recall_rows()), @r"
        dataset,task,detector,min_score,no,tp,fo,precision,recall
        street,vehicles,pca,0.900000,4,1,0,1.000000,0.250000
        street,vehicles,pca,0.800000,4,1,1,0.500000,0.250000
        street,vehicles,pca,0.700000,4,2,1,0.666667,0.500000
        ");
    }

    #[test]
    fn a_detection_without_a_score_leaves_no_ranking() {
        let mut tally = scene();
        let detection = detection(None, 70, boxed(20.0, 1.0, 0.0));
        tally.add_match(&match_row(3, MatchOutcome::False { detection, reason: FalseReason::Fragment }));
        assert!(!tally.metric_rows().iter().any(|it| matches!(it.metric, Metric::AveragePrecision(_))));
    }

    /// The interval of the F-rate of scans of drives, each with its drive and time.
    fn f_rate_interval(scans: &[(&str, f64)]) -> Option<Interval> {
        let mut tally = Tally::default();
        for (scan, (drive, time_s)) in (0_u32..).zip(scans) {
            let row = scan_row(scan, 4, 1 + u64::from(scan % 2), Some(1));
            tally.add_scan(&ScanRow { sequence: (*drive).to_owned(), time_s: Some(*time_s), ..row });
        }
        let row = tally.metric_rows().into_iter().find(|it| it.metric == Metric::FRate);
        row.unwrap().interval()
    }

    #[test]
    fn scans_of_a_second_are_one_block_and_one_block_has_no_interval() {
        assert_eq!(f_rate_interval(&[("a", 0.0), ("a", 0.3), ("a", 0.9)]), None);
        let scans = [("a", 0.0), ("a", 0.3), ("a", 0.9), ("a", 1.0), ("a", 3.5)];
        let interval = f_rate_interval(&scans).unwrap();
        assert_eq!((interval.blocks.n_blocks, interval.blocks.kind), (3, BlockKind::Seconds));
        // The two blocks reach 2 / 6 and 4 / 7; all resamples lie between.
        assert_eq!(f_rate_interval(&[("a", 0.0), ("a", 1.1)]).unwrap().ends, [2.0 / 6.0, 4.0 / 7.0]);
    }

    #[test]
    fn ten_drives_are_ten_blocks_however_many_scans_they_have() {
        let drives: Vec<String> = (0..10).map(|it| format!("{it}")).collect();
        let scans: Vec<(&str, f64)> =
            drives.iter().flat_map(|drive| [0.0, 5.0, 10.0].map(|it| (drive.as_str(), it))).collect();
        let blocks = f_rate_interval(&scans).unwrap().blocks;
        assert_eq!((blocks.n_blocks, blocks.kind, blocks.are_too_few()), (10, BlockKind::Drives, false));
        // Nine of them are drawn by the second.
        let blocks = f_rate_interval(&scans[..27]).unwrap().blocks;
        assert_eq!((blocks.n_blocks, blocks.kind, blocks.are_too_few()), (27, BlockKind::Seconds, false));
    }

    #[test]
    fn matches_belong_to_the_block_of_their_scan() {
        // Scan 3 of the scene is at 0.3 s by its number, and at 20.3 s by its time stamp.
        let mut tally = Tally::default();
        for (scan, time_s) in [(3, 20.3), (4, 0.4)] {
            tally.add_scan(&ScanRow { time_s: Some(time_s), ..scan_row(scan, 1, 0, Some(0)) });
            tally.add_match(&match_row(scan, missed(AnnotationClass::Car, 30, boxed(10.0, 4.0, 0.0))));
        }
        let rows = tally.metric_rows();
        let of_cars = rows
            .iter()
            .find(|it| it.subject.slice == Slice::Class(AnnotationClass::Car) && it.metric == Metric::Recall);
        assert_eq!(of_cars.unwrap().interval().unwrap().blocks.n_blocks, 2);
        // A match of a scan without a row counts nowhere.
        tally.add_match(&match_row(5, missed(AnnotationClass::Bus, 30, boxed(10.0, 4.0, 0.0))));
        assert!(!tally.metric_rows().iter().any(|it| it.subject.slice == Slice::Class(AnnotationClass::Bus)));
    }

    #[test]
    fn overall_numbers_are_those_of_the_sums() {
        let mut tally = scene();
        assert!(tally.overall_rows(&tally.draw()).is_empty());
        tally.add_scan(&ScanRow { dataset: "kitti".to_owned(), ..scan_row(3, 6, 1, Some(4)) });
        let overall = tally.overall_rows(&tally.draw());
        let value = |metric| overall.iter().find(|it| it.metric == metric).unwrap().value();
        assert_eq!(
            (value(Metric::No), value(Metric::Tp), value(Metric::Fo)),
            (Some(10.0), Some(3.0), Some(5.0))
        );
        assert_eq!(value(Metric::FRate), Some(6.0 / 18.0));
        assert!(overall.iter().all(|it| it.subject.dataset == OVERALL));
    }

    #[test]
    fn recorded_and_simulated_numbers_are_never_put_together() {
        let mut tally = Tally::of_run(Processors::Alike, ["street".to_owned()].into());
        let scan = |dataset: &str, no, fo| ScanRow { dataset: dataset.to_owned(), ..scan_row(3, no, 1, fo) };
        tally.add_scan(&scan("street", 4, Some(2)));
        tally.add_scan(&scan("kitti", 6, None));
        assert!(tally.overall_rows(&tally.draw()).is_empty() && tally.overall_time_rows().is_empty());
        let of_all = Question { dataset: OVERALL, task: Task::Vehicles, detector: "pca", slice: Slice::All };
        assert!(tally.sample(&of_all, &tally.draw()).is_none());
        tally.add_scan(&scan("nuscenes", 10, None));
        let overall = tally.overall_rows(&tally.draw());
        assert!(overall.iter().all(|it| it.subject.dataset == "overall-recorded"));
        assert_eq!(overall.iter().find(|it| it.metric == Metric::No).unwrap().value(), Some(16.0));
    }

    #[test]
    fn unknown_false_objects_leave_recall() {
        let rows = seen(&scan_row(3, 4, 2, None), []).metric_rows();
        let value = |metric| rows.iter().find(|it| it.metric == metric).unwrap().value();
        assert_eq!([Metric::Fo, Metric::Precision, Metric::FRate].map(value), [None; 3]);
        assert_eq!(value(Metric::Recall), Some(0.5));
    }
}
