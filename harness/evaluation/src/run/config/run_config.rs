//! The parameters of all detectors and of the matching in a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baselines::params::{BaselineParams, PARAMS_TOML};
use detector::grid::density_curve::DensityCurve;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::whole::box_model::BoxModels;
use reports::files::regular_file::read_settings;
use scans::dataset::DatasetDescription;
use scans::dataset::class_table::ClassTable;
use toml::{Table, Value};

use super::detector_table::DETECTOR_TABLE;
use super::error::ConfigError;
use super::matching_table::{MATCHING_TOML, matching_from};
use super::override_file::OverrideFile;
use super::override_option::{OverrideOption, OverrideOptions};
use super::parameter_tree::parameters;
use super::slice_table::{OwnSlices, SLICES};
use super::value_problem::ValueProblem;
use super::vehicle_model_table::{
    TrainedModel, VEHICLE_MODEL, VEHICLE_MODEL_TOML, VehicleModels, vehicle_models_from,
};
use crate::matching::assign::MatchingParams;
use crate::matching::class_criteria::ClassCriteria;
use crate::matching::criterion::Criterion;
use crate::run::foreign_detector::ForeignDetector;

/// Parameters of all detectors and of the matching in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunConfig {
    /// The hierarchical detector.
    pub hierarchical: HierarchicalParams,
    /// The detector of the papers, which has the density curve of the hierarchical one.
    pub paper: PaperParams,
    /// The baselines.
    pub baselines: BaselineParams,
    /// How detections are judged.
    pub matching: MatchingParams,
    /// How those of single classes are judged.
    pub class_criteria: ClassCriteria,
    /// Slices of the user.
    pub slices: OwnSlices,
    /// Models that classify vehicles; `None` if they are classified by size.
    pub vehicle_models: Option<VehicleModels>,
    /// Meanings of class names in labels, from the file.
    pub classes: ClassTable,
    /// Detectors that are not built in, from the file.
    pub foreign: Vec<ForeignDetector>,
    /// The file; `None` if there is none.
    pub file: Option<PathBuf>,
    /// Directories of models that the file of a project names, by parameter.
    models_of_project: BTreeMap<&'static str, String>,
    /// The sensor of the scans, once known.
    pub sensor: Option<String>,
    /// Density curves, learned from their scans, of data sets whose sensor has no shipped one; by id and sensor.
    pub own_curves: BTreeMap<(String, String), DensityCurve>,
    /// Where labels of the scans lie, once known: data sets, and runs on them.
    pub places_of_labels: Vec<PathBuf>,
    /// All parameters as one document, for the manifest; without the density curve if it is the sensor's.
    pub resolved: Table,
}

/// All parameters with their shipped values.
pub(super) fn shipped() -> Table {
    let parse = |text: &str| text.parse::<Table>().expect("the embedded files are tested");
    let mut all = parse(PARAMS_TOML);
    all.insert("matching".to_owned(), Value::Table(parse(MATCHING_TOML)));
    all.insert("hierarchical".to_owned(), Value::Table(HierarchicalParams::shipped_table()));
    all.insert("paper".to_owned(), Value::Table(PaperParams::shipped_table()));
    all.insert(VEHICLE_MODEL.to_owned(), Value::Table(parse(VEHICLE_MODEL_TOML)));
    all
}

impl RunConfig {
    /// Loads the shipped parameters, overridden by the TOML file at `overrides`, if there is one.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] if the file cannot be read, or holds unknown parameters or values that cannot be used.
    pub fn load(overrides: Option<&Path>) -> Result<Self, ConfigError> {
        let Some(path) = overrides else { return Self::resolve("", Path::new("built-in configuration")) };
        Ok(Self { file: Some(path.to_owned()), ..Self::resolve(&text_of(path)?, path)? })
    }

    /// As [`Self::load`], of a file that is for all commands of a project: detectors that read other models than it names do
    /// not mind.
    ///
    /// # Errors
    ///
    /// As [`Self::load`].
    pub fn of_project(path: &Path) -> Result<Self, ConfigError> {
        let config = Self::load(Some(path))?;
        let models = TrainedModel::ALL.into_iter().filter_map(|it| Some((it, config.directory_of(it)?)));
        let models = models.map(|(model, directory)| (model.parameter(), directory.to_owned())).collect();
        Ok(Self { models_of_project: models, ..config })
    }

    /// Meanings of class names in labels that the file at `path` has. Its own classes are known from then on.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] as [`Self::load`], but for values that cannot be used.
    pub fn classes_in(path: &Path) -> Result<ClassTable, ConfigError> {
        let text = text_of(path)?;
        Ok(OverrideFile { path, text: &text }.apply(&mut shipped())?.classes)
    }

    /// The shipped parameters, with vehicles classified by their size. No model is read, so the models of the program may be
    /// outdated.
    ///
    /// # Errors
    ///
    /// None that a test would not have found.
    pub fn without_vehicle_models() -> Result<Self, ConfigError> {
        Self::resolve("vehicle_model.enabled = false", Path::new("built-in configuration"))
    }

    /// These parameters for scans of `sensor`, with its density curve instead of the paper's; `None` if the detector has no
    /// curve of this sensor. A curve from the file is kept.
    pub fn for_sensor(&self, sensor: &str) -> Option<Self> {
        self.with_curve(sensor, || DensityCurve::shipped(sensor))
    }

    /// As [`Self::for_sensor`], for scans of the data set `id`: with the curve of its `sensor`, or its own one of
    /// [`Self::own_curves`].
    pub fn for_dataset(&self, id: &str, sensor: &str) -> Option<Self> {
        let own = || self.own_curves.get(&(id.to_owned(), sensor.to_owned())).cloned();
        self.with_curve(sensor, || DensityCurve::shipped(sensor).or_else(own))
    }

    /// As [`Self::for_dataset`], for scans of `dataset`. A sensor of unknown density is treated as the paper's.
    pub fn for_scans_of(&self, dataset: &DatasetDescription) -> Self {
        self.for_dataset(&dataset.id, &dataset.sensor).unwrap_or_else(|| self.clone())
    }

    fn with_curve(&self, sensor: &str, curve: impl FnOnce() -> Option<DensityCurve>) -> Option<Self> {
        let mut config = self.clone();
        config.sensor = Some(sensor.to_owned());
        if !gives_density_curve(&self.resolved) {
            config.hierarchical.density_weighting.curve = curve()?;
        }
        Some(config)
    }

    /// Replaces the criterion of the file by the kind of `criterion`. The gate stays that of the file.
    pub fn choose_criterion(&mut self, criterion: Criterion) {
        self.matching.criterion = match (criterion, self.resolved.get("matching").and_then(Value::as_table)) {
            (Criterion::Points { .. }, Some(table)) => {
                Criterion::Points { min_iou: number(table, "min_iou") }
            }
            (Criterion::BevIou { .. }, Some(table)) => {
                Criterion::BevIou { min_iou: number(table, "min_iou") }
            }
            (Criterion::Iou3d { .. }, Some(table)) => Criterion::Iou3d { min_iou: number(table, "min_iou") },
            (Criterion::Centre { .. }, Some(table)) => {
                Criterion::Centre { max_distance_m: number(table, "max_centre_distance_m") }
            }
            (criterion, None) => criterion,
        };
        if let Some(Value::Table(table)) = self.resolved.get_mut("matching") {
            table.insert("criterion".to_owned(), Value::String(criterion.name().to_owned()));
        }
    }

    /// Judges nothing outside the slice `name`.
    ///
    /// # Errors
    ///
    /// A sentence if there is no such slice.
    pub fn judge_only(&mut self, name: &str) -> Result<(), String> {
        self.matching.eligibility.only = Some(self.slices.bounds_of(name)?);
        if let Some(Value::Table(table)) = self.resolved.get_mut("matching") {
            table.insert("only".to_owned(), Value::String(name.to_owned()));
        }
        Ok(())
    }

    /// These parameters, overridden by `options`. A parameter of the tables `own` may be named by the end of its name if
    /// that is unique.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] if an option names no parameter, or several, or its value cannot be used.
    pub fn overridden(&self, options: &[OverrideOption], own: &[&str]) -> Result<Self, ConfigError> {
        let options = OverrideOptions::resolve(options, &self.resolved, own)?;
        let mut resolved = self.resolved.clone();
        options.apply(&mut resolved)?;
        let config = self.changed_to(resolved).map_err(|problem| options.value_error(problem))?;
        let (classes, foreign) = (self.classes.clone(), self.foreign.clone());
        let (file, sensor, own_curves) = (self.file.clone(), self.sensor.clone(), self.own_curves.clone());
        let models_of_project = self.models_of_project.clone();
        let places_of_labels = self.places_of_labels.clone();
        Ok(Self { classes, foreign, file, models_of_project, sensor, own_curves, places_of_labels, ..config })
    }

    /// The full name of the parameter that `option` names, by the rules of [`Self::overridden`].
    ///
    /// # Errors
    ///
    /// [`ConfigError`] if it names no parameter, or several.
    pub fn full_name(&self, option: &OverrideOption, own: &[&str]) -> Result<String, ConfigError> {
        Ok(option.keys(&parameters(&self.resolved), own)?.join("."))
    }

    /// The value of the parameter with this full name.
    pub fn value_of(&self, full_name: &str) -> Option<&Value> {
        let (first, rest) = full_name.split_once('.')?;
        rest.split('.').try_fold(self.resolved.get(first)?, |table, key| table.get(key))
    }

    /// The model of the boxes of whole vehicles; `None` for the one that comes with the program.
    pub fn box_model(&self) -> Option<Arc<BoxModels>> {
        self.vehicle_models.as_ref().and_then(VehicleModels::boxes)
    }

    /// The directory that `model` is from; `None` for one that comes with the program.
    pub fn directory_of(&self, model: TrainedModel) -> Option<&str> {
        self.value_of(model.parameter()).and_then(Value::as_str).filter(|it| !it.is_empty())
    }

    /// The directory of `model`, unless the file of the project names it.
    pub fn directory_asked_for(&self, model: TrainedModel) -> Option<&str> {
        let of_project = self.models_of_project.get(model.parameter());
        self.directory_of(model).filter(|it| of_project.is_none_or(|of_project| of_project != it))
    }

    fn resolve(overrides: &str, path: &Path) -> Result<Self, ConfigError> {
        let file = OverrideFile { path, text: overrides };
        let mut resolved = shipped();
        let applied = file.apply(&mut resolved)?;
        name_models_from_here(&mut resolved, path);
        if !applied.gives_density_curve
            && let Some(Value::Table(weighting)) = resolved["hierarchical"].get_mut("density_weighting")
        {
            weighting.remove("curve");
        }
        let vehicle_models = vehicle_models_of(&resolved).map_err(|problem| file.value_error(problem))?;
        if !applied.foreign_parameters.is_empty() {
            resolved.insert(DETECTOR_TABLE.to_owned(), Value::Table(applied.foreign_parameters));
        }
        let config =
            Self::from_resolved(resolved, vehicle_models).map_err(|problem| file.value_error(problem))?;
        Ok(Self { classes: applied.classes, foreign: applied.foreign, ..config })
    }

    /// The parameters `resolved`. Reuses the loaded models if their parameters are equal.
    fn changed_to(&self, resolved: Table) -> Result<Self, ValueProblem> {
        let are_here = resolved.get(VEHICLE_MODEL) == self.resolved.get(VEHICLE_MODEL);
        let vehicle_models =
            if are_here { self.vehicle_models.clone() } else { vehicle_models_of(&resolved)? };
        Self::from_resolved(resolved, vehicle_models)
    }

    fn from_resolved(resolved: Table, vehicle_models: Option<VehicleModels>) -> Result<Self, ValueProblem> {
        if let Some(models) = &vehicle_models {
            models.check_parameters(&resolved)?;
        }
        let table = |name: &str| resolved[name].as_table().cloned().unwrap_or_default();
        // Without a curve in the file the sensor's is used; until the sensor is known, the paper's.
        let hierarchical = if gives_density_curve(&resolved) {
            table("hierarchical")
        } else {
            with_density_curve(table("hierarchical"), &HierarchicalParams::shipped_table())
        };
        let (hierarchical, paper) = (hierarchical.to_string(), table("paper").to_string());
        let matching = table("matching").to_string();
        let slices = OwnSlices::of_table(resolved.get(SLICES))
            .map_err(|(keys, problem)| ValueProblem { keys, problem })?;
        let (matching, class_criteria) = matching_from(&matching, &slices)
            .map_err(|error| ValueProblem::new(&error, Some("matching"), &matching))?;
        let of_others = ["matching", "hierarchical", "paper", VEHICLE_MODEL, DETECTOR_TABLE, SLICES];
        let of_baselines = resolved.iter().filter(|(name, _)| !of_others.contains(&name.as_str()));
        let baselines: Table = of_baselines.map(|(name, value)| (name.clone(), value.clone())).collect();
        let baselines = baselines.to_string();
        Ok(Self {
            hierarchical: HierarchicalParams::from_toml(&hierarchical)
                .map_err(|error| ValueProblem::new(&error, Some("hierarchical"), &hierarchical))?,
            paper: PaperParams::from_toml(&paper)
                .map_err(|error| ValueProblem::new(&error, Some("paper"), &paper))?,
            baselines: BaselineParams::from_toml(&baselines)
                .map_err(|error| ValueProblem::new(&error, None, &baselines))?,
            matching,
            class_criteria,
            slices,
            vehicle_models,
            classes: ClassTable::default(),
            file: None,
            models_of_project: BTreeMap::new(),
            sensor: None,
            own_curves: BTreeMap::new(),
            places_of_labels: Vec::new(),
            foreign: Vec::new(),
            resolved,
        })
    }
}

fn text_of(path: &Path) -> Result<String, ConfigError> {
    let bytes = read_settings(path).map_err(|source| ConfigError::Io { path: path.to_owned(), source })?;
    String::from_utf8(bytes).map_err(|error| ConfigError::NotText {
        path: path.to_owned(),
        byte_offset: error.utf8_error().valid_up_to(),
    })
}

/// Directories of models in a file are relative to it, wherever the program runs.
fn name_models_from_here(resolved: &mut Table, path: &Path) {
    let here = std::env::current_dir().ok();
    let is_elsewhere = |it: &&Path| !it.as_os_str().is_empty() && here.as_deref() != Some(*it);
    let Some(folder) = path.parent().filter(is_elsewhere) else { return };
    let Some(Value::Table(models)) = resolved.get_mut(VEHICLE_MODEL) else { return };
    for (_, directory) in models.iter_mut() {
        if let Value::String(directory) = directory
            && !directory.is_empty()
        {
            *directory = folder.join(&*directory).to_string_lossy().into_owned();
        }
    }
}

fn vehicle_models_of(all: &Table) -> Result<Option<VehicleModels>, ValueProblem> {
    vehicle_models_from(&all[VEHICLE_MODEL].as_table().cloned().unwrap_or_default().to_string())
}

fn gives_density_curve(all: &Table) -> bool {
    let weighting = all.get("hierarchical").and_then(|it| it.get("density_weighting"));
    weighting.is_some_and(|it| it.get("curve").is_some())
}

/// The parameters `hierarchical` with the density curve of `other`.
fn with_density_curve(mut hierarchical: Table, other: &Table) -> Table {
    let curve = other.get("density_weighting").and_then(|it| it.get("curve"));
    if let (Some(Value::Table(weighting)), Some(curve)) = (hierarchical.get_mut("density_weighting"), curve) {
        weighting.insert("curve".to_owned(), curve.clone());
    }
    hierarchical
}

/// A number of a table that has been checked to hold it.
fn number(table: &Table, name: &str) -> f64 {
    table.get(name).and_then(Value::as_float).expect("the table was read into parameters before")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::eligibility::EligibilityParams;
    use reports::vocabulary::class::AnnotationClass;

    fn resolve(text: &str) -> Result<RunConfig, ConfigError> {
        RunConfig::resolve(text, Path::new("mine.toml"))
    }

    #[test]
    fn nothing_overridden_is_the_standard() {
        let config = resolve("").unwrap();
        assert_eq!(config.hierarchical, HierarchicalParams::shipped());
        assert_eq!(config.paper, PaperParams::shipped());
        assert_eq!(config.baselines, BaselineParams::shipped());
        let standard =
            MatchingParams { criterion: Criterion::POINTS, eligibility: EligibilityParams::STANDARD };
        assert_eq!(config.matching, standard);
    }

    #[test]
    fn a_value_is_overridden_alone() {
        let config = resolve("[hierarchical.grid]\ncell_size_m = 1\n[kd_tree]\ntolerance_m = 0.7").unwrap();
        assert_eq!((config.hierarchical.grid.cell_size_m, config.hierarchical.grid.xi), (1.0, 3));
        assert_eq!(config.baselines.kd_tree.tolerance_m, 0.7);
        let resolved = config.resolved["hierarchical"]["grid"]["cell_size_m"].as_float();
        assert_eq!(resolved, Some(1.0));
    }

    #[test]
    fn the_ends_of_a_range_are_within_it() {
        assert_eq!(resolve("kd_tree.tolerance_m = 0.01").unwrap().baselines.kd_tree.tolerance_m, 0.01);
        assert_eq!(
            resolve("hierarchical.grid.cell_size_m = 0.05").unwrap().hierarchical.grid.cell_size_m,
            0.05
        );
    }

    #[test]
    fn the_density_curve_is_that_of_the_sensor_unless_the_file_gives_one() {
        let peak = |it: &RunConfig| it.hierarchical.density_weighting.curve.peak_points_per_m2;
        let of = |sensor: &str| DensityCurve::shipped(sensor).unwrap().peak_points_per_m2;
        let config = resolve("hierarchical.density_weighting.enabled = false").unwrap();
        assert_eq!(peak(&config.for_sensor("vlp-16").unwrap()), of("vlp-16"));
        assert_eq!(config.resolved["hierarchical"]["density_weighting"].get("curve"), None);
        assert_eq!(config.for_sensor("mine.toml"), None);
        let given = DensityCurve::shipped("os1-128").unwrap().to_toml();
        let config = resolve(&given).unwrap();
        for sensor in ["vlp-16", "mine.toml"] {
            assert_eq!(peak(&config.for_sensor(sensor).unwrap()), of("os1-128"));
        }
        let resolved = &config.resolved["hierarchical"]["density_weighting"]["curve"]["sensor"];
        assert_eq!(resolved.as_str(), Some("os1-128"));
    }

    #[test]
    fn an_option_leaves_the_density_curve_to_the_sensor() {
        let option = "hierarchical.grid.xi=2".parse().unwrap();
        let config = resolve("").unwrap().overridden(&[option], &[]).unwrap();
        let shipped = DensityCurve::shipped("vlp-16").unwrap();
        assert_eq!(config.for_sensor("vlp-16").unwrap().hierarchical.density_weighting.curve, shipped);
    }

    #[track_caller]
    fn check_refused(text: &str, message: &str) {
        let error = resolve(text).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn what_nothing_reads_is_refused_with_its_line() {
        check_refused(
            "# mine\n[kd_tree]\ntolerence_m = 1.0",
            "\"mine.toml\", line 3: unknown parameter kd_tree.tolerence_m",
        );
        check_refused(
            "[hirarchical]",
            "line 1: unknown parameter hirarchical; parameters are hierarchical, kd_tree, matching, paper, pca, vehicle_model",
        );
        check_refused(
            "[kd_tree]\ntolerance_m = \"far\"",
            "line 2: kd_tree.tolerance_m is of type string, but must be float",
        );
    }

    #[test]
    fn what_cannot_be_worked_with_is_refused_with_its_line() {
        check_refused(
            "# mine\n[matching]\nmin_iou = 0.0",
            "\"mine.toml\", line 3: matching.min_iou = 0 is not within 0.01 to 1",
        );
        check_refused(
            "[matching]\nmin_points = -1",
            "line 2: matching.min_points: invalid value: integer `-1`",
        );
        check_refused(
            "\n[hierarchical.grid]\ncell_size_m = 1.0\nxi = 9",
            "line 4: hierarchical.grid.xi = 9 is not within 1 to 8",
        );
        check_refused(
            "hierarchical.grid.xi = -3",
            "line 1: hierarchical.grid.xi: invalid value: integer `-3`, expected u32",
        );
        check_refused(
            "[hierarchical.terrain]\nlow_quantile = 1.1",
            "line 2: hierarchical.terrain.low_quantile = 1.1 is not within 0 to 1",
        );
        check_refused(
            "kd_tree.max_points = 9",
            "line 1: kd_tree.max_points = 9 is less than kd_tree.min_points = 15",
        );
        check_refused("kd_tree.foreground = \"blue\"", "line 1: kd_tree.foreground: unknown variant `blue`");
        check_refused("[pca.grid]\ncell_size_m = 0", "line 2: pca.grid.cell_size_m = 0 is not within");
    }

    #[test]
    fn names_of_classes_are_no_parameters() {
        let config = resolve("[classes]\nforklift = \"misc\"\n[kd_tree]\ntolerance_m = 0.7").unwrap();
        assert_eq!(config.classes.get("Forklift"), Some(AnnotationClass::Misc));
        assert_eq!((config.resolved.get("classes"), config.baselines.kd_tree.tolerance_m), (None, 0.7));
        let option = "hierarchical.grid.xi=2".parse().unwrap();
        assert_eq!(config.overridden(&[option], &[]).unwrap().classes, config.classes);
        check_refused(
            "[classes]\nforklift = \"mics\"",
            "line 2: classes.forklift: \"mics\" is not a class; classes are car",
        );
        check_refused(
            "[classes]\nforklift = 3",
            "line 2: classes.forklift is of type integer, but must be string",
        );
        check_refused("classes = 3", "line 1: classes is of type integer, but must be table");
    }

    #[test]
    fn what_is_not_toml_is_refused_with_its_line() {
        check_refused("# mine\n[kd_tree", "\"mine.toml\", line 2: unclosed table");
    }

    #[test]
    fn the_chosen_criterion_keeps_the_gate_of_the_file() {
        let mut config =
            resolve("[matching]\ncriterion = \"centre\"\nmin_iou = 0.7\nmax_centre_distance_m = 1").unwrap();
        assert_eq!(config.matching.criterion, Criterion::Centre { max_distance_m: 1.0 });
        config.choose_criterion(Criterion::POINTS);
        assert_eq!(config.matching.criterion, Criterion::Points { min_iou: 0.7 });
        assert_eq!(config.resolved["matching"]["criterion"].as_str(), Some("points"));
        config.choose_criterion(Criterion::CENTRE);
        assert_eq!(config.matching.criterion, Criterion::Centre { max_distance_m: 1.0 });
        assert_eq!(config.resolved["matching"]["criterion"].as_str(), Some("centre"));
    }
}
