//! Sums and ranked detections of one detector on one data set in one task.

use std::collections::BTreeMap;

use crate::numbers::average_precision::RankedDetection;
use crate::numbers::block_sums::BlockSums;
use crate::numbers::blocks::{Blocks, DriveSecond};
use crate::numbers::sums::{FalseObjects, Sums};
use crate::rows::counts::Counts;
use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, range_m};
use crate::vocabulary::formula::Term;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Sums and ranked detections of one detector on one data set in one task.
#[derive(Debug, Clone)]
pub(crate) struct Gathered {
    pub(crate) n_scans: u64,
    pub(crate) false_objects: FalseObjects,
    pub(super) counts: Option<Counts>,
    has_enough_drives: bool,
    pub(super) slices: BTreeMap<Slice, BlockSums>,
    /// The detections that count, of each slice that ranks them; `None` if the task does not, or once one of them came without
    /// a score.
    ranked: Option<BTreeMap<Slice, Vec<RankedDetection>>>,
}

impl Gathered {
    pub(super) fn of_task(task: Task, has_enough_drives: bool) -> Self {
        Self {
            n_scans: 0,
            false_objects: FalseObjects::Known,
            counts: None,
            has_enough_drives,
            slices: BTreeMap::new(),
            ranked: task.ranks_detections().then(BTreeMap::new),
        }
    }

    /// The detections of `slice` that count; `None` if they are not ranked, or if rows of matches are not kept.
    pub(crate) fn ranked(&self, slice: Slice) -> Option<&[RankedDetection]> {
        let ranked = self.ranked.as_ref()?;
        let of_slice = |slice| ranked.get(&slice).map_or(&[][..], Vec::as_slice);
        let n_detections = self.counts.and_then(Counts::nd);
        let is_whole = n_detections.is_none_or(|n| n == of_slice(Slice::All).len() as u64);
        is_whole.then(|| of_slice(slice))
    }

    /// Keeps sums of whole drives only, since these will be drawn.
    pub(super) fn forget_seconds(&mut self) {
        self.has_enough_drives = true;
        self.slices.values_mut().for_each(BlockSums::forget_seconds);
    }

    pub(super) fn add_counts(&mut self, counts: Counts) {
        match &mut self.counts {
            None => self.counts = Some(counts),
            Some(sum) => *sum += counts,
        }
    }

    /// The sums of `slice`, with the indices of their blocks; blocks without sums are left out.
    pub(crate) fn sums_of_blocks(&self, slice: &Slice, blocks: &Blocks) -> Vec<(usize, Sums)> {
        self.slices.get(slice).map_or_else(Vec::new, |it| it.placed(blocks))
    }

    /// The sum of `term` over all objects.
    pub(crate) fn total(&self, term: Term) -> f64 {
        self.slices.get(&Slice::All).map_or(0.0, |it| it.total().of(term))
    }

    pub(super) fn sums(&mut self, slice: Slice, block: &DriveSecond) -> &mut Sums {
        let has_enough_drives = self.has_enough_drives;
        self.slices.entry(slice).or_insert_with(|| BlockSums::new(has_enough_drives)).of(block)
    }

    pub(super) fn add_to_slices(&mut self, slices: &[Slice], block: &DriveSecond, term: Term) {
        for slice in slices {
            self.sums(*slice, block).add(term, 1.0);
        }
    }

    /// Ranks a detection, in those of `slices` that rank them, too.
    pub(super) fn rank(&mut self, detection: &DetectionFacts, is_match: bool, slices: &[Slice]) {
        match (detection.score, &mut self.ranked) {
            (Some(score), Some(ranked)) => {
                let of_slices = slices.iter().filter(|it| it.ranks_detections());
                for slice in of_slices.chain([&Slice::All]) {
                    ranked.entry(*slice).or_default().push(RankedDetection { score, is_match });
                }
            }
            (None, _) => self.ranked = None,
            (_, None) => {}
        }
    }
}

/// The slices of an annotation beside [`Slice::All`].
pub(crate) fn slices_of_annotation(annotation: &AnnotationFacts) -> Vec<Slice> {
    let mut slices = vec![Slice::Class(annotation.class), Slice::of_points(annotation.n_points)];
    slices.extend(annotation.center_m().and_then(|it| Slice::of_range(range_m(it))));
    slices.extend(annotation.occlusion.map(Slice::Occlusion));
    slices.extend(annotation.is_truncated().then_some(Slice::Truncated));
    slices
}

/// The slices of a detection beside [`Slice::All`].
pub(crate) fn slices_of_detection(detection: &DetectionFacts) -> Vec<Slice> {
    let mut slices = vec![Slice::of_points(detection.n_points)];
    slices.extend(Slice::of_range(range_m(detection.bounding_box.center_m)));
    slices
}

/// Adds the errors of the box `found` against the box `labelled`.
pub(super) fn add_box_errors(sums: &mut Sums, labelled: &BoxFacts, found: &BoxFacts) {
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
