//! What tells vehicles, as a table of the configuration.

use std::path::Path;
use std::sync::Arc;

use baselines::pca_vehicle_model::PcaVehicleModel;
use detector::classify::grouping_model::{GroupingModel, GroupingModelError};
use detector::classify::paper_model::PaperModel;
use detector::classify::vehicle_model::{VehicleModel, VehicleModelError};
use detector::params::ParamsError;
use scans::dataset::checksum::sha256;
use serde::Deserialize;

use super::value_problem::ValueProblem;

/// The models that come with the program, unless something else is said.
pub(super) const VEHICLE_MODEL_TOML: &str = r#"
enabled = true
directory = ""
paper_directory = ""
pca_directory = ""
groupings_directory = ""
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleModelTable {
    /// Otherwise all detectors tell vehicles by their size.
    enabled: bool,
    /// What `scanbench train` wrote; the model that comes with the program if empty.
    directory: String,
    /// The same for the detector paper.
    paper_directory: String,
    /// The same for the detector pca.
    pca_directory: String,
    /// The same for the groupings of the detector hierarchical.
    groupings_directory: String,
}

/// A model that tells vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrainedModel {
    /// The SVM of the clusters of grids and kd-tree, and of detectors that are not built in.
    Clusters,
    /// The SVM of the detector paper.
    Paper,
    /// The SVM of the detector pca.
    Pca,
    /// The forests of the detector hierarchical.
    Groupings,
}

impl TrainedModel {
    /// All models.
    pub const ALL: [Self; 4] = [Self::Clusters, Self::Paper, Self::Pca, Self::Groupings];

    /// The parameter that names its directory.
    pub fn parameter(self) -> &'static str {
        match self {
            Self::Clusters => "vehicle_model.directory",
            Self::Paper => "vehicle_model.paper_directory",
            Self::Pca => "vehicle_model.pca_directory",
            Self::Groupings => "vehicle_model.groupings_directory",
        }
    }

    /// What it is, for people.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Clusters => "SVM of grid clusters",
            Self::Paper | Self::Pca => "its own SVM",
            Self::Groupings => "its own forests",
        }
    }
}

/// What tells vehicles. The models that come with the program are read when a detector first asks for one.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModels {
    by_shape: ModelSource<VehicleModel>,
    paper: ModelSource<PaperModel>,
    pca: ModelSource<PcaVehicleModel>,
    groupings: ModelSource<Arc<GroupingModel>>,
}

/// Where a model is from.
#[derive(Debug, Clone, PartialEq)]
enum ModelSource<M> {
    Shipped,
    /// Read from files with this checksum.
    Trained {
        model: Arc<M>,
        checksum: String,
    },
}

impl VehicleModels {
    /// The model of the clusters of grids and kd-tree.
    pub fn by_shape(&self) -> VehicleModel {
        self.by_shape.model(VehicleModel::shipped)
    }

    /// That of the detector paper.
    pub fn paper(&self) -> PaperModel {
        self.paper.model(PaperModel::shipped)
    }

    /// That of the clusters of the detector pca.
    pub fn pca(&self) -> PcaVehicleModel {
        self.pca.model(PcaVehicleModel::shipped)
    }

    /// That of the groupings of the detector hierarchical.
    pub fn groupings(&self) -> Arc<GroupingModel> {
        self.groupings.model(GroupingModel::shipped)
    }

    /// What tells these models from others of the same program: a checksum for each, of the first, of paper's, of pca's and of
    /// groupings.
    pub fn identity(&self) -> [&str; 4] {
        [self.by_shape.identity(), self.paper.identity(), self.pca.identity(), self.groupings.identity()]
    }
}

impl<M: Clone> ModelSource<M> {
    fn model(&self, shipped: fn() -> M) -> M {
        match self {
            Self::Shipped => shipped(),
            Self::Trained { model, .. } => M::clone(model),
        }
    }

    fn identity(&self) -> &str {
        match self {
            Self::Shipped => "shipped",
            Self::Trained { checksum, .. } => checksum,
        }
    }

    fn trained(model: M, files: &[&str]) -> Self {
        Self::Trained { model: Arc::new(model), checksum: sha256(files.concat()) }
    }
}

/// The models of a complete TOML document; `None` if they are switched off. Those of directories with names are read at once,
/// because what is wrong with them is wrong with the configuration.
pub(super) fn vehicle_models_from(text: &str) -> Result<Option<VehicleModels>, ValueProblem> {
    let table: VehicleModelTable = toml::from_str(text)
        .map_err(|error| ValueProblem::new(&ParamsError::Syntax(error), Some("vehicle_model"), text))?;
    if !table.enabled {
        return Ok(None);
    }
    let by_shape = match table.directory.as_str() {
        "" => ModelSource::Shipped,
        directory => {
            ModelDirectory { parameter: "directory", directory }.with_prototypes(VehicleModel::from_toml)?
        }
    };
    let paper = match table.paper_directory.as_str() {
        "" => ModelSource::Shipped,
        directory => ModelDirectory { parameter: "paper_directory", directory }
            .with_prototypes(PaperModel::from_toml)?,
    };
    let pca = match table.pca_directory.as_str() {
        "" => ModelSource::Shipped,
        directory => pca_from(&ModelDirectory { parameter: "pca_directory", directory })?,
    };
    let groupings = match table.groupings_directory.as_str() {
        "" => ModelSource::Shipped,
        directory => groupings_from(&ModelDirectory { parameter: "groupings_directory", directory })?,
    };
    Ok(Some(VehicleModels { by_shape, paper, pca, groupings }))
}

const PROTOTYPES: &str = "prototypes.toml";
const MODEL: &str = "model.toml";
const OBJECTS: &str = "objects.toml";
const MORE_LOOKS: [&str; 2] = ["objects_second_look.toml", "objects_third_look.toml"];
const VEHICLES: &str = "vehicles.toml";

fn pca_from(files: &ModelDirectory<'_>) -> Result<ModelSource<PcaVehicleModel>, ValueProblem> {
    let svm = files.read(MODEL)?;
    let model = PcaVehicleModel::from_toml(&svm).map_err(|error| files.problem(MODEL, &error))?;
    Ok(ModelSource::trained(model, &[&svm]))
}

fn groupings_from(files: &ModelDirectory<'_>) -> Result<ModelSource<Arc<GroupingModel>>, ValueProblem> {
    let mut texts = Vec::new();
    for name in [PROTOTYPES, OBJECTS, MORE_LOOKS[0], MORE_LOOKS[1], VEHICLES] {
        texts.push(files.read(name)?);
    }
    let texts = std::array::from_fn(|it| texts[it].as_str());
    let model = GroupingModel::from_toml(texts).map_err(|error| match error {
        GroupingModelError::Prototypes(error) => files.problem(PROTOTYPES, &error),
        GroupingModelError::Objects(error) => files.problem(OBJECTS, &error),
        GroupingModelError::MoreLooks { look_idx, source } => files.problem(MORE_LOOKS[look_idx], &source),
        GroupingModelError::Vehicles(error) => files.problem(VEHICLES, &error),
    })?;
    Ok(ModelSource::trained(Arc::new(model), &texts))
}

/// A directory with what training wrote, and the parameter that names it.
struct ModelDirectory<'a> {
    parameter: &'static str,
    directory: &'a str,
}

impl ModelDirectory<'_> {
    /// The model that `from_toml` makes of prototypes and classifier.
    fn with_prototypes<M: Clone>(
        &self,
        from_toml: fn(&str, &str) -> Result<M, VehicleModelError>,
    ) -> Result<ModelSource<M>, ValueProblem> {
        let [prototypes, svm] = [self.read(PROTOTYPES)?, self.read(MODEL)?];
        let model = from_toml(&prototypes, &svm).map_err(|error| match error {
            VehicleModelError::Prototypes(error) => self.problem(PROTOTYPES, &error),
            VehicleModelError::Svm(error) => self.problem(MODEL, &error),
        })?;
        Ok(ModelSource::trained(model, &[&prototypes, &svm]))
    }

    fn read(&self, name: &str) -> Result<String, ValueProblem> {
        let path = Path::new(self.directory).join(name);
        std::fs::read_to_string(path).map_err(|error| self.problem(name, &error))
    }

    fn problem(&self, name: &str, error: &dyn std::fmt::Display) -> ValueProblem {
        ValueProblem {
            keys: vec!["vehicle_model".to_owned(), self.parameter.to_owned()],
            problem: format!(" = {:?}: {name}: {error}", self.directory),
        }
    }
}
