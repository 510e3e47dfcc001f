//! `scanbench baseline`.

use std::io::Write as _;
use std::path::Path;

use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::files::new_folders::NewFolders;
use reports::files::whole_file::WholeFile;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::partial_archive::PartialArchive;
use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format as _;
use reports::tables::verdict::brief::{Brief, Purpose};
use reports::tables::verdict::partial_comparison::{PartialSummary, SummaryExtent};
use reports::verdicts::accept::{
    ACCEPTED_RUN, AcceptError, Acceptance, SCORES_MD, Succession, TOLERANCES_TOML, accept, refuse_uncommitted,
};
use reports::verdicts::accept_partial::accept_partial;
use reports::verdicts::least_loss::least_losses;
use reports::verdicts::partial_verdict::{BUILT_IN_TOLERANCES, judge_partial};
use reports::verdicts::tolerances::Tolerances;
use reports::verdicts::verdict::{JudgeError, judge_successor};

use crate::cli::{AcceptArgs, BaselineInitArgs};
use crate::commands::failure::{Failure, Usage, WorseThanAccepted};
use crate::commands::gate::tolerances;
use crate::commands::gate_workflow::{GATE_WORKFLOW, gate_workflow, partial_gate_workflow};
use crate::commands::open_run::open_run;
use crate::commands::partial_verdicts::{open_partial, partial_tolerances};
use crate::commands::provenance::utc_day;
use crate::commands::standard_streams::{print_bytes, print_diagnostic, print_result, terminal};

/// Writes what it takes to hold later runs to a run: the run itself, tolerances of all its numbers, and a workflow.
pub fn baseline_init(arguments: &BaselineInitArgs) -> Result<(), Failure> {
    let folder = &arguments.output;
    for name in [ACCEPTED_RUN, SCORES_MD, TOLERANCES_TOML, GATE_WORKFLOW] {
        refuse_existing(&folder.join(name))?;
    }
    let accepted = Accepted::open(&arguments.run)?;
    // Whatever fails from here on leaves nothing behind.
    let _folders =
        NewFolders::create(folder).map_err(|source| ArchiveError::Write { path: folder.clone(), source })?;
    let tolerances = begun(&folder.join(TOLERANCES_TOML), &accepted.tolerances())?;
    let workflow = begun(&folder.join(GATE_WORKFLOW), &accepted.workflow(folder))?;
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: "the first accepted run",
        succession: Succession::Comparable,
    };
    accepted.accept(folder, acceptance)?;
    tolerances.finish()?;
    workflow.finish()?;
    let losses = accepted.least_losses().into_iter().map(|it| format!("\n{it}"));
    print_result(format!("{}\n{}", next_steps(folder, &arguments.run), losses.collect::<String>()).trim_end())
}

/// What others are held to.
enum Accepted {
    /// A run of detectors.
    Run(Box<RunArchive>),
    /// A result of `scanbench partial`.
    Partial(Box<PartialArchive>),
}

impl Accepted {
    fn open(directory: &Path) -> Result<Self, Failure> {
        if PartialArchive::is_partial(directory) {
            return Ok(Self::Partial(Box::new(open_partial(directory)?)));
        }
        Ok(Self::Run(Box::new(open_run(directory)?)))
    }

    fn tolerances(&self) -> String {
        match self {
            Self::Run(run) => Tolerances::built_in(run).annotated(),
            Self::Partial(_) => BUILT_IN_TOLERANCES.to_owned(),
        }
    }

    fn workflow(&self, folder: &Path) -> String {
        match self {
            Self::Run(run) => gate_workflow(&run.manifest, folder),
            Self::Partial(result) => partial_gate_workflow(&result.manifest, folder),
        }
    }

    fn refuse_uncommitted(&self) -> Result<(), AcceptError> {
        refuse_uncommitted(match self {
            Self::Run(run) => run.manifest.git.as_ref(),
            Self::Partial(result) => result.manifest.git.as_ref(),
        })
    }

    /// What comes of it beside what was accepted before in the baseline `directory`; `None` if there is nothing that it can
    /// be compared with. It lies in `path`.
    fn judged_by(&self, directory: &Path, path: &Path) -> Result<Option<Judged>, Failure> {
        let target = directory.join(ACCEPTED_RUN);
        match self {
            Self::Run(run) => {
                let Ok(before) = RunArchive::read(&target) else { return Ok(None) };
                let tolerances = tolerances(directory, None, &before)?;
                let verdict = match judge_successor(&before, run, &tolerances) {
                    Ok(verdict) => verdict,
                    // Whether it may follow all the same is asked by whoever accepts it.
                    Err(JudgeError::NotComparable(_)) => return Ok(None),
                    Err(error) => return Err(error.into()),
                };
                let sides = [path, directory].map(|it| it.display().to_string());
                let brief =
                    Brief { verdict: &verdict, sides: [&sides[0], &sides[1]], purpose: Purpose::Accept };
                Ok(Some(Judged { text: terminal().text(&brief), n_worse: verdict.n_worse() }))
            }
            Self::Partial(result) => {
                let Ok(before) = PartialArchive::read(&target) else { return Ok(None) };
                let tolerances = partial_tolerances(directory, None)?;
                let Ok(verdict) = judge_partial(&before, result, &tolerances) else { return Ok(None) };
                let summary = PartialSummary { verdict: &verdict, extent: SummaryExtent::Accept };
                Ok(Some(Judged { text: terminal().text(&summary), n_worse: verdict.n_worse() }))
            }
        }
    }

    /// Which losses it will show, line by line.
    fn least_losses(&self) -> Vec<String> {
        match self {
            Self::Run(run) => least_losses(run, &Tolerances::built_in(run)).lines(),
            Self::Partial(_) => Vec::new(),
        }
    }

    fn accept(&self, folder: &Path, acceptance: Acceptance<'_>) -> Result<String, AcceptError> {
        match self {
            Self::Run(run) => accept(run, folder, acceptance),
            Self::Partial(result) => accept_partial(result, folder, acceptance),
        }
    }
}

/// A verdict on what is to be accepted.
struct Judged {
    text: String,
    n_worse: usize,
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

/// A file with all of its content, but not yet with its name.
fn begun(path: &Path, content: &str) -> Result<WholeFile, ArchiveError> {
    let mut file = WholeFile::create(path)?;
    let written = file.write_all(content.as_bytes());
    written.map_err(|source| ArchiveError::Write { path: path.to_path_buf(), source })?;
    Ok(file)
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
    let accepted = Accepted::open(&arguments.run)?;
    let directory = &arguments.baseline.baseline;
    accepted.refuse_uncommitted()?;
    if let Some(judged) = accepted.judged_by(directory, &arguments.run)? {
        print_bytes(judged.text.as_bytes())?;
        if judged.n_worse > 0 && !arguments.worse {
            return Err(WorseThanAccepted { n_worse: judged.n_worse }.into());
        }
    }
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: &arguments.why,
        succession: if arguments.new_baseline { Succession::Anew } else { Succession::Comparable },
    };
    let line = accepted.accept(directory, acceptance)?;
    print_bytes(format!("{line}\n").as_bytes())?;
    print_diagnostic(format_args!("Baseline: {}", directory.display()));
    Ok(())
}
