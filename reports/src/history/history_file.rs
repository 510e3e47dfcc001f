//! The file that keeps the numbers of runs: a line of JSON for each run, each number, and each of the settings that runs have.
//!
//! Lines are sorted: settings, runs by time, numbers. Two files put together, line by line in any order and with lines twice, are
//! a history again, so that git merges them (`merge=union`).

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::files::archive::ArchiveError;
use crate::files::regular_file::read_text;
use crate::files::whole_file::write_whole;
use crate::numbers::run_report::{MetricRow, Subject};
use crate::run_folder::manifest::{GitState, Machine, Manifest};
use crate::run_folder::run_archive::RunArchive;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Layout of the lines.
const HISTORY_SCHEMA: u32 = 1;
/// The largest file that is read, in bytes.
const MOST_BYTES: u64 = 1 << 30;
/// Digits of a hash that name settings and runs.
const N_DIGITS: usize = 12;

/// The numbers of some runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// By the names of runs, which begin with their times.
    runs: BTreeMap<String, RunOfHistory>,
    settings: BTreeMap<String, Manifest>,
}

/// A run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOfHistory {
    /// When it began, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The commit of the project that it ran in or, without one, of the source of its program.
    pub commit: Option<String>,
    /// Whether there were changes beyond the commit.
    pub dirty: bool,
    /// The commit of the source of its program, in short, if the other is that of a project.
    pub program: Option<String>,
    /// The machine of its times.
    pub machine: Machine,
    /// Where its page is.
    pub link: Option<String>,
    settings: String,
    /// Its numbers.
    pub numbers: BTreeMap<NumberName, Number>,
}

/// What a number is about.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct NumberName {
    /// Data set, task, detector and slice.
    pub subject: Subject,
    /// The metric.
    pub metric: Metric,
}

/// A number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// The value. Finite.
    pub value: f64,
    /// Its 95 % interval.
    pub within: Option<[f64; 2]>,
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "line", rename_all = "kebab-case", deny_unknown_fields)]
enum Line {
    History {
        schema: u32,
    },
    Settings {
        settings: String,
        manifest: Box<Manifest>,
    },
    Run {
        run: String,
        created: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        commit: Option<String>,
        #[serde(default)]
        dirty: bool,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        program: Option<String>,
        machine: Machine,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        link: Option<String>,
        settings: String,
    },
    Number {
        run: String,
        dataset: String,
        task: Task,
        detector: String,
        slice: Slice,
        metric: String,
        value: f64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        interval_95: Option<[f64; 2]>,
    },
}

/// Whether a number is kept: rates, times beside the reference, and errors of boxes, of everything and of slices of the user.
fn is_kept(row: &MetricRow) -> bool {
    row.metric.is_kept_in_history() && matches!(row.subject.slice, Slice::All | Slice::Own(_))
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    let mut first = [0; 8];
    first.copy_from_slice(&digest[..8]);
    format!("{:016x}", u64::from_be_bytes(first))[..N_DIGITS].to_owned()
}

/// What decides the numbers of a run, without what is its alone or takes much room.
fn settings_of(manifest: &Manifest) -> Manifest {
    let mut settings = Manifest {
        created: String::new(),
        argv: Vec::new(),
        config: serde_json::Value::Null,
        git: None,
        project: None,
        machine: Machine::default(),
        experiment: None,
        shard: None,
        shards: Vec::new(),
        ..manifest.clone()
    };
    for dataset in &mut settings.datasets {
        dataset.blocks.clear();
        dataset.root = None;
        dataset.skipped_scans.clear();
        dataset.doubts.clear();
    }
    for foreign in settings.detectors.iter_mut().filter_map(|it| it.foreign.as_mut()) {
        foreign.result_files.clear();
    }
    settings
}

impl History {
    /// Reads the history in `path`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if it cannot be read, or a line of it is none of a history.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        let text = read_text(path, MOST_BYTES)
            .map_err(|source| ArchiveError::Read { path: path.to_owned(), source })?;
        let damaged = |line_idx: usize, problem: String| ArchiveError::Contradiction {
            path: path.to_owned(),
            problem: format!("line {}: {problem}", line_idx + 1),
        };
        let mut history = Self::default();
        let mut numbers = Vec::new();
        let mut has_schema = false;
        for (line_idx, line) in text.lines().enumerate().filter(|(_, it)| !it.trim().is_empty()) {
            let line: Line =
                serde_json::from_str(line).map_err(|error| damaged(line_idx, error.to_string()))?;
            match line {
                Line::History { schema: HISTORY_SCHEMA } => has_schema = true,
                Line::History { schema } => {
                    let problem = format!("schema {schema} is not that of this program, {HISTORY_SCHEMA}");
                    return Err(damaged(line_idx, problem));
                }
                Line::Settings { settings, manifest } => drop(history.settings.insert(settings, *manifest)),
                Line::Run { run, created, commit, dirty, program, machine, link, settings } => {
                    let numbers = BTreeMap::new();
                    let entry =
                        RunOfHistory { created, commit, dirty, program, machine, link, settings, numbers };
                    history.runs.insert(run, entry);
                }
                Line::Number { run, dataset, task, detector, slice, metric, value, interval_95 } => {
                    let subject = Subject { dataset, task, detector, slice };
                    let metric = Metric::from_id(&metric)
                        .ok_or_else(|| damaged(line_idx, format!("unknown metric {metric:?}")))?;
                    let number = Number { value, within: interval_95 };
                    numbers.push((line_idx, run, NumberName { subject, metric }, number));
                }
            }
        }
        if !has_schema && !history.runs.is_empty() {
            return Err(damaged(0, "no line says the schema".to_owned()));
        }
        for (line_idx, run, name, number) in numbers {
            let unknown = || damaged(line_idx, format!("there is no run {run:?}"));
            history.runs.get_mut(&run).ok_or_else(unknown)?.numbers.insert(name, number);
        }
        if let Some((name, run)) =
            history.runs.iter().find(|(_, it)| !history.settings.contains_key(&it.settings))
        {
            return Err(damaged(0, format!("there are no settings {:?} of the run {name}", run.settings)));
        }
        // Files of earlier versions of the program may have a run once for each of its links.
        Ok(Self::default().with(history))
    }

    /// Adds a run, whose page is at `link`; one that is there already takes over the link.
    pub fn add(&mut self, run: &RunArchive, link: Option<&str>) {
        let manifest = &run.manifest;
        let settings = settings_of(manifest);
        let id = hash(&serde_json::to_vec(&settings).unwrap_or_default());
        self.settings.insert(id.clone(), settings);
        let first_task = run.report.first_task();
        // Times are the same in every task.
        let is_once = |it: &&MetricRow| !it.metric.is_time() || Some(it.subject.task) == first_task;
        let rows = run.report.rows().iter().chain(run.report.overall());
        let rows = rows.filter(|it| is_kept(it)).filter(is_once);
        let number = |it: &MetricRow| {
            let name = NumberName { subject: it.subject.clone(), metric: it.metric.clone() };
            Some((name, Number { value: it.value()?, within: it.interval().map(|it| it.ends) }))
        };
        let entry = RunOfHistory {
            created: manifest.created.clone(),
            commit: manifest.versioned_by().map(|it| it.commit.clone()),
            dirty: manifest.versioned_by().is_some_and(|it| it.dirty),
            program: manifest.git.as_ref().filter(|_| manifest.project.is_some()).map(GitState::in_short),
            machine: manifest.machine.clone(),
            link: None,
            settings: id,
            numbers: rows.filter_map(number).collect(),
        };
        let lines: String = entry.lines("").concat();
        let name = format!("{}-{}", entry.created, hash(lines.as_bytes()));
        self.insert(name, RunOfHistory { link: link.map(str::to_owned), ..entry });
    }

    /// Inserts a run; one that is there already, maybe by another name, takes over the link: names once had it in them.
    fn insert(&mut self, name: String, run: RunOfHistory) {
        match self.runs.values_mut().find(|it| it.is_but_for_link(&run)) {
            Some(known) => known.link = run.link.or_else(|| known.link.take()),
            None => drop(self.runs.insert(name, run)),
        }
    }

    /// This history with the runs of `other`.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        other.runs.into_iter().for_each(|(name, run)| self.insert(name, run));
        self.settings.extend(other.settings);
        self
    }

    /// Writes it to `path`, whole or not at all.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ArchiveError> {
        write_whole(path, self.to_text().as_bytes())
    }

    /// Its lines.
    pub fn to_text(&self) -> String {
        let settings = self.settings.iter().map(|(settings, manifest)| {
            json(&Line::Settings { settings: settings.clone(), manifest: Box::new(manifest.clone()) })
        });
        let of_runs = self.runs.iter().map(|(name, run)| run.lines(name));
        let (mut runs, mut numbers) = (Vec::new(), Vec::new());
        for lines in of_runs {
            let mut lines = lines.into_iter();
            runs.extend(lines.next());
            numbers.extend(lines);
        }
        let schema = json(&Line::History { schema: HISTORY_SCHEMA });
        [schema].into_iter().chain(settings).chain(runs).chain(numbers).collect()
    }

    /// The runs with their names, by time.
    pub fn runs(&self) -> Vec<(&str, &RunOfHistory)> {
        self.runs.iter().map(|(name, run)| (name.as_str(), run)).collect()
    }

    /// What decided the numbers of `run`.
    pub fn settings(&self, run: &RunOfHistory) -> &Manifest {
        &self.settings[&run.settings]
    }
}

impl RunOfHistory {
    /// Whether `other` is the same run, wherever its page is.
    fn is_but_for_link(&self, other: &Self) -> bool {
        self.created == other.created && *self == Self { link: self.link.clone(), ..other.clone() }
    }

    /// Its lines, under this name; the first is that of the run.
    fn lines(&self, name: &str) -> Vec<String> {
        let Self { created, commit, dirty, program, machine, link, settings, numbers } = self;
        let run = Line::Run {
            run: name.to_owned(),
            created: created.clone(),
            commit: commit.clone(),
            dirty: *dirty,
            program: program.clone(),
            machine: machine.clone(),
            link: link.clone(),
            settings: settings.clone(),
        };
        let number = |(NumberName { subject, metric }, number): (&NumberName, &Number)| {
            let Subject { dataset, task, detector, slice } = subject.clone();
            let Number { value, within } = *number;
            let (run, metric) = (name.to_owned(), metric.id());
            json(&Line::Number { run, dataset, task, detector, slice, metric, value, interval_95: within })
        };
        [json(&run)].into_iter().chain(numbers.iter().map(number)).collect()
    }

    /// The beginning of the commit, for people.
    pub fn short_commit(&self) -> String {
        let state = self.commit.clone().map(|commit| GitState { commit, dirty: self.dirty });
        state.map_or_else(|| "–".to_owned(), |it| it.in_short())
    }
}

fn json(line: &Line) -> String {
    serde_json::to_string(line).expect("its keys are text") + "\n"
}
