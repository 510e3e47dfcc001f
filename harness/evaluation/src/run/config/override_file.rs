//! A TOML document that overrides parameters, and where in it something is wrong.

use std::path::Path;

use toml::Table;
use toml::de::DeTable;

use super::error::{ConfigError, ConfigPlace};
use super::parameter_tree::set;
use super::value_problem::ValueProblem;

/// The document that overrides values, for error messages.
pub(super) struct OverrideFile<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl OverrideFile<'_> {
    /// Puts the values of the document into `table`, and returns whether there is a density curve among them.
    pub(super) fn apply(&self, table: &mut Table) -> Result<bool, ConfigError> {
        let values = self.parse()?;
        let curve = values.get("hierarchical").and_then(|it| it.get("density_weighting")?.get("curve"));
        let gives_curve = curve.is_some();
        set(table, values, &mut Vec::new(), &|keys| self.place_of(keys))?;
        Ok(gives_curve)
    }

    /// Says where in the document the value stands that makes a problem.
    pub(super) fn value_error(&self, problem: ValueProblem) -> ConfigError {
        let ValueProblem { keys, problem } = problem;
        ConfigError::Value { place: self.place_of(&keys), key: keys.join("."), problem }
    }

    fn parse(&self) -> Result<Table, ConfigError> {
        self.text.parse().map_err(|error: toml::de::Error| ConfigError::Syntax {
            place: self.place_at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })
    }

    /// Where the key with these parents stands.
    fn place_of(&self, keys: &[String]) -> ConfigPlace {
        let document = DeTable::parse(self.text).expect("the document was parsed before");
        let mut table = document.get_ref();
        let mut offset = 0;
        for key in keys {
            let Some((key, value)) = table.get_key_value(key.as_str()) else { break };
            offset = key.span().start;
            let Some(inner) = value.get_ref().as_table() else { break };
            table = inner;
        }
        self.place_at(offset)
    }

    fn place_at(&self, byte_offset: usize) -> ConfigPlace {
        let before = self.text.as_bytes().iter().take(byte_offset);
        let line = 1 + before.filter(|&&byte| byte == b'\n').count();
        ConfigPlace::Line { path: self.path.to_owned(), line }
    }
}
