//! List of the detectors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use baselines::kd_tree_detector::{kd_tree, kd_tree_same_walls};
use baselines::kd_tree_groups::{kd_tree_trained, kd_tree_tree};
use baselines::kd_tree_models::{TrainedComponents, shipped_tree};
use baselines::pca_detector::pca;
use baselines::simple_grid_detector::simple_grid;
use detector::Detector;
use detector::classify::grouping_model::GroupingModel;
use detector::pipeline::object_stages::ObjectModels;
use detector::pipeline::paper_detector::paper;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use reports::verdicts::suggestion::closest;

use crate::run::config::{DETECTOR_TABLE, RunConfig, TrainedModel, VehicleModels};
use crate::run::foreign_detector::{ForeignDetector, ForeignWork, VehicleRule};

/// A detector that can be asked for by name.
#[derive(Debug, Clone, Copy)]
pub struct ListedDetector {
    /// The name on the command line.
    pub name: &'static str,
    /// Its table in the configuration.
    pub table: &'static str,
    /// Parameters of the table that are fixed for it, whatever the configuration says, with their values.
    pub fixed: &'static [(&'static str, &'static str)],
    model: TrainedModel,
    build: fn(&RunConfig, f32) -> Box<dyn Detector>,
}

/// The method of the papers, without any addition.
pub const PAPER: ListedDetector = ListedDetector {
    name: "paper",
    table: "paper",
    fixed: &[],
    model: TrainedModel::Paper,
    build: |config, sensor_height_m| {
        let model = config.vehicle_models.as_ref().map(VehicleModels::paper);
        Box::new(paper(&config.paper, &config.hierarchical, model, sensor_height_m))
    },
};

/// Every detector, in the order of tables and pictures: the best cut of the hierarchical grid, its rivals with the same
/// training, the method of the papers, and the baselines of the papers.
pub const DETECTORS: &[ListedDetector] = &[
    ListedDetector {
        name: "hierarchical",
        table: "hierarchical",
        fixed: &[],
        model: TrainedModel::Groupings,
        build: |config, sensor_height_m| {
            let groupings = config.vehicle_models.as_ref().map(VehicleModels::groupings);
            let models = group_models(config, groupings.unwrap_or_else(GroupingModel::shipped));
            Box::new(hierarchical(&config.hierarchical, models, sensor_height_m))
        },
    },
    ListedDetector {
        name: "kd-tree-trained",
        table: "hierarchical",
        fixed: &[],
        model: TrainedModel::Components,
        build: |config, sensor_height_m| {
            let components = config.vehicle_models.as_ref().map(VehicleModels::components);
            let components = components.unwrap_or_else(TrainedComponents::shipped);
            let tolerance_m = components.tolerance_m(config.sensor.as_deref());
            let models = group_models(config, components.judge);
            Box::new(kd_tree_trained(&config.hierarchical, tolerance_m, models, sensor_height_m))
        },
    },
    ListedDetector {
        name: "kd-tree-tree",
        table: "hierarchical",
        fixed: &[],
        model: TrainedModel::NestedComponents,
        build: |config, sensor_height_m| {
            let nested = config.vehicle_models.as_ref().map(VehicleModels::nested_components);
            let models = group_models(config, nested.unwrap_or_else(shipped_tree));
            Box::new(kd_tree_tree(&config.hierarchical, models, sensor_height_m))
        },
    },
    PAPER,
    // The next one has the walls of the first, for a comparison like for like.
    ListedDetector {
        name: "kd-tree-same-walls",
        table: "kd_tree",
        fixed: &[("foreground", "refined")],
        model: TrainedModel::Clusters,
        build: |config, sensor_height_m| {
            let params = &config.baselines.kd_tree;
            Box::new(kd_tree_same_walls(
                params,
                &config.hierarchical,
                cluster_models(config),
                sensor_height_m,
            ))
        },
    },
    ListedDetector {
        name: "kd-tree",
        table: "kd_tree",
        fixed: &[],
        model: TrainedModel::Clusters,
        build: |config, sensor_height_m| {
            let params = &config.baselines.kd_tree;
            Box::new(kd_tree(params, &config.hierarchical, cluster_models(config), sensor_height_m))
        },
    },
    ListedDetector {
        name: "pca",
        table: "pca",
        fixed: &[],
        model: TrainedModel::Pca,
        build: |config, sensor_height_m| {
            let model = config.vehicle_models.as_ref().map(VehicleModels::pca);
            Box::new(pca(&config.baselines.pca, &config.hierarchical, model, sensor_height_m))
        },
    },
    // This one is an ablation of the first and has its parameters.
    ListedDetector {
        name: "simple-grid",
        table: "hierarchical",
        fixed: &[],
        model: TrainedModel::Clusters,
        build: |config, sensor_height_m| {
            Box::new(simple_grid(&config.hierarchical, cluster_models(config), sensor_height_m))
        },
    },
];

/// Models of a detector of groups that `groups` judges.
fn group_models(config: &RunConfig, groups: Arc<GroupingModel>) -> GroupModels {
    let vehicles = if config.vehicle_models.is_some() { VehiclesBy::Model } else { VehiclesBy::Size };
    GroupModels { groups, vehicles, boxes: config.box_model() }
}

/// Models of a detector of clusters.
fn cluster_models(config: &RunConfig) -> ObjectModels {
    let vehicles = config.vehicle_models.as_ref().map(VehicleModels::clusters);
    ObjectModels { vehicles, boxes: config.box_model() }
}

/// Default detectors of a run: the method, its strongest rival, which has the same training, the method of the papers, and
/// the baselines of the papers.
pub const DEFAULT_DETECTORS: [&str; 5] = ["hierarchical", "kd-tree-tree", "paper", "kd-tree", "pca"];

/// A detector that was asked for, built in or not.
#[derive(Debug, Clone)]
pub enum ChosenDetector {
    /// One of [`DETECTORS`].
    BuiltIn(ListedDetector),
    /// A detector that the configuration defines.
    Foreign(ForeignDetector),
}

/// Why a detector cannot be chosen by its name.
#[derive(Debug, thiserror::Error)]
pub enum DetectorListError {
    /// No detector has this name.
    #[error("there is no detector {name:?}{}; detectors are {}; {}", or_was_meant(.name, .known), .known.join(", "), of_file(.file.as_deref()))]
    Unknown {
        /// The name.
        name: String,
        /// Names of all detectors.
        known: Vec<&'static str>,
        /// The file that may define others; `None` if there is none.
        file: Option<PathBuf>,
    },
    /// The verb needs a built-in detector.
    #[error("{name:?} is not built in, and this verb works with built-in detectors alone: {}", built_in_names().join(", "))]
    NotBuiltIn {
        /// The name.
        name: String,
    },
    /// A detector is asked for twice.
    #[error("the detector {name:?} is given twice")]
    Twice {
        /// The name.
        name: String,
    },
}

fn or_was_meant(name: &str, known: &[&'static str]) -> String {
    let closest = closest(name, known.iter().copied());
    closest.map_or_else(String::new, |it| format!(" (did you mean {it:?}?)"))
}

fn of_file(file: Option<&Path>) -> String {
    match file {
        Some(path) => format!("{} defines no other", path.display()),
        None => "no scanbench.toml defines others: it is searched for in this folder and those above it"
            .to_owned(),
    }
}

impl ListedDetector {
    /// Builds the detector for a sensor `sensor_height_m` above the road.
    pub fn build(&self, config: &RunConfig, sensor_height_m: f32) -> Box<dyn Detector> {
        (self.build)(config, sensor_height_m)
    }
}

impl ChosenDetector {
    /// Whether it consists of results of another program.
    pub fn is_of_results(&self) -> bool {
        matches!(self, Self::Foreign(foreign) if matches!(foreign.work, ForeignWork::Results(_)))
    }

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::BuiltIn(listed) => listed.name,
            Self::Foreign(foreign) => foreign.name,
        }
    }

    /// The model that classifies its vehicles with the parameters of `config`; `None` if they are classified by size.
    pub fn vehicle_model(&self, config: &RunConfig) -> Option<TrainedModel> {
        config.vehicle_models.as_ref()?;
        match self {
            Self::BuiltIn(listed) => Some(listed.model),
            Self::Foreign(foreign) => {
                (foreign.vehicles == VehicleRule::Model).then_some(TrainedModel::Clusters)
            }
        }
    }

    /// Whether the model of whole boxes completes its boxes with the parameters of `config`.
    pub fn has_whole_boxes(&self, config: &RunConfig) -> bool {
        let are_ours = match self {
            Self::BuiltIn(listed) => !matches!(listed.model, TrainedModel::Paper | TrainedModel::Pca),
            Self::Foreign(_) => true,
        };
        are_ours && config.hierarchical.boxes.whole
    }

    /// In words, how its vehicles are classified with the parameters of `config`.
    pub fn vehicles_in_words(&self, config: &RunConfig) -> String {
        let model = self.vehicle_model(config);
        let by = model.map_or("size", TrainedModel::in_words);
        let from = model.and_then(|it| config.directory_of(it)).map(|it| format!(" from {it:?}"));
        let by = format!("{by}{}", from.unwrap_or_default());
        match self {
            Self::BuiltIn(_) => by,
            Self::Foreign(_) if self.has_whole_boxes(config) => {
                format!("its own classes, else {by}; boxes of its own, else whole ones of ours")
            }
            Self::Foreign(_) => format!("its own classes, else {by}"),
        }
    }

    /// Table of its parameters in the configuration, names separated by dots.
    pub fn table(&self) -> String {
        match self {
            Self::BuiltIn(listed) => listed.table.to_owned(),
            Self::Foreign(foreign) => format!("{DETECTOR_TABLE}.{}", foreign.name),
        }
    }
}

impl From<ListedDetector> for ChosenDetector {
    fn from(listed: ListedDetector) -> Self {
        Self::BuiltIn(listed)
    }
}

/// The detectors with these names, in this order: built-in ones and those that `config` defines.
///
/// # Errors
///
/// [`DetectorListError`] if a name is unknown or given twice.
pub fn detectors_named(
    names: &[String],
    config: &RunConfig,
) -> Result<Vec<ChosenDetector>, DetectorListError> {
    let mut chosen: Vec<ChosenDetector> = Vec::new();
    for name in names {
        let built_in = DETECTORS.iter().find(|it| it.name == name).map(|it| ChosenDetector::BuiltIn(*it));
        let foreign =
            || config.foreign.iter().find(|it| it.name == name).cloned().map(ChosenDetector::Foreign);
        let unknown = || {
            let foreign = config.foreign.iter().map(|it| it.name);
            let known = built_in_names().into_iter().chain(foreign).collect();
            DetectorListError::Unknown { name: name.clone(), known, file: config.file.clone() }
        };
        let found = built_in.or_else(foreign).ok_or_else(unknown)?;
        if chosen.iter().any(|it| it.name() == found.name()) {
            return Err(DetectorListError::Twice { name: name.clone() });
        }
        chosen.push(found);
    }
    Ok(chosen)
}

/// The built-in detectors with these names, in this order.
///
/// # Errors
///
/// [`DetectorListError`] if a name is unknown, of a foreign detector, or given twice.
pub fn built_in_named(
    names: &[String],
    config: &RunConfig,
) -> Result<Vec<ListedDetector>, DetectorListError> {
    let built_in = |it: ChosenDetector| match it {
        ChosenDetector::BuiltIn(listed) => Ok(listed),
        ChosenDetector::Foreign(foreign) => {
            Err(DetectorListError::NotBuiltIn { name: foreign.name.to_owned() })
        }
    };
    detectors_named(names, config)?.into_iter().map(built_in).collect()
}

/// Names of all built-in detectors.
pub fn built_in_names() -> Vec<&'static str> {
    DETECTORS.iter().map(|it| it.name).collect()
}

#[cfg(test)]
mod tests {
    use detector::detector::DetectorOutput;
    use detector::stage_product::Shape;
    use detector::{DetectedClass, Rule};

    use super::*;
    use crate::run::config::TAKEN_NAMES;
    use reports::tables::paper_figures::{PAPER_DETECTOR, PAPER_TABLES, VEHICLE_STEPS};
    use scans::annotation::LabeledScan;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    const SENSOR: &str = "hdl-32e";

    fn scans() -> (Vec<LabeledScan>, f32) {
        let options = OpenOptions {
            n_simulated_scans: Some(12),
            sensor: Some(SENSOR.to_owned()),
            ..OpenOptions::default()
        };
        let street = open_dataset("street-main-road", &options, &built_in_catalogue().unwrap()).unwrap();
        let scans = (0..12).map(|scan_idx| street.read_scan(scan_idx).unwrap()).collect();
        (scans, street.description().sensor_height_m)
    }

    /// Rules of a detector that are visible in its results on `scans`.
    fn rules_seen(detector: &mut dyn Detector, scans: &[LabeledScan], min_points: usize) -> Vec<Rule> {
        let mut output = DetectorOutput::default();
        let (mut has_walls, mut is_judged, mut has_small, mut has_completed) = (false, false, false, false);
        let mut has_whole = false;
        for scan in scans {
            detector.detect(&scan.cloud, &mut output);
            for product in detector.stage_products(&scan.cloud) {
                has_walls |= matches!(&product.shape, Shape::Segments(it) if product.stage == "walls" && !it.is_empty());
                let is_completion = product.stage == "completion";
                // More points than were clustered.
                if let (true, Shape::Clusters(completed)) = (is_completion, &product.shape) {
                    let products = detector.stage_products(&scan.cloud);
                    let foreground = products.iter().find_map(|it| match &it.shape {
                        Shape::LabeledPoints(classes) => Some(classes.clone()),
                        _ => None,
                    });
                    has_completed |= foreground.is_some_and(|classes| {
                        let is_added = |point_idx: usize| {
                            classes[point_idx] != detector::surface_class::SurfaceClass::Short
                        };
                        (0..completed.len()).any(|it| completed[it].is_some() && is_added(it))
                    });
                }
            }
            let vehicles = || output.detections.iter().filter(|it| it.class == DetectedClass::Vehicle);
            has_whole |= vehicles().any(|it| {
                let along_m = it.point_indices.iter().map(|&point_idx| {
                    it.bounding_box.in_box_frame(scan.cloud.position_m(point_idx as usize))[0].abs()
                });
                along_m.fold(0.0, f32::max) + 0.3 < 0.5 * it.bounding_box.length_width_height_m[0]
            });
            has_small |= vehicles().any(|it| it.point_indices.len() < min_points);
            is_judged |= output.stage_times.iter().any(|it| it.stage == "best_cut");
        }
        let seen = [
            // Walls that are evidence stay.
            (has_walls && !is_judged, Rule::Walls),
            (is_judged, Rule::TrainedGroups),
            (has_small, Rule::SmallVehicles { min_points: 10 }),
            (has_completed, Rule::Completion),
            (has_whole, Rule::WholeBoxes),
        ];
        seen.into_iter().filter_map(|(is_seen, rule)| is_seen.then_some(rule)).collect()
    }

    #[test]
    fn rules_are_what_detectors_do() {
        let config = RunConfig::load(None).unwrap().for_sensor(SENSOR).unwrap();
        let (scans, sensor_height_m) = scans();
        let mut n_rules = Vec::new();
        for listed in DETECTORS {
            let mut detector = listed.build(&config, sensor_height_m);
            assert_eq!(detector.name(), listed.name);
            let said: Vec<Rule> = detector.rules();
            n_rules.push((listed.name, said.len()));
            // The size bounds and the best cut cannot be seen from outside.
            let is_hidden = |it: &Rule| [Rule::SizeBounds, Rule::BestCut].contains(it);
            let to_be_seen: Vec<Rule> = said.into_iter().filter(|it| !is_hidden(it)).collect();
            assert_eq!(rules_seen(&mut *detector, &scans, 15), to_be_seen, "{}", listed.name);
        }
        let expected = [
            ("hierarchical", 6),
            ("kd-tree-trained", 5),
            ("kd-tree-tree", 6),
            // Walls, which the papers have.
            ("paper", 1),
            ("kd-tree-same-walls", 5),
            ("kd-tree", 4),
            ("pca", 0),
            ("simple-grid", 5),
        ];
        assert_eq!(n_rules, expected);
    }

    #[test]
    fn published_steps_are_stages_of_the_detector_of_the_papers_and_no_published_number_is_of_another() {
        assert_eq!(PAPER.name, PAPER_DETECTOR);
        let config = RunConfig::load(None).unwrap().for_sensor(SENSOR).unwrap();
        let (scans, sensor_height_m) = scans();
        let mut output = DetectorOutput::default();
        PAPER.build(&config, sensor_height_m).detect(&scans[0].cloud, &mut output);
        let stages: Vec<&str> = output.stage_times.iter().map(|it| it.stage).collect();
        let of_steps: Vec<&str> = VEHICLE_STEPS.iter().flat_map(|it| it.stages).copied().collect();
        assert_eq!(of_steps, stages);
        for method in PAPER_TABLES.iter().flat_map(|it| &it.methods) {
            assert!(["paper", "kd-tree", "pca"].contains(&method.detector), "{}", method.name);
        }
    }

    #[test]
    fn nobody_else_has_their_names() {
        assert!(built_in_names().iter().all(|it| TAKEN_NAMES.contains(it)));
    }

    #[test]
    fn bounds_that_are_switched_off_are_no_rule() {
        let rules = |options: &[&str]| {
            let options: Vec<_> = options.iter().map(|it| it.parse().unwrap()).collect();
            let config = RunConfig::load(None).unwrap().overridden(&options, &["hierarchical"]).unwrap();
            let listed = built_in_named(&["kd-tree".to_owned()], &config).unwrap()[0];
            listed.build(&config.for_sensor(SENSOR).unwrap(), 1.73).rules()
        };
        assert!(rules(&[]).contains(&Rule::SizeBounds));
        assert!(!rules(&["hierarchical.vehicle_bounds.enabled=false"]).contains(&Rule::SizeBounds));
    }

    #[test]
    fn the_kd_tree_with_the_same_walls_differs_by_its_foreground_alone() {
        let (scans, sensor_height_m) = scans();
        let load = |options: &[&str]| {
            let options: Vec<_> = options.iter().map(|it| it.parse().unwrap()).collect();
            RunConfig::load(None).unwrap().overridden(&options, &["kd_tree"]).unwrap()
        };
        let found = |name: &str, config: &RunConfig| {
            let listed = built_in_named(&[name.to_owned()], config).unwrap()[0];
            let mut output = DetectorOutput::default();
            listed.build(config, sensor_height_m).detect(&scans[0].cloud, &mut output);
            output.detections
        };
        for more in [&[][..], &["tolerance_m=0.7"], &["min_points=40", "max_points=3000"]] {
            let config = load(more);
            let of_refined = found("kd-tree", &load(&[more, &["foreground=refined"]].concat()));
            assert_eq!(found("kd-tree-same-walls", &config), of_refined, "{more:?}");
            assert_ne!(found("kd-tree", &config), of_refined, "{more:?}");
        }
    }
}
