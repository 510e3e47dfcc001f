//! A TOML document that overrides parameters, and the positions of errors in it.

use std::path::Path;

use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::ClassTraits;
use scans::dataset::class_table::{ClassTable, class_of_word};
use toml::de::DeTable;
use toml::{Table, Value};

use super::detector_table::{DETECTOR_TABLE, foreign_detectors};
use super::error::{ConfigError, ConfigPosition};
use super::matching_table::WITHOUT_DEFAULT;
use super::parameter_tree::set;
use super::slice_table::SLICES;
use super::value_problem::ValueProblem;
use crate::run::foreign_detector::ForeignDetector;

/// The table of class names, which are no parameters.
pub(super) const CLASSES: &str = "classes";

/// The table of classes of the user, which are no parameters either.
pub(super) const OWN_CLASSES: &str = "class";

/// Contents of a document besides values of parameters.
pub(super) struct Applied {
    /// Whether the values include a density curve.
    pub(super) gives_density_curve: bool,
    /// Meanings of class names in labels.
    pub(super) classes: ClassTable,
    /// Detectors that are not built in.
    pub(super) foreign: Vec<ForeignDetector>,
    /// Their parameters, a table for each detector that has any.
    pub(super) foreign_parameters: Table,
}

/// The document that overrides values, for error messages.
pub(super) struct OverrideFile<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl OverrideFile<'_> {
    /// Puts the values of the document into `table`. Returns its other contents.
    pub(super) fn apply(&self, table: &mut Table) -> Result<Applied, ConfigError> {
        let mut values = self.parse()?;
        let own =
            values.remove(OWN_CLASSES).map_or(Ok(ClassTable::default()), |it| self.own_classes_in(it))?;
        let classes =
            values.remove(CLASSES).map_or(Ok(ClassTable::default()), |it| self.classes_in(it))?.or(&own);
        let written = values.remove(DETECTOR_TABLE);
        let (foreign, foreign_parameters) = written.map_or_else(
            || Ok(Default::default()),
            |it| foreign_detectors(self.path, &|keys| self.position_of(keys), it),
        )?;
        let curve = values.get("hierarchical").and_then(|it| it.get("density_weighting")?.get("curve"));
        let gives_density_curve = curve.is_some();
        // No parameters that the shipped tables have.
        let mut without_default = Table::new();
        if let Some(Value::Table(matching)) = values.get_mut("matching") {
            let removed = WITHOUT_DEFAULT.iter().filter_map(|it| matching.remove_entry(*it));
            without_default.extend(removed);
        }
        let slices = values.remove(SLICES);
        set(table, values, &mut Vec::new(), &|keys| self.position_of(keys))?;
        if let Some(Value::Table(matching)) = table.get_mut("matching") {
            matching.extend(without_default);
        }
        table.extend(slices.map(|it| (SLICES.to_owned(), it)));
        Ok(Applied { gives_density_curve, classes, foreign, foreign_parameters })
    }

    /// Defines the classes of the user, and returns their names.
    fn own_classes_in(&self, written: Value) -> Result<ClassTable, ConfigError> {
        let mut classes = ClassTable::default();
        let at = |keys: &[&str], problem: String| {
            let keys: Vec<String> = keys.iter().map(|it| (*it).to_owned()).collect();
            ConfigError::Value { position: self.position_of(&keys), key: keys.join("."), problem }
        };
        let Value::Table(written) = written else {
            return Err(at(&[OWN_CLASSES], " is no table: write [class.NAME]".to_owned()));
        };
        for (name, value) in written {
            let keys = [OWN_CLASSES, name.as_str()];
            let traits: ClassTraits = value
                .try_into()
                .map_err(|error: toml::de::Error| at(&keys, format!(": {}", error.message())))?;
            if !traits.hints.is_empty() {
                return Err(at(&keys, ": a class of yours has no hints".to_owned()));
            }
            let words = traits.names.clone();
            let class = AnnotationClass::define(&name, traits);
            let class = class.map_err(|problem| at(&keys, format!(": {problem}")))?;
            for word in words.iter().chain([&name]) {
                classes.insert(word, class);
            }
        }
        Ok(classes)
    }

    fn classes_in(&self, written: Value) -> Result<ClassTable, ConfigError> {
        let wrong_type = |keys: &[String], found: &Value, expected| {
            let (position, key) = (self.position_of(keys), keys.join("."));
            ConfigError::WrongType { position, key, found: found.type_str(), expected }
        };
        let Value::Table(written) = written else {
            return Err(wrong_type(&[CLASSES.to_owned()], &written, "table"));
        };
        let mut classes = ClassTable::default();
        for (name, word) in written {
            let keys = [CLASSES.to_owned(), name];
            let Value::String(word) = word else { return Err(wrong_type(&keys, &word, "string")) };
            let class = class_of_word(&word).map_err(|problem| ConfigError::Value {
                position: self.position_of(&keys),
                key: keys.join("."),
                problem: format!(": {problem}"),
            })?;
            classes.insert(&keys[1], class);
        }
        Ok(classes)
    }

    /// The error for a problem, with the position of the value in the document.
    pub(super) fn value_error(&self, problem: ValueProblem) -> ConfigError {
        let ValueProblem { keys, problem } = problem;
        ConfigError::Value { position: self.position_of(&keys), key: keys.join("."), problem }
    }

    fn parse(&self) -> Result<Table, ConfigError> {
        self.text.parse().map_err(|error: toml::de::Error| ConfigError::Syntax {
            position: self.position_at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })
    }

    /// Position of the last of `keys`, nested from the outermost table in, or of the last one that is there.
    fn position_of(&self, keys: &[String]) -> ConfigPosition {
        let document = DeTable::parse(self.text).expect("the document was parsed before");
        let mut table = document.get_ref();
        let mut offset = 0;
        for key in keys {
            let Some((key, value)) = table.get_key_value(key.as_str()) else { break };
            offset = key.span().start;
            let Some(inner) = value.get_ref().as_table() else { break };
            table = inner;
        }
        self.position_at(offset)
    }

    fn position_at(&self, byte_offset: usize) -> ConfigPosition {
        let before = self.text.as_bytes().iter().take(byte_offset);
        let line = 1 + before.filter(|&&byte| byte == b'\n').count();
        ConfigPosition::Line { path: self.path.to_owned(), line }
    }
}
