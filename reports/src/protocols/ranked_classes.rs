//! Rows of ranked boxes, sorted by class and score.

use std::collections::BTreeMap;

use crate::rows::ranked_box_row::{BoxKind, BoxState, PairErrors, RankedBox};
use crate::rows::scan_name::ScanName;
use crate::vocabulary::ranked_protocol::RankedProtocol;

/// What counts of one scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct RankedScan {
    // By the place of their class.
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
    pub(super) fn add(&mut self, protocol: RankedProtocol, it: &RankedBox) {
        let class = protocol.classes().iter().position(|name| *name == it.class);
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
    // Of each scan that has some: its place, and how many.
    annotations: Vec<(u32, u32)>,
    /// The best score first; those of like scores by scan, and in a scan by their numbers.
    pub(super) detections: Vec<RankedDetection>,
    errors: Vec<PairErrors>,
    /// Whether the velocity of any annotation is known.
    pub(super) has_velocity: bool,
    /// Whether any annotation has an attribute.
    pub(super) has_attribute: bool,
}

/// A detection in the ranking.
#[derive(Debug, Clone, Copy)]
pub(super) struct RankedDetection {
    pub(super) score: f64,
    /// The place of its scan.
    pub(super) scan: u32,
    errors: u32,
    pairs: u8,
}

impl RankedDetection {
    /// Whether it finds an annotation at the distance at this place of `PAIR_DISTANCES_M`.
    pub(super) fn finds_at(&self, distance: usize) -> bool {
        self.pairs >> distance & 1 == 1
    }
}

impl RankedClass {
    /// The classes of `protocol`, in its order, of the scans at the places of their names in `scans`, which ascend.
    pub(super) fn all(
        protocol: RankedProtocol,
        scans: &[ScanName],
        rows: &BTreeMap<ScanName, RankedScan>,
    ) -> Vec<Self> {
        let mut classes = vec![Self::default(); protocol.classes().len()];
        for (name, scan) in rows {
            let Ok(place) = scans.binary_search(name) else { continue };
            for (class, annotations) in &scan.annotations {
                let class = &mut classes[usize::from(*class)];
                class.annotations.push((place as u32, annotations.n));
                class.has_velocity |= annotations.n_with_velocity > 0;
                class.has_attribute |= annotations.n_with_attribute > 0;
            }
            let mut by_id: Vec<&FoundBox> = scan.detections.iter().collect();
            by_id.sort_by_key(|it| it.id);
            for it in by_id {
                classes[usize::from(it.class)].push(place as u32, it);
            }
        }
        for class in &mut classes {
            // Stable: boxes of like scores stay in the order of scans and numbers.
            class.detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        }
        classes
    }

    fn push(&mut self, scan: u32, it: &FoundBox) {
        let errors = self.errors.len() as u32;
        self.errors.extend(it.errors.as_deref());
        self.detections.push(RankedDetection { score: it.score, scan, errors, pairs: it.pairs });
    }

    /// The annotations where scan *i* is there `times[i]` times.
    pub(super) fn n_annotations(&self, times: &[u16]) -> u64 {
        self.annotations.iter().map(|(scan, n)| u64::from(*n) * u64::from(times[*scan as usize])).sum()
    }

    /// The annotations of all scans once.
    pub(super) fn n(&self) -> u64 {
        self.annotations.iter().map(|(_, n)| u64::from(*n)).sum()
    }

    /// How far `detection` is from the annotation that it finds at the distance of errors, where it finds one.
    pub(super) fn errors_of(&self, detection: &RankedDetection) -> &PairErrors {
        &self.errors[detection.errors as usize]
    }
}
