//! Rows of ranked boxes, sorted by class and score.

use std::collections::BTreeMap;

use super::drawn_scans::{Times, add, n_in_draws};
use crate::rows::ranked_box_row::{BoxKind, BoxState, PairErrors, RankedBox};
use crate::rows::scan_name::ScanName;
use crate::vocabulary::protocol::{ERROR_DISTANCE, Protocol};

/// Boxes of one scan that count.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct RankedScan {
    // By the index of their class.
    annotations: BTreeMap<u8, Annotations>,
    detections: Vec<FoundBox>,
}

/// The annotations of a class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Annotations {
    n: u32,
    n_with_velocity: u32,
    n_with_attribute: u32,
}

/// A detection that counts.
#[derive(Debug, Clone, PartialEq)]
struct FoundBox {
    class: u8,
    id: u32,
    score: f64,
    pairs: u8,
    errors: Option<Box<PairErrors>>,
}

impl RankedScan {
    /// Adds a box; one that is not evaluated changes nothing.
    pub(super) fn add(&mut self, protocol: Protocol, it: &RankedBox) {
        let class = protocol.ranked_classes().iter().position(|name| *name == it.class);
        let (Some(class), BoxState::Counts) = (class.map(|it| it as u8), it.state) else { return };
        match &it.kind {
            BoxKind::Annotation => {
                let annotations = self.annotations.entry(class).or_default();
                annotations.n += 1;
                annotations.n_with_velocity += u32::from(it.velocity_m_per_s.is_some());
                annotations.n_with_attribute += u32::from(it.attribute.is_some());
            }
            BoxKind::Detection { score, pairs, errors } => {
                let bits = pairs.iter().zip(0..).map(|(pair, distance)| u8::from(pair.is_some()) << distance);
                let pairs = bits.sum();
                let errors = errors.map(Box::new);
                self.detections.push(FoundBox { class, id: it.id, score: *score, pairs, errors });
            }
        }
    }
}

/// The boxes of one class in all scans.
#[derive(Debug, Clone, Default)]
pub(super) struct RankedClass {
    // For each scan with annotations: its index and their number.
    annotations: Vec<(u32, u32)>,
    // Invariant: for each detection the index of its scan and its score, the best score first; equal scores by scan, and in
    // a scan by number.
    scans: Vec<u32>,
    scores: Vec<f64>,
    // Detections that find an annotation, in the same order.
    finders: Vec<Finder>,
    /// Whether the velocity of any annotation is known.
    pub(super) has_velocity: bool,
    /// Whether any annotation has an attribute.
    pub(super) has_attribute: bool,
}

/// A detection that finds an annotation at some distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Finder {
    /// Its index in the ranking.
    pub(super) index: u32,
    pairs: u8,
    // Errors at the distance of errors, if it finds an annotation there.
    errors: Option<PairErrors>,
}

impl Finder {
    /// Whether it finds an annotation at the distance at this index of `PAIR_DISTANCES_M`.
    pub(super) fn finds_at(&self, distance: usize) -> bool {
        self.pairs >> distance & 1 == 1
    }
}

impl RankedClass {
    /// Classes of `protocol`, in its order, of these `scans`, which ascend; scans have the indices of their names in it.
    pub(super) fn all(
        protocol: Protocol,
        scans: &[ScanName],
        rows: &BTreeMap<ScanName, RankedScan>,
    ) -> Vec<Self> {
        let mut classes = vec![Self::default(); protocol.ranked_classes().len()];
        let mut detections: Vec<Vec<(f64, u32, &FoundBox)>> = vec![Vec::new(); classes.len()];
        for (name, scan) in rows {
            let Ok(index) = scans.binary_search(name) else { continue };
            for (class, annotations) in &scan.annotations {
                let class = &mut classes[usize::from(*class)];
                class.annotations.push((index as u32, annotations.n));
                class.has_velocity |= annotations.n_with_velocity > 0;
                class.has_attribute |= annotations.n_with_attribute > 0;
            }
            let mut by_id: Vec<&FoundBox> = scan.detections.iter().collect();
            by_id.sort_by_key(|it| it.id);
            for it in by_id {
                detections[usize::from(it.class)].push((it.score, index as u32, it));
            }
        }
        for (class, detections) in classes.iter_mut().zip(detections) {
            class.rank(detections);
        }
        classes
    }

    /// Ranks detections, which come by scan, and in a scan by number.
    fn rank(&mut self, mut detections: Vec<(f64, u32, &FoundBox)>) {
        // Stable: boxes of equal scores stay in this order.
        detections.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
        self.scans = detections.iter().map(|(_, scan, _)| *scan).collect();
        self.scores = detections.iter().map(|(score, ..)| *score).collect();
        let finders = (0..).zip(detections).filter(|(_, (_, _, it))| it.pairs != 0);
        self.finders = finders
            .map(|(index, (_, _, it))| Finder {
                index,
                pairs: it.pairs,
                errors: it.errors.as_deref().copied(),
            })
            .collect();
    }

    /// Number of annotations in each draw.
    pub(super) fn n_annotations<const N: usize>(&self, times: &[Times<N>]) -> [f64; N] {
        n_in_draws(&self.annotations, times)
    }

    /// Number of annotations, with all scans once.
    pub(super) fn n(&self) -> u64 {
        self.annotations.iter().map(|(_, n)| u64::from(*n)).sum()
    }

    /// Number of detections, with all scans once.
    pub(super) fn n_detections(&self) -> usize {
        self.scans.len()
    }

    /// The score of a detection.
    pub(super) fn score(&self, index: u32) -> f64 {
        self.scores[index as usize]
    }

    /// How often a detection occurs in each draw.
    pub(super) fn times_of<'a, const N: usize>(&self, index: u32, times: &'a [Times<N>]) -> &'a Times<N> {
        &times[self.scans[index as usize] as usize]
    }

    /// Score of the last of the first `n` detections that occurs in a draw; 0 if none does.
    pub(super) fn last_score<const N: usize>(&self, n: usize, times: &[Times<N>], draw: usize) -> f64 {
        let last = self.scans[..n].iter().rposition(|scan| times[*scan as usize][draw] > 0.0);
        last.map_or(0.0, |it| self.scores[it])
    }

    /// Calls `visit` with every detection that finds an annotation, the best first, with how often it occurs in each draw
    /// and how many detections come before it. Returns the number of detections in each draw.
    #[inline(always)]
    pub(super) fn go_through<const N: usize>(
        &self,
        times: &[Times<N>],
        mut visit: impl FnMut(&Finder, &Times<N>, &[f64; N]),
    ) -> [f64; N] {
        let (mut n_all, mut next) = ([0.0; N], 0);
        for finder in &self.finders {
            let index = finder.index as usize;
            for scan in &self.scans[next..index] {
                add(&mut n_all, &times[*scan as usize]);
            }
            let n_times = &times[self.scans[index] as usize];
            visit(finder, n_times, &n_all);
            add(&mut n_all, n_times);
            next = index + 1;
        }
        for scan in &self.scans[next..] {
            add(&mut n_all, &times[*scan as usize]);
        }
        n_all
    }

    /// Detections that find an annotation at the distance of errors, the best first: index and errors.
    pub(super) fn errors(&self) -> impl Iterator<Item = (u32, &PairErrors)> {
        self.finders
            .iter()
            .filter(|it| it.finds_at(ERROR_DISTANCE))
            .filter_map(|it| Some((it.index, it.errors.as_ref()?)))
    }
}
