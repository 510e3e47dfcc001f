//! JSON schema of a configuration: completion and checks for editors.

use std::collections::BTreeMap;

use baselines::params::{BASELINE_BOUNDS, PARAMS_TOML};
use detector::params::HIERARCHICAL_TOML;
use detector::params::bounds::{Bounds, HIERARCHICAL_BOUNDS};
use detector::params::paper::PAPER_TOML;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::ClassGroup;
use reports::vocabulary::criterion::CriterionKind;
use serde_json::{Value as Json, json};
use toml::{Table, Value};

use super::detector_table::{
    DETECTOR_TABLE, LONGEST_LIMIT_S, MOST_THREADS, START_LIMIT, TAKEN_NAMES, TIME_LIMIT,
};
use super::matching_table::MATCHING_BOUNDS;
use super::override_file::{CLASSES, OWN_CLASSES};
use super::run_config::shipped;
use super::slice_table::SLICES;
use crate::matching::criterion_preset::CriterionPreset;
use crate::run::foreign_detector::VehicleRule;

/// The schema (JSON Schema 2020-12) of a file that overrides parameters. The type of a parameter is that of its shipped
/// value, as when such a file is read.
pub fn config_schema() -> Json {
    let mut schema = Parameters::shipped().schema_of_table("", &shipped());
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("scanbench.toml");
    let properties = &mut schema["properties"];
    let matching = &mut properties["matching"]["properties"];
    matching["criterion"]["enum"] = json!(CriterionKind::ALL);
    let gates = ["min_iou", "max_centre_distance_m"].map(|it| (it.to_owned(), matching[it].clone()));
    let mut of_class: serde_json::Map<String, Json> = gates.into_iter().collect();
    of_class.values_mut().for_each(|it| drop(it.as_object_mut().map(|it| it.remove("default"))));
    of_class.insert("criterion".to_owned(), json!({"enum": CriterionKind::ALL}));
    matching[OWN_CLASSES] = json!({
        "type": "object",
        "description": "Criteria of single classes",
        "additionalProperties": {"type": "object", "additionalProperties": false, "properties": of_class},
    });
    matching["preset"] = json!({"enum": CriterionPreset::ALL, "description": "A benchmark whose criteria of classes are used"});
    matching["only"] =
        json!({"type": "string", "description": "The slice outside of which nothing is judged"});
    properties[OWN_CLASSES] = json!({
        "type": "object",
        "description": "Classes of your own",
        "propertyNames": {"pattern": "^[a-z0-9-]{1,40}$"},
        "additionalProperties": schema_of_class(),
    });
    properties[SLICES] = json!({
        "type": "object",
        "description": "Slices of your own: regions, or bounds",
        "propertyNames": {"pattern": "^[a-z0-9-]{1,40}$"},
        "additionalProperties": schema_of_slice(),
    });
    let classes = AnnotationClass::ALL.map(AnnotationClass::name).join(", ");
    properties[CLASSES] = json!({
        "type": "object",
        "description": format!("What names of classes in labels stand for: {classes}"),
        "additionalProperties": {"type": "string"},
    });
    properties[DETECTOR_TABLE] = json!({
        "type": "object",
        "description": "Detectors that are not built in",
        "propertyNames": {"pattern": "^[A-Za-z0-9][A-Za-z0-9_-]{0,39}$", "not": {"enum": TAKEN_NAMES}},
        "additionalProperties": schema_of_detector(),
    });
    schema
}

fn schema_of_class() -> Json {
    let words =
        |description: &str| json!({"type": "array", "items": {"type": "string"}, "description": description});
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "group": {"enum": ClassGroup::ALL},
            "names": words("Other names for it, in labels and of detectors"),
            "whole_group": {"type": "boolean", "description": "Whether it stands for every class of its group", "default": false},
            "may_be_tall": {"type": "boolean", "description": "Whether the task objects ignores one that is tall"},
            "may_be_vehicle": {"type": "boolean", "description": "Whether the task vehicles ignores it", "default": false},
            "written": {
                "type": "object",
                "additionalProperties": false,
                "properties": {"kitti": {"type": "string"}, "nuscenes": {"type": "string"}, "argoverse2": {"type": "string"}},
                "description": "Its words in the files of others",
            },
        },
    })
}

fn schema_of_slice() -> Json {
    let pair = json!({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2});
    let bounds = ["range_m", "z_m", "length_m", "width_m", "height_m", "points"];
    let mut properties: serde_json::Map<String, Json> =
        bounds.into_iter().map(|it| (it.to_owned(), pair.clone())).collect();
    properties.insert("polygon_m".to_owned(), json!({"type": "array", "items": pair, "minItems": 3}));
    json!({"type": "object", "additionalProperties": false, "minProperties": 1, "properties": properties})
}

/// Schema of a foreign detector: a program, or results of one.
fn schema_of_detector() -> Json {
    let limit = |default: std::time::Duration, of: &str| {
        json!({
            "type": "number", "exclusiveMinimum": 0, "maximum": LONGEST_LIMIT_S, "default": default.as_secs(),
            "description": format!("Seconds {of}"),
        })
    };
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "command": {
                "type": "array", "items": {"type": "string"}, "minItems": 1,
                "description": "The program and its arguments; it runs in the folder of this file",
            },
            "results": {"type": "string", "minLength": 1, "description": "What another program wrote, from the folder of this file"},
            "parameters": {"type": "object", "description": "Passed to the program, and changed by -P"},
            "start_limit_s": limit(START_LIMIT, "until it can be asked"),
            "time_limit_s": limit(TIME_LIMIT, "for a scan"),
            "threads": {"type": "integer", "minimum": 1, "maximum": MOST_THREADS, "default": 1},
            "sandbox": {"type": "boolean", "default": false, "description": "No network, no sight of data sets and runs"},
            "vehicles": {"enum": VehicleRule::ALL, "default": VehicleRule::default(), "description": "What classifies vehicles"},
        },
        "oneOf": [
            {"required": ["command"], "properties": {"results": false}},
            {
                "required": ["results"],
                "properties": {
                    "command": false, "start_limit_s": false, "time_limit_s": false, "threads": false, "sandbox": false
                },
            },
        ],
    })
}

/// Meanings and bounds of parameters, by their full names.
struct Parameters {
    meanings: BTreeMap<String, String>,
    bounds: BTreeMap<String, Bounds>,
}

impl Parameters {
    fn shipped() -> Self {
        let mut all = Self { meanings: BTreeMap::new(), bounds: BTreeMap::new() };
        all.add("hierarchical.", HIERARCHICAL_TOML, HIERARCHICAL_BOUNDS);
        all.add("paper.", PAPER_TOML, HIERARCHICAL_BOUNDS);
        all.add("", PARAMS_TOML, BASELINE_BOUNDS);
        all.add("matching.", "", MATCHING_BOUNDS);
        all
    }

    /// Adds the meanings of the parameters of a file, which are comments after the values, and their bounds. Full names
    /// begin with `outer`.
    fn add(&mut self, outer: &str, text: &str, bounds: &[Bounds]) {
        let mut within = String::new();
        for line in text.lines() {
            if let Some((table, _)) = line.strip_prefix('[').and_then(|it| it.split_once(']')) {
                within = format!("{table}.");
            } else if let Some((key, (_, meaning))) =
                line.split_once(" = ").and_then(|(key, rest)| Some((key, rest.split_once("# ")?)))
            {
                self.meanings.insert(format!("{outer}{within}{key}"), meaning.to_owned());
            }
        }
        self.bounds.extend(bounds.iter().map(|it| (format!("{outer}{}", it.name), *it)));
    }

    /// `parents` are the names of the tables around it, each followed by a dot.
    fn schema_of_table(&self, parents: &str, table: &Table) -> Json {
        let properties: serde_json::Map<String, Json> = table
            .iter()
            .map(|(key, value)| (key.clone(), self.schema_of(&format!("{parents}{key}"), value)))
            .collect();
        json!({"type": "object", "additionalProperties": false, "properties": properties})
    }

    fn schema_of(&self, name: &str, value: &Value) -> Json {
        let mut schema = match value {
            Value::Table(table) => return self.schema_of_table(&format!("{name}."), table),
            Value::Array(values) => {
                let items = values.first().map_or(json!({}), |it| json!({"type": json_type(it)}));
                return json!({"type": "array", "items": items});
            }
            _ => json!({"type": json_type(value), "default": value}),
        };
        if let Some(bounds) = self.bounds.get(name) {
            for (word, bound) in [("minimum", bounds.low), ("maximum", bounds.high)] {
                if bound.is_finite() {
                    schema[word] = json!(bound);
                }
            }
        }
        if let Some(meaning) = self.meanings.get(name) {
            schema["description"] = json!(meaning);
        }
        schema
    }
}

/// The JSON type of values like `value`. An integer is also a valid float.
fn json_type(value: &Value) -> &'static str {
    match value {
        Value::String(_) | Value::Datetime(_) => "string",
        Value::Integer(_) => "integer",
        Value::Float(_) => "number",
        Value::Boolean(_) => "boolean",
        Value::Array(_) => "array",
        Value::Table(_) => "object",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::config::detector_table::KEYS;
    use crate::run::config::parameter_tree::parameters;

    #[test]
    fn every_parameter_is_there_with_its_value_and_bounds() {
        let (schema, shipped) = (config_schema(), shipped());
        for keys in parameters(&shipped) {
            let value = keys.iter().skip(1).fold(&shipped[&keys[0]], |value, key| &value[key]);
            let of_it = keys.iter().fold(&schema, |schema, key| &schema["properties"][key]);
            assert_eq!(of_it["type"], json_type(value), "{keys:?}");
            if keys.contains(&"curve".to_owned()) || value.is_array() {
                continue;
            }
            assert_eq!(of_it["default"], json!(value), "{keys:?}");
            let is_number = matches!(value, Value::Integer(_) | Value::Float(_));
            let is_bounded = ["minimum", "maximum"].iter().any(|it| of_it[it].is_number());
            assert!(is_bounded == is_number || keys == ["matching", "min_points"], "{keys:?}: {of_it}");
        }
        let cell_size = &schema["properties"]["paper"]["properties"]["grid"]["properties"]["cell_size_m"];
        assert_eq!((&cell_size["minimum"], &cell_size["maximum"]), (&json!(0.05), &json!(10.0)));
        assert!(cell_size["description"].as_str().unwrap().starts_with("side of a coarse cell"));
    }

    #[test]
    fn a_detector_has_the_keys_that_are_read() {
        let of_detector = &config_schema()["properties"]["detector"]["additionalProperties"]["properties"];
        let mut keys = KEYS.to_vec();
        keys.sort_unstable();
        assert_eq!(of_detector.as_object().unwrap().keys().collect::<Vec<_>>(), keys);
    }
}
