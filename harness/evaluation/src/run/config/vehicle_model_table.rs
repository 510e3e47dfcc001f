//! What tells vehicles, as a table of the configuration.

use std::path::Path;
use std::sync::Arc;

use baselines::pca_vehicle_model::PcaVehicleModel;
use detector::classify::vehicle_model::{VehicleModel, VehicleModelError};
use detector::params::ParamsError;
use scans::dataset::checksum::sha256;
use serde::Deserialize;

use super::value_problem::ValueProblem;

/// The models that come with the program, unless something else is said.
pub(super) const VEHICLE_MODEL_TOML: &str = r#"
enabled = true
directory = ""
pca_directory = ""
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleModelTable {
    /// Otherwise all detectors tell vehicles by their size.
    enabled: bool,
    /// What `scanbench train` wrote; the model that comes with the program if empty.
    directory: String,
    /// The same for the detector pca.
    pca_directory: String,
}

/// What tells vehicles. The models that come with the program are read when a detector first asks for one.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModels {
    by_shape: ModelSource<VehicleModel>,
    pca: ModelSource<PcaVehicleModel>,
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

    /// That of the clusters of the detector pca.
    pub fn pca(&self) -> PcaVehicleModel {
        self.pca.model(PcaVehicleModel::shipped)
    }

    /// What tells these models from others of the same program: a checksum for each, of the first and of pca's.
    pub fn identity(&self) -> [&str; 2] {
        [self.by_shape.identity(), self.pca.identity()]
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
        directory => by_shape_from(&ModelDirectory { parameter: "directory", directory })?,
    };
    let pca = match table.pca_directory.as_str() {
        "" => ModelSource::Shipped,
        directory => pca_from(&ModelDirectory { parameter: "pca_directory", directory })?,
    };
    Ok(Some(VehicleModels { by_shape, pca }))
}

const PROTOTYPES: &str = "prototypes.toml";
const MODEL: &str = "model.toml";

fn by_shape_from(files: &ModelDirectory<'_>) -> Result<ModelSource<VehicleModel>, ValueProblem> {
    let [prototypes, svm] = [files.read(PROTOTYPES)?, files.read(MODEL)?];
    let model = VehicleModel::from_toml(&prototypes, &svm).map_err(|error| match error {
        VehicleModelError::Prototypes(error) => files.problem(PROTOTYPES, &error),
        VehicleModelError::Svm(error) => files.problem(MODEL, &error),
    })?;
    Ok(ModelSource::trained(model, &[&prototypes, &svm]))
}

fn pca_from(files: &ModelDirectory<'_>) -> Result<ModelSource<PcaVehicleModel>, ValueProblem> {
    let svm = files.read(MODEL)?;
    let model = PcaVehicleModel::from_toml(&svm).map_err(|error| files.problem(MODEL, &error))?;
    Ok(ModelSource::trained(model, &[&svm]))
}

/// A directory with what training wrote, and the parameter that names it.
struct ModelDirectory<'a> {
    parameter: &'static str,
    directory: &'a str,
}

impl ModelDirectory<'_> {
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
