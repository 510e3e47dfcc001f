//! Nested tables of parameters, and how their values are replaced.

use toml::{Table, Value};

use super::error::{ConfigError, ConfigPosition};

/// The parameters below `table`, each with its tables.
pub(super) fn parameters(table: &Table) -> Vec<Vec<String>> {
    let below = table.iter().flat_map(|(key, value)| match value {
        Value::Table(inner) => parameters(inner)
            .into_iter()
            .map(|mut keys| {
                keys.insert(0, key.clone());
                keys
            })
            .collect(),
        _ => vec![vec![key.clone()]],
    });
    below.collect()
}

/// Puts the values of `overrides` into `table`, which is found under `parents`; `position_of` gives the position of each
/// override.
pub(super) fn set(
    table: &mut Table,
    overrides: Table,
    parents: &mut Vec<String>,
    position_of: &impl Fn(&[String]) -> ConfigPosition,
) -> Result<(), ConfigError> {
    for (key, value) in overrides {
        parents.push(key);
        let key = parents.last().expect("it was just pushed");
        let Some(present) = table.get_mut(key) else {
            let known = table.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            // Only the top level has tables that are no parameters.
            let others = if parents.len() == 1 {
                "; other tables are classes, class.NAME, slice.NAME and detector.NAME"
            } else {
                ""
            };
            let remedy = format!("parameters are {known}{others}");
            return Err(ConfigError::Unknown {
                position: position_of(parents),
                key: parents.join("."),
                remedy,
            });
        };
        match (present, value) {
            (Value::Table(table), Value::Table(overrides)) => set(table, overrides, parents, position_of)?,
            (present @ Value::Float(_), Value::Integer(value)) => *present = Value::Float(value as f64),
            (present, value) if present.same_type(&value) => *present = value,
            (present, value) => {
                let (found, expected) = (value.type_str(), present.type_str());
                let (position, key) = (position_of(parents), parents.join("."));
                return Err(ConfigError::WrongType { position, key, found, expected });
            }
        }
        parents.pop();
    }
    Ok(())
}
