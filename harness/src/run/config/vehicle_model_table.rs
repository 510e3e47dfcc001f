//! What tells vehicles, as a table of the configuration.

use std::path::Path;

use detector::params::ParamsError;
use detector::pipeline::vehicle_model::VehicleModel;
use serde::Deserialize;

use super::value_problem::ValueProblem;

/// The model that comes with the program, unless something else is said.
pub(super) const VEHICLE_MODEL_TOML: &str = r#"
enabled = true
directory = ""
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleModelTable {
    /// Otherwise vehicles are told by their size.
    enabled: bool,
    /// What `scanbench train` wrote; the model that comes with the program if empty.
    directory: String,
}

/// The model of a complete TOML document, read from its directory if that has a name; `None` if it is switched off.
pub(super) fn vehicle_model_from(text: &str) -> Result<Option<VehicleModel>, ValueProblem> {
    let table: VehicleModelTable = toml::from_str(text)
        .map_err(|error| ValueProblem::new(&ParamsError::Syntax(error), Some("vehicle_model"), text))?;
    if !table.enabled {
        return Ok(None);
    }
    if table.directory.is_empty() {
        return Ok(Some(VehicleModel::shipped()));
    }
    let problem = |problem: String| ValueProblem {
        keys: vec!["vehicle_model".to_owned(), "directory".to_owned()],
        problem: format!(" = {:?}: {problem}", table.directory),
    };
    let read = |name: &str| {
        let path = Path::new(&table.directory).join(name);
        std::fs::read_to_string(path).map_err(|error| problem(format!("{name}: {error}")))
    };
    let model = VehicleModel::from_toml(&read("prototypes.toml")?, &read("model.toml")?);
    model.map(Some).map_err(|error| problem(error.to_string()))
}
