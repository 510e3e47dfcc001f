//! `scanbench train boxes`.

use detector::road_user::RoadUser;
use detector::whole::box_model::{BoxModel, BoxModels};
use evaluation::run::config::{BOXES_FILE, RunConfig};
use evaluation::run::detector_list::{DETECTORS, ListedDetector};
use evaluation::training::CHOICE_SEED;
use evaluation::training::box_training::{
    BoxJudgement, FEWEST_EXAMPLES, LEARNED_FROM, N_BOX_FORESTS, RoadUserExample, SEEN, collect_road_users,
    right_iou, train_boxes as train_trees,
};
use jiff::Timestamp;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::BoxTrainingArgs;
use crate::plumbing::config::warn_of_unknown_sensor;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::ids_of;
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::train::data::{TrainingData, nothing};
use crate::verbs::train::files::{manifest, print_run_command};
use crate::verbs::train::groupings::drives;

/// Trains the model that makes boxes whole, judges it by drives it has not seen, and writes and prints the result.
pub fn train_boxes(arguments: &BoxTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let data = TrainingData::open(
        RunConfig::load(None)?,
        &arguments.data,
        &arguments.sensors,
        None,
        &arguments.judging,
    )?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let detectors: Vec<ListedDetector> =
        DETECTORS.iter().filter(|it| LEARNED_FROM.contains(&it.name)).copied().collect();
    let (mut judged, mut taught): (Vec<RoadUserExample>, Vec<RoadUserExample>) = (Vec::new(), Vec::new());
    for it in data.opened() {
        let description = it.dataset.description();
        warn_of_unknown_sensor(&data.config, description);
        let mut of_sensor = data.config.for_scans_of(description);
        of_sensor.hierarchical.boxes = SEEN;
        let height_m = description.sensor_height_m;
        let new_detectors = || detectors.iter().map(|it| it.build(&of_sensor, height_m)).collect();
        let found = it.look(interrupted, |pass| {
            collect_road_users(pass, &new_detectors, &of_sensor.hierarchical, &of_sensor.matching)
        })?;
        for vehicle in found {
            let is_judged = data.parted.is_held_out(&description.id, &vehicle.sequence);
            if is_judged { &mut judged } else { &mut taught }.push(vehicle);
        }
    }
    let progress = progress_over_results(RoadUser::ALL.len() * N_BOX_FORESTS, 0, "forests");
    let mut texts = vec![drives(&data.parted)];
    let mut learned = |road_user: RoadUser| -> Result<Option<BoxModel>, Failure> {
        let of_class = |all: &'_ [RoadUserExample]| -> Vec<RoadUserExample> {
            all.iter().filter(|it| it.road_user == road_user).cloned().collect()
        };
        let (taught, judged) = (of_class(&taught), of_class(&judged));
        let [taught, judged] = [&taught, &judged].map(|all| all.iter().collect::<Vec<_>>());
        if road_user != RoadUser::Vehicle && taught.len() < FEWEST_EXAMPLES {
            return Ok(None);
        }
        let (model, n_taught) = train_trees(&taught, &|| progress.inc(1)).map_err(|error| nothing(&error))?;
        let judgement = BoxJudgement::of(&model, &judged);
        texts.push(text(road_user, [n_taught, judged.len()], &judgement));
        Ok(Some(model))
    };
    let vehicles = learned(RoadUser::Vehicle)?.ok_or_else(|| nothing(&"there are no vehicles"))?;
    let pedestrians = learned(RoadUser::Pedestrian)?;
    let cyclists = learned(RoadUser::Cyclist)?;
    progress.finish_and_clear();
    let models = BoxModels { vehicles, pedestrians, cyclists };
    let sensors = (!arguments.sensors.is_empty()).then(|| arguments.sensors.join(","));
    let made = data.provenance("train boxes", &[("--sensors", sensors)], &arguments.judging, CHOICE_SEED);
    directory.write_file(MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).as_bytes())?;
    directory.write_file(BOXES_FILE, &models.to_file(made).to_bytes())?;
    let finished = directory.finish()?;
    let printed = print_result_in("Model", &finished, texts.join("\n\n"));
    print_run_command("", "boxes", &finished, &[]);
    printed
}

/// How boxes do on road users of drives that the model has not seen, for people.
fn text(road_user: RoadUser, [n_taught, n_judged]: [usize; 2], judgement: &BoxJudgement) -> String {
    let BoxJudgement { seen, whole, sure_fronts, right_boxes } = judgement;
    let mut lines = vec![
        format!("Trained on {n_taught} {}; of {n_judged} held-out ones, in %:", road_user.in_plural()),
        format!("{:<24}{:>12}{:>12}", "", "as seen", "whole"),
    ];
    let mut line = |what: &str, seen: f64, whole: f64| {
        lines.push(format!("{what:<24}{:>12.1}{:>12.1}", 100.0 * seen, 100.0 * whole));
    };
    for (index, what) in ["yaw within 5 degrees", "yaw within 10 degrees"].into_iter().enumerate() {
        line(what, seen.yaw[index], whole.yaw[index]);
    }
    for (index, least) in [0.5, 0.7].into_iter().enumerate() {
        line(&format!("IoU from above >= {least}"), seen.bev[index], whole.bev[index]);
        line(&format!("IoU in space >= {least}"), seen.space[index], whole.space[index]);
    }
    for (what, share) in [
        ("front right", Some(whole.heading)),
        ("front sure", Some(sure_fronts.share)),
        ("of these right", sure_fronts.right),
    ] {
        let share = share.map_or_else(|| "–".to_owned(), |it| format!("{:.1}", 100.0 * it));
        lines.push(format!("{what:<24}{:>12}{share:>12}", "–"));
    }
    lines.push(format!(
        "\nIoU in space >= {}\n{:>10}{:>10}{:>10}",
        right_iou(road_user),
        "expected",
        "observed",
        "boxes"
    ));
    lines.extend(
        right_boxes.iter().map(|it| format!("{:>10.3}{:>10.3}{:>10}", it.expected, it.observed, it.n)),
    );
    lines.join("\n")
}
