//! Metrics: each with its id, its unit and which way is better.

use super::formula::{Formula, Term};

/// A metric of `report.json`.
///
/// The order is that in which a report lists them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Metric {
    /// NO, the annotations that count.
    No,
    /// TP, the annotations found.
    Tp,
    /// MO, the annotations missed.
    Mo,
    /// FO, the false detections.
    Fo,
    /// TP / (TP + FO).
    Precision,
    /// TP / NO.
    Recall,
    /// 2 TP / (2 TP + MO + FO).
    FRate,
    /// Annotations that are neither found nor missed.
    IgnoredAnnotations,
    /// Detections that are neither right nor false.
    IgnoredDetections,
    /// Detections of which it cannot be known whether they are false.
    UnknowableDetections,
    /// Share of the annotations that are torn apart.
    OverSegmentation,
    /// Share of the detections holding an annotation that run several together.
    UnderSegmentation,
    /// OSE, how far the points of annotations are spread over several detections: an entropy, summed over annotations.
    OverSegmentationEntropy,
    /// OSE over the number of annotations.
    OverSegmentationEntropyPerObject,
    /// USE, how far the points of detections belong to several annotations: an entropy, summed over detections.
    UnderSegmentationEntropy,
    /// USE over the number of detections that hold a point of an annotation.
    UnderSegmentationEntropyPerObject,
    /// Distance of the centres of the boxes of matched pairs on the ground plan, a mean.
    BoxCenterError,
    /// Difference of their lengths, along the heading.
    BoxLengthError,
    /// Difference of their widths.
    BoxWidthError,
    /// Angle between their headings, where front and back are the same.
    BoxYawError,
    /// Mean precision over recall, where detections are ranked by score.
    AveragePrecision(RecallPositions),
    /// Scans per second of detection: number of scans / total time.
    FpsMean,
    /// One over the median time of detection of a scan.
    FpsP50,
    /// Time of detection of a scan.
    Latency(LatencyStatistic),
    /// Time on processors of a detection, on all threads and in all processes of the detector: mean over scans.
    CpuMean,
    /// Median time of the way to a detector that is a program of its own, and back.
    OverheadP50,
    /// Scans to which the detector gave no answer, and that count as if it had found nothing.
    FailedScans,
    /// Time of the reference that detectors are timed in turns with: a plain write of a grid. Geometric mean over scans of
    /// the shortest of all repetitions.
    ReferenceTime,
    /// Time of detection over that of the reference, of the shortest of all repetitions: geometric mean over scans.
    TimeRatio,
    /// Instructions of a detection: mean over scans.
    Instructions,
    /// The most memory of a detection at once: mean over scans.
    PeakMemory,
    /// How well objects are classified of which a part has been seen.
    Partial(PartialMetric),
    /// Median time of the stage of this name.
    StageP50(String),
    /// A number under a protocol of others.
    OfProtocol(ProtocolMetricName),
}

/// A number under a protocol of others.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProtocolMetricName {
    /// The name used in files, such as `ap` or `nds`.
    pub id: String,
    /// The unit of its values.
    pub unit: &'static str,
    /// Which way is better.
    pub direction: Direction,
}

/// A number of partly seen objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartialMetric {
    /// The mean of the recalls of the learnt classes.
    MeanRecall,
    /// The share of objects of no learnt class that are classified as none of these.
    StrangersRejected,
    /// The share of objects of the learnt classes that are classified as none of these.
    KnownRejected,
}

impl PartialMetric {
    /// All.
    pub const ALL: [Self; 3] = [Self::MeanRecall, Self::StrangersRejected, Self::KnownRejected];
}

/// At which recalls precision is looked up for an average precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RecallPositions {
    /// 0, 0.01, …, 1: as COCO has it.
    Points101,
    /// 1/40, 2/40, …, 1: as KITTI has had it since 2019.
    R40,
}

/// A statistic of the times of all scans, by nearest rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LatencyStatistic {
    /// The shortest.
    Min,
    /// The median.
    P50,
    /// The 90th percentile.
    P90,
    /// The 95th percentile.
    P95,
    /// The 99th percentile.
    P99,
    /// The longest.
    Max,
}

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// More is better.
    HigherIsBetter,
    /// Less is better.
    LowerIsBetter,
    /// Neither: it says how much was measured, not how well.
    Neither,
}

const STAGE_PREFIX: &str = "stage_p50_ms/";

/// Name of the reference that detectors are timed in turns with: a plain grid write, the least of any grid method.
pub const SPEED_REFERENCE: &str = "grid-write";

/// A metric with its id, its unit, which way is better, and how it is made.
type Declared = (Metric, &'static str, &'static str, Direction, Formula);

/// The metrics without a name in their id, in the order of a report.
static METRICS: &[Declared] = {
    use Direction::{HigherIsBetter as Higher, LowerIsBetter as Lower, Neither};
    use Formula::{Difference, GeometricMean, NotOfSums, Ratio, Sum};
    use Term::{
        Annotations, BoxPairs, CenterError, False, Holding, Joining, LengthError, LogReference, LogTimeRatio,
        Matched, OverEntropy, Split, TimedScans, Touching, UnderEntropy, Unknowable, WidthError, YawError,
    };
    &[
        (Metric::No, "no", "count", Neither, Sum(Annotations)),
        (Metric::Tp, "tp", "count", Higher, Sum(Matched)),
        (Metric::Mo, "mo", "count", Lower, Difference(Annotations, Matched)),
        (Metric::Fo, "fo", "count", Lower, Sum(False)),
        (Metric::Precision, "precision", "ratio", Higher, Ratio(&[Matched], &[Matched, False])),
        (Metric::Recall, "recall", "ratio", Higher, Ratio(&[Matched], &[Annotations])),
        (
            Metric::FRate,
            "f_rate",
            "ratio",
            Higher,
            Ratio(&[Matched, Matched], &[Annotations, Matched, False]),
        ),
        (Metric::IgnoredAnnotations, "ignored_annotations", "count", Neither, Sum(Term::IgnoredAnnotations)),
        (Metric::IgnoredDetections, "ignored_detections", "count", Neither, Sum(Term::IgnoredDetections)),
        (Metric::UnknowableDetections, "unknowable_detections", "count", Neither, Sum(Unknowable)),
        (Metric::OverSegmentation, "over_segmentation", "ratio", Lower, Ratio(&[Split], &[Annotations])),
        (Metric::UnderSegmentation, "under_segmentation", "ratio", Lower, Ratio(&[Joining], &[Holding])),
        (Metric::OverSegmentationEntropy, "ose", "nats", Lower, Sum(OverEntropy)),
        (
            Metric::OverSegmentationEntropyPerObject,
            "ose_per_object",
            "nats",
            Lower,
            Ratio(&[OverEntropy], &[Annotations]),
        ),
        (Metric::UnderSegmentationEntropy, "use", "nats", Lower, Sum(UnderEntropy)),
        (
            Metric::UnderSegmentationEntropyPerObject,
            "use_per_object",
            "nats",
            Lower,
            Ratio(&[UnderEntropy], &[Touching]),
        ),
        (Metric::BoxCenterError, "box_center_error_m", "m", Lower, Ratio(&[CenterError], &[BoxPairs])),
        (Metric::BoxLengthError, "box_length_error_m", "m", Lower, Ratio(&[LengthError], &[BoxPairs])),
        (Metric::BoxWidthError, "box_width_error_m", "m", Lower, Ratio(&[WidthError], &[BoxPairs])),
        (Metric::BoxYawError, "box_yaw_error_deg", "deg", Lower, Ratio(&[YawError], &[BoxPairs])),
        (Metric::AveragePrecision(RecallPositions::Points101), "ap_101_points", "ratio", Higher, NotOfSums),
        (Metric::AveragePrecision(RecallPositions::R40), "ap_r40", "ratio", Higher, NotOfSums),
        (Metric::FpsMean, "fps_mean", "scans/s", Higher, NotOfSums),
        (Metric::FpsP50, "fps_p50", "scans/s", Higher, NotOfSums),
        (Metric::Latency(LatencyStatistic::Min), "latency_min_ms", "ms", Lower, NotOfSums),
        (Metric::Latency(LatencyStatistic::P50), "latency_p50_ms", "ms", Lower, NotOfSums),
        (Metric::Latency(LatencyStatistic::P90), "latency_p90_ms", "ms", Lower, NotOfSums),
        (Metric::Latency(LatencyStatistic::P95), "latency_p95_ms", "ms", Lower, NotOfSums),
        (Metric::Latency(LatencyStatistic::P99), "latency_p99_ms", "ms", Lower, NotOfSums),
        (Metric::Latency(LatencyStatistic::Max), "latency_max_ms", "ms", Lower, NotOfSums),
        (Metric::CpuMean, "cpu_mean_ms", "ms", Lower, NotOfSums),
        (Metric::OverheadP50, "overhead_p50_ms", "ms", Neither, NotOfSums),
        (Metric::FailedScans, "failed_scans", "count", Lower, NotOfSums),
        (Metric::ReferenceTime, "reference_ms", "ms", Neither, GeometricMean(LogReference, TimedScans)),
        (Metric::TimeRatio, "time_over_reference", "times", Lower, GeometricMean(LogTimeRatio, TimedScans)),
        (
            Metric::Instructions,
            "instructions_million",
            "million",
            Lower,
            Ratio(&[Term::Instructions], &[Term::CountedScans]),
        ),
        (
            Metric::PeakMemory,
            "peak_memory_mib",
            "mib",
            Lower,
            Ratio(&[Term::PeakMemory], &[Term::CountedScans]),
        ),
        (Metric::Partial(PartialMetric::MeanRecall), "mean_recall", "ratio", Higher, NotOfSums),
        (Metric::Partial(PartialMetric::StrangersRejected), "strangers_rejected", "ratio", Higher, NotOfSums),
        (Metric::Partial(PartialMetric::KnownRejected), "known_rejected", "ratio", Lower, NotOfSums),
    ]
};

impl Metric {
    /// The line of a metric without a name in its id.
    fn declared(&self) -> &'static Declared {
        METRICS.iter().find(|it| it.0 == *self).expect("all that have no name in their id are listed")
    }

    /// The name used in files.
    pub fn id(&self) -> String {
        match self {
            Self::StageP50(stage) => format!("{STAGE_PREFIX}{stage}"),
            Self::OfProtocol(name) => name.id.clone(),
            listed => listed.declared().1.to_owned(),
        }
    }

    /// The metric of this id; `None` if there is none.
    pub fn from_id(id: &str) -> Option<Self> {
        match id.strip_prefix(STAGE_PREFIX) {
            Some("") => None,
            Some(stage) => Some(Self::StageP50(stage.to_owned())),
            None => METRICS.iter().find(|it| it.1 == id).map(|it| it.0.clone()),
        }
    }

    /// The unit of its values.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::StageP50(_) => "ms",
            Self::OfProtocol(name) => name.unit,
            listed => listed.declared().2,
        }
    }

    /// Which way is better.
    pub fn direction(&self) -> Direction {
        match self {
            Self::StageP50(_) => Direction::LowerIsBetter,
            Self::OfProtocol(name) => name.direction,
            listed => listed.declared().3,
        }
    }

    /// How it is made of sums.
    pub fn formula(&self) -> Formula {
        match self {
            Self::StageP50(_) | Self::OfProtocol(_) => Formula::NotOfSums,
            listed => listed.declared().4,
        }
    }

    /// The metrics that are made of sums, in the order of a report.
    pub fn of_sums() -> impl Iterator<Item = Self> {
        METRICS.iter().filter(|it| !matches!(it.4, Formula::NotOfSums)).map(|it| it.0.clone())
    }

    /// Whether it is a ratio of sums.
    pub fn is_ratio(&self) -> bool {
        matches!(self.formula(), Formula::Ratio(..))
    }

    /// Whether histories of runs keep it: rates, errors of boxes, and times beside the reference.
    pub fn is_kept_in_history(&self) -> bool {
        self.is_ratio() || matches!(self, Self::AveragePrecision(_) | Self::TimeRatio)
    }

    /// Whether it is a time or made of one, and so another in every run.
    pub fn is_time(&self) -> bool {
        !matches!(self, Self::OfProtocol(_)) && matches!(self.unit(), "ms" | "scans/s" | "times")
    }

    /// The metrics that a gate can hold to a tolerance.
    pub(crate) fn gated() -> impl Iterator<Item = Self> {
        let is_gated = |it: &Self| {
            !it.is_time() && it.direction() != Direction::Neither && !matches!(it, Self::AveragePrecision(_))
        };
        METRICS.iter().map(|it| it.0.clone()).filter(is_gated)
    }

    /// The caveat of a value made of `n`; `None` if there is none.
    ///
    /// Below these numbers of scans it is more than 5 % likely that none of them is slower than the percentile that it
    /// stands for: 0.95^59 and 0.99^299 are just below 0.05.
    pub fn caveat(&self, n: u64) -> Option<&'static str> {
        match self {
            Self::Latency(LatencyStatistic::P95) if n < 59 => Some("p95 of fewer than 59 scans"),
            Self::Latency(LatencyStatistic::P99) if n < 299 => Some("p99 of fewer than 299 scans"),
            _ => None,
        }
    }
}

impl Formula {
    /// The sums that it is made of.
    fn terms(&self) -> impl Iterator<Item = Term> {
        let [left, right]: [&[Term]; 2] = match self {
            Self::Sum(sum) => [std::slice::from_ref(sum), &[]],
            Self::Difference(left, right) | Self::GeometricMean(left, right) => {
                [std::slice::from_ref(left), std::slice::from_ref(right)]
            }
            Self::Ratio(part, whole) => [part, whole],
            Self::NotOfSums => [&[], &[]],
        };
        left.iter().chain(right).copied()
    }

    /// Whether it can be known only where all false detections are.
    pub fn needs_false_detections(&self) -> bool {
        self.terms().any(|it| it == Term::False)
    }

    /// Whether it can be known of a part of the objects: segmentation and boxes are measured of everything alone.
    pub fn is_of_slices(&self) -> bool {
        let is_of_slices = |it| matches!(it, Term::Annotations | Term::Matched | Term::False);
        !matches!(self, Self::NotOfSums) && self.terms().all(is_of_slices)
    }
}

impl Direction {
    /// As `report.json` writes it: yes, no, or null for neither.
    pub fn higher_is_better(self) -> Option<bool> {
        match self {
            Self::HigherIsBetter => Some(true),
            Self::LowerIsBetter => Some(false),
            Self::Neither => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_id_leads_back_to_its_metric() {
        let listed = METRICS.iter().map(|it| it.0.clone());
        for metric in listed.chain([Metric::StageP50("grid".to_owned())]) {
            assert_eq!(Metric::from_id(&metric.id()), Some(metric));
        }
    }

    #[test]
    fn unknown_ids_lead_nowhere() {
        for id in ["", "F_RATE", "stage_p50_ms", "stage_p50_ms/"] {
            assert_eq!(Metric::from_id(id), None, "{id:?}");
        }
    }

    #[test]
    fn percentiles_of_few_scans_are_flagged() {
        let [p95, p99] = [LatencyStatistic::P95, LatencyStatistic::P99].map(Metric::Latency);
        assert_eq!([58, 59].map(|n| p95.caveat(n).is_some()), [true, false]);
        assert_eq!([298, 299].map(|n| p99.caveat(n).is_some()), [true, false]);
        assert!(0.95_f64.powi(59) < 0.05 && 0.95_f64.powi(58) > 0.05);
        assert!(0.99_f64.powi(299) < 0.05 && 0.99_f64.powi(298) > 0.05);
        assert_eq!(Metric::FRate.caveat(1), None);
    }

    #[test]
    fn metrics_are_listed_in_their_order() {
        assert!(METRICS.iter().map(|it| &it.0).is_sorted());
    }
}
