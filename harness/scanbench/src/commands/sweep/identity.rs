//! Which sweep it is: everything that decides its results.

use evaluation::journal::JournalIdentity;
use evaluation::metrics::counts::SCORING_VERSION;
use evaluation::run::config::{DETECTOR_TABLE, VehicleModels};
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::foreign_detector::{ForeignDetector, ForeignWork};
use evaluation::sweep::sweep_plan::SweepPlan;
use evaluation::sweep::timing_pass::DETECTIONS_PER_SCAN;
use serde_json::{Value, json};

use crate::cli::SweepArgs;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::provenance::program_checksum;
use crate::commands::run_manifest::{blocks, criterion_in_words};

/// What the sweep of `plan` over `datasets` depends on. Results of another sweep, or of another program, are none of it.
pub fn sweep_identity(
    arguments: &SweepArgs,
    plan: &SweepPlan,
    datasets: &[OpenedDataset],
) -> JournalIdentity {
    let points: Vec<&Vec<String>> = plan.points.iter().map(|it| &it.values).collect();
    let data_sets: Vec<Value> = datasets.iter().map(data_set).collect();
    // Beyond the names of their directories.
    let vehicle_models = plan.base.vehicle_models.as_ref().map(VehicleModels::identity);
    let identity = json!({
        "program": program_checksum(),
        "scoring_version": SCORING_VERSION,
        "detectors": plan.detectors.iter().map(ChosenDetector::name).collect::<Vec<_>>(),
        "swept_parameters": plan.parameters(),
        "points": points,
        "other_parameters": other_parameters(plan),
        "detectors_of_others": plan.detectors.iter().filter_map(of_others).collect::<Vec<_>>(),
        "vehicle_models": vehicle_models,
        "protocols": arguments.protocol.protocols,
        "matching_criterion": criterion_in_words(plan.base.matching.criterion),
        "data_sets": data_sets,
        "timed_scans": arguments.timed_scans,
        "detections_per_timed_scan": DETECTIONS_PER_SCAN,
    });
    let Value::Object(identity) = identity else { unreachable!("it is written as one") };
    identity
}

/// All that is not swept, without the parameters of detectors of others that do not take part.
fn other_parameters(plan: &SweepPlan) -> Value {
    let mut parameters = json!(plan.base.resolved);
    if let Some(of_others) = parameters.get_mut(DETECTOR_TABLE).and_then(Value::as_object_mut) {
        of_others.retain(|name, _| plan.detectors.iter().any(|it| it.name() == name));
        if of_others.is_empty() {
            parameters.as_object_mut().map(|it| it.remove(DETECTOR_TABLE));
        }
    }
    parameters
}

/// What a detector of others is beside its parameters; `None` of ours.
fn of_others(detector: &ChosenDetector) -> Option<Value> {
    let ChosenDetector::Foreign(ForeignDetector { name, work, vehicles, .. }) = detector else { return None };
    // A sweep takes no results of others.
    let ForeignWork::Process(process) = work else { return None };
    Some(json!({
        "name": name,
        "command": process.command,
        "files": process.files,
        "start_limit_s": process.start_limit.as_secs_f64(),
        "time_limit_s": process.time_limit.as_secs_f64(),
        "threads": process.threads,
        "vehicles": vehicles.name(),
    }))
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
        "blocks": blocks(opened),
    })
}
