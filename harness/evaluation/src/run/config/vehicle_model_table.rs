//! What tells vehicles, as a table of the configuration.

use std::path::Path;

use baselines::pca_vehicle_model::PcaVehicleModel;
use detector::params::ParamsError;
use detector::pipeline::vehicle_model::{VehicleModel, VehicleModelError};
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

/// What tells vehicles.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModels {
    /// Of the clusters of grids and kd-tree.
    pub by_shape: VehicleModel,
    /// Of those of the detector pca.
    pub pca: PcaVehicleModel,
}

/// The models of a complete TOML document, read from their directories if these have names; `None` if they are switched off.
pub(super) fn vehicle_models_from(text: &str) -> Result<Option<VehicleModels>, ValueProblem> {
    let table: VehicleModelTable = toml::from_str(text)
        .map_err(|error| ValueProblem::new(&ParamsError::Syntax(error), Some("vehicle_model"), text))?;
    if !table.enabled {
        return Ok(None);
    }
    let by_shape = match table.directory.as_str() {
        "" => VehicleModel::shipped(),
        directory => by_shape_from(&ModelDirectory { parameter: "directory", directory })?,
    };
    let pca = match table.pca_directory.as_str() {
        "" => PcaVehicleModel::shipped(),
        directory => {
            let files = ModelDirectory { parameter: "pca_directory", directory };
            PcaVehicleModel::from_toml(&files.read(MODEL)?).map_err(|error| files.problem(MODEL, &error))?
        }
    };
    Ok(Some(VehicleModels { by_shape, pca }))
}

const PROTOTYPES: &str = "prototypes.toml";
const MODEL: &str = "model.toml";

fn by_shape_from(files: &ModelDirectory<'_>) -> Result<VehicleModel, ValueProblem> {
    let model = VehicleModel::from_toml(&files.read(PROTOTYPES)?, &files.read(MODEL)?);
    model.map_err(|error| match error {
        VehicleModelError::Prototypes(error) => files.problem(PROTOTYPES, &error),
        VehicleModelError::Svm(error) => files.problem(MODEL, &error),
    })
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
