//! `NAME=VALUE` on the command line: one parameter overridden.

use std::fmt;
use std::str::FromStr;

use toml::{Table, Value};

use super::error::{ConfigError, ConfigPosition};
use super::parameter_tree::{parameters, set};
use super::value_problem::ValueProblem;

/// One parameter and its new value.
#[derive(Debug, Clone, PartialEq)]
pub struct OverrideOption {
    written: String,
    name: String,
    value: Value,
}

impl FromStr for OverrideOption {
    type Err = String;

    /// Reads `NAME=VALUE`, where VALUE is TOML, except that a word or a path needs no quotes.
    fn from_str(written: &str) -> Result<Self, String> {
        let (name, value) = written.split_once('=').ok_or("expected NAME=VALUE")?;
        let (name, value) = (name.trim(), value.trim());
        if name.is_empty() || value.is_empty() {
            return Err("expected NAME=VALUE".to_owned());
        }
        let value = match value.parse::<Value>() {
            Ok(value) => value,
            Err(_) if is_word(value) || is_path(value) => Value::String(value.to_owned()),
            Err(error) => {
                let problem = error.message();
                return Err(format!(
                    "{value} is not a valid value, which is a number, true, false, a word or a path: {problem}"
                ));
            }
        };
        Ok(Self { written: written.to_owned(), name: name.to_owned(), value })
    }
}

/// The option as it was written.
impl fmt::Display for OverrideOption {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.written)
    }
}

fn is_word(text: &str) -> bool {
    let is_of_word = |it: char| it.is_alphanumeric() || it == '-' || it == '_';
    text.starts_with(char::is_alphabetic) && text.chars().all(is_of_word)
}

/// Whether it is a path: it must have a separator, so that a misspelt number is not taken for one.
fn is_path(text: &str) -> bool {
    let is_of_path = |it: char| it.is_alphanumeric() || "-_./~ ".contains(it);
    let begins = text.starts_with(['/', '.', '~']) || text.starts_with(char::is_alphabetic);
    begins && text.contains('/') && text.chars().all(is_of_path)
}

/// Options with the full names of their parameters, at most one for each parameter.
pub(super) struct OverrideOptions<'a> {
    options: Vec<(Vec<String>, &'a OverrideOption)>,
}

impl<'a> OverrideOptions<'a> {
    /// Finds the parameters of `options` in `all`: by their full names, or by ends of names that are unique among the
    /// parameters of the tables `own`.
    pub(super) fn resolve(
        options: &'a [OverrideOption],
        all: &Table,
        own: &[&str],
    ) -> Result<Self, ConfigError> {
        let known = parameters(all);
        let mut resolved: Vec<(Vec<String>, &OverrideOption)> = Vec::new();
        for option in options {
            let keys = option.keys(&known, own)?;
            if resolved.iter().any(|(before, _)| *before == keys) {
                return Err(ConfigError::Twice { position: option.position(), key: keys.join(".") });
            }
            resolved.push((keys, option));
        }
        Ok(Self { options: resolved })
    }

    /// Puts the values into `table`.
    pub(super) fn apply(&self, table: &mut Table) -> Result<(), ConfigError> {
        for (keys, option) in &self.options {
            let in_its_table =
                |value: Value, key: &String| Value::Table(Table::from_iter([(key.clone(), value)]));
            let nested = keys.iter().rev().fold(option.value.clone(), in_its_table);
            let Value::Table(nested) = nested else { unreachable!("a parameter has a name") };
            set(table, nested, &mut Vec::new(), &|_| option.position())?;
        }
        Ok(())
    }

    /// The error for a problem, with the option that causes it; with all options if none of them names the parameter.
    pub(super) fn value_error(&self, problem: ValueProblem) -> ConfigError {
        let ValueProblem { keys, problem } = problem;
        let guilty = self.options.iter().find(|(of_option, _)| *of_option == keys);
        let position = match guilty {
            Some((_, option)) => option.position(),
            None => ConfigPosition::Options(self.options.iter().map(|(_, it)| it.written.clone()).collect()),
        };
        ConfigError::Value { position, key: keys.join("."), problem }
    }
}

impl OverrideOption {
    fn position(&self) -> ConfigPosition {
        ConfigPosition::Options(vec![self.written.clone()])
    }

    /// The full name of the parameter: the name itself, or the only full name in the tables `own` that ends with it.
    pub(super) fn keys(&self, known: &[Vec<String>], own: &[&str]) -> Result<Vec<String>, ConfigError> {
        let parts: Vec<&str> = self.name.split('.').collect();
        if let Some(keys) = known.iter().find(|keys| **keys == parts) {
            return Ok(keys.clone());
        }
        let ends_so =
            |keys: &&Vec<String>| keys.len() > parts.len() && keys[keys.len() - parts.len()..] == parts;
        let of_own = |keys: &&Vec<String>| is_of(own, &keys.join("."));
        let meant: Vec<&Vec<String>> = known.iter().filter(of_own).filter(ends_so).collect();
        match meant[..] {
            [keys] => Ok(keys.clone()),
            [] => Err(ConfigError::Unknown {
                position: self.position(),
                key: self.name.clone(),
                remedy: self.remedy(known, own),
            }),
            _ => Err(ConfigError::Ambiguous {
                position: self.position(),
                name: self.name.clone(),
                meanings: meant.into_iter().map(|keys| keys.join(".")).collect(),
            }),
        }
    }

    /// Advice for a name that no parameter has.
    fn remedy(&self, known: &[Vec<String>], own: &[&str]) -> String {
        let full: Vec<String> = known.iter().map(|keys| keys.join(".")).collect();
        let within = format!(".{}.", self.name);
        let inside: Vec<&str> =
            full.iter().filter(|it| format!(".{it}").contains(&within)).map(String::as_str).collect();
        if !inside.is_empty() {
            return format!("it is a table; its parameters are {}", inside.join(", "));
        }
        let of_others = format!(".{}", self.name);
        let elsewhere: Vec<&str> =
            full.iter().filter(|it| it.ends_with(&of_others)).map(String::as_str).collect();
        if !elsewhere.is_empty() {
            return format!("write {}", elsewhere.join(" or "));
        }
        let near = nearest(&self.name, &full);
        if near.is_empty() {
            let listed: Vec<&str> = full.iter().map(String::as_str).filter(|it| is_of(own, it)).collect();
            let is_foreign = own.iter().any(|it| it.starts_with("detector."));
            let hint = if is_foreign {
                "; a new one has to stand in `parameters` of its detector first"
            } else {
                ""
            };
            // A longer list would not be read.
            if listed.len() > 20 {
                return format!("`scanbench params` lists the {} of these detectors{hint}", listed.len());
            }
            return format!("parameters are {}{hint}", listed.join(", "));
        }
        format!("did you mean {}?", near.join(", "))
    }
}

/// Whether a parameter is in one of `tables`, or in tables within them.
fn is_of(tables: &[&str], full_name: &str) -> bool {
    tables.iter().any(|table| full_name.strip_prefix(table).is_some_and(|rest| rest.starts_with('.')))
}

/// Up to three of `full` whose ends are spelt most like `name`, the most similar first.
fn nearest<'a>(name: &str, full: &'a [String]) -> Vec<&'a str> {
    // Below this it is rather another word than a misspelt one.
    const LEAST_SIMILARITY: f64 = 0.7;
    let n_parts = name.split('.').count();
    let similarity = |candidate: &str| {
        let parts: Vec<&str> = candidate.split('.').collect();
        let end = parts[parts.len().saturating_sub(n_parts)..].join(".");
        strsim::normalized_damerau_levenshtein(name, &end)
    };
    let mut near: Vec<(f64, &str)> = full.iter().map(|it| (similarity(it), it.as_str())).collect();
    near.retain(|(similarity, _)| *similarity >= LEAST_SIMILARITY);
    near.sort_by(|left, right| right.0.total_cmp(&left.0).then(left.1.cmp(right.1)));
    near.into_iter().take(3).map(|(_, it)| it).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::config::RunConfig;

    fn overridden(options: &[&str], own: &[&str]) -> Result<RunConfig, ConfigError> {
        let options: Vec<OverrideOption> = options.iter().map(|it| it.parse().expect("sound")).collect();
        RunConfig::load(None)?.overridden(&options, own)
    }

    #[track_caller]
    fn check_refused(options: &[&str], own: &[&str], message: &str) {
        let error = overridden(options, own).expect_err(message);
        assert_eq!(error.to_string(), message);
    }

    const ALL: [&str; 3] = ["hierarchical", "kd_tree", "pca"];

    #[test]
    fn a_full_name_is_understood_whatever_runs() {
        let config = overridden(&["hierarchical.grid.cell_size_m=0.8"], &["pca"]).unwrap();
        assert_eq!(config.hierarchical.grid.cell_size_m, 0.8);
        assert_eq!(config.resolved["hierarchical"]["grid"]["cell_size_m"].as_float(), Some(0.8));
    }

    #[test]
    fn a_short_name_is_that_of_the_only_parameter_it_can_be() {
        let config = overridden(&["tolerance_m=1", "foreground=all"], &ALL).unwrap();
        assert_eq!(config.baselines.kd_tree.tolerance_m, 1.0);
        assert_eq!(config.baselines.kd_tree.foreground, baselines::params::ForegroundChoice::All);
        assert_eq!(overridden(&["min_points=7"], &["kd_tree"]).unwrap().baselines.kd_tree.min_points, 7);
        let config = overridden(&["cluster.min_points = 7"], &["hierarchical"]).unwrap();
        assert_eq!(config.hierarchical.cluster.min_points, 7);
    }

    #[test]
    fn a_short_name_of_several_parameters_is_refused_with_all_of_them() {
        check_refused(
            &["cluster.min_points=7"],
            &ALL,
            "-P cluster.min_points=7: cluster.min_points is ambiguous; write one of hierarchical.cluster.min_points, \
             pca.cluster.min_points",
        );
    }

    #[test]
    fn a_name_of_nothing_is_refused_with_what_may_be_meant() {
        check_refused(
            &["tolerence_m=1"],
            &["kd_tree"],
            "-P tolerence_m=1: unknown parameter tolerence_m; did you mean kd_tree.tolerance_m?",
        );
        check_refused(
            &["tolerance_m=1"],
            &["pca"],
            "-P tolerance_m=1: unknown parameter tolerance_m; write kd_tree.tolerance_m",
        );
        check_refused(
            &["colour=red"],
            &["kd_tree"],
            "-P colour=red: unknown parameter colour; parameters are kd_tree.foreground, kd_tree.max_points, \
             kd_tree.min_points, kd_tree.neighbors, kd_tree.tolerance_m",
        );
        check_refused(
            &["pca.grid=1"],
            &ALL,
            "-P pca.grid=1: unknown parameter pca.grid; it is a table; its parameters are pca.grid.cell_size_m, pca.grid.extent_m",
        );
    }

    #[test]
    fn what_cannot_be_worked_with_is_refused_with_its_option() {
        check_refused(
            &["hierarchical.grid.xi=3", "tolerance_m=far"],
            &ALL,
            "-P tolerance_m=far: kd_tree.tolerance_m is of type string, but must be float",
        );
        check_refused(
            &["hierarchical.grid.xi=3", "tolerance_m=0.001"],
            &ALL,
            "-P tolerance_m=0.001: kd_tree.tolerance_m = 0.001 is not within 0.01 to 100 m",
        );
        check_refused(
            &["foreground=blue"],
            &ALL,
            "-P foreground=blue: kd_tree.foreground: unknown variant `blue`, expected one of \
             `short`, `refined`, `standing`, `all`",
        );
        check_refused(
            &["tolerance_m=1", "kd_tree.min_points=30000"],
            &ALL,
            "-P tolerance_m=1 -P kd_tree.min_points=30000: kd_tree.max_points = 25000 is less than \
             kd_tree.min_points = 30000",
        );
    }

    #[test]
    fn a_parameter_has_one_value() {
        check_refused(
            &["tolerance_m=1", "kd_tree.tolerance_m=2"],
            &ALL,
            "-P kd_tree.tolerance_m=2: kd_tree.tolerance_m is set twice",
        );
    }

    #[test]
    fn a_value_is_toml_or_a_word() {
        let value = |written: &str| written.parse::<OverrideOption>().map(|it| it.value);
        assert_eq!(value("a=0.5"), Ok(Value::Float(0.5)));
        assert_eq!(value("a = true"), Ok(Value::Boolean(true)));
        assert_eq!(value("a=kd-tree"), Ok(Value::String("kd-tree".to_owned())));
        assert_eq!(value("a=\"x=y\""), Ok(Value::String("x=y".to_owned())));
        for path in ["/tmp/x", "./model", "~/a model/b-2.0", "runs/3"] {
            assert_eq!(value(&format!("a={path}")), Ok(Value::String(path.to_owned())));
        }
        for damaged in ["a=1/2", "a=/x\"y", "a", "=1", "a=", "a=1.2.3", "a=[1", "a=1\nb=2"] {
            assert!(value(damaged).is_err(), "{damaged:?}");
        }
    }
}
