//! How many annotated objects survive each step of the detector hierarchical.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use detector::detector::StageClock;
use detector::pipeline::grouping_stages::GroupingStages;
use detector::{DetectedClass, Detector, DetectorOutput};
use rayon::prelude::*;
use reports::tables::studies::survival_table::SurvivalRow;
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;
use scans::dataset::Dataset;

use crate::matching::criterion::Criterion;
use crate::matching::eligibility::{EligibilityParams, counts_as_vehicle, exclusions, may_be_vehicle};
use crate::realism::survey::SurveyError;
use crate::run::config::RunConfig;
use crate::run::detector_list::ListedDetector;
use crate::training::group_examples::{LEAST_IOU, annotations_of_points, points_of_dense_cells};

/// How many objects there are, and how many survive each step.
#[derive(Debug, Clone, Copy, Default)]
struct Survivors {
    objects: usize,
    candidates: usize,
    in_tree: usize,
    described: usize,
    taken: usize,
    classified: usize,
}

/// What every thread looks at its scans with.
type State = (GroupingStages, Box<dyn Detector>, DetectorOutput);

/// The survivors among the annotated objects of the scans `scan_indices` of `dataset` that count in the task *objects*: of all
/// classes first, then class by class.
///
/// What can be found at all is told by labels alone, so that it bounds the recall of whatever chooses among the groups.
/// `on_scan` is called after every scan, from several threads.
///
/// # Errors
///
/// [`SurveyError`] if a scan cannot be read (the first such scan), or once `interrupted` is set.
pub fn survival(
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    (listed, config): (ListedDetector, &RunConfig),
    interrupted: &AtomicBool,
    on_scan: impl Fn() + Sync,
) -> Result<Vec<SurvivalRow>, SurveyError> {
    let description = dataset.description();
    let new_state = || {
        let stages = GroupingStages::new(config.hierarchical.clone(), description.sensor_height_m);
        (stages, listed.build(config, description.sensor_height_m), DetectorOutput::default())
    };
    let look = |(stages, detector, output): &mut State, &scan_idx: &usize| {
        if interrupted.load(Ordering::Relaxed) {
            let (dataset, n_scans) = (description.id.clone(), scan_indices.len());
            return Err(SurveyError::Interrupted { dataset, n_scans });
        }
        let scan = dataset.read_scan(scan_idx)?;
        stages.run(&scan.cloud, &mut StageClock::start(), &mut Vec::new());
        detector.detect(&scan.cloud, output);
        on_scan();
        Ok(survivors_of(&scan, stages, output))
    };
    // Collected before it is looked through for errors, so that the first in order is reported.
    let of_scans: Vec<_> = scan_indices.par_iter().map_init(new_state, look).collect();
    let mut all = Survivors::default();
    let mut by_class: BTreeMap<&'static str, Survivors> = BTreeMap::new();
    for of_scan in of_scans {
        for (class, survivors) in of_scan? {
            all.add(&survivors);
            by_class.entry(class).or_default().add(&survivors);
        }
    }
    let row = |class: &str, it: &Survivors| SurvivalRow {
        data: description.id.clone(),
        simulated: description.is_simulated(),
        class: class.to_owned(),
        objects: it.objects,
        candidates: it.candidates,
        in_tree: it.in_tree,
        described: it.described,
        taken: it.taken,
        classified: it.classified,
    };
    let of_classes = by_class.iter().map(|(class, it)| row(class, it));
    Ok(std::iter::once(row("all", &all)).chain(of_classes).collect())
}

fn survivors_of(
    scan: &LabeledScan,
    stages: &GroupingStages,
    output: &DetectorOutput,
) -> Vec<(&'static str, Survivors)> {
    let exclusions = exclusions(scan, Task::Objects, Criterion::POINTS, &EligibilityParams::STANDARD);
    let annotations_of_point = annotations_of_points(scan);
    let points_of_dense = points_of_dense_cells(stages);
    let mut survivors = vec![Survivors { objects: 1, ..Survivors::default() }; scan.annotations.len()];
    let mut n_candidates = vec![0; scan.annotations.len()];
    for &point_idx in stages.candidates().point_indices() {
        for &it in &annotations_of_point[point_idx as usize] {
            n_candidates[it as usize] += 1;
        }
    }
    for ((it, n), annotation) in survivors.iter_mut().zip(n_candidates).zip(&scan.annotations) {
        it.candidates = usize::from(2 * n >= annotation.point_indices.len());
    }
    let shown_by = |point_indices: &mut dyn Iterator<Item = u32>| {
        let mut n_shared: BTreeMap<u32, usize> = BTreeMap::new();
        let mut n_points = 0;
        for point_idx in point_indices {
            n_points += 1;
            for &it in &annotations_of_point[point_idx as usize] {
                *n_shared.entry(it).or_default() += 1;
            }
        }
        let is_shown = |&(it, n): &(u32, usize)| {
            let n_annotated = scan.annotations[it as usize].point_indices.len();
            n as f32 >= LEAST_IOU * (n_points + n_annotated - n) as f32
        };
        n_shared.into_iter().filter(is_shown).map(|(it, _)| it as usize).collect::<Vec<_>>()
    };
    let mut described = stages.described().iter().map(|it| it.node_idx).peekable();
    for (node, node_idx) in stages.tree().nodes().iter().zip(0..) {
        let is_described = described.next_if_eq(&node_idx).is_some();
        let cells = stages.tree().cells(node);
        for it in shown_by(&mut cells.iter().flat_map(|&it| points_of_dense[it as usize].iter().copied())) {
            survivors[it].in_tree = 1;
            survivors[it].described |= usize::from(is_described);
        }
    }
    for detection in output.detections.iter() {
        for it in shown_by(&mut detection.point_indices.iter().copied()) {
            let class = scan.annotations[it].class;
            let is_vehicle = detection.class == DetectedClass::Vehicle;
            survivors[it].taken = 1;
            survivors[it].classified |=
                usize::from(may_be_vehicle(class) || counts_as_vehicle(class) == is_vehicle);
        }
    }
    let counting = survivors.into_iter().zip(&scan.annotations).zip(exclusions);
    let counting = counting.filter(|(_, exclusion)| exclusion.is_none());
    counting.map(|((it, annotation), _)| (annotation.class.name(), it)).collect()
}

impl Survivors {
    fn add(&mut self, other: &Self) {
        self.objects += other.objects;
        self.candidates += other.candidates;
        self.in_tree += other.in_tree;
        self.described += other.described;
        self.taken += other.taken;
        self.classified += other.classified;
    }
}
