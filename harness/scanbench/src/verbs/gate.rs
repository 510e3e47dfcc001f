//! `scanbench gate`.

use std::path::Path;

use reports::files::whole_set::WholeSet;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::{SERVICE_FORMATS, VERDICT_FORMATS};
use reports::tables::formats::markdown::Markdown;
use reports::tables::verdict::brief::{Brief, Purpose};
use reports::tables::verdict::summary::InFull;
use reports::verdicts::accept::{TOLERANCES_TOML, run_of_baseline};
use reports::verdicts::classes_of_both::with_classes_of_both;
use reports::verdicts::tolerances::{DriftRule, Tolerances};
use reports::verdicts::tolerances_file::TolerancesError;
use reports::verdicts::verdict::{JudgeError, Verdict, judge_with_streams};

use crate::cli::GateArgs;
use crate::plumbing::failure::{Failure, GateClosed, Usage};
use crate::plumbing::open_run::open_run;
use crate::plumbing::standard_streams::{print_diagnostic, print_error, print_text, terminal};
use crate::plumbing::step_summary::append_to_step_summary;
use crate::plumbing::streams::gated_streams;
use crate::verbs::history::add_to_history;

/// Judges a run by an accepted one, and prints and writes the verdict.
pub fn gate(arguments: &GateArgs) -> Result<(), Failure> {
    let directory = &arguments.baseline.baseline;
    let sides = [open_baseline(directory)?, open_run(&arguments.run)?];
    let [baseline, run] = with_classes_of_both(sides);
    let mut tolerances = tolerances(directory, arguments.tolerances.as_deref(), &baseline)?;
    if let Some(is_allowed) = arguments.allow_drift {
        tolerances.drift = if is_allowed { DriftRule::Warn } else { DriftRule::Fail };
    }
    let sides = [(&baseline, &*run_of_baseline(directory)), (&run, &*arguments.run)];
    let streams = gated_streams(&tolerances, sides)?;
    let judged = judge_with_streams(&baseline, &run, &tolerances, &streams);
    if let Err(JudgeError::NotComparable(_)) = &judged {
        print_diagnostic(format_args!("{}", about_a_new_baseline(arguments)));
    }
    let mut verdict = judged?;
    let remembered = remember(arguments, &run, &mut verdict);
    if let Err(problem) = &remembered {
        verdict.doubts.push(format!("History: {problem}."));
    }
    if let Some(output) = &arguments.output {
        write_verdict(output, &verdict, &run)?;
    }
    append_to_step_summary(&Markdown.text(&verdict))?;
    print_text(&printed(arguments, &verdict))?;
    match verdict.conclusion() {
        passed if passed.is_pass() => remembered,
        closed => {
            if let Err(problem) = remembered {
                print_error(format_args!("error: {problem}"));
            }
            Err(GateClosed(closed).into())
        }
    }
}

/// Adds `run` to the history, and to `verdict` what became of the numbers since an earlier run, as far as that is asked for.
fn remember(arguments: &GateArgs, run: &RunArchive, verdict: &mut Verdict) -> Result<(), Failure> {
    let Some(path) = &arguments.history else { return Ok(()) };
    let history = add_to_history(path, run, &arguments.run, arguments.link.as_deref())?;
    if let Some(wanted) = &arguments.since {
        let since = history.since(wanted, &run.manifest.created, &verdict.tolerances)?;
        verdict.since = Some(since.in_words());
    }
    Ok(())
}

fn printed(arguments: &GateArgs, verdict: &Verdict) -> String {
    let terminal = terminal();
    if arguments.full {
        return terminal.text(&InFull(verdict));
    }
    let [run, baseline] = [&arguments.run, &arguments.baseline.baseline].map(|it| it.display().to_string());
    let in_full = in_full(arguments);
    terminal.text(&Brief { verdict, sides: [&run, &baseline], purpose: Purpose::Gate { in_full: &in_full } })
}

/// What to do if the run is meant to be compared with nothing before it.
fn about_a_new_baseline(arguments: &GateArgs) -> String {
    let word = |path: &Path| shell_word(&path.display().to_string());
    let (run, baseline) = (word(&arguments.run), word(&arguments.baseline.baseline));
    format!(
        "If that is meant, begin anew: scanbench baseline accept {run} --baseline {baseline} --new-baseline --why '…'"
    )
}

/// The command that prints everything.
fn in_full(arguments: &GateArgs) -> String {
    let word = |path: &Path| shell_word(&path.display().to_string());
    let GateArgs { run, baseline, tolerances, allow_drift, .. } = arguments;
    let mut words = vec!["scanbench gate".to_owned(), word(run), "--baseline".to_owned()];
    words.push(word(&baseline.baseline));
    words.extend(tolerances.iter().map(|it| format!("--tolerances {}", word(it))));
    words.extend(allow_drift.map(|is_allowed| format!("--allow-drift={is_allowed}")));
    words.push("--full".to_owned());
    words.join(" ")
}

fn open_baseline(directory: &Path) -> Result<RunArchive, Failure> {
    if !directory.is_dir() {
        return Err(Usage(format!(
            "there is no baseline {}; name a run with --baseline, or make one: scanbench baseline init RUN -o ci",
            directory.display()
        ))
        .into());
    }
    open_run(&run_of_baseline(directory))
}

/// The tolerances of the command line, else those beside the baseline in `directory`, else the built-in ones.
pub fn tolerances(
    directory: &Path,
    of_command_line: Option<&Path>,
    baseline: &RunArchive,
) -> Result<Tolerances, TolerancesError> {
    let beside = directory.join(TOLERANCES_TOML);
    match of_command_line {
        Some(path) => Tolerances::read(path),
        // A link that leads nowhere is an error, and no reason to take others.
        None if beside.symlink_metadata().is_ok() => Tolerances::read(&beside),
        None => Ok(Tolerances::built_in(baseline)),
    }
}

/// Writes all files of the verdict, or none.
fn write_verdict(directory: &Path, verdict: &Verdict, run: &RunArchive) -> Result<(), Failure> {
    let files = WholeSet::within(directory)?;
    for format in VERDICT_FORMATS {
        files.write(&format.file_name("gate"), format.text(verdict).as_bytes())?;
    }
    // These formats are of the numbers that a run of detectors has beside its rows.
    for format in SERVICE_FORMATS.iter().filter(|_| run.manifest.partial.is_none()) {
        files.write(&format.file_name("gate"), format.text(&run.report).as_bytes())?;
    }
    Ok(files.finish()?)
}
