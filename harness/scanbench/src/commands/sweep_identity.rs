//! Which sweep it is: everything that decides its results.

use evaluation::metrics::counts::SCORING_VERSION;
use evaluation::run::config::VehicleModels;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::sweep::journal::SweepIdentity;
use evaluation::sweep::sweep_plan::SweepPlan;
use evaluation::sweep::timing_pass::DETECTIONS_PER_SCAN;
use scans::dataset::checksum::sha256;
use serde_json::{Value, json};

use crate::cli::SweepArgs;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::run_manifest::criterion_in_words;

/// What the sweep of `plan` over `datasets` depends on. Results of another sweep, or of another program, are none of it.
pub fn sweep_identity(arguments: &SweepArgs, plan: &SweepPlan, datasets: &[OpenedDataset]) -> SweepIdentity {
    let points: Vec<&Vec<String>> = plan.points.iter().map(|it| &it.values).collect();
    let data_sets: Vec<Value> = datasets.iter().map(data_set).collect();
    // Beyond the names of their directories.
    let vehicle_models = plan.base.vehicle_models.as_ref().map(VehicleModels::identity);
    let identity = json!({
        "program": program(),
        "scoring_version": SCORING_VERSION,
        "detectors": plan.detectors.iter().map(ChosenDetector::name).collect::<Vec<_>>(),
        "swept_parameters": plan.parameters(),
        "points": points,
        "other_parameters": plan.base.resolved,
        "vehicle_models": vehicle_models,
        "matching_criterion": criterion_in_words(plan.base.matching.criterion),
        "data_sets": data_sets,
        "timed_scans": arguments.timed_scans,
        "detections_per_timed_scan": DETECTIONS_PER_SCAN,
    });
    let Value::Object(identity) = identity else { unreachable!("it is written as one") };
    identity
}

fn data_set(opened: &OpenedDataset) -> Value {
    let description = opened.dataset.description();
    json!({
        "id": description.id,
        "checksum": description.checksum,
        "sensor": description.sensor,
        "sensor_height_m": description.sensor_height_m,
        "scans": opened.scan_indices,
        "classes": opened.classes.written(),
    })
}

/// The program's own bytes: a version, or a commit with changes on top, would not tell two builds apart.
fn program() -> String {
    sha256(std::env::current_exe().and_then(std::fs::read).unwrap_or_default())
}
