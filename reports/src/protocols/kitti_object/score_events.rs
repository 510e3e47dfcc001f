//! How counts change as the least score that is kept goes down.

/// What changes when detections of this score join.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreEvent {
    /// The score.
    pub score: f64,
    /// Place of the scan.
    pub scan: u32,
    /// By how much the detections that are right grow. Of the makers' matching it may be negative, since what joins may take an annotation away.
    pub tp: i32,
    /// By how much those that are false grow.
    pub fp: i32,
    /// By how much the sum of the similarities of headings grows.
    pub similarity: f64,
}

/// A detection that is kept, whatever else is: what thresholds are taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Its score.
    pub score: f64,
    /// Place of the scan.
    pub scan: u32,
}

/// What one question asks of all scans, matched in one way.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScoredMatches {
    /// Of each scan that has some: its place, and the annotations that are to be found.
    pub annotations: Vec<(u32, u32)>,
    /// Detections that are right when all are kept, the best score first; empty where nobody asks for them.
    pub hits: Vec<Hit>,
    /// The changes, the best score first.
    pub events: Vec<ScoreEvent>,
}

/// Detections of some least score.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counted {
    /// Those that are right.
    pub tp: i64,
    /// Those that are false.
    pub fp: i64,
    /// Sum of the similarities of headings, each 0 to 1.
    pub similarity: f64,
}

impl ScoredMatches {
    /// Puts hits and events in the order of scores; those of like scores stay in the order of scans.
    pub fn sort(&mut self) {
        self.hits.sort_by(|a, b| b.score.total_cmp(&a.score));
        self.events.sort_by(|a, b| b.score.total_cmp(&a.score));
    }

    /// Annotations that are to be found where scan *i* is there `times[i]` times.
    pub fn n_annotations(&self, times: &[u16]) -> u64 {
        self.annotations.iter().map(|(scan, n)| u64::from(*n) * u64::from(times[*scan as usize])).sum()
    }
}

impl Counted {
    /// Takes an event in, whose scan is there `times` times.
    pub fn add(&mut self, event: &ScoreEvent, times: u16) {
        let times = i64::from(times);
        self.tp += times * i64::from(event.tp);
        self.fp += times * i64::from(event.fp);
        self.similarity += times as f64 * event.similarity;
    }
}
