//! `scanbench train groupings`.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use detector::classify::grouping_model::{GROUPING_MODEL, GroupingModel};
use detector::classify::model_file::ModelFile;
use detector::classify::refinement_forests::RefinementBuffers;
use detector::classify::vehicle_model::VehicleModel;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::params::HierarchicalParams;
use detector::pipeline::frame::{Frame, Groups};
use detector::pipeline::grouping_stages::grouping;
use detector::pipeline::stage_list::Pipeline;
use detector::road_user::{N_ROAD_USERS, RoadUser};
use evaluation::run::config::GROUPINGS_FILE;
use evaluation::training::CHOICE_SEED;
use evaluation::training::group_examples::{GroupLabels, LEAST_IOU, ScanGroups, collect_groups};
use evaluation::training::grouping_training::{LEAST_IOU_OF_ROAD_USERS, N_GROUPING_FORESTS, train_on_groups};
use evaluation::training::held_out::HeldOut;
use evaluation::training::model_odds::ModelOdds;
use evaluation::training::operating_curves::OperatingCurves;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::files::regular_file::{MOST_OF_MODEL, read_bytes};
use reports::numbers::calibration::{CalibrationBin, calibration};
use reports::rows::training_row::CalibrationRow;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::{RecordedArgs, TreeTrainingArgs};
use crate::plumbing::config::warn_of_unknown_sensor;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of};
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::train::data::{TrainingData, TrainingParameters, nothing, weights_of};
use crate::verbs::train::files::{manifest, print_run_command};

/// Trains all forests, judges them by drives they have not seen, and writes and prints the result.
pub fn train_groupings(arguments: &TreeTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    check_odds(&arguments.odds, &[GROUPING_MODEL])?;
    let named = claim_named(&arguments.output)?;
    let library = match &arguments.prototypes {
        Some(path) => prototypes_from(path)?,
        None => VehicleModel::shipped().prototypes().clone(),
    };
    let TrainingParameters { config, parameters } = TrainingParameters::of(&arguments.parameters)?;
    let data = TrainingData::open(
        config,
        &arguments.data,
        &arguments.sensors,
        Some(&arguments.recorded),
        &arguments.judging,
    )?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let by_gaps = |_: &str, params: &HierarchicalParams, height_m| {
        grouping(Frame::new(Groups::by_gaps(params), &params.front_end(), height_m), params)
    };
    let scans = groups_of_all(&data, &library, &by_gaps, interrupted)?;
    let rounds = data.config.hierarchical.grouping.rounds;
    let trained = TrainedTrees::of(&data, &scans, rounds, library, (GROUPING_MODEL, &arguments.odds))?;
    let made = data.provenance("train groupings", &options(arguments), &arguments.judging, CHOICE_SEED);
    let file = trained.model.to_file(GROUPING_MODEL, made, toml::Table::new()).with_parameters(parameters);
    directory.write_file(MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).as_bytes())?;
    directory.write_file(GROUPINGS_FILE, &file.to_bytes())?;
    directory.write_file("calibration.csv", &to_csv_bytes(&trained.judgement.rows("groupings"))?)?;
    let finished = directory.finish()?;
    let printed =
        print_result_in("Model", &finished, format_args!("{}\n\n{}", drives(&data.parted), trained.text()));
    print_run_command("-d hierarchical", "groupings", &finished, &arguments.parameters);
    printed
}

/// The side profiles of the model at `path`.
pub fn prototypes_from(path: &Path) -> Result<PrototypeLibrary, Failure> {
    let problem = |error: &dyn std::fmt::Display| Usage(format!("--prototypes {}: {error}", path.display()));
    let bytes = read_bytes(path, MOST_OF_MODEL).map_err(|error| problem(&error))?;
    let file = ModelFile::of_any_kind(&bytes).map_err(|error| problem(&error))?;
    Ok(file.prototypes().map_err(|error| problem(&error))?)
}

/// The options that decide what trees learn.
pub fn options(arguments: &TreeTrainingArgs) -> Vec<(&'static str, Option<String>)> {
    let sensors = (!arguments.sensors.is_empty()).then(|| arguments.sensors.join(","));
    let prototypes = arguments.prototypes.as_ref().map(|it| it.display().to_string());
    let RecordedArgs { recorded, recorded_format, recorded_scans } = &arguments.recorded;
    let recorded = recorded.iter().map(|it| ("--recorded", Some(it.clone())));
    let of_recorded =
        [("--recorded-format", recorded_format.clone()), ("--recorded-scans", recorded_scans.clone())];
    let parameters = arguments.parameters.iter().map(|it| ("-P", Some(it.to_string())));
    let odds = arguments.odds.iter().map(|it| ("--odds", Some(it.to_string())));
    let options = [("--sensors", sensors), ("--prototypes", prototypes)].into_iter();
    options.chain(recorded).chain(of_recorded).chain(parameters).chain(odds).collect()
}

/// Refuses odds of models that are not among `models`, and two for one of them.
pub fn check_odds(odds: &[ModelOdds], models: &[&str]) -> Result<(), Usage> {
    for (index, it) in odds.iter().enumerate() {
        if !models.contains(&it.model.as_str()) {
            return Err(Usage(format!("--odds {it}: only {} is trained", models.join(", "))));
        }
        if odds[..index].iter().any(|earlier| earlier.is_of_same(it)) {
            return Err(Usage(format!("--odds {it}: there are other odds for this class of this model")));
        }
    }
    Ok(())
}

/// Which drives are trained on and which are held out, for people.
pub fn drives(parted: &HeldOut) -> String {
    format!(
        "Trained on {} drives: {}\nHeld out {} drives: {}",
        parted.trained.len(),
        HeldOut::summary(&parted.trained),
        parted.held_out.len(),
        HeldOut::summary(&parted.held_out),
    )
}

/// Makes the grouping whose groups are learned from, for a sensor of this name and height above the road.
pub type GroupingFor<'a> = &'a (dyn Fn(&str, &HierarchicalParams, f32) -> Pipeline<Groups> + Sync);

/// The groups of all scans, with their data sets.
pub fn groups_of_all<'a>(
    data: &'a TrainingData<'_>,
    library: &PrototypeLibrary,
    grouping_for: GroupingFor<'_>,
    interrupted: &AtomicBool,
) -> Result<Vec<(&'a OpenedDataset, ScanGroups)>, Failure> {
    let (mut found_of_all, mut n_by_dataset) = (Vec::new(), Vec::new());
    for it in data.opened() {
        let description = it.dataset.description();
        warn_of_unknown_sensor(&data.config, description);
        let of_sensor = data.config.for_scans_of(description).hierarchical;
        let new_grouping = || grouping_for(&description.sensor, &of_sensor, description.sensor_height_m);
        let found = it.look(interrupted, |pass| collect_groups(pass, &new_grouping, library))?;
        let is_taught = |found: &&ScanGroups| !data.parted.is_held_out(&description.id, &found.sequence);
        let n_taught = found.iter().filter(is_taught).map(ScanGroups::n_labeled).sum();
        n_by_dataset.push((it, n_taught));
        found_of_all.push((it, found));
    }
    let weights = weights_of(&n_by_dataset);
    let weighted = found_of_all.into_iter().zip(weights).flat_map(|((it, found), weight)| {
        found.into_iter().map(move |found| (it, ScanGroups { weight, ..found }))
    });
    Ok(weighted.collect())
}

/// Trained forests, and how they do on drives they have not seen.
pub struct TrainedTrees {
    pub model: GroupingModel,
    pub judgement: Judgement,
    n_taught: usize,
}

impl TrainedTrees {
    /// Trains a model of this name with those of `scans` that are not held out, for so many `rounds`, gives it its odds if
    /// some are for it, and judges by the others.
    pub fn of(
        data: &TrainingData<'_>,
        scans: &[(&OpenedDataset, ScanGroups)],
        rounds: u8,
        library: PrototypeLibrary,
        (name, odds): (&str, &[ModelOdds]),
    ) -> Result<Self, Failure> {
        let (mut judged, mut taught): (Vec<&ScanGroups>, Vec<&ScanGroups>) = (Vec::new(), Vec::new());
        for (opened, it) in scans {
            let is_judged = data.parted.is_held_out(&opened.dataset.description().id, &it.sequence);
            if is_judged { &mut judged } else { &mut taught }.push(it);
        }
        let progress = progress_over_results(N_GROUPING_FORESTS, 0, "forests");
        let mut model = train_on_groups(&taught, rounds, library, &|| progress.inc(1))
            .map_err(|error| nothing(&error))?;
        model.road_users = ModelOdds::applied(odds, name, model.road_users);
        progress.finish_and_clear();
        let judgement = Judgement::of(&model, rounds, &judged);
        let n_taught = taught.iter().map(|it| it.n_labeled()).sum();
        Ok(Self { model, judgement, n_taught })
    }

    /// How they do, for people.
    pub fn text(&self) -> String {
        self.judgement.text(self.n_taught)
    }
}

/// How the forests do on groups of drives they have not seen.
pub struct Judgement {
    n: usize,
    n_objects: usize,
    // Of the annotated objects, how many there are, and how many some group shows.
    n_annotated: usize,
    n_grouped: usize,
    objects: OperatingCurves,
    // Of each class of road users that was learned.
    road_users: Vec<(RoadUser, OperatingCurves)>,
    ious: Vec<CalibrationBin>,
    probabilities: Vec<CalibrationBin>,
}

impl Judgement {
    fn of(model: &GroupingModel, rounds: u8, judged: &[&ScanGroups]) -> Self {
        let mut buffers = RefinementBuffers::default();
        let mut expected_ious = Vec::new();
        let mut odds: [Vec<(f32, bool)>; N_ROAD_USERS] = Default::default();
        for scan in judged {
            for (expected_iou, it) in
                scan.expected_ious(&model.objects, rounds, &mut buffers).into_iter().zip(&scan.groups)
            {
                let Some(GroupLabels { iou, .. }) = it.labels else { continue };
                expected_ious.push((expected_iou, iou));
                if expected_iou < LEAST_IOU_OF_ROAD_USERS {
                    continue;
                }
                for road_user in RoadUser::ALL.into_iter().filter(|class| it.may_be.allows(*class)) {
                    let forest = model.road_users.of_class(road_user);
                    if let Some((forest, is_so)) = forest.zip(it.shows(road_user)) {
                        odds[road_user as usize].push((forest.sum(&it.vehicle_values), is_so));
                    }
                }
            }
        }
        let best_ious = || judged.iter().flat_map(|it| &it.best_iou_of_objects);
        let probability = |log_odds: f32| 1.0 / (1.0 + f64::from(-log_odds).exp());
        Self {
            n: expected_ious.len(),
            n_annotated: best_ious().count(),
            n_grouped: best_ious().filter(|it| **it >= LEAST_IOU).count(),
            n_objects: expected_ious.iter().filter(|it| it.1 >= LEAST_IOU).count(),
            objects: OperatingCurves::of(expected_ious.iter().map(|it| (it.0, it.1 >= LEAST_IOU))),
            road_users: RoadUser::ALL
                .into_iter()
                .filter(|it| model.road_users.of_class(*it).is_some())
                .map(|it| (it, OperatingCurves::of(odds[it as usize].iter().copied())))
                .collect(),
            ious: calibration(
                expected_ious.iter().map(|it| (f64::from(it.0).clamp(0.0, 1.0), f64::from(it.1))),
            ),
            probabilities: calibration(
                odds[0].iter().map(|it| (probability(it.0), f64::from(u8::from(it.1)))),
            ),
        }
    }

    /// Rows of expected and observed values of the model called `model`.
    pub fn rows(&self, model: &str) -> Vec<CalibrationRow> {
        let row = |what: &str, it: &CalibrationBin| {
            CalibrationRow::new(&format!("{model}: {what}"), [it.expected, it.observed], it.n)
        };
        let ious = self.ious.iter().map(|it| row("iou", it));
        ious.chain(self.probabilities.iter().map(|it| row("vehicle", it))).collect()
    }

    fn text(&self, n_taught: usize) -> String {
        let share = |area: Option<f64>| area.map_or_else(|| "undefined".to_owned(), |it| format!("{it:.4}"));
        let Self { n, n_objects, n_annotated, n_grouped, .. } = self;
        let mut lines = vec![
            format!("Trained on {n_taught} groups"),
            format!("Of {n_annotated} held-out annotated objects {n_grouped} are a group, and can be found"),
            String::new(),
            format!(
                "On {n} held-out groups; road users among those with an expected IoU of {LEAST_IOU_OF_ROAD_USERS} and more:"
            ),
            format!("{:<12}{:>10}{:>10}{:>24}", "", "groups", "ROC area", "precision-recall area"),
        ];
        let road_users =
            self.road_users.iter().map(|(it, curves)| (it.in_plural(), curves.totals()[0], curves));
        for (what, n, curves) in std::iter::once(("objects", *n_objects, &self.objects)).chain(road_users) {
            let areas = [curves.roc_area(), curves.precision_recall_area()].map(share);
            lines.push(format!("{what:<12}{n:>10}{:>10}{:>24}", areas[0], areas[1]));
        }
        for (title, bins) in [
            ("Intersection over union with an object", &self.ious),
            ("Probability of a vehicle", &self.probabilities),
        ] {
            lines.push(String::new());
            lines.push(title.to_owned());
            lines.push(format!("{:>10}{:>10}{:>10}", "expected", "observed", "groups"));
            for it in bins {
                lines.push(format!("{:>10.3}{:>10.3}{:>10}", it.expected, it.observed, it.n));
            }
        }
        lines.join("\n")
    }
}
