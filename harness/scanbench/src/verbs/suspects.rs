//! `scanbench suspects`: labels that several detectors contradict.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use evaluation::run::kept_names::kept;
use evaluation::run::scan_recorder::Mark;
use reports::files::csv_rows::to_csv_bytes;
use reports::files::whole_set::WholeSet;
use reports::worst::suspects::{suspects as suspects_of, suspects_to_terminal};

use crate::cli::StreamArgs;
use crate::cli::data_prelabel::ToolName;
use crate::cli::help_text::{DATA, DETECTORS, MISTAKES, OUTPUT};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::open_run::{open_run, refuse_unknown};
use crate::plumbing::standard_streams::{print_diagnostic, print_text};
use crate::verbs::changed_scans::{PointedScan, TwoSides, record_sides, rows_by_scan};
use crate::verbs::suspect_project::write_project;
use crate::verbs::worst_scans::task_named;

/// Arguments of `scanbench suspects`.
#[derive(Debug, Args)]
#[command(after_help = SUSPECTS_EXAMPLES)]
pub struct SuspectsArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Also fetch data from the addresses that the run names
    #[arg(long, help_heading = DATA)]
    pub trust: bool,
    /// Detectors that have to agree, two or more, good ones [default: all of the run]
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help_heading = DETECTORS)]
    pub detectors: Vec<String>,
    /// Task: objects, vehicles, or a class that all of them give
    #[arg(long, value_name = "TASK", default_value = "objects", help_heading = DETECTORS)]
    pub task: String,
    /// Number of labels to list and record; suspects.csv has all
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = MISTAKES)]
    pub most: u32,
    /// Write the listed ones as a project of this annotation tool, too, into the folder of -o
    #[arg(long, value_enum, value_name = "TOOL", requires = "output", help_heading = OUTPUT)]
    pub to: Option<ToolName>,
    /// Folder of the project
    #[arg(short, long, value_name = "DIR", requires = "to", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

const SUSPECTS_EXAMPLES: &str = "\
Examples:
  scanbench suspects runs/latest -d hierarchical,kd-tree-tree
  scanbench suspects runs/latest -d net-a,net-b --task vehicles --most 50
  scanbench suspects runs/mine --most 100 --to labelcloud -o doubtful

Ranks labels by how unusual it is that all detectors contradict them: none finds the
object, all find it elsewhere, longer, turned or of another class, or all find something
where nothing is labelled. Writes suspects.csv and suspects.rrd, which shows the first two
of the detectors, into the run directory. With --to, writes their scans for an annotation
tool: with all labels, and a box where one may be missing.
It is agreement of detectors and no truth: look before you change a label.";

/// Lists suspect labels, writes them, and records their scans.
pub fn suspects(arguments: &SuspectsArgs) -> Result<(), Failure> {
    let run = open_run(&arguments.run)?;
    let known = run.detector_names();
    let asked: Vec<&str> = arguments.detectors.iter().map(String::as_str).collect();
    asked.iter().try_for_each(|it| refuse_unknown("detector", it, &known))?;
    let mut detectors = if asked.is_empty() { known } else { asked };
    let mut seen = BTreeSet::new();
    detectors.retain(|it| seen.insert(*it));
    let [first, second, ..] = detectors[..] else {
        return Err(
            Usage("labels are suspect where detectors agree: name two or more with -d".to_owned()).into()
        );
    };
    let task = task_named(&run, &arguments.task)?;
    let all = suspects_of(&run.matches, task, &detectors);
    if all.is_empty() {
        let reason = format!("{} contradict no label together", detectors.join(", "));
        return Err(NothingEvaluated { reason }.into());
    }
    let listed = &all[..all.len().min(arguments.most as usize)];
    if let (Some(tool), Some(output)) = (arguments.to, &arguments.output) {
        write_project(&run.manifest, arguments.trust, listed, (tool.format(), output))?;
    }
    let files = WholeSet::within(&arguments.run)?;
    files.write("suspects.csv", &to_csv_bytes(&all)?)?;
    files.finish()?;
    print_text(&suspects_to_terminal(listed, all.len()))?;
    print_diagnostic(format_args!("Suspects: {}", arguments.run.join("suspects.csv").display()));
    let mut scans: Vec<PointedScan<'_>> = Vec::new();
    for (rank, it) in (1..).zip(listed) {
        let mark = it.position_m().map(|position_m| Mark {
            position_m,
            text: format!("{rank} {}: {}", it.kind, it.class),
            change: None,
        });
        let line = (None, format!("{rank} {}: {}, {} points, {}", it.kind, it.class, it.n_points, it.reason));
        PointedScan::of(&mut scans, (&it.dataset, &it.sequence, it.scan)).add(mark, line);
    }
    record_sides(
        &TwoSides {
            stream: &arguments.stream,
            file: arguments.run.join("suspects.rrd"),
            name: "suspect labels",
            manifest: &run.manifest,
            is_trusted: arguments.trust,
            names: [first, second].map(kept),
            rows: [first, second].map(|it| rows_by_scan(&run.matches, it, task)),
            task,
        },
        &scans,
    )
}
