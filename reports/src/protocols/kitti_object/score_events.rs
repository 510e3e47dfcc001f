//! Changes of counts as the least score that is kept goes down.

use crate::protocols::drawn_scans::{Times, add, n_in_draws};

/// Changes when detections of this score join, other than one more false detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreEvent {
    /// The score.
    pub score: f64,
    /// Index of the scan.
    pub scan: u32,
    /// Increase of the number of right detections. It may be negative in the makers' matching, since a detection that joins
    /// may take an annotation away.
    pub tp: i32,
    /// Increase of the number of false detections.
    pub fp: i32,
    /// Number of hits among them, right when all detections are kept: thresholds are taken from their scores.
    pub n_hits: u32,
    /// Increase of the sum of the similarities of headings.
    pub similarity: f64,
}

/// Annotations and changes of all scans for one question, matched in one way, in any order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScoreEvents {
    /// For each scan with annotations to be found: its index and their number.
    pub annotations: Vec<(u32, u32)>,
    /// Detections that are false and change nothing else: score, and index of the scan.
    pub falses: Vec<(f64, u32)>,
    /// All other changes.
    pub events: Vec<ScoreEvent>,
}

/// Annotations and changes of all scans for one question, the best score first.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredMatches {
    annotations: Vec<(u32, u32)>,
    hits: Vec<(u32, u32)>,
    falses: Vec<u32>,
    turns: Vec<Turn>,
}

/// A change that is more than a false detection.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    scan: u32,
    // Number of false detections with its score or a better one.
    n_falses: u32,
    tp: i32,
    fp: i32,
    n_hits: u32,
    // Whether it is the last of its score.
    is_last: bool,
    similarity: f64,
}

/// Counts of the detections of at least some score, in each of `N` draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counted<const N: usize> {
    /// Those that are right.
    pub tp: [f64; N],
    /// Those that are false.
    pub fp: [f64; N],
    /// Those that thresholds are taken from.
    pub n_hits: [f64; N],
    /// Sum of the similarities of headings, each 0 to 1.
    pub similarity: [f64; N],
}

impl ScoreEvents {
    /// Sorts the changes by score.
    pub fn sorted(mut self) -> ScoredMatches {
        self.falses.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        // Stable: changes of equal scores stay in the order of scans.
        self.events.sort_by(|a, b| b.score.total_cmp(&a.score));
        let (mut turns, mut n_falses) = (Vec::with_capacity(self.events.len()), 0);
        for alike in self.events.chunk_by(|a, b| a.score == b.score) {
            n_falses += self.falses[n_falses..].partition_point(|it| it.0 >= alike[0].score);
            for (index, it) in alike.iter().enumerate() {
                turns.push(Turn {
                    scan: it.scan,
                    n_falses: n_falses as u32,
                    tp: it.tp,
                    fp: it.fp,
                    n_hits: it.n_hits,
                    is_last: index + 1 == alike.len(),
                    similarity: it.similarity,
                });
            }
        }
        let hits = turns.iter().filter(|it| it.n_hits > 0).map(|it| (it.scan, it.n_hits)).collect();
        let falses = self.falses.into_iter().map(|(_, scan)| scan).collect();
        ScoredMatches { annotations: self.annotations, hits, falses, turns }
    }
}

impl ScoredMatches {
    /// Number of annotations that are to be found, where each scan is there once.
    pub fn n_annotations_once(&self) -> u64 {
        self.annotations.iter().map(|(_, n)| u64::from(*n)).sum()
    }

    /// Number of annotations that are to be found in each draw.
    pub fn n_annotations<const N: usize>(&self, times: &[Times<N>]) -> [f64; N] {
        n_in_draws(&self.annotations, times)
    }

    /// Number of detections that thresholds are taken from in each draw.
    pub fn n_hits<const N: usize>(&self, times: &[Times<N>]) -> [f64; N] {
        n_in_draws(&self.hits, times)
    }

    /// Calls `visit` with the counts down to each score at which more changes than the number of false detections, the best
    /// first.
    #[inline(always)]
    pub fn go_through<const N: usize>(&self, times: &[Times<N>], mut visit: impl FnMut(&Counted<N>)) {
        let zeros = [0.0; N];
        let mut counted = Counted { tp: zeros, fp: zeros, n_hits: zeros, similarity: zeros };
        let mut n_falses = 0;
        for turn in &self.turns {
            for scan in &self.falses[n_falses..turn.n_falses as usize] {
                add(&mut counted.fp, &times[*scan as usize]);
            }
            n_falses = turn.n_falses as usize;
            let of_scan = &times[turn.scan as usize];
            let changes = [f64::from(turn.tp), f64::from(turn.fp), f64::from(turn.n_hits), turn.similarity];
            let [tp, fp, n_hits, similarity] = changes.map(|change| of_scan.map(|it| it * change));
            add(&mut counted.tp, &tp);
            add(&mut counted.fp, &fp);
            add(&mut counted.n_hits, &n_hits);
            add(&mut counted.similarity, &similarity);
            if turn.is_last {
                visit(&counted);
            }
        }
    }
}
