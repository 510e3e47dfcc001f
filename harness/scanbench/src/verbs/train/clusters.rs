//! The clusters that classifiers learn from.

use std::sync::atomic::AtomicBool;

use detector::Detector;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::built_in_named;
use evaluation::training::candidates::{Candidate, CandidateSource, as_models_are_asked, collect_candidates};
use evaluation::training::model_kind::ModelKind;
use evaluation::training::prototypes::{COLUMN_M, find_prototypes};

use crate::plumbing::config::warn_of_unknown_sensor;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::verbs::train::data::nothing;

/// The clusters of a detector, which classifiers learn from.
pub struct ClustersOf<'a> {
    /// The parameters of the detector, which classifies vehicles by their size.
    pub config: &'a RunConfig,
    pub detector: &'static str,
    pub min_points: usize,
    /// Seed of the choice of regions that are cut out.
    pub seed: u64,
}

impl ClustersOf<'_> {
    /// Results of `kept` for the clusters of the scans of a data set.
    pub fn candidates<T: Send>(
        &self,
        opened: &OpenedDataset,
        kind: ModelKind,
        interrupted: &AtomicBool,
        kept: impl Fn(Vec<Candidate>) -> Vec<T> + Sync + Send,
    ) -> Result<Vec<T>, Failure> {
        let description = opened.dataset.description();
        warn_of_unknown_sensor(self.config, description);
        let mut of_sensor = self.config.for_scans_of(description);
        let shared = &mut of_sensor.hierarchical;
        as_models_are_asked(shared, &mut of_sensor.baselines.kd_tree, self.min_points);
        let listed = built_in_named(&[self.detector.to_owned()], &of_sensor)?[0];
        let new_detector = || -> Box<dyn Detector> { listed.build(&of_sensor, description.sensor_height_m) };
        let source = CandidateSource {
            new_detector: &new_detector,
            object_box: kind.object_box(),
            ground: &of_sensor.hierarchical,
            min_points: self.min_points,
            seed: self.seed,
        };
        opened.look(interrupted, |pass| collect_candidates(pass, &source, kept))
    }
}

/// The side profiles that stand for all vehicles of a kind among `candidates`.
pub fn prototypes_of(
    candidates: &[&Candidate],
    n_per_kind: usize,
    made: Provenance,
) -> Result<PrototypeLibrary, Failure> {
    let prototypes = find_prototypes(candidates, n_per_kind);
    if prototypes.is_empty() {
        return Err(nothing(&"no vehicle has enough points for a side profile").into());
    }
    Ok(PrototypeLibrary::new(made, COLUMN_M, prototypes).map_err(|error| nothing(&error))?)
}
