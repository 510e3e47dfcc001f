//! `scanbench gate` and `scanbench baseline`.

use std::io::Write as _;
use std::path::Path;

use jiff::Timestamp;
use reports::gate::accept::{Acceptance, Succession, TOLERANCES_TOML, accept, run_of_baseline};
use reports::gate::benchmark_formats::{to_bencher_metric_format, to_custom_smaller_is_better};
use reports::gate::junit::to_junit;
use reports::gate::summary::{to_markdown, to_terminal};
use reports::gate::tolerances::{Tolerances, TolerancesError};
use reports::gate::verdict::{Conclusion, Verdict, judge};
use reports::gate::verdict_json::to_json;
use reports::run_archive::RunArchive;
use reports::whole_file::write_whole;

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
/// [`GateClosed`] if the run is worse or judged otherwise; and if it cannot be compared, or something cannot be read or written.
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
        append(Path::new(&summary), &to_markdown(&verdict))?;
    }
    print_bytes(to_terminal(&verdict).as_bytes())?;
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
    for (name, text) in [
        ("gate.json", to_json(verdict)),
        ("gate.md", to_markdown(verdict)),
        ("junit.xml", to_junit(verdict)),
        ("custom-smaller-is-better.json", to_custom_smaller_is_better(&run.report)),
        ("bencher.json", to_bencher_metric_format(&run.report)),
    ] {
        write_whole(&directory.join(name), text.as_bytes())?;
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
