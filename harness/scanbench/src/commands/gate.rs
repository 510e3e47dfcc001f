//! `scanbench gate` and `scanbench baseline`.

use std::io::Write as _;
use std::path::Path;

use jiff::Timestamp;
use reports::files::whole_file::write_whole;
use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::{SERVICE_FORMATS, VERDICT_FORMATS};
use reports::tables::formats::markdown::Markdown;
use reports::tables::formats::terminal::Terminal;
use reports::verdicts::accept::{Acceptance, Succession, TOLERANCES_TOML, accept, run_of_baseline};
use reports::verdicts::tolerances::{Tolerances, TolerancesError};
use reports::verdicts::verdict::{Conclusion, Verdict, judge};

use crate::cli::{AcceptArgs, GateArgs};
use crate::commands::failure::{Failure, GateClosed, Usage};
use crate::commands::open_run::open_run;
use crate::commands::provenance::utc_day;
use crate::commands::standard_streams::{print_bytes, print_diagnostic};

/// The file that GitHub shows as the summary of a job.
const STEP_SUMMARY: &str = "GITHUB_STEP_SUMMARY";

/// Judges a run by an accepted one, and prints and writes the verdict.
///
/// # Errors
///
/// [`GateClosed`] if the run is worse or results changed; and if it cannot be compared, or something cannot be read or written.
pub fn gate(arguments: &GateArgs) -> Result<(), Failure> {
    let directory = &arguments.baseline.baseline;
    let tolerances = tolerances(arguments, directory)?;
    let baseline = open_run(&run_of_baseline(directory))?;
    let run = open_run(&arguments.run)?;
    let verdict = judge(&baseline, &run, &tolerances)?;
    if let Some(output) = &arguments.output {
        write_verdict(output, &verdict, &run)?;
    }
    if let Some(summary) = std::env::var_os(STEP_SUMMARY).filter(|it| !it.is_empty()) {
        append(Path::new(&summary), &Markdown.text(&verdict))?;
    }
    print_bytes(Terminal::UNFOLDED.text(&verdict).as_bytes())?;
    match verdict.conclusion() {
        Conclusion::Same => Ok(()),
        closed => Err(GateClosed(closed).into()),
    }
}

fn tolerances(arguments: &GateArgs, baseline: &Path) -> Result<Tolerances, TolerancesError> {
    match &arguments.tolerances {
        Some(path) => Tolerances::read(path),
        None => Tolerances::read(&baseline.join(TOLERANCES_TOML)),
    }
}

fn write_verdict(directory: &Path, verdict: &Verdict, run: &RunArchive) -> Result<(), Failure> {
    std::fs::create_dir_all(directory).map_err(|error| {
        Failure::usage(format!("cannot make the directory {}", directory.display()), error)
    })?;
    for format in VERDICT_FORMATS {
        write_whole(&directory.join(format.file_name("gate")), format.text(verdict).as_bytes())?;
    }
    for format in SERVICE_FORMATS {
        write_whole(&directory.join(format.file_name("gate")), format.text(&run.report).as_bytes())?;
    }
    Ok(())
}

/// Other steps of the job have written there before.
fn append(path: &Path, text: &str) -> Result<(), Failure> {
    let file = std::fs::File::options().append(true).create(true).open(path);
    let written = file.and_then(|mut it| it.write_all(text.as_bytes()));
    written.map_err(|error| {
        Failure::usage(format!("cannot write {}, the file that {STEP_SUMMARY} names", path.display()), error)
    })
}

/// Makes a run the one that others are judged by.
///
/// # Errors
///
/// If no reason is given, the run cannot be made again or is no successor of the one accepted before, or something cannot be read
/// or written.
pub fn baseline_accept(arguments: &AcceptArgs) -> Result<(), Failure> {
    if arguments.why.trim().is_empty() {
        return Err(Usage("--why is empty; say why the scores changed".to_owned()).into());
    }
    let run = open_run(&arguments.run)?;
    let directory = &arguments.baseline.baseline;
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: &arguments.why,
        succession: if arguments.new_baseline { Succession::Anew } else { Succession::Comparable },
    };
    let line = accept(&run, directory, acceptance)?;
    print_bytes(format!("{line}\n").as_bytes())?;
    print_diagnostic(format_args!("Baseline: {}", directory.display()));
    Ok(())
}
