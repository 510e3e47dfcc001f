//! `scanbench streaming`: what the detections of a run are worth while the world moves on.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::Ordering;

use clap::{Args, ValueEnum};
use evaluation::matching::criterion::Criterion;
use evaluation::run::side_by_side::RunError;
use evaluation::streaming::latencies::LatencySource;
use evaluation::streaming::stream_study::StreamStudy;
use reports::files::csv_rows::to_csv_bytes;
use reports::files::whole_set::WholeSet;
use reports::pages::streaming_page::StreamingPage;
use reports::rows::scan_name::ScanName;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_directory::FIGURES;
use reports::streaming::streamed::Streamed;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::streaming_table::{StreamingRow, StreamingTable};
use reports::vocabulary::task::Task;

use crate::cli::help_text::{DATA, DETECTORS, JUDGING, OUTPUT, VIEWER};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_run::{open_run, refuse_unknown};
use crate::plumbing::progress::{progress_over_results, progress_over_scans};
use crate::plumbing::recorder::record_stream;
use crate::plumbing::run_manifest::criterion_in_words;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_diagnostic, print_text, terminal};
use crate::plumbing::streams::Stream;
use crate::verbs::worst_scans::{datasets_of, place_of, task_named};

/// Arguments of `scanbench streaming`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StreamingArgs {
    /// Run directory; its scans follow one another closely
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Detectors [default: all of the run]
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help_heading = DETECTORS)]
    pub detectors: Vec<String>,
    /// Time of detection of every scan, instead of the measured ones, such as `mine=120ms`; may be repeated
    #[arg(long = "latency", value_name = "NAME=TIME", help_heading = DETECTORS)]
    pub latencies: Vec<LatencyOption>,
    /// Take the times of detection from this run of the same scans, on another machine
    #[arg(long, value_name = "RUN", help_heading = DETECTORS)]
    pub latencies_of: Option<PathBuf>,
    /// Tasks: objects, vehicles, or classes [default: all of the run]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = JUDGING)]
    pub task: Vec<String>,
    /// When a box is good enough
    #[arg(long, value_enum, value_name = "RULE", default_value = "centre", help_heading = JUDGING)]
    pub criterion: BoxCriterion,
    /// Time from one moment to the next
    #[arg(long, value_name = "TIME", default_value = "10ms", value_parser = clock_ms, help_heading = JUDGING)]
    pub clock: f64,
    /// Record a drive in real time for Rerun, too: scans as they are taken, answers as they are known [default FILE: `streaming.rrd` beside the page]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, help_heading = VIEWER)]
    #[allow(clippy::option_option, reason = "both the option and its value may be left out")]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Drive that is recorded [default: the first]
    #[arg(long, value_name = "NAME", requires = "save_rrd", help_heading = VIEWER)]
    pub drive: Option<String>,
    /// Also fetch data from the addresses that the run names, for the recording
    #[arg(long, requires = "save_rrd", help_heading = DATA)]
    pub trust: bool,
    /// Directory for streaming.csv, streaming.html and figures/ [default: the run directory]
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
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
    let notes = choice.notes(arguments);
    let streamed = choice.streamed(arguments)?;
    let criterion = criterion_in_words(arguments.criterion.criterion());
    let in_full =
        StreamingTable { streamed: &streamed, matched_by: &criterion, notes: &notes, is_short: false };
    let output = arguments.output.as_deref().unwrap_or(&arguments.run);
    write(&in_full, arguments, output)?;
    let is_short = !is_said(Verbosity::Verbose);
    print_text(&terminal().text(&StreamingTable { is_short, ..in_full }))?;
    print_diagnostic(format_args!("Page: {}", output.join("streaming.html").display()));
    match &arguments.save_rrd {
        Some(file) => {
            let path = file.clone().unwrap_or_else(|| output.join("streaming.rrd"));
            choice.record(arguments, drive_idx, &path)
        }
        None => Ok(()),
    }
}

fn write(table: &StreamingTable<'_>, arguments: &StreamingArgs, output: &Path) -> Result<(), Failure> {
    let files = WholeSet::within(output)?;
    let rows: Vec<StreamingRow> = table.streamed.iter().flat_map(StreamingRow::all).collect();
    files.write("streaming.csv", &to_csv_bytes(&rows)?)?;
    let words: Vec<String> = std::env::args().skip(1).map(|it| shell_word(&it)).collect();
    let name = arguments.run.file_name().unwrap_or(arguments.run.as_os_str()).to_string_lossy();
    let page = StreamingPage::of(table, &name, &format!("scanbench {}", words.join(" ")));
    files.write("streaming.html", page.html.as_bytes())?;
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
    latencies: Vec<Vec<Vec<f64>>>,
}

impl<'a> Choice<'a> {
    fn of(
        arguments: &StreamingArgs,
        run: &'a RunArchive,
        elsewhere: Option<&[ScanRow]>,
    ) -> Result<Self, Failure> {
        let known = run.detector_names();
        let asked = arguments.detectors.iter().chain(arguments.latencies.iter().map(|it| &it.detector));
        asked.clone().try_for_each(|it| refuse_unknown("detector", it, &known))?;
        let is_asked =
            |it: &&str| arguments.detectors.is_empty() || arguments.detectors.iter().any(|name| name == it);
        let detectors = known.into_iter().filter(is_asked).collect();
        let tasks: Vec<Task> = match &arguments.task[..] {
            [] => run.tally().tasks().to_vec(),
            named => named.iter().map(|it| task_named(run, it)).collect::<Result<_, _>>()?,
        };
        let stream = Stream::of(run, &arguments.run, detectors)?;
        let fixed_ms = arguments.latencies.iter().map(|it| (it.detector.clone(), it.latency_ms)).collect();
        let latencies = stream.latencies(&LatencySource { fixed_ms, elsewhere })?;
        Ok(Self { stream, tasks, latencies })
    }

    fn study(&self, arguments: &StreamingArgs) -> StreamStudy<'_> {
        StreamStudy {
            drives: &self.stream.drives,
            detectors: &self.stream.detectors,
            tasks: &self.tasks,
            latencies: &self.latencies,
            criterion: arguments.criterion.criterion(),
            step_us: (1000.0 * arguments.clock).round() as i64,
            is_in_full: true,
        }
    }

    /// The numbers of all drives.
    fn streamed(&self, arguments: &StreamingArgs) -> Result<Vec<Streamed>, Failure> {
        let n_drives = self.stream.drives.len();
        let progress = progress_over_results(n_drives, 0, "drives");
        let mut n_done = 0;
        let result = self.study(arguments).run(
            || self.stream.run.manifest.tally_of_moments(),
            || {
                progress.inc(1);
                n_done += 1;
                let is_interrupted = interruption_flag().load(Ordering::Relaxed);
                if is_interrupted { Err(RunError::Interrupted { n_done, n_scans: n_drives }) } else { Ok(()) }
            },
        )?;
        progress.finish_and_clear();
        let streamed = Streamed::all(&result.per_scan, &result.streamed, &result.sums);
        if streamed.iter().all(|it| it.streamed.no() == 0) {
            let reason = "no object that counts can be followed: it needs boxes and tracks".to_owned();
            return Err(NothingEvaluated { reason }.into());
        }
        Ok(streamed)
    }

    /// What a reader has to know beside the numbers.
    fn notes(&self, arguments: &StreamingArgs) -> Vec<String> {
        let mut notes = self.stream.notes.clone();
        notes.extend(about_times(arguments, self.stream.run));
        notes.push(format!(
            "{} drives, {} scans, a moment every {} ms.",
            self.stream.drives.len(),
            self.stream.drives.iter().map(|it| it.scans.len()).sum::<usize>(),
            arguments.clock
        ));
        notes
    }

    /// Index of the drive that is recorded.
    fn recorded_drive(&self, arguments: &StreamingArgs) -> Result<usize, Usage> {
        let Some(name) = &arguments.drive else { return Ok(0) };
        let found = self.stream.drives.iter().position(|it| it.name == *name);
        found.ok_or_else(|| {
            let names: Vec<&str> = self.stream.drives.iter().map(|it| it.name.as_str()).collect();
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

/// Where times of detection come from.
fn about_times(arguments: &StreamingArgs, run: &RunArchive) -> Vec<String> {
    let mut about: Vec<String> = arguments
        .latencies
        .iter()
        .map(|it| format!("The time of {} is set to {} ms.", it.detector, it.latency_ms))
        .collect();
    about.push(match &arguments.latencies_of {
        Some(path) => format!("Times of detection are those of {}.", path.display()),
        None => format!("Times of detection as measured on {}.", run.manifest.machine.cpu_model),
    });
    about
}
