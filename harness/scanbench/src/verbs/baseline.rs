//! `scanbench baseline`.

use std::path::Path;

use jiff::Timestamp;
use reports::run_folder::command_line::{command_again, shell_word};
use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format as _;
use reports::tables::verdict::brief::{Brief, Purpose};
use reports::verdicts::accept::{
    ACCEPTED_RUN, Acceptance, SCORES_MD, Succession, TOLERANCES_TOML, accept, refuse_uncommitted,
};
use reports::verdicts::annotated_tolerances::built_in_file;
use reports::verdicts::classes_of_both::with_classes_of_both;
use reports::verdicts::least_loss::least_losses;
use reports::verdicts::tolerances::Tolerances;
use reports::verdicts::verdict::{JudgeError, judge_with_streams};

use crate::cli::{AcceptArgs, BaselineInitArgs};
use crate::plumbing::failure::{Failure, Usage, WorseThanAccepted};
use crate::plumbing::open_run::open_run;
use crate::plumbing::provenance::utc_day;
use crate::plumbing::standard_streams::{print_diagnostic, print_result, print_text, terminal};
use crate::plumbing::streams::gated_streams;
use crate::verbs::gate::tolerances;
use crate::verbs::gate_workflow::{GATE_WORKFLOW, gate_workflow};
use crate::verbs::history::add_to_history;

/// Writes the baseline that later runs are held to: the run itself, tolerances of all its numbers, and a workflow.
pub fn baseline_init(arguments: &BaselineInitArgs) -> Result<(), Failure> {
    let folder = &arguments.output;
    for name in [ACCEPTED_RUN, SCORES_MD, TOLERANCES_TOML, GATE_WORKFLOW] {
        refuse_existing(&folder.join(name))?;
    }
    let run = open_run(&arguments.run)?;
    let beside =
        [(TOLERANCES_TOML, built_in_file(&run)), (GATE_WORKFLOW, gate_workflow(&run.manifest, folder)?)];
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: "the first accepted run",
        succession: Succession::Comparable,
    };
    accept(&run, folder, acceptance, &beside)?;
    let losses =
        least_losses(&run, &Tolerances::built_in(&run)).lines().into_iter().map(|it| format!("\n{it}"));
    print_result(format!("{}\n{}", next_steps(folder, &arguments.run), losses.collect::<String>()).trim_end())
}

/// Verdict on `run`, which lies in `path`, against the run `before`, which is accepted in the baseline `directory`; `None` if
/// they cannot be compared.
fn judged_by(
    directory: &Path,
    before: RunArchive,
    run: &RunArchive,
    path: &Path,
) -> Result<Option<Judged>, Failure> {
    let [before, run] = with_classes_of_both([before, run.clone()]);
    let tolerances = tolerances(directory, None, &before)?;
    let streams = gated_streams(&tolerances, [(&before, &directory.join(ACCEPTED_RUN)), (&run, path)])?;
    let verdict = match judge_with_streams(&before, &run, &tolerances, &streams) {
        Ok(verdict) => verdict,
        // Whether it may follow all the same is decided when it is accepted.
        Err(JudgeError::NotComparable(_)) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let sides = [path, directory].map(|it| it.display().to_string());
    let brief = Brief { verdict: &verdict, sides: [&sides[0], &sides[1]], purpose: Purpose::Accept };
    let n_worse = verdict.n_worse();
    Ok(Some(Judged { text: terminal().text(&brief), n_worse, n_sure: n_worse - verdict.n_unsure() }))
}

/// A verdict on a run that is to be accepted.
struct Judged {
    text: String,
    n_worse: usize,
    /// How many of them surely.
    n_sure: usize,
}

fn refuse_existing(path: &Path) -> Result<(), Failure> {
    if !path.exists() {
        return Ok(());
    }
    Err(Usage(format!(
        "{path:?} exists; name another folder, or accept the run instead of the one before: scanbench baseline accept"
    ))
    .into())
}

fn next_steps(folder: &Path, run: &Path) -> String {
    let run = shell_word(&run.display().to_string());
    let folder = folder.display().to_string();
    let folder = shell_word(folder.trim_end_matches('/'));
    format!(
        "{folder}/{ACCEPTED_RUN}/             the accepted run\n\
         {folder}/{SCORES_MD}        what was accepted when, and why\n\
         {folder}/{TOLERANCES_TOML}  how much worse each number may become: change it as you like\n\
         {folder}/{GATE_WORKFLOW}    runs and gates on GitHub, after every push\n\n  \
           mkdir -p .github/workflows && mv {folder}/{GATE_WORKFLOW} .github/workflows/\n  \
           git add .github {folder} && git commit -m 'Gate on the accepted run'\n  \
           scanbench gate {run} --baseline {folder}     # after each change"
    )
}

/// Makes a run the one that others are judged by.
pub fn baseline_accept(arguments: &AcceptArgs) -> Result<(), Failure> {
    if arguments.why.trim().is_empty() {
        return Err(Usage("--why is empty; say why the scores changed".to_owned()).into());
    }
    let run = open_run(&arguments.run)?;
    let directory = &arguments.baseline.baseline;
    refuse_uncommitted(run.manifest.git.as_ref())?;
    let mut changed_command = None;
    if let Ok(before) = RunArchive::read(&directory.join(ACCEPTED_RUN)) {
        changed_command = command_if_changed(&before, &run);
        if let Some(judged) = judged_by(directory, before, &run, &arguments.run)? {
            print_text(&judged.text)?;
            if judged.n_worse > 0 && !arguments.worse {
                let Judged { n_worse, n_sure, .. } = judged;
                return Err(WorseThanAccepted { n_worse, n_sure }.into());
            }
        }
    }
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: &arguments.why,
        succession: if arguments.new_baseline { Succession::Anew } else { Succession::Comparable },
    };
    let line = accept(&run, directory, acceptance, &[])?;
    print_text(&format!("{line}\n"))?;
    if let Some(history) = &arguments.history {
        add_to_history(history, &run, &arguments.run, arguments.link.as_deref())?;
    }
    print_diagnostic(format_args!("Baseline: {}", directory.display()));
    if let Some(command) = changed_command {
        print_diagnostic(format_args!(
            "The command of the run has changed. Where the one before stands, as in a workflow, it has to be this now:\n  {command}"
        ));
    }
    Ok(())
}

/// The command that makes `run` again, if the one accepted before was made by another.
fn command_if_changed(before: &RunArchive, run: &RunArchive) -> Option<String> {
    let [before, run] = [before, run].map(|it| command_again(&it.manifest.argv, "runs/gate"));
    (before != run).then_some(run)
}
