//! What is measured: each metric with its id, its unit and which way is better.

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
    /// Mean error of the boxes of matched pairs.
    BoxError(BoxDimension),
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
    DoorP50,
    /// Scans to which the detector gave no answer, and that count as if it had found nothing.
    FailedScans,
    /// Time of the reference that detectors are timed in turns with: a plain write of a grid. Geometric mean over scans of the
    /// shortest of all repetitions.
    ReferenceTime,
    /// Time of detection over that of the reference, of the shortest of all repetitions: geometric mean over scans.
    TimeRatio,
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

/// What two boxes are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BoxDimension {
    /// Distance of the centres on the ground plan.
    Center,
    /// Length, along the heading.
    Length,
    /// Width.
    Width,
    /// Heading, where front and back are the same.
    Yaw,
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

/// The name of what detectors are timed in turns with: a plain write of a grid, the least that any grid method has to do.
pub const SPEED_REFERENCE: &str = "grid-write";

impl Metric {
    /// The metrics without a name in their id, in the order of a report.
    const UNNAMED: [Self; 35] = [
        Self::No,
        Self::Tp,
        Self::Mo,
        Self::Fo,
        Self::Precision,
        Self::Recall,
        Self::FRate,
        Self::IgnoredAnnotations,
        Self::IgnoredDetections,
        Self::UnknowableDetections,
        Self::OverSegmentation,
        Self::UnderSegmentation,
        Self::OverSegmentationEntropy,
        Self::OverSegmentationEntropyPerObject,
        Self::UnderSegmentationEntropy,
        Self::UnderSegmentationEntropyPerObject,
        Self::BoxError(BoxDimension::Center),
        Self::BoxError(BoxDimension::Length),
        Self::BoxError(BoxDimension::Width),
        Self::BoxError(BoxDimension::Yaw),
        Self::AveragePrecision(RecallPositions::Points101),
        Self::AveragePrecision(RecallPositions::R40),
        Self::FpsMean,
        Self::FpsP50,
        Self::Latency(LatencyStatistic::Min),
        Self::Latency(LatencyStatistic::P50),
        Self::Latency(LatencyStatistic::P90),
        Self::Latency(LatencyStatistic::P95),
        Self::Latency(LatencyStatistic::P99),
        Self::Latency(LatencyStatistic::Max),
        Self::CpuMean,
        Self::DoorP50,
        Self::FailedScans,
        Self::ReferenceTime,
        Self::TimeRatio,
    ];

    /// The name used in files.
    pub fn id(&self) -> String {
        let id = match self {
            Self::No => "no",
            Self::Tp => "tp",
            Self::Mo => "mo",
            Self::Fo => "fo",
            Self::Precision => "precision",
            Self::Recall => "recall",
            Self::FRate => "f_rate",
            Self::IgnoredAnnotations => "ignored_annotations",
            Self::IgnoredDetections => "ignored_detections",
            Self::UnknowableDetections => "unknowable_detections",
            Self::OverSegmentation => "over_segmentation",
            Self::UnderSegmentation => "under_segmentation",
            Self::OverSegmentationEntropy => "ose",
            Self::OverSegmentationEntropyPerObject => "ose_per_object",
            Self::UnderSegmentationEntropy => "use",
            Self::UnderSegmentationEntropyPerObject => "use_per_object",
            Self::BoxError(BoxDimension::Center) => "box_center_error_m",
            Self::BoxError(BoxDimension::Length) => "box_length_error_m",
            Self::BoxError(BoxDimension::Width) => "box_width_error_m",
            Self::BoxError(BoxDimension::Yaw) => "box_yaw_error_deg",
            Self::AveragePrecision(RecallPositions::Points101) => "ap_101_points",
            Self::AveragePrecision(RecallPositions::R40) => "ap_r40",
            Self::FpsMean => "fps_mean",
            Self::FpsP50 => "fps_p50",
            Self::Latency(LatencyStatistic::Min) => "latency_min_ms",
            Self::Latency(LatencyStatistic::P50) => "latency_p50_ms",
            Self::Latency(LatencyStatistic::P90) => "latency_p90_ms",
            Self::Latency(LatencyStatistic::P95) => "latency_p95_ms",
            Self::Latency(LatencyStatistic::P99) => "latency_p99_ms",
            Self::Latency(LatencyStatistic::Max) => "latency_max_ms",
            Self::CpuMean => "cpu_mean_ms",
            Self::DoorP50 => "door_p50_ms",
            Self::FailedScans => "failed_scans",
            Self::ReferenceTime => "reference_ms",
            Self::TimeRatio => "time_over_reference",
            Self::StageP50(stage) => return format!("{STAGE_PREFIX}{stage}"),
            Self::OfProtocol(name) => &name.id,
        };
        id.to_owned()
    }

    /// The metric of this id; `None` if there is none.
    pub fn from_id(id: &str) -> Option<Self> {
        match id.strip_prefix(STAGE_PREFIX) {
            Some("") => None,
            Some(stage) => Some(Self::StageP50(stage.to_owned())),
            None => Self::UNNAMED.into_iter().find(|it| it.id() == id),
        }
    }

    /// The unit of its values.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::No
            | Self::Tp
            | Self::Mo
            | Self::Fo
            | Self::IgnoredAnnotations
            | Self::IgnoredDetections
            | Self::UnknowableDetections
            | Self::FailedScans => "count",
            Self::Precision
            | Self::Recall
            | Self::FRate
            | Self::OverSegmentation
            | Self::UnderSegmentation
            | Self::AveragePrecision(_) => "ratio",
            Self::OverSegmentationEntropy
            | Self::OverSegmentationEntropyPerObject
            | Self::UnderSegmentationEntropy
            | Self::UnderSegmentationEntropyPerObject => "nats",
            Self::BoxError(BoxDimension::Center | BoxDimension::Length | BoxDimension::Width) => "m",
            Self::BoxError(BoxDimension::Yaw) => "deg",
            Self::FpsMean | Self::FpsP50 => "scans/s",
            Self::Latency(_) | Self::CpuMean | Self::DoorP50 | Self::StageP50(_) | Self::ReferenceTime => {
                "ms"
            }
            Self::TimeRatio => "times",
            Self::OfProtocol(name) => name.unit,
        }
    }

    /// Which way is better.
    pub fn direction(&self) -> Direction {
        match self {
            Self::No
            | Self::IgnoredAnnotations
            | Self::IgnoredDetections
            | Self::UnknowableDetections
            | Self::DoorP50
            | Self::ReferenceTime => Direction::Neither,
            Self::Tp
            | Self::Precision
            | Self::Recall
            | Self::FRate
            | Self::AveragePrecision(_)
            | Self::FpsMean
            | Self::FpsP50 => Direction::HigherIsBetter,
            Self::Mo
            | Self::Fo
            | Self::OverSegmentation
            | Self::UnderSegmentation
            | Self::OverSegmentationEntropy
            | Self::OverSegmentationEntropyPerObject
            | Self::UnderSegmentationEntropy
            | Self::UnderSegmentationEntropyPerObject
            | Self::BoxError(_)
            | Self::Latency(_)
            | Self::CpuMean
            | Self::FailedScans
            | Self::TimeRatio
            | Self::StageP50(_) => Direction::LowerIsBetter,
            Self::OfProtocol(name) => name.direction,
        }
    }

    /// Whether it is a time or made of one, and so another in every run.
    pub fn is_time(&self) -> bool {
        matches!(
            self,
            Self::FpsMean
                | Self::FpsP50
                | Self::Latency(_)
                | Self::CpuMean
                | Self::DoorP50
                | Self::ReferenceTime
                | Self::TimeRatio
                | Self::StageP50(_)
        )
    }

    /// The metrics that a gate can hold to a tolerance.
    pub(crate) fn gated() -> impl Iterator<Item = Self> {
        let is_gated = |it: &Self| {
            !it.is_time() && it.direction() != Direction::Neither && !matches!(it, Self::AveragePrecision(_))
        };
        Self::UNNAMED.into_iter().filter(is_gated)
    }

    /// What is to be said of a value made of `n`; `None` if nothing is.
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
        for metric in Metric::UNNAMED.into_iter().chain([Metric::StageP50("grid".to_owned())]) {
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
        assert!(Metric::UNNAMED.is_sorted());
    }
}
