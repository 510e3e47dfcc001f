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
use reports::verdicts::accept::{
    ACCEPTED_RUN, AcceptError, Acceptance, SCORES_MD, Succession, TOLERANCES_TOML, accept,
};
use reports::verdicts::accept_partial::accept_partial;
use reports::verdicts::partial_verdict::BUILT_IN_TOLERANCES;
use reports::verdicts::tolerances::Tolerances;

use crate::cli::{AcceptArgs, BaselineInitArgs};
use crate::commands::failure::{Failure, Usage};
use crate::commands::gate_workflow::{GATE_WORKFLOW, gate_workflow, partial_gate_workflow};
use crate::commands::open_run::open_run;
use crate::commands::partial_verdicts::open_partial;
use crate::commands::provenance::utc_day;
use crate::commands::standard_streams::{print_bytes, print_diagnostic, print_result};

/// Writes what it takes to hold later runs to a run: the run itself, tolerances of all its numbers, and a workflow.
///
/// # Errors
///
/// [`Usage`] if a baseline is there already; if the run cannot be made again, or something cannot be read or written.
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
    print_result(next_steps(folder))
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

    fn accept(&self, folder: &Path, acceptance: Acceptance<'_>) -> Result<String, AcceptError> {
        match self {
            Self::Run(run) => accept(run, folder, acceptance),
            Self::Partial(result) => accept_partial(result, folder, acceptance),
        }
    }
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

fn next_steps(folder: &Path) -> String {
    let folder = folder.display().to_string();
    let folder = shell_word(folder.trim_end_matches('/'));
    format!(
        "{folder}/{ACCEPTED_RUN}/             the accepted run\n\
         {folder}/{SCORES_MD}        what was accepted when, and why\n\
         {folder}/{TOLERANCES_TOML}  how much worse each number may become: change it as you like\n\
         {folder}/{GATE_WORKFLOW}    runs and gates on GitHub, after every push\n\n  \
           mkdir -p .github/workflows && mv {folder}/{GATE_WORKFLOW} .github/workflows/\n  \
           git add .github {folder} && git commit -m 'Gate on the accepted run'\n  \
           scanbench gate runs/latest --baseline {folder}     # after each change"
    )
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
    let accepted = Accepted::open(&arguments.run)?;
    let directory = &arguments.baseline.baseline;
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
