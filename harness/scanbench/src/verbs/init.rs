//! `scanbench init`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;
use evaluation::run::side_by_side::RunError;
use reports::files::archive::ArchiveError;
use reports::files::new_folders::NewFolders;
use reports::files::whole_set::WholeSet;
use reports::run_folder::command_line::shell_word;
use scans::conversion::convert::{Output, convert};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use crate::plumbing::empty_folder::refuse_occupied;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;

/// Arguments of `scanbench init`.
#[derive(Debug, Args)]
#[command(after_help = INIT_EXAMPLES)]
pub struct InitArgs {
    /// Folder to write; a new or empty one
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

const INIT_EXAMPLES: &str = "\
Examples:
  scanbench init my-detector
  cd my-detector && scanbench run data/street -d cells,hierarchical

Writes a small detector in Python, a scanbench.toml that names it, a simulated street
with labels in KITTI's format, and a workflow for GitHub that runs `scanbench gate`.
Detectors in Python need the package: pip install ./harness/python in a checkout of
scanbench. No package index has it.";

/// The files beside the data, by their path in the folder.
const TEMPLATE: [(&str, &str); 6] = [
    ("scanbench.toml", include_str!("init_template/scanbench.toml")),
    ("detector.py", include_str!("init_template/detector.py")),
    ("tolerances.toml", include_str!("init_template/tolerances.toml")),
    ("README.md", include_str!("init_template/README.md")),
    (".gitignore", include_str!("init_template/.gitignore")),
    (".github/workflows/gate.yml", include_str!("init_template/.github/workflows/gate.yml")),
];

/// Where the scans go. The workflow of the template makes the same ones again.
const DATA: &str = "data/street";
const STREET: &str = "street-narrow";
/// Few enough beams that twenty scans are small, and enough to classify objects.
const SENSOR: &str = "hdl-32e";

/// Writes a folder with a detector to begin with, scans and labels to judge it by, and what a gate needs.
pub fn init(arguments: &InitArgs) -> Result<(), Failure> {
    let folder = &arguments.folder;
    refuse_occupied(folder)?;
    // All files are on the disk before any takes its name. The scans, which take longest, are the first to do so.
    let files = WholeSet::within(folder)?;
    TEMPLATE.iter().try_for_each(|(name, content)| files.write(name, content.as_bytes()))?;
    let data = folder.join(DATA);
    let _folders = data.parent().map(new_folder).transpose()?;
    let n_scans = write_street(&data)?;
    if let Err(error) = files.finish() {
        // The scans are of no use without the other files.
        let _ = std::fs::remove_dir_all(&data);
        return Err(error.into());
    }
    print_result(next_steps(folder, n_scans))
}

fn new_folder(folder: &Path) -> Result<NewFolders, ArchiveError> {
    NewFolders::create(folder).map_err(|source| ArchiveError::Write { path: folder.to_path_buf(), source })
}

/// Simulates the street and writes it to `path`; returns the number of scans.
fn write_street(path: &Path) -> Result<usize, Failure> {
    let interrupted = interruption_flag();
    let options = OpenOptions { sensor: Some(SENSOR.to_owned()), ..OpenOptions::default() };
    let street = open_dataset(STREET, &options, &built_in_catalogue()?)?;
    let n_scans = street.scan_ids().len();
    let scan_indices: Vec<usize> = (0..n_scans).collect();
    let output = Output { path, format: OutputFormat::KittiTracking, compression: ChunkCompression::None };
    let progress = progress_over_scans(n_scans, STREET);
    let mut n_done = 0;
    convert(
        &*street,
        &scan_indices,
        output,
        |_, error| Err(error),
        || -> Result<(), Failure> {
            progress.inc(1);
            n_done += 1;
            if interrupted.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted { n_done, n_scans }.into());
            }
            Ok(())
        },
    )?;
    progress.finish_and_clear();
    Ok(n_scans)
}

fn next_steps(folder: &Path, n_scans: usize) -> String {
    let (folder, word) = (folder.display(), shell_word(&folder.display().to_string()));
    format!(
        "{folder}: a detector in Python, and {n_scans} simulated scans with labels.\n\n  \
           cd {word}\n  \
           pip install CHECKOUT/harness/python          # the package for detectors in Python; CHECKOUT is scanbench's source\n  \
           scanbench run {DATA} -d cells,hierarchical   # a row for yours, and one for ours\n\n\
         {folder}/README.md goes on from there: look at mistakes, sweep parameters, gate changes."
    )
}
