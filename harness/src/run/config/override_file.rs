//! A TOML document that overrides parameters, and where in it something is wrong.

use std::path::Path;

use detector::params::ParamsError;
use toml::de::DeTable;
use toml::{Table, Value};

use super::error::ConfigError;

/// The document that overrides values, for error messages.
pub(super) struct OverrideSource<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl OverrideSource<'_> {
    pub(super) fn parse(&self) -> Result<Table, ConfigError> {
        self.text.parse().map_err(|error: toml::de::Error| ConfigError::Syntax {
            path: self.path.to_owned(),
            line: self.line_at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })
    }

    /// Says where in this document the value stands that `error` complains about in the resolved `document`, whose
    /// parameters are those of the table `parent`, or of several tables.
    pub(super) fn value_error(
        &self,
        error: &ParamsError,
        parent: Option<&str>,
        document: &str,
    ) -> ConfigError {
        let (names, problem) = match error {
            ParamsError::OutOfRange { name, value, allowed } => {
                let names = name.split('.').map(str::to_owned).collect();
                (names, format!(" = {value} is outside of {allowed}"))
            }
            ParamsError::Syntax(error) => {
                let offset = error.span().map_or(0, |span| span.start);
                let parsed = DeTable::parse(document).expect("the document was written from values");
                let names = key_at(parsed.get_ref(), offset).unwrap_or_default();
                (names, format!(": {}", error.message()))
            }
        };
        let mut keys: Vec<String> = parent.map(str::to_owned).into_iter().collect();
        keys.extend(names);
        let (line, key) = (self.line_of(&keys), keys.join("."));
        ConfigError::Value { path: self.path.to_owned(), line, key, problem }
    }

    /// Puts the values of `overrides` into `table`, which is found under `parents`.
    pub(super) fn apply(
        &self,
        table: &mut Table,
        overrides: Table,
        parents: &mut Vec<String>,
    ) -> Result<(), ConfigError> {
        for (key, value) in overrides {
            parents.push(key);
            let key = parents.last().expect("it was just pushed");
            let path = || self.path.to_owned();
            let Some(present) = table.get_mut(key) else {
                let known = table.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                let (line, key) = (self.line_of(parents), parents.join("."));
                return Err(ConfigError::Unknown { path: path(), line, key, known });
            };
            match (present, value) {
                (Value::Table(table), Value::Table(overrides)) => self.apply(table, overrides, parents)?,
                (present @ Value::Float(_), Value::Integer(value)) => *present = Value::Float(value as f64),
                (present, value) if present.same_type(&value) => *present = value,
                (present, value) => {
                    let (found, expected) = (value.type_str(), present.type_str());
                    let (line, key) = (self.line_of(parents), parents.join("."));
                    return Err(ConfigError::WrongType { path: path(), line, key, found, expected });
                }
            }
            parents.pop();
        }
        Ok(())
    }

    /// Line, from 1, on which the key with these parents stands.
    fn line_of(&self, keys: &[String]) -> usize {
        let document = DeTable::parse(self.text).expect("the document was parsed before");
        let mut table = document.get_ref();
        let mut offset = 0;
        for key in keys {
            let Some((key, value)) = table.get_key_value(key.as_str()) else { break };
            offset = key.span().start;
            let Some(inner) = value.get_ref().as_table() else { break };
            table = inner;
        }
        self.line_at(offset)
    }

    fn line_at(&self, byte_offset: usize) -> usize {
        let before = self.text.as_bytes().iter().take(byte_offset);
        1 + before.filter(|&&byte| byte == b'\n').count()
    }
}

/// The names of the value at this place of the document of `table`, from the outermost in.
fn key_at(table: &DeTable<'_>, byte_offset: usize) -> Option<Vec<String>> {
    table.iter().find_map(|(key, value)| {
        let mut keys = vec![key.get_ref().to_string()];
        match value.get_ref().as_table() {
            Some(inner) => keys.extend(key_at(inner, byte_offset)?),
            None if value.span().contains(&byte_offset) => {}
            None => return None,
        }
        Some(keys)
    })
}
