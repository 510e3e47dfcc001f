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
    /// Scans per second of detection: number of scans / total time.
    FpsMean,
    /// Time of detection of a scan.
    Latency(LatencyStatistic),
    /// Median time of the stage of this name.
    StageP50(String),
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// More is better.
    HigherIsBetter,
    /// Less is better.
    LowerIsBetter,
    /// Neither: it says how much was measured, not how well.
    Neither,
}

const STAGE_PREFIX: &str = "stage_p50_ms/";

impl Metric {
    /// The metrics without a name in their id, in the order of a report.
    const UNNAMED: [Self; 19] = [
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
        Self::FpsMean,
        Self::Latency(LatencyStatistic::Min),
        Self::Latency(LatencyStatistic::P50),
        Self::Latency(LatencyStatistic::P90),
        Self::Latency(LatencyStatistic::P95),
        Self::Latency(LatencyStatistic::P99),
        Self::Latency(LatencyStatistic::Max),
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
            Self::FpsMean => "fps_mean",
            Self::Latency(LatencyStatistic::Min) => "latency_min_ms",
            Self::Latency(LatencyStatistic::P50) => "latency_p50_ms",
            Self::Latency(LatencyStatistic::P90) => "latency_p90_ms",
            Self::Latency(LatencyStatistic::P95) => "latency_p95_ms",
            Self::Latency(LatencyStatistic::P99) => "latency_p99_ms",
            Self::Latency(LatencyStatistic::Max) => "latency_max_ms",
            Self::StageP50(stage) => return format!("{STAGE_PREFIX}{stage}"),
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
            | Self::UnknowableDetections => "count",
            Self::Precision
            | Self::Recall
            | Self::FRate
            | Self::OverSegmentation
            | Self::UnderSegmentation => "ratio",
            Self::FpsMean => "scans/s",
            Self::Latency(_) | Self::StageP50(_) => "ms",
        }
    }

    /// Which way is better.
    pub fn direction(&self) -> Direction {
        match self {
            Self::No | Self::IgnoredAnnotations | Self::IgnoredDetections | Self::UnknowableDetections => {
                Direction::Neither
            }
            Self::Tp | Self::Precision | Self::Recall | Self::FRate | Self::FpsMean => {
                Direction::HigherIsBetter
            }
            Self::Mo
            | Self::Fo
            | Self::OverSegmentation
            | Self::UnderSegmentation
            | Self::Latency(_)
            | Self::StageP50(_) => Direction::LowerIsBetter,
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
    fn metrics_are_listed_in_their_order() {
        assert!(Metric::UNNAMED.is_sorted());
    }
}
