//! `scanbench baseline`.

use std::io::Write as _;
use std::path::Path;

use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::files::new_folders::NewFolders;
use reports::files::whole_file::WholeFile;
use reports::run_folder::command_line::shell_word;
use reports::verdicts::accept::{ACCEPTED_RUN, Acceptance, SCORES_MD, Succession, TOLERANCES_TOML, accept};
use reports::verdicts::tolerances::Tolerances;

use crate::cli::{AcceptArgs, BaselineInitArgs};
use crate::commands::failure::{Failure, Usage};
use crate::commands::gate_workflow::{GATE_WORKFLOW, gate_workflow};
use crate::commands::open_run::open_run;
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
    let run = open_run(&arguments.run)?;
    // Whatever fails from here on leaves nothing behind.
    let _folders =
        NewFolders::create(folder).map_err(|source| ArchiveError::Write { path: folder.clone(), source })?;
    let tolerances = begun(&folder.join(TOLERANCES_TOML), &Tolerances::built_in(&run).annotated())?;
    let workflow = begun(&folder.join(GATE_WORKFLOW), &gate_workflow(&run.manifest, folder))?;
    let acceptance = Acceptance {
        date: &utc_day(Timestamp::now()),
        why: "the first accepted run",
        succession: Succession::Comparable,
    };
    accept(&run, folder, acceptance)?;
    tolerances.finish()?;
    workflow.finish()?;
    print_result(next_steps(folder))
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
