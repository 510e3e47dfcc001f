//! Whether two runs may be compared at all.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use crate::rows::partial_row::PartialRow;
use crate::rows::scan_row::{ScanOutcome, ScanRow};
use crate::run_folder::detector_changes::{add_values, detector_changes};
use crate::run_folder::manifest::{DatasetEntry, DetectorEntry, Manifest};
use crate::run_folder::run_archive::RunArchive;
use crate::verdicts::partial_differences::{CurveName, check_same_parts, rows_of_curves};
use crate::vocabulary::own_slice::SliceBounds;
use crate::vocabulary::task::Task;
use crate::vocabulary::taxonomy::class_named;

/// Two runs cannot be compared.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("the runs cannot be compared: {}", .reasons.join("; "))]
pub struct NotComparable {
    /// Why, one reason or more.
    pub reasons: Vec<String>,
}

/// Checks that `run` answers the same question as `baseline`: the same scans, judged by the same rules, with all its
/// detectors and tasks.
///
/// Detectors that `run` has beyond those of `baseline` do not matter, nor does anything of a detector itself: its parameters,
/// its program and models, or the files with its results. They are what a comparison is for.
///
/// # Errors
///
/// [`NotComparable`] with everything that differs.
pub fn check_comparable(baseline: &RunArchive, run: &RunArchive) -> Result<(), NotComparable> {
    if baseline.manifest.partial.is_some() != run.manifest.partial.is_some() {
        let reason = "one is a result of `partial`, and the other is not";
        return Err(NotComparable { reasons: vec![reason.to_owned()] });
    }
    let mut reasons = differences_of_rules_and_data(&baseline.manifest, &run.manifest);
    if reasons.is_empty() {
        reasons.extend(scans(baseline, run));
    } else {
        reasons.extend(changed_scan(baseline, run));
    }
    if reasons.is_empty() {
        reasons.extend(missing_detectors(baseline, run));
        reasons.extend(partial_clouds(baseline, run));
    }
    if reasons.is_empty() { Ok(()) } else { Err(NotComparable { reasons }) }
}

/// Checks that `added` judged other detectors exactly as `run` judged its own, so that both make one run: the same scans and
/// rules, program, processor, repetitions and parameters.
///
/// # Errors
///
/// [`NotComparable`] with everything that differs.
pub fn check_joinable(run: &RunArchive, added: &RunArchive) -> Result<(), NotComparable> {
    let (before, now) = (&run.manifest, &added.manifest);
    let mut reasons = differences_of_rules_and_data(before, now);
    let mut compare = |what: &str, before: &dyn Display, now: &dyn Display| {
        let [before, now] = [before, now].map(ToString::to_string);
        if before != now {
            reasons.push(format!("{what} changed from {before} to {now}"));
        }
    };
    let program = |it: &Manifest| {
        let commit = it.git.as_ref().map_or("no known commit", |it| it.commit.as_str());
        // Of two programs whose commits nobody knows, one may be from before there were these.
        let has_versions = it.detectors.iter().all(|it| it.scoring_version.is_some());
        let versions = if has_versions { "" } else { " without scoring versions of detectors" };
        format!("{} of {commit} by rustc {}{versions}", it.scanbench_version, it.rustc_version)
    };
    compare("the program", &program(before), &program(now));
    compare("the processor", &before.machine.cpu_model, &now.machine.cpu_model);
    compare("--repeats", &before.n_repeats, &now.n_repeats);
    compare("--warmup", &before.n_warmup_detections, &now.n_warmup_detections);
    let protocols = |it: &Manifest| it.protocols.iter().map(|it| it.name()).collect::<Vec<_>>().join(",");
    compare("--protocol", &protocols(before), &protocols(now));
    let [old, new] = [before, now].map(|it| {
        let mut values = BTreeMap::new();
        add_values("", &it.config, &mut values);
        values
    });
    for (name, value) in &old {
        // Tables of detectors of the user are those of one side.
        if let Some(value_now) = new.get(name).filter(|_| !name.starts_with("detector.")) {
            compare(&format!("the parameter {name}"), value, value_now);
        }
    }
    if reasons.is_empty() {
        reasons.extend(scans(run, added));
    }
    if reasons.is_empty() { Ok(()) } else { Err(NotComparable { reasons }) }
}

/// Why numbers of two runs may not be compared, as far as their manifests say.
pub(crate) fn differences_of_rules_and_data(before: &Manifest, now: &Manifest) -> Vec<String> {
    let mut reasons = rules(before, now);
    reasons.extend(datasets(before, now));
    reasons
}

/// Differences in the rules of judging.
fn rules(baseline: &Manifest, run: &Manifest) -> Vec<String> {
    let mut reasons = scoring_versions(baseline, run);
    let mut compare = |what: &str, before: String, now: String| {
        if before != now {
            reasons.push(format!("{what} changed from {before} to {now}"));
        }
    };
    let criterion = |it: &Manifest| format!("{:?}", it.matching_criterion);
    compare("the matching criterion", criterion(baseline), criterion(run));
    let ignored = |it: &Manifest| {
        format!("fewer than {} points or beyond {} m", it.ignored.min_points, it.ignored.max_range_m)
    };
    compare("the ignored annotations", ignored(baseline), ignored(run));
    // A run that counts nothing says nothing else about its numbers.
    let counted_by = |it: &Manifest| match it.counted_by.as_deref() {
        Some("valgrind") => Some("valgrind".to_owned()),
        other => other.map(|it| format!("{it} on {}", run.machine.cpu_model)),
    };
    if let Some((before, now)) = counted_by(baseline).zip(counted_by(run)) {
        compare("what counts instructions", before, now);
    }
    for (name, before) in &baseline.slices {
        let bounds = |it: &SliceBounds| serde_json::to_string(it).unwrap_or_default();
        if let Some(now) = run.slices.get(name) {
            compare(&format!("the slice {name}"), bounds(before), bounds(now));
        }
    }
    reasons
}

/// Differences in the versions of the rules, by which detectors of both runs were judged.
fn scoring_versions(baseline: &Manifest, run: &Manifest) -> Vec<String> {
    let mut changed: BTreeMap<[u32; 2], Vec<&str>> = BTreeMap::new();
    for before in &baseline.detectors {
        if let Some(now) = run.detectors.iter().find(|it| it.name == before.name) {
            let versions = [scoring_version(baseline, before), scoring_version(run, now)];
            changed.entry(versions).or_default().push(&before.name);
        }
    }
    changed.retain(|[before, now], _| before != now);
    let in_words = |([before, now], names): (&[u32; 2], &Vec<&str>)| {
        format!("the scoring version of {} changed from {before} to {now}", names.join(", "))
    };
    changed.iter().map(in_words).collect()
}

/// The version of the rules by which `detector` of the run of `manifest` was judged.
fn scoring_version(manifest: &Manifest, detector: &DetectorEntry) -> u32 {
    /// That of detectors that are not built in, which whole runs with such detectors had before each detector had its own.
    const OF_OTHERS: u32 = 4;
    let is_by_boxes = || {
        let of_boxes = ["boxes on the ground plan, ", "boxes in space, ", "centre, closer than "];
        of_boxes.iter().any(|it| manifest.matching_criterion.contains(it))
    };
    let of_run = match (manifest.scoring_version, &detector.foreign) {
        // Built-in detectors were judged as in a run without others.
        (OF_OTHERS, None) if is_by_boxes() => 3,
        (OF_OTHERS, None) => 2,
        (of_run, _) => of_run,
    };
    detector.scoring_version.unwrap_or(of_run)
}

fn datasets(baseline: &Manifest, run: &Manifest) -> Vec<String> {
    let objects = |it: &Manifest| {
        let sets = it.partial.iter().flat_map(|it| &it.sets);
        sets.map(|it| (it.judged.id.clone(), it.judged.simulation.clone())).collect::<Vec<_>>()
    };
    if objects(baseline) != objects(run) {
        return vec!["the objects that are judged are not the same".to_owned()];
    }
    let ids = |it: &Manifest| it.datasets.iter().map(|it| it.id.clone()).collect::<Vec<_>>();
    let (before, now) = (ids(baseline), ids(run));
    if before != now {
        return vec![format!("the data sets changed from {} to {}", before.join(", "), now.join(", "))];
    }
    let pairs = baseline.datasets.iter().zip(&run.datasets);
    pairs.filter_map(|(before, now)| difference(before, now)).collect()
}

fn difference(before: &DatasetEntry, now: &DatasetEntry) -> Option<String> {
    let id = &before.id;
    if before.checksum != now.checksum {
        return Some(format!("the data of {id} changed: their checksums differ"));
    }
    if before.annotated != now.annotated {
        return Some(format!("the annotated classes of {id} changed"));
    }
    // A word that one side does not know is in no label: it would have been refused.
    let meant = |it: &DatasetEntry, word: &str| it.classes.get(word).copied().or_else(|| class_named(word));
    for word in before.classes.keys().chain(now.classes.keys()) {
        if let (Some(old), Some(new)) = (meant(before, word), meant(now, word))
            && old != new
        {
            return Some(format!("the word {word:?} in the labels of {id} meant {old}, and now means {new}"));
        }
    }
    if before.labels_ahead_deg != now.labels_ahead_deg {
        return Some(format!(
            "how far to either side of forward the labels of {id} reach changed (--labels-ahead)"
        ));
    }
    if before.blocks != now.blocks {
        return Some(format!("the blocks of scans of {id} that intervals are drawn from changed"));
    }
    if (before.sensor_height_m, &before.sensor) != (now.sensor_height_m, &now.sensor) {
        return Some(format!("the sensor of {id} or its height changed"));
    }
    None
}

/// Differences in the scans.
fn scans(baseline: &RunArchive, run: &RunArchive) -> Vec<String> {
    let of_scans = |it: &RunArchive| {
        let rows = it.scans.iter();
        rows.map(|row| (row.dataset.clone(), row.sequence.clone(), row.scan)).collect::<BTreeSet<_>>()
    };
    let (before, now) = (of_scans(baseline), of_scans(run));
    if before != now {
        let n_common = before.intersection(&now).count();
        return vec![format!(
            "the scans differ: {} before, {} now, {n_common} in common",
            before.len(),
            now.len()
        )];
    }
    let times = |it: &RunArchive| {
        let rows = it.scans.iter().map(|row| (&row.dataset, &row.sequence, row.scan, row.time_s));
        // Rows of other detectors and tasks say the same.
        rows.map(|(dataset, sequence, scan, time_s)| {
            ((dataset.clone(), sequence.clone(), scan), time_s.map(|it| (it * 1000.0).round() as i64))
        })
        .collect::<BTreeMap<_, _>>()
    };
    let (before, now) = (times(baseline), times(run));
    if let Some((name, _)) = before.iter().find(|(name, time_ms)| now.get(*name) != Some(*time_ms)) {
        let (dataset, sequence, scan) = name;
        return vec![format!("the time of scan {sequence}/{scan:06} of {dataset} changed")];
    }
    changed_scan(baseline, run).into_iter().collect()
}

/// Curves of `baseline` of which `run` lacks some parts of objects.
fn partial_clouds(baseline: &RunArchive, run: &RunArchive) -> Vec<String> {
    let (before, now) = (rows_of_curves(&baseline.objects), rows_of_curves(&run.objects));
    if baseline.manifest.partial.is_some() && before.is_empty() {
        return vec!["the earlier one has no rows".to_owned()];
    }
    let difference = |(name, rows): (&CurveName, &Vec<&PartialRow>)| {
        let named = format!("{}, {}", name.detector(), name.on());
        match now.get(name) {
            None => Some(format!("only the earlier one has {named}")),
            Some(theirs) => check_same_parts(rows, theirs).err().map(|it| format!("{named}: {it}")),
        }
    };
    before.iter().filter_map(difference).collect()
}

/// The first scan whose points or labels changed, and the number of such scans.
fn changed_scan(baseline: &RunArchive, run: &RunArchive) -> Option<String> {
    let checksums = |it: &RunArchive| {
        let of_row = |row: &ScanRow| {
            let name = (row.dataset.clone(), row.sequence.clone(), row.scan);
            Some((name, row.numbers()?.checksum))
        };
        // Rows of other detectors and tasks say the same.
        it.scans.iter().filter_map(of_row).collect::<BTreeMap<_, _>>()
    };
    let (before, now) = (checksums(baseline), checksums(run));
    let changed = before.iter().filter(|(name, before)| now.get(*name).is_some_and(|now| now != *before));
    let changed: Vec<_> = changed.map(|it| it.0).collect();
    let (dataset, sequence, scan) = changed.first()?;
    Some(format!(
        "points or labels changed in {} of {} scans, the first of them {sequence}/{scan:06} of {dataset}: their checksums differ",
        changed.len(),
        before.len()
    ))
}

/// Detectors of `baseline` that `run` has not evaluated on all of the same scans.
fn missing_detectors(baseline: &RunArchive, run: &RunArchive) -> Vec<String> {
    let evaluated = |it: &'_ RunArchive| {
        let mut scans: BTreeMap<(String, Task, String), BTreeSet<(String, u32)>> = BTreeMap::new();
        // Who does not give a class has found nothing of it: see `classes_of_both`.
        let of_all = it.scans.iter().filter(|row| row.task.class().is_none());
        for row in of_all.filter(|row| matches!(row.outcome, ScanOutcome::Evaluated(_))) {
            let subject = (row.detector.clone(), row.task, row.dataset.clone());
            scans.entry(subject).or_default().insert((row.sequence.clone(), row.scan));
        }
        scans
    };
    let (before, now) = (evaluated(baseline), evaluated(run));
    let gone = detectors_only_in(baseline, run);
    let whole =
        gone.iter().map(|it| format!("the detector {it} is only in the earlier run, not in the later one"));
    let missing = before.iter().filter_map(|(subject, scans)| {
        let (detector, task, dataset) = subject;
        if gone.contains(detector) {
            return None;
        }
        match now.get(subject) {
            None => Some(format!("{detector} has no results on {dataset} in the task {task}")),
            Some(theirs) if theirs != scans => Some(format!(
                "{detector} was evaluated on {} scans of {dataset} in the task {task}, and now on {}",
                scans.len(),
                theirs.len()
            )),
            Some(_) => None,
        }
    });
    whole.chain(missing).collect()
}

/// Changes in the configuration of detectors of both runs, a text each.
pub fn configuration_changes(baseline: &RunArchive, run: &RunArchive) -> Vec<String> {
    let of_run = |name: &str| run.manifest.detectors.iter().find(|it| it.name == name);
    let pairs = baseline.manifest.detectors.iter().filter_map(|it| Some((it, of_run(&it.name)?)));
    pairs.flat_map(|(before, now)| detector_changes(before, now)).collect()
}

/// Detectors with results in `run`, but not in `other`, by name.
pub fn detectors_only_in(run: &RunArchive, other: &RunArchive) -> Vec<String> {
    let names = |it: &RunArchive| {
        let is_evaluated = |row: &&ScanRow| matches!(row.outcome, ScanOutcome::Evaluated(_));
        let of_scans = it.scans.iter().filter(is_evaluated).map(|row| row.detector.clone());
        of_scans.chain(it.objects.iter().map(|row| CurveName::of(row).detector())).collect::<BTreeSet<_>>()
    };
    names(run).difference(&names(other)).cloned().collect()
}
