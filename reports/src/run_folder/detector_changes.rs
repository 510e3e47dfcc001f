//! Changes in how a detector was run.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::run_folder::manifest::{DetectorEntry, ForeignEntry};

/// Digits of a checksum that are shown.
const N_DIGITS: usize = 12;

/// Changes from `before` to `now`, two entries of one detector, each with both values: `mine: vehicles: size → model`.
///
/// A value that an earlier version of the program did not write is unknown, and no change.
pub fn detector_changes(before: &DetectorEntry, now: &DetectorEntry) -> Vec<String> {
    let mut changes = Vec::new();
    let [old, new] = [before, now].map(settings);
    let known = old.keys().filter(|it| new.contains_key(*it));
    changes.extend(differing(known, &old, &new));
    let [old, new] = [before, now].map(|it| {
        let mut values = BTreeMap::new();
        add_values("", &it.parameters, &mut values);
        values
    });
    changes.extend(differing(old.keys().chain(new.keys()), &old, &new));
    let [old, new] = [before, now].map(files);
    if !old.is_empty() && !new.is_empty() {
        changes.extend(differing(old.keys().chain(new.keys()), &old, &new));
    }
    changes.extend(result_change(before, now));
    changes.iter().map(|it| format!("{}: {it}", now.name)).collect()
}

/// Both values of those `names` whose values differ, by name.
fn differing<'a>(
    names: impl Iterator<Item = &'a String>,
    before: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
) -> Vec<String> {
    let names: BTreeSet<&String> = names.filter(|it| before.get(*it) != now.get(*it)).collect();
    let value = |of: &BTreeMap<String, String>, name: &str| of.get(name).map_or("none", |it| it).to_owned();
    names.into_iter().map(|it| format!("{it}: {} → {}", value(before, it), value(now, it))).collect()
}

/// The settings of a detector other than its parameters and files.
fn settings(entry: &DetectorEntry) -> BTreeMap<String, String> {
    let DetectorEntry { vehicles, foreign, .. } = entry;
    let mut settings = vec![("vehicles classified by", vehicles.clone())];
    if let Some(it) = foreign {
        let ForeignEntry {
            command,
            results,
            version,
            start_limit_s,
            time_limit_s,
            threads,
            sandbox,
            vehicles,
            ..
        } = it;
        settings = vec![
            ("command", (!command.is_empty()).then(|| command.join(" "))),
            ("results", results.clone()),
            ("version", version.clone()),
            ("start_limit_s", start_limit_s.map(|it| it.to_string())),
            ("time_limit_s", time_limit_s.map(|it| it.to_string())),
            ("threads", threads.map(|it| it.to_string())),
            ("sandbox", sandbox.then(|| "true".to_owned())),
            ("vehicles", Some(vehicles.clone())),
        ];
    }
    settings.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// Adds the values of `parameters`, by their names joined with dots.
pub(crate) fn add_values(name: &str, parameters: &Value, to: &mut BTreeMap<String, String>) {
    match parameters {
        Value::Object(table) => {
            for (key, value) in table {
                let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
                add_values(&name, value, to);
            }
        }
        Value::Null => {}
        value => {
            to.insert(name.to_owned(), value.to_string());
        }
    }
}

/// Checksums of the files of its program, and of its models from elsewhere, by name.
fn files(entry: &DetectorEntry) -> BTreeMap<String, String> {
    let files = entry.foreign.iter().flat_map(|it| &it.files).chain(&entry.models);
    files.map(|(name, checksum)| (name.clone(), format!("SHA-256 {}…", first_digits(checksum)))).collect()
}

/// The number of its result files that changed, in words, if it ran somewhere else.
fn result_change(before: &DetectorEntry, now: &DetectorEntry) -> Option<String> {
    let (before, now) = before.foreign.as_ref().zip(now.foreign.as_ref())?;
    let (old, new) = before.results_checksum.as_ref().zip(now.results_checksum.as_ref())?;
    if old == new {
        return None;
    }
    let [old, new] = [before, now].map(|it| &it.result_files);
    if old.is_empty() || new.is_empty() {
        return Some("results: files changed".to_owned());
    }
    let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let n_changed = names.iter().filter(|it| old.get(**it) != new.get(**it)).count();
    Some(format!("results: {n_changed} of {} files changed", names.len()))
}

/// The part of a checksum that is enough to distinguish it.
pub fn first_digits(checksum: &str) -> String {
    checksum.chars().take(N_DIGITS).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn mine(parameters: Value, foreign: ForeignEntry) -> DetectorEntry {
        DetectorEntry {
            name: "mine".to_owned(),
            parameters,
            foreign: Some(foreign),
            ..DetectorEntry::default()
        }
    }

    fn program() -> ForeignEntry {
        ForeignEntry {
            command: vec!["python3".to_owned(), "mine.py".to_owned()],
            files: BTreeMap::from([("mine.py".to_owned(), "0123456789abcdef".to_owned())]),
            time_limit_s: Some(10.0),
            threads: Some(1),
            vehicles: "size".to_owned(),
            ..ForeignEntry::default()
        }
    }

    #[track_caller]
    fn check(parameters: Value, foreign: ForeignEntry, expected: &[&str]) {
        let before = mine(json!({"eps": 0.5, "ground": {"cell_m": 5}}), program());
        let now = mine(parameters, foreign);
        assert_eq!(detector_changes(&before, &now), expected);
    }

    #[test]
    fn every_change_has_both_values() {
        let parameters = || json!({"eps": 0.5, "ground": {"cell_m": 5}});
        check(parameters(), program(), &[]);
        check(
            parameters(),
            ForeignEntry { vehicles: "model".to_owned(), ..program() },
            &["mine: vehicles: size → model"],
        );
        check(
            json!({"eps": 0.7, "ground": {"cell_m": 4, "top_m": 3}}),
            ForeignEntry { time_limit_s: Some(2.5), ..program() },
            &[
                "mine: time_limit_s: 10 → 2.5",
                "mine: eps: 0.5 → 0.7",
                "mine: ground.cell_m: 5 → 4",
                "mine: ground.top_m: none → 3",
            ],
        );
        let files = [("mine.py", "fedcba9876543210"), ("more.py", "00112233445566778899")];
        let files = files.map(|(name, checksum)| (name.to_owned(), checksum.to_owned()));
        check(
            parameters(),
            ForeignEntry { files: files.into(), ..program() },
            &[
                "mine: mine.py: SHA-256 0123456789ab… → SHA-256 fedcba987654…",
                "mine: more.py: none → SHA-256 001122334455…",
            ],
        );
    }

    #[test]
    fn files_with_results_are_counted() {
        let with = |files: &[(&str, &str)]| {
            let files = files.iter().map(|(name, sum)| ((*name).to_owned(), (*sum).to_owned()));
            let result_files: BTreeMap<String, String> = files.collect();
            let (results, results_checksum) = (Some("net".to_owned()), Some(format!("{result_files:?}")));
            let foreign = ForeignEntry { results, results_checksum, result_files, ..ForeignEntry::default() };
            mine(Value::Null, foreign)
        };
        let before = with(&[("a", "1"), ("b", "2"), ("c", "3")]);
        let now = with(&[("a", "1"), ("b", "5"), ("d", "3")]);
        assert_eq!(detector_changes(&before, &now), ["mine: results: 3 of 4 files changed"]);
        assert!(detector_changes(&before, &before).is_empty());
        let mut earlier = with(&[]);
        earlier.foreign.as_mut().unwrap().results_checksum = Some("0".to_owned());
        assert_eq!(detector_changes(&earlier, &now), ["mine: results: files changed"]);
    }

    #[test]
    fn a_model_trained_anew_in_the_same_folder_is_a_change() {
        let trained = |checksum: &str| {
            let models = BTreeMap::from([("groupings.model".to_owned(), checksum.to_owned())]);
            DetectorEntry { models, foreign: None, ..mine(Value::Null, program()) }
        };
        let expected = ["mine: groupings.model: SHA-256 0123456789ab… → SHA-256 fedcba987654…"];
        assert_eq!(detector_changes(&trained("0123456789abcdef"), &trained("fedcba9876543210")), expected);
    }

    #[test]
    fn what_an_earlier_version_did_not_write_is_no_change() {
        let parameters = || json!({"eps": 0.5, "ground": {"cell_m": 5}});
        let earlier = ForeignEntry { files: BTreeMap::new(), time_limit_s: None, ..program() };
        check(parameters(), earlier, &[]);
        let before = DetectorEntry { vehicles: None, foreign: None, ..mine(parameters(), program()) };
        let said = |vehicles: &str| DetectorEntry { vehicles: Some(vehicles.to_owned()), ..before.clone() };
        assert!(detector_changes(&before, &said("size")).is_empty());
        let expected = ["mine: vehicles classified by: size → its own SVM"];
        assert_eq!(detector_changes(&said("size"), &said("its own SVM")), expected);
    }
}
