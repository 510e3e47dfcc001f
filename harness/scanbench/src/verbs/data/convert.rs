//! `scanbench data convert` and `scanbench data simulate`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use evaluation::run::side_by_side::RunError;
use reports::files::new_folders::NewFolders;
use scans::conversion::ConversionError;
use scans::conversion::convert::{Output, convert};
use scans::conversion::output_format::OutputFormat;
use scans::dataset::class_table::ClassTable;
use scans::dataset::folder_name::folder_name;

use crate::cli::ConvertArgs;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;

pub fn data_convert(arguments: &ConvertArgs) -> Result<(), Failure> {
    convert_all(
        arguments,
        &open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &ClassTable::default())?,
    )
}

pub fn data_simulate(arguments: &ConvertArgs) -> Result<(), Failure> {
    let opened = open_datasets(&arguments.data, &ClassTable::default())?;
    if let Some(recorded) = opened.iter().map(|it| it.dataset.description()).find(|it| it.root.is_some()) {
        let problem =
            format!("{:?} is already on disk; use `data convert` to change its format", recorded.id);
        return Err(Usage(problem).into());
    }
    convert_all(arguments, &opened)
}

fn convert_all(arguments: &ConvertArgs, opened: &[OpenedDataset]) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let format = format_of(arguments, opened.len())?;
    let _new_folders = (opened.len() > 1).then(|| folder_of_several(&arguments.output)).transpose()?;
    for (opened, path) in opened.iter().zip(paths_of(arguments, format, opened)) {
        let output = Output { path: &path, format, compression: arguments.compression.compression() };
        let n_scans = opened.scan_indices.len();
        let progress = progress_over_scans(n_scans, &opened.dataset.description().id);
        let mut n_done = 0;
        let policy = arguments.damage.policy();
        let on_damage = |id: &_, error| progress.suspend(|| opened.on_damage(policy, id, error));
        convert(&*opened.dataset, &opened.scan_indices, output, on_damage, || -> Result<(), Failure> {
            progress.inc(1);
            n_done += 1;
            if interrupted.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted { n_done, n_scans }.into());
            }
            Ok(())
        })?;
        progress.finish_and_clear();
        opened.warn_of_points_left_out();
        let simulated = if opened.dataset.description().is_simulated() { ", simulated" } else { "" };
        print_result(format_args!("{}  {n_done} scans  {format}{simulated}", path.display()))?;
    }
    Ok(())
}

fn format_of(arguments: &ConvertArgs, n_datasets: usize) -> Result<OutputFormat, Usage> {
    let says_mcap = arguments.output.extension().is_some_and(|it| it.eq_ignore_ascii_case("mcap"));
    match arguments.to {
        Some(name) => Ok(name.format()),
        None if says_mcap && n_datasets == 1 => Ok(OutputFormat::Mcap),
        None => Err(Usage(
            "choose the format with --to: mcap, kitti-tracking, kitti-object or semantic-kitti".to_owned(),
        )),
    }
}

/// Makes the folder for several data sets; it is removed again if none is written.
pub fn folder_of_several(folder: &Path) -> Result<NewFolders, ConversionError> {
    NewFolders::create(folder).map_err(|source| ConversionError::Write { path: folder.to_path_buf(), source })
}

fn paths_of(arguments: &ConvertArgs, format: OutputFormat, opened: &[OpenedDataset]) -> Vec<PathBuf> {
    let folder = &arguments.output;
    if let [_] = opened {
        return vec![folder.clone()];
    }
    let ending = if format == OutputFormat::Mcap { ".mcap" } else { "" };
    let path = |it: &OpenedDataset| {
        Path::new(folder).join(format!("{}{ending}", folder_name(&it.dataset.description().id)))
    };
    opened.iter().map(path).collect()
}
