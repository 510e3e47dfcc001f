//! Answers of the classifier of vehicles for each kind of background, and for vehicles.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use detector::Detector;
use evaluation::run::config::{RunConfig, VehicleModels};
use evaluation::run::detector_list::built_in_named;
use evaluation::training::CHOICE_SEED;
use evaluation::training::candidates::{Candidate, CandidateSource, collect_candidates};
use evaluation::training::model_kind::ModelKind;
use reports::tables::studies::background_table::{BackgroundTable, Classified};

use super::METHOD;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;

/// Has the classifier judge the clusters of the method in `datasets`, and regions that are cut out of them as its training
/// set has them.
pub fn backgrounds(
    datasets: &[OpenedDataset],
    config: &RunConfig,
    interrupted: &AtomicBool,
) -> Result<BackgroundTable, Failure> {
    let model = config.vehicle_models.as_ref().map(VehicleModels::paper);
    let mut counts: BTreeMap<(bool, &'static str), Classified> = BTreeMap::new();
    for it in datasets {
        let description = it.dataset.description();
        let of_sensor = config.for_scans_of(description);
        let listed = built_in_named(&[METHOD.to_owned()], &of_sensor)?[0];
        let new_detector = || -> Box<dyn Detector> { listed.build(&of_sensor, description.sensor_height_m) };
        let source = CandidateSource {
            new_detector: &new_detector,
            object_box: ModelKind::Paper.object_box(),
            ground: &of_sensor.hierarchical,
            min_points: of_sensor.paper.cluster.min_points,
            seed: CHOICE_SEED,
        };
        let classified = |candidates: Vec<Candidate>| {
            let mut model = model.clone();
            let is_vehicle = |it: &Candidate| {
                model.as_mut().is_some_and(|model| {
                    let values = model.values(&it.bounding_box, it.positions_m.iter().copied());
                    model.decision_on(values.as_ref()) > 0.0
                })
            };
            let said: Vec<bool> = candidates.iter().map(is_vehicle).collect();
            candidates
                .iter()
                .zip(said)
                .map(|(it, said)| (it.kind.is_vehicle(), it.kind.name(), said))
                .collect()
        };
        let found = it.look_unsaid(interrupted, |pass| collect_candidates(pass, &source, classified))?;
        for (is_vehicle, name, said) in found {
            let name = if is_vehicle { "vehicle" } else { name };
            let counts = counts.entry((is_vehicle, name)).or_default();
            counts.n += 1;
            counts.n_vehicle += u64::from(said);
        }
    }
    let of = |is_vehicle: bool| counts.iter().filter(move |it| it.0.0 == is_vehicle);
    Ok(BackgroundTable {
        vehicles: of(true).next().map_or_else(Classified::default, |it| *it.1),
        backgrounds: of(false).map(|(key, it)| (key.1.to_owned(), *it)).collect(),
    })
}
