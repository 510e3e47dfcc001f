//! The `manifest.json` of a run.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use detector::Rule;
use evaluation::matching::criterion::Criterion;
use evaluation::metrics::counts::scoring_version;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::{RunConfig, TrainedModel};
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::foreign_detector::{ForeignDetector, ForeignWork};
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::run_folder::manifest::{
    AnnotatedClasses, DatasetEntry, DetectorEntry, ForeignEntry, IgnoreRule, Manifest, Simulation,
};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::protocol::Protocol;
use scans::dataset;
use simulator::SIMULATOR_VERSION;
use simulator::simulated_street::StreetDrive;
use simulator::street_conditions::StreetConditions;

use crate::plumbing::failure::Usage;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::provenance::{
    command_line, git_state, machine, project_state, rfc3339_utc, rustc_version,
};
use crate::plumbing::recorder::rerun_version;

pub struct RunSettings<'a> {
    /// Which scans of the data sets were chosen, as the command line writes it; `None` for all.
    pub selection: Option<&'a str>,
    /// Detections that were thrown away before any was timed.
    pub n_warmup: u16,
    /// How often each detector looked at each scan.
    pub n_repeats: NonZeroUsize,
    pub config: &'a RunConfig,
    /// Entries of the detectors, in the order of the tables.
    pub detectors: Vec<DetectorEntry>,
    pub datasets: &'a [OpenedDataset],
    /// The protocols of others.
    pub protocols: &'a [Protocol],
    pub started: Timestamp,
}

/// The manifest of a run: everything that decides its numbers.
pub fn run_manifest(settings: RunSettings<'_>) -> Manifest {
    let matching = &settings.config.matching;
    Manifest {
        schema: SCHEMA,
        scoring_version: scoring_version(
            criteria_of(settings.config),
            settings.detectors.iter().any(|it| it.foreign.is_some()),
        ),
        scanbench_version: env!("CARGO_PKG_VERSION").to_owned(),
        created: rfc3339_utc(settings.started),
        argv: command_line(),
        seeds: seeds(settings.datasets),
        n_warmup_detections: settings.n_warmup.into(),
        n_repeats: settings.n_repeats.get() as u32,
        matching_criterion: criteria_in_words(settings.config),
        ignored: IgnoreRule {
            min_points: matching.eligibility.min_points as u32,
            max_range_m: matching.eligibility.max_range_m,
        },
        slices: settings.config.slices.all(),
        datasets: settings.datasets.iter().map(|it| dataset_entry(it, settings.selection)).collect(),
        detectors: settings.detectors,
        config: json(&settings.config.resolved),
        git: git_state(),
        project: project_state(),
        rustc_version: rustc_version(),
        rerun_version: rerun_version(),
        machine: machine(),
        experiment: None,
        sweep: None,
        partial: None,
        counted_by: None,
        shard: None,
        shards: Vec::new(),
        protocols: settings.protocols.to_vec(),
    }
}

/// Entries of `detectors` in a manifest, with the parameters of `config`.
pub fn detector_entries(detectors: &[ChosenDetector], config: &RunConfig) -> Vec<DetectorEntry> {
    detectors.iter().map(|it| detector_entry(&ComparedDetector::of(it.clone(), config))).collect()
}

pub fn detector_entry(compared_detector: &ComparedDetector) -> DetectorEntry {
    let ComparedDetector { name, chosen, config } = compared_detector;
    let listed = match chosen {
        ChosenDetector::BuiltIn(listed) => listed,
        ChosenDetector::Foreign(foreign) => return foreign_entry(name, foreign, config),
    };
    let mut parameters = json(&config.resolved)[listed.table].take();
    for (parameter, value) in listed.fixed {
        parameters[*parameter] = (*value).into();
    }
    // Rules do not depend on the height.
    let rules = listed.build(config, 0.0).rules();
    let rules = rules.iter().map(ToString::to_string).collect();
    let vehicles = Some(chosen.vehicles_in_words(config));
    let (name, models) = ((*name).to_owned(), models(chosen, config));
    let scoring_version = Some(scoring_version(criteria_of(config), false));
    let (doubts, foreign) = (Vec::new(), None);
    DetectorEntry { name, parameters, rules, vehicles, models, doubts, scoring_version, foreign }
}

/// Checksums of the models of `chosen` that did not come with the program, by the names of their files.
fn models(chosen: &ChosenDetector, config: &RunConfig) -> BTreeMap<String, String> {
    let boxes = chosen.has_whole_boxes(config).then_some(TrainedModel::Boxes);
    let of_model = |model: TrainedModel| {
        let checksum = config.vehicle_models.as_ref()?.checksum(model)?;
        Some((model.file_name().to_owned(), checksum.to_owned()))
    };
    chosen.vehicle_model(config).into_iter().chain(boxes).filter_map(of_model).collect()
}

fn foreign_entry(name: &str, foreign: &ForeignDetector, config: &RunConfig) -> DetectorEntry {
    let vehicles = foreign.vehicles.name().to_owned();
    let entry = match &foreign.work {
        ForeignWork::Process(process) => {
            let introduction = process.introduction.get();
            ForeignEntry {
                command: process.command.clone(),
                files: process.files.clone(),
                reported_name: introduction.map(|it| it.name.clone()),
                version: introduction.and_then(|it| it.version.clone()),
                start_limit_s: Some(process.start_limit.as_secs_f64()),
                time_limit_s: Some(process.time_limit.as_secs_f64()),
                threads: Some(process.threads),
                sandbox: process.sandbox,
                vehicles,
                ..ForeignEntry::default()
            }
        }
        ForeignWork::Results(path) => {
            ForeignEntry { results: Some(path.display().to_string()), vehicles, ..ForeignEntry::default() }
        }
    };
    let chosen = ChosenDetector::Foreign(foreign.clone());
    // The rule of our model for objects of others; what their program does is its own.
    let has_bounds = chosen.vehicle_model(config).is_some() && config.hierarchical.vehicle_bounds.enabled;
    DetectorEntry {
        name: name.to_owned(),
        parameters: foreign.parameters(config).into(),
        rules: has_bounds.then(|| Rule::SizeBounds.to_string()).into_iter().collect(),
        vehicles: Some(chosen.vehicles_in_words(config)),
        models: models(&chosen, config),
        doubts: Vec::new(),
        scoring_version: Some(scoring_version(criteria_of(config), true)),
        foreign: Some(entry),
    }
}

fn json(resolved: &toml::Table) -> serde_json::Value {
    serde_json::to_value(resolved).expect("a configuration has text keys only")
}

/// The kinds of criteria that a run judges by.
fn criteria_of(config: &RunConfig) -> Vec<CriterionKind> {
    let of_run = config.matching.criterion;
    let of_classes = config.class_criteria.all(of_run).map(|(_, it)| it.kind());
    [of_run.kind()].into_iter().chain(of_classes).collect()
}

/// The criterion of the run, of the classes that have one of their own, and the slice that alone is judged, in words.
fn criteria_in_words(config: &RunConfig) -> String {
    let of_run = config.matching.criterion;
    let mut of_classes: Vec<(String, Vec<&str>)> = Vec::new();
    for (class, criterion) in config.class_criteria.all(of_run) {
        let words = criterion_in_words(criterion);
        match of_classes.iter_mut().find(|(it, _)| *it == words) {
            Some((_, classes)) => classes.push(class.name()),
            None => of_classes.push((words, vec![class.name()])),
        }
    }
    let of_classes = of_classes.into_iter().map(|(words, classes)| match classes.len() {
        n if n == AnnotationClass::ALL.len() => format!("; each class: {words}"),
        _ => format!("; {}: {words}", classes.join(", ")),
    });
    let preset = config.class_criteria.preset();
    let preset = preset.map(|it| format!(" (criteria of classes as in {})", it.benchmark()));
    let only = config.value_of("matching.only").and_then(toml::Value::as_str);
    let only = only.map(|it| format!("; judged in the slice {it} only"));
    [criterion_in_words(of_run), of_classes.collect(), preset.unwrap_or_default(), only.unwrap_or_default()]
        .concat()
}

/// Words for when a detection matches an annotation.
pub fn criterion_in_words(criterion: Criterion) -> String {
    match criterion {
        Criterion::Points { min_iou } => format!("points, IoU at least {min_iou}"),
        Criterion::BevIou { min_iou } => format!("boxes on the ground plan, IoU at least {min_iou}"),
        Criterion::Iou3d { min_iou } => format!("boxes in space, IoU at least {min_iou}"),
        Criterion::Centre { max_distance_m } => format!("centre, closer than {max_distance_m} m"),
    }
}

/// The seeds of the simulated ones among `datasets`, by their ids.
pub fn seeds(datasets: &[OpenedDataset]) -> BTreeMap<String, u64> {
    let descriptions = datasets.iter().map(|it| it.dataset.description());
    descriptions.filter_map(|it| Some((it.id.clone(), StreetDrive::of(it)?.seed))).collect()
}

/// Refuses data sets that are not those of the run of `manifest`, of which the scans of `selection` were chosen.
pub fn refuse_other_scans(
    manifest: &Manifest,
    datasets: &[OpenedDataset],
    selection: Option<&str>,
) -> Result<(), Usage> {
    for opened in datasets {
        let id = &opened.dataset.description().id;
        let found = dataset_entry(opened, selection);
        // Simulated scans have no checksum: they are what version, street and seed make.
        let is_same = |entry: &&DatasetEntry| {
            (&entry.id, &entry.checksum, &entry.simulation) == (&found.id, &found.checksum, &found.simulation)
        };
        let is_listed = manifest.datasets.iter().any(|entry| is_same(&entry));
        if !is_listed || seeds(datasets).get(id) != manifest.seeds.get(id) {
            let problem =
                format!("the scans of {id:?} differ from those of the run: data or simulator have changed");
            return Err(Usage(problem));
        }
    }
    Ok(())
}

/// Entry of a data set in a manifest; `selection` are the scans that were chosen, `None` for all.
pub fn dataset_entry(opened: &OpenedDataset, selection: Option<&str>) -> DatasetEntry {
    let description = opened.dataset.description();
    let [doubts, overruled_doubts] = opened.first_look.doubts();
    DatasetEntry {
        id: description.id.clone(),
        format: description.format.clone(),
        root: description.root.as_ref().map(|it| it.display().to_string()),
        simulated: description.is_simulated(),
        annotated: match &description.annotated {
            dataset::AnnotatedClasses::EveryObject => AnnotatedClasses::EveryObject,
            dataset::AnnotatedClasses::Only(classes) => AnnotatedClasses::Only(classes.clone()),
        },
        checksum: description.checksum.clone(),
        n_scans: opened.scan_indices.len() as u64,
        skipped_scans: opened.skipped.borrow().clone(),
        seen: opened.first_look.seen.clone(),
        label_points: opened.first_look.label_points.clone(),
        doubts,
        overruled_doubts,
        classes: opened.classes.written(),
        labels_ahead_deg: opened.labels_ahead_deg,
        n_points_left_out: opened.points_left_out.n_points_in(&opened.scan_indices) as u64,
        selection: selection.map(str::to_owned),
        blocks: blocks(opened),
        blocks_checksum: opened.blocks_checksum.clone(),
        sensor_height_m: description.sensor_height_m,
        sensor: description.sensor.clone(),
        licence: description.licence.clone(),
        simulation: StreetDrive::of(description).as_ref().map(simulation),
    }
}

/// Blocks or drives of the scans where they are not their sequences, each with its scans.
pub fn blocks(opened: &OpenedDataset) -> BTreeMap<String, Vec<String>> {
    let mut blocks: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for &scan_idx in &opened.scan_indices {
        if let Some(block) = opened.dataset.scan_block(scan_idx) {
            blocks.entry(block.to_owned()).or_default().push(opened.dataset.scan_ids()[scan_idx].to_string());
        }
    }
    blocks
}

fn simulation(drive: &StreetDrive) -> Simulation {
    Simulation {
        simulator_version: SIMULATOR_VERSION,
        street: drive.street.name().to_owned(),
        n_drive_scans: drive.n_scans,
        turns_per_scan: drive.turns_per_scan,
        scans_per_drive: drive.scans_per_drive,
        sensor: drive.sensor.clone(),
        shutter: drive.shutter.name().to_owned(),
        rain_mm_per_h: drive.rain_mm_per_h,
        sensor_height_m: drive.sensor_height_m,
        conditions: (drive.conditions != StreetConditions::default())
            .then(|| serde_json::to_value(drive.conditions).expect("conditions are numbers")),
        labeled_to_either_side_deg: drive.labeled_to_either_side_deg,
    }
}
