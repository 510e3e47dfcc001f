//! The notes beneath a table.

use std::collections::BTreeSet;

use crate::numbers::blocks::{BlockKind, FEWEST_BLOCKS, FEWEST_DRIVES};
use crate::tables::grid::{Cell, Grid, Line, LineKind, Mark, Undefined};
use crate::tables::task_table::{MeasuredRow, TableRow, TaskTable};
use crate::uncertainty::bootstrap::N_RESAMPLES;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::task::Task;

/// The label of intervals.
pub(crate) const INTERVAL_TITLE: &str = "95 % interval";

/// The sentences beneath a table, and the signs in it that refer to them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Notes {
    marks: BTreeSet<Mark>,
    /// The sentences, in order; those that a sign refers to begin with it.
    pub(crate) sentences: Vec<String>,
}

/// The title of the table of a task.
pub(crate) fn title(table: &TaskTable) -> String {
    format!("Task {}. Rates in %. {}", table.task, about_matching(&table.matching_criterion))
}

/// How detections were matched with annotations, from the criterion in the manifest.
pub(crate) fn about_matching(criterion: &str) -> String {
    match criterion.strip_prefix("points, IoU at least ") {
        Some(least) => format!("Matched by a point-set IoU of at least {least}."),
        None => format!("Matched by {criterion}."),
    }
}

/// The notes beneath `grids`, which are printed together.
pub(crate) fn notes(table: &TaskTable, grids: &[&Grid]) -> Notes {
    let lines = || grids.iter().flat_map(|it| &it.lines);
    let marks: BTreeSet<Mark> = grids.iter().flat_map(|it| marks(it)).collect();
    let has_line = |kind| lines().any(|it: &Line| it.kind == kind);
    let has_column = |title| grids.iter().flat_map(|it| &it.columns).any(|it| it.title == title);

    let mut notes = Notes { marks, sentences: vec![abbreviations(&table.cpu_model)] };
    if has_column("IA") {
        notes.sentences.push(
            "P: precision, TP / ND. R: recall, TP / NO. IA, ID: ignored annotations and detections, \
             neither right nor wrong."
                .to_owned(),
        );
    }
    if lines().flat_map(|it| &it.cells).any(|it| it.is_interval) {
        notes
            .sentences
            .extend(table.block_kind().map(|it| format!("{INTERVAL_TITLE}: {}", about_interval(it))));
    }
    if has_line(LineKind::Overall) {
        let is_apart = |it: &TableRow| {
            matches!(it, TableRow::Measured(MeasuredRow { extent: Extent::OverallOf(_), .. }))
        };
        let apart = if table.rows.iter().any(is_apart) { ", recorded and simulated ones apart" } else { "" };
        notes
            .sentences
            .push(format!("overall: ratios of counts and times summed over the data sets{apart}."));
    }
    if has_line(LineKind::Paper) {
        notes.sentences.extend(table.paper.map(|paper| {
            let methods =
                paper.methods.iter().filter(|it| table.detectors.iter().any(|our| our == it.detector));
            let rows: Vec<_> = methods.map(|it| format!("{} under {}", it.name, it.detector)).collect();
            format!(
                "Numbers of data sets are measured here, and may be compared within a row. Published rows are printed in {}; {}. \
                 They are of other scans, annotations and machines: for orientation, and not to be compared with the numbers measured here.",
                paper.source,
                rows.join(", ")
            )
        }));
    }
    if table.lacks_paper {
        let asked = "Published numbers of the papers are shown with their own method: -d paper,hierarchical,kd-tree,pca.";
        notes.sentences.push(asked.to_owned());
    }
    notes.sentences.extend(about_detectors(table));
    notes.explain_marks();
    notes
}

/// Facts that decide the lead beside the method: training, rules, origin of results, scans without an answer.
pub(crate) fn about_detectors(table: &TaskTable) -> Vec<String> {
    let read = table.foreign.iter().filter_map(|(detector, results)| {
        Some(format!("{detector} did not run here: its results were read from {}.", results.as_ref()?))
    });
    let failures = table.failures.iter().map(|(detector, [n_failed, n_scans])| {
        format!("{detector} gave no answer to {n_failed} of {n_scans} scans, which count as nothing found.")
    });
    vehicles(table).into_iter().chain(rules(table)).chain(read).chain(failures).collect()
}

/// Vehicle classifiers of the detectors; `None` where they are not known, or in another task.
fn vehicles(table: &TaskTable) -> Option<String> {
    let of_words = table.vehicles.iter().map(|(words, names)| format!("{}: {words}", names.join(", ")));
    let of_words: Vec<String> = of_words.collect();
    (table.task == Task::Vehicles && !of_words.is_empty())
        .then(|| format!("Vehicles classified by: {}.", of_words.join(" · ")))
}

/// Rules of the detectors beside the clusters; `None` if none has any. Those of foreign programs are not known.
fn rules(table: &TaskTable) -> Option<String> {
    let mut of_names: Vec<(&[String], Vec<&str>)> = Vec::new();
    for (rule, names) in &table.rules {
        match of_names.iter_mut().find(|(known, _)| known == names) {
            Some((_, rules)) => rules.push(rule),
            None => of_names.push((names, vec![rule])),
        }
    }
    let is_ours = |it: &&String| table.foreign.iter().all(|(name, _)| name != *it);
    let has_any = |detector: &&String| table.rules.iter().any(|(_, names)| names.contains(detector));
    let (ours, theirs): (Vec<&String>, Vec<&String>) = table.detectors.iter().partition(is_ours);
    let without: Vec<&String> = ours.into_iter().filter(|it| !has_any(it)).collect();
    let listed = |names: Vec<&String>, what: &str| {
        let names: Vec<&str> = names.iter().map(|it| it.as_str()).collect();
        (!names.is_empty()).then(|| format!("{}: {what}", names.join(", ")))
    };
    let rules = of_names.iter().map(|(names, rules)| {
        let whose = if names.len() == table.detectors.len() { "all".to_owned() } else { names.join(", ") };
        format!("{whose}: {}", rules.join(", "))
    });
    let others = [listed(without, "none"), listed(theirs, "of its own, unknown here")];
    let all: Vec<String> = rules.chain(others.into_iter().flatten()).collect();
    (!of_names.is_empty()).then(|| format!("Rules besides clustering: {}.", all.join(" · ")))
}

/// How intervals are made, and what they cover.
pub(crate) fn about_interval(kind: BlockKind) -> String {
    about_interval_of(N_RESAMPLES, kind)
}

/// The text of [`about_interval`] for another number of resamples.
pub(crate) fn about_interval_of(n_resamples: usize, kind: BlockKind) -> String {
    let of = format!("cluster bootstrap, {n_resamples} resamples");
    let same_drives = "the intervals cover other scans of the same drives, but not other drives";
    match kind {
        BlockKind::Drives => format!("{of} of whole drives."),
        BlockKind::Seconds => format!(
            "{of}; each second of driving is one block, because there are fewer than {FEWEST_DRIVES} drives: {same_drives}."
        ),
        BlockKind::Named => format!("{of} of the blocks of --blocks."),
        BlockKind::Scans => format!(
            "{of} of single scans, because when they were taken is not known: they may be neighbours."
        ),
        BlockKind::Tracks => format!("{of} of objects, each with all its scans: {same_drives}."),
        BlockKind::Objects => format!("{of} of objects, each with all its steps."),
        BlockKind::Both => format!(
            "{of}; each drive is one block or, in data sets with fewer than {FEWEST_DRIVES} drives, each second of driving: \
             {same_drives}."
        ),
    }
}

fn marks(grid: &Grid) -> impl Iterator<Item = Mark> + '_ {
    grid.lines.iter().flat_map(|it| &it.cells).filter_map(|it| it.mark)
}

pub(crate) fn abbreviations(cpu_model: &str) -> String {
    format!(
        "NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). fps: scans per \
         second, detection only, on {cpu_model}."
    )
}

impl Notes {
    /// `sentences`, followed by the meanings of the marks in `grids`.
    pub(crate) fn beneath<'a>(grids: impl IntoIterator<Item = &'a Grid>, sentences: Vec<String>) -> Self {
        let mut notes = Self { marks: grids.into_iter().flat_map(marks).collect(), sentences };
        notes.explain_marks();
        notes
    }

    fn explain_marks(&mut self) {
        let about_marks: Vec<_> = self.marks.iter().map(|&mark| self.sentence_about(mark)).collect();
        self.sentences.extend(about_marks);
    }

    /// The sign of a cell's mark, empty without one. Marks of the origin of scans have a word instead, see [`Self::tag`].
    pub(crate) fn sign(&self, cell: &Cell) -> String {
        match cell.mark {
            None | Some(Mark::Recorded | Mark::Simulated) => String::new(),
            Some(mark) => self.sign_of(mark),
        }
    }

    /// The word for the origin of the scans of a cell.
    pub(crate) fn tag(cell: &Cell) -> Option<&'static str> {
        match cell.mark {
            Some(Mark::Simulated) => Some("simulated"),
            Some(Mark::Recorded) => Some("recorded"),
            _ => None,
        }
    }

    fn sign_of(&self, mark: Mark) -> String {
        match mark {
            Mark::Undefined(_) => {}
            Mark::BusyMachine => return "‖".to_owned(),
            Mark::FewScans => return "‡".to_owned(),
            Mark::FewBlocks => return "§".to_owned(),
            Mark::MaybeNeighbours => return "¶".to_owned(),
            Mark::Recorded | Mark::Simulated | Mark::NotPublic => return "†".to_owned(),
        }
        let is_number = |it: &&Mark| matches!(it, Mark::Undefined(_));
        let number_idx = self.marks.iter().filter(is_number).position(|it| *it == mark);
        // There are three reasons, so three signs are enough.
        ["¹", "²", "³"][number_idx.expect("the marks of all printed cells were collected")].to_owned()
    }

    fn sentence_about(&self, mark: Mark) -> String {
        let sentence = match mark {
            Mark::Recorded => return "recorded: from a sensor.".to_owned(),
            Mark::Simulated => return "simulated: from a simulator, not recorded.".to_owned(),
            Mark::NotPublic => "Budapest recordings, not public; overall with those of KITTI.",
            Mark::BusyMachine => "unreliable: the machine was busy.",
            Mark::FewScans => "from too few scans to be reliable: p95 needs 59, p99 needs 299.",
            Mark::FewBlocks => {
                let sign = self.sign_of(mark);
                return format!(
                    "{sign} from fewer than {FEWEST_BLOCKS} blocks: too few for a reliable interval and for conclusions."
                );
            }
            Mark::MaybeNeighbours => {
                "over scans that may be neighbours, because their times are not known: no basis for conclusions. --blocks FILE \
                 says which scans belong together; KITTI's mapping files do, too."
            }
            Mark::Undefined(Undefined::FalseObjectsUnknown) => {
                "undefined: not every class of object is annotated, so false objects cannot be counted."
            }
            Mark::Undefined(Undefined::ZeroDenominator) => "undefined: the denominator is zero.",
            Mark::Undefined(Undefined::NotTimed) => "undefined: no scan was timed.",
        };
        format!("{} {sentence}", self.sign_of(mark))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_folder::manifest::ForeignEntry;
    use crate::tables::sample::{manifest, report};
    use crate::tables::task_table::task_tables;

    #[test]
    fn scans_without_an_answer_are_counted_beneath_the_table() {
        let mut table = task_tables(&report(), &manifest()).unwrap().remove(0);
        table.failures = vec![("pca".to_owned(), [3, 60])];
        let sentence = "pca gave no answer to 3 of 60 scans, which count as nothing found.";
        assert!(notes(&table, &[]).sentences.contains(&sentence.to_owned()));
    }

    #[test]
    fn what_did_not_run_here_is_said_and_that_its_rules_are_its_own() {
        let mut manifest = manifest();
        manifest.detectors[0].rules = vec!["completion".to_owned()];
        manifest.detectors[2].foreign = Some(ForeignEntry {
            results: Some("results/deep".to_owned()),
            vehicles: "size".to_owned(),
            ..ForeignEntry::default()
        });
        let table = task_tables(&report(), &manifest).unwrap().remove(0);
        let sentences = notes(&table, &[]).sentences;
        for expected in [
            "Rules besides clustering: paper: completion · kd-tree: none · pca: of its own, unknown here.",
            "pca did not run here: its results were read from results/deep.",
        ] {
            assert!(sentences.contains(&expected.to_owned()), "{sentences:?}");
        }
    }

    #[test]
    fn how_vehicles_are_classified_is_said_of_every_detector() {
        let mut manifest = manifest();
        let said = |manifest: &_| {
            let tables = task_tables(&report(), manifest).unwrap();
            let of_table = |it: &TaskTable| {
                notes(it, &[]).sentences.into_iter().find(|it| it.starts_with("Vehicles classified"))
            };
            [0, 1].map(|it| of_table(&tables[it]))
        };
        // As in a run of an earlier version.
        assert_eq!(said(&manifest), [None, None]);
        for (entry, words) in manifest.detectors.iter_mut().zip(["SVM of eight values", "an SVM", "an SVM"]) {
            entry.vehicles = Some(words.to_owned());
        }
        let expected = "Vehicles classified by: paper: SVM of eight values · kd-tree, pca: an SVM.";
        assert_eq!(said(&manifest), [None, Some(expected.to_owned())]);
    }

    #[test]
    fn what_is_whose_stands_beneath_the_table() {
        let mut manifest = manifest();
        manifest.detectors[0].rules =
            ["walls removed", "regrouping", "completion"].map(str::to_owned).to_vec();
        manifest.detectors[1].rules = vec!["completion".to_owned()];
        let sentence =
            |table: &TaskTable| notes(table, &[]).sentences.into_iter().find(|it| it.starts_with("Rules"));
        let tables = task_tables(&report(), &manifest).unwrap();
        let expected = "Rules besides clustering: paper: walls removed, regrouping · paper, kd-tree: completion · \
                        pca: none.";
        assert_eq!(sentence(&tables[0]).as_deref(), Some(expected));
        manifest.detectors[2].rules = vec!["completion".to_owned()];
        manifest.detectors[0].rules.truncate(0);
        manifest.detectors[0].rules.push("completion".to_owned());
        let tables = task_tables(&report(), &manifest).unwrap();
        assert_eq!(sentence(&tables[0]).as_deref(), Some("Rules besides clustering: all: completion."));
        manifest.detectors.iter_mut().for_each(|it| it.rules.clear());
        assert_eq!(sentence(&task_tables(&report(), &manifest).unwrap()[0]), None);
    }
}
