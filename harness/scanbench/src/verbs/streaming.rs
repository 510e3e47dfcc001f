//! `scanbench streaming`: what the detections of a run are worth while the world moves on.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::Ordering;

use clap::{Args, ValueEnum};
use evaluation::matching::criterion::Criterion;
use evaluation::run::side_by_side::RunError;
use evaluation::streaming::latencies::{Latencies, LatencySource, NoLatency};
use evaluation::streaming::stream_study::StreamStudy;
use reports::files::csv_rows::to_csv_bytes;
use reports::files::whole_set::WholeSet;
use reports::pages::streaming_page::StreamingPage;
use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_directory::FIGURES;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::streaming::streamed::Streamed;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::streaming_table::{StreamingRow, StreamingTable};
use reports::verdicts::times_doubt::times_doubts;
use reports::vocabulary::task::Task;

use crate::cli::help_text::{DATA, DETECTORS, JUDGING, OUTPUT, VIEWER};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_run::{open_run, refuse_unknown};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::recorder::record_stream;
use crate::plumbing::run_manifest::criterion_in_words;
use crate::plumbing::standard_streams::{
    Verbosity, is_said, print_diagnostic, print_result, print_text, terminal,
};
use crate::plumbing::streams::Stream;
use crate::verbs::worst_scans::{datasets_of, place_of, task_named};

/// Arguments of `scanbench streaming`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StreamingArgs {
    /// Run directory; its scans follow one another closely
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Also fetch data from the addresses that the run names, for the recording
    #[arg(long, requires = "save_rrd", help_heading = DATA, hide_short_help = true)]
    pub trust: bool,
    /// Detectors [default: all of the run]
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help_heading = DETECTORS)]
    pub detectors: Vec<String>,
    /// Time of detection of every scan, instead of the measured ones, such as `mine=120ms`; may be repeated
    #[arg(long = "latency", value_name = "NAME=TIME", help_heading = DETECTORS)]
    pub latencies: Vec<LatencyOption>,
    /// Take the times of detection from this run of the same scans, on another machine
    #[arg(long, value_name = "RUN", help_heading = DETECTORS)]
    pub latencies_of: Option<PathBuf>,
    /// Tasks: objects, vehicles, or the name of a class [default: all of the run]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = JUDGING)]
    pub task: Vec<String>,
    /// When a box is good enough
    #[arg(long, value_enum, value_name = "RULE", default_value = "centre", help_heading = JUDGING)]
    pub criterion: BoxCriterion,
    /// Time from one moment to the next
    #[arg(long, value_name = "TIME", default_value = "10ms", value_parser = clock_ms, help_heading = JUDGING)]
    pub clock: f64,
    /// Directory for streaming.csv, streaming.html and figures/ [default: the run directory]
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
    /// Record a drive in real time for Rerun, too [default FILE: `streaming.rrd` beside the page]
    ///
    /// It shows scans as they are taken, and what detectors know as late as they know it.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, help_heading = VIEWER)]
    #[allow(clippy::option_option, reason = "both the option and its value may be left out")]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Drive that is recorded [default: the first]
    #[arg(long, value_name = "NAME", requires = "save_rrd", help_heading = VIEWER, hide_short_help = true)]
    pub drive: Option<String>,
}

/// Names of the criteria by boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BoxCriterion {
    /// Centres less than 2 m apart, seen from above
    Centre,
    /// Boxes seen from above: intersection over union of at least 0.5
    BevIou,
    /// Boxes in space: intersection over union of at least 0.5
    #[value(name = "iou-3d")]
    Iou3d,
}

impl BoxCriterion {
    fn criterion(self) -> Criterion {
        match self {
            Self::Centre => Criterion::CENTRE,
            Self::BevIou => Criterion::BEV_IOU,
            Self::Iou3d => Criterion::IOU_3D,
        }
    }
}

/// A detector and its time of detection.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyOption {
    /// Name of the detector.
    pub detector: String,
    /// Its time in milliseconds.
    pub latency_ms: f64,
}

impl FromStr for LatencyOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (detector, time) = text.rsplit_once('=').ok_or("write NAME=TIME, such as mine=120ms")?;
        Ok(Self { detector: detector.to_owned(), latency_ms: time_ms(time)? })
    }
}

/// A time such as `120ms` or `0.5s`, in milliseconds.
fn time_ms(text: &str) -> Result<f64, String> {
    let number = |digits: &str, ms: f64| digits.trim().parse().ok().map(|it: f64| it * ms);
    let time_ms = match text.strip_suffix("ms") {
        Some(digits) => number(digits, 1.0),
        None => text.strip_suffix('s').and_then(|digits| number(digits, 1000.0)),
    };
    time_ms
        .filter(|it| (0.0..=60_000.0).contains(it))
        .ok_or_else(|| format!("{text:?} is no time from 0 to 60 s: write 120ms or 0.12s"))
}

fn clock_ms(text: &str) -> Result<f64, String> {
    let clock_ms = time_ms(text)?;
    if (1.0..=1000.0).contains(&clock_ms) { Ok(clock_ms) } else { Err("not from 1 ms to 1 s".to_owned()) }
}

/// The page.
const STREAMING_HTML: &str = "streaming.html";
/// A longer time from moment to moment is not fine, in milliseconds: half of that from scan to scan.
const LONGEST_FINE_CLOCK_MS: f64 = 50.0;

/// Whether both paths lead to the same folder.
fn same_file(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(|it| it.canonicalize().ok());
    a.is_some() && a == b
}

const EXAMPLES: &str = "\
Examples:
  scanbench run streaming-streets && scanbench streaming runs/latest
  scanbench streaming runs/kitti --criterion bev-iou --task vehicles
  scanbench streaming runs/mine --latency mine=120ms
  scanbench streaming runs/laptop --latencies-of runs/in-the-car
  scanbench streaming runs/latest -d kd-tree,hierarchical --save-rrd --drive main-road-803595

A clock goes through each drive. A detector takes the newest scan when it is free, and
its answer is known from when it is done until the next. At every moment the newest
answer is judged against where things are then: labels interpolated along their tracks.
Nothing is detected again. Needs boxes, tracks and times, scans at most 0.25 s apart.
docs/streaming.md says more.";

/// Judges the answers of a run at every moment, and shows what they are worth.
pub fn streaming(arguments: &StreamingArgs) -> Result<(), Failure> {
    let run = open_run(&arguments.run)?;
    let elsewhere = arguments.latencies_of.as_deref().map(open_run).transpose()?;
    let choice = Choice::of(arguments, &run, elsewhere.as_ref().map(|it| &it.scans[..]))?;
    let drive_idx = choice.recorded_drive(arguments)?;
    let (streamed, caveats) = choice.streamed(arguments, elsewhere.as_ref().unwrap_or(&run))?;
    let notes = choice.notes(arguments);
    let criterion = criterion_in_words(arguments.criterion.criterion());
    let in_full = StreamingTable {
        streamed: &streamed,
        matched_by: &criterion,
        caveats: &caveats,
        notes: &notes,
        is_short: false,
    };
    let output = arguments.output.as_deref().unwrap_or(&arguments.run);
    write(&in_full, arguments, output)?;
    if is_said(Verbosity::Usual) {
        let is_short = !is_said(Verbosity::Verbose);
        print_text(&terminal().text(&StreamingTable { is_short, ..in_full }))?;
        print_diagnostic(format_args!("Page: {}", output.join(STREAMING_HTML).display()));
    } else {
        print_result(output.join(STREAMING_HTML).display())?;
    }
    match &arguments.save_rrd {
        Some(file) => {
            let path = file.clone().unwrap_or_else(|| output.join("streaming.rrd"));
            choice.record(arguments, drive_idx, &path)
        }
        None => Ok(()),
    }
}

fn write(table: &StreamingTable<'_>, arguments: &StreamingArgs, output: &Path) -> Result<(), Failure> {
    let is_of_run = same_file(output, &arguments.run);
    if !is_of_run && output.join(MANIFEST_JSON).exists() {
        let name = output.display();
        return Err(Usage(format!("{name} is the directory of another run; choose another for -o")).into());
    }
    let files = WholeSet::within(output)?;
    let rows: Vec<StreamingRow> = table
        .streamed
        .iter()
        .flat_map(|it| StreamingRow::all(it, arguments.criterion.criterion().kind(), arguments.clock))
        .collect();
    files.write("streaming.csv", &to_csv_bytes(&rows)?)?;
    let words: Vec<String> = std::env::args().skip(1).map(|it| shell_word(&it)).collect();
    let name = arguments.run.file_name().unwrap_or(arguments.run.as_os_str()).to_string_lossy();
    let page = StreamingPage::of(table, &name, &format!("scanbench {}", words.join(" ")));
    files.write(STREAMING_HTML, page.html.as_bytes())?;
    for figure in &page.figures {
        files.write(&format!("{FIGURES}/{}.svg", figure.file_stem), figure.svg.as_bytes())?;
    }
    files.finish()?;
    Ok(())
}

/// A run as a stream, and what is asked of it.
struct Choice<'a> {
    stream: Stream<'a>,
    tasks: Vec<Task>,
    latencies: Latencies,
}

impl<'a> Choice<'a> {
    fn of(
        arguments: &StreamingArgs,
        run: &'a RunArchive,
        elsewhere: Option<&[ScanRow]>,
    ) -> Result<Self, Failure> {
        let known = run.detector_names();
        arguments.detectors.iter().try_for_each(|it| refuse_unknown("detector", it, &known))?;
        let is_asked =
            |it: &&str| arguments.detectors.is_empty() || arguments.detectors.iter().any(|name| name == it);
        let detectors: Vec<&str> = known.into_iter().filter(is_asked).collect();
        let mut fixed_ms = BTreeMap::new();
        for LatencyOption { detector, latency_ms } in &arguments.latencies {
            refuse_unknown("detector", detector, &detectors)?;
            if fixed_ms.insert(detector.clone(), *latency_ms).is_some() {
                return Err(Usage(format!("--latency: {detector} is given twice")).into());
            }
        }
        let tasks: Vec<Task> = match &arguments.task[..] {
            [] => run.tally().tasks().to_vec(),
            named => named.iter().map(|it| task_named(run, it)).collect::<Result<_, _>>()?,
        };
        let stream = Stream::of(run, &arguments.run, detectors)?;
        let source = LatencySource { fixed_ms, elsewhere };
        let latencies = source.latencies(&stream.drives, &stream.detectors);
        let latencies = latencies.map_err(|NoLatency { detector }| {
            let where_from = match &arguments.latencies_of {
                Some(path) => format!(" for these scans in {}", path.display()),
                None => String::new(),
            };
            Usage(format!(
                "no time of detection of {detector} is known{where_from}: give it with --latency {detector}=120ms"
            ))
        })?;
        Ok(Self { stream, tasks, latencies })
    }

    fn study(&self, arguments: &StreamingArgs) -> StreamStudy<'_> {
        StreamStudy {
            drives: &self.stream.drives,
            detectors: &self.stream.detectors,
            tasks: &self.tasks,
            latencies: &self.latencies.ms,
            criterion: arguments.criterion.criterion(),
            step_us: (1000.0 * arguments.clock).round() as i64,
            is_in_full: true,
        }
    }

    /// The numbers of all drives, and what a reader has to know before them; the times are those of `timed`.
    fn streamed(
        &self,
        arguments: &StreamingArgs,
        timed: &RunArchive,
    ) -> Result<(Vec<Streamed>, Vec<String>), Failure> {
        let drives = &self.stream.drives;
        let n_scans = drives.iter().map(|it| it.scans.len()).sum();
        let progress = progress_over_scans(n_scans, "streaming");
        let (mut n_done, mut n_drives_done) = (0, 0);
        let result = self.study(arguments).run(
            || self.stream.run.manifest.tally_of_moments(),
            || {
                n_done += drives[n_drives_done].scans.len();
                n_drives_done += 1;
                progress.set_position(n_done as u64);
                let is_interrupted = interruption_flag().load(Ordering::Relaxed);
                if is_interrupted { Err(RunError::Interrupted { n_done, n_scans }) } else { Ok(()) }
            },
        )?;
        progress.finish_and_clear();
        let streamed = Streamed::all(&result.per_scan, &result.streamed, &result.sums);
        if streamed.iter().all(|it| it.streamed.no() == 0) {
            let reason = "no object that counts can be followed: it needs boxes and tracks".to_owned();
            return Err(NothingEvaluated { reason }.into());
        }
        let mut caveats = self.caveats(arguments, timed);
        let [n_unfollowed, n_labels] = result.n_unfollowed;
        if n_unfollowed > 0 {
            caveats.push(format!(
                "{n_unfollowed} of {n_labels} labels that count have no box, or no track that is their own: they count in scans, and \
                 not as it streams."
            ));
        }
        Ok((streamed, caveats))
    }

    /// What decides whether the numbers mean anything.
    fn caveats(&self, arguments: &StreamingArgs, timed: &RunArchive) -> Vec<String> {
        let mut caveats = self.stream.notes.clone();
        if arguments.latencies.len() < self.stream.detectors.len() {
            caveats.extend(times_doubts(&timed.manifest, &timed.report));
        }
        if self.latencies.n_filled_in > 0 {
            caveats.push(format!(
                "{} times of a scan are not known: the median of the detector's others stands for them.",
                self.latencies.n_filled_in
            ));
        }
        if arguments.clock > LONGEST_FINE_CLOCK_MS {
            caveats.push(format!(
                "A clock of {} ms is too coarse: it misses most of what happens.",
                arguments.clock
            ));
        }
        caveats
    }

    /// What numbers were made of.
    fn notes(&self, arguments: &StreamingArgs) -> Vec<String> {
        let mut notes = about_times(arguments, self.stream.run, &self.stream.detectors);
        let (of_run, here) = (
            &self.stream.run.manifest.matching_criterion,
            criterion_in_words(arguments.criterion.criterion()),
        );
        if *of_run != here {
            notes.push(format!(
                "The run itself matched by {of_run}: its rates are others than those of *scans* here."
            ));
        }
        let drives: BTreeSet<(&str, &str)> =
            self.stream.drives.iter().map(|it| (it.dataset.as_str(), it.name.as_str())).collect();
        let gaps = match self.stream.drives.len() - drives.len() {
            0 => String::new(),
            n_gaps => format!(" with {n_gaps} gaps"),
        };
        notes.push(format!(
            "Drives: {}{gaps}; scans: {}; a moment every {} ms.",
            drives.len(),
            self.stream.drives.iter().map(|it| it.scans.len()).sum::<usize>(),
            arguments.clock
        ));
        notes
    }

    /// Index of the drive that is recorded, of one with gaps its longest stretch.
    fn recorded_drive(&self, arguments: &StreamingArgs) -> Result<usize, Usage> {
        let Some(name) = &arguments.drive else { return Ok(0) };
        let drives = self.stream.drives.iter();
        let stretches = drives.clone().enumerate().filter(|(_, it)| it.name == *name);
        let longest = stretches.max_by_key(|(drive_idx, it)| (it.scans.len(), Reverse(*drive_idx)));
        longest.map(|(drive_idx, _)| drive_idx).ok_or_else(|| {
            let names: BTreeSet<&str> = drives.map(|it| it.name.as_str()).collect();
            let names: Vec<&str> = names.into_iter().collect();
            Usage(format!("the run has no drive {name:?}; its drives are {}", names.join(", ")))
        })
    }

    /// Records the drive with this index to the file at `path`.
    fn record(&self, arguments: &StreamingArgs, drive_idx: usize, path: &Path) -> Result<(), Failure> {
        let drive = &self.stream.drives[drive_idx];
        let task = if self.tasks.contains(&Task::Vehicles) { Task::Vehicles } else { self.tasks[0] };
        let Some(picture) = self.study(arguments).picture(drive_idx, task) else {
            let reason = format!("drive {} has nothing of the task {task}", drive.name);
            return Err(NothingEvaluated { reason }.into());
        };
        let datasets = datasets_of(&self.stream.run.manifest, arguments.trust)?;
        let progress = progress_over_scans(drive.scans.len(), "recording");
        record_stream(path, &format!("{} in real time", drive.name), &picture, |scan_idx| {
            let ScanName { dataset, sequence, scan } = &drive.scans[scan_idx].name;
            let [dataset_idx, scan_idx] = place_of(&datasets, (dataset, sequence, *scan))?;
            progress.inc(1);
            Ok(datasets[dataset_idx].dataset.read_scan(scan_idx)?)
        })?;
        progress.finish_and_clear();
        print_diagnostic(format_args!(
            "Recording of {}: rerun {}",
            drive.name,
            shell_word(&path.display().to_string())
        ));
        Ok(())
    }
}

/// The sources of the times of detection.
fn about_times(arguments: &StreamingArgs, run: &RunArchive, detectors: &[&str]) -> Vec<String> {
    let set = arguments.latencies.iter();
    let mut about: Vec<String> =
        set.map(|it| format!("The time of {} is set to {} ms.", it.detector, it.latency_ms)).collect();
    if arguments.latencies.len() < detectors.len() {
        about.push(match &arguments.latencies_of {
            Some(path) => format!("Times of detection are those of {}.", path.display()),
            None => format!("Times of detection as measured on {}.", run.manifest.machine.cpu_model),
        });
    }
    about
}
