//! The format of results, recognised by the files at their path.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use reports::vocabulary::named::named;

use super::result_files::{ResultFiles, is_named_after_scans};
use super::{argoverse2_table, kitti_text, own_files, semantic_labels};
use crate::dataset::folder_name::folder_name;
use crate::dataset::mcap::mcap_dataset::is_mcap;
use crate::dataset::{Dataset, DatasetError};

named! {
    /// A format of results.
    pub enum ResultFormat {
        /// KITTI's text files.
        KittiText = "KITTI's .txt",
        /// A submission of nuScenes.
        NuScenesJson = "nuScenes' .json",
        /// Tables of Argoverse 2.
        Argoverse2Tables = "Argoverse 2's .feather",
        /// `SemanticKITTI`'s labels.
        SemanticLabels = "SemanticKITTI's .label",
        /// What `detect` writes.
        OwnFiles = "scanbench's .csv and .u32",
        /// A recording.
        Recording = ".mcap",
    }
}

impl ResultFormat {
    /// The endings of its files.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::KittiText => &[kitti_text::ENDING],
            Self::NuScenesJson => &[".json"],
            Self::Argoverse2Tables => &[argoverse2_table::ENDING],
            Self::SemanticLabels => &[semantic_labels::ENDING],
            Self::OwnFiles => &own_files::ENDINGS,
            Self::Recording => &[".mcap"],
        }
    }

    /// The files of this format.
    pub fn files<'a>(self, files: &'a ResultFiles, dataset: &dyn Dataset) -> Vec<&'a Path> {
        let drives = dataset.scan_ids().iter().map(|it| folder_name(&it.sequence));
        let file_name = |scan_idx: usize| dataset.file_name(scan_idx).map(str::to_owned);
        let known: BTreeSet<String> =
            drives.chain((0..dataset.scan_ids().len()).filter_map(file_name)).collect();
        let is_one = |name: &str, ending: &str| match self {
            // Other text files are often beside them, such as a readme.
            Self::KittiText => is_named_after_scans(name, ending, &known),
            _ => true,
        };
        let of_ending = |ending: &'static str| {
            files.ending_in(ending).filter(move |(name, _)| is_one(name, ending)).map(|(_, path)| path)
        };
        self.endings().iter().flat_map(|ending| of_ending(ending).collect::<Vec<_>>()).collect()
    }
}

/// The format of `files`, and the only file if the format has just one.
pub fn format_of(
    files: &ResultFiles,
    dataset: &dyn Dataset,
) -> Result<(ResultFormat, PathBuf), DatasetError> {
    let root = files.root();
    let unusable = |problem| DatasetError::UnusableResults { path: root.to_path_buf(), problem };
    if is_mcap(root) {
        return Ok((ResultFormat::Recording, root.to_path_buf()));
    }
    let mut found: Vec<(ResultFormat, Vec<&Path>)> = ResultFormat::ALL
        .into_iter()
        .map(|format| (format, format.files(files, dataset)))
        .filter(|(_, paths)| !paths.is_empty())
        .collect();
    if found.len() > 1 {
        // Output of evaluators is often beside results.
        found.retain(|(format, _)| *format != ResultFormat::NuScenesJson);
    }
    match &found[..] {
        [] => {
            let known = ResultFormat::ALL.map(ResultFormat::name).join(", ");
            Err(unusable(format!("has no results in a known format ({known})")))
        }
        [(format, paths)] => match (format, &paths[..]) {
            (ResultFormat::NuScenesJson | ResultFormat::Recording, [first, second, ..]) => {
                let problem =
                    format!("has several files of results, such as {first:?} and {second:?}; name one");
                Err(unusable(problem))
            }
            (_, paths) => Ok((*format, paths[0].to_path_buf())),
        },
        several => {
            let names: Vec<&str> = several.iter().map(|(format, _)| format.name()).collect();
            Err(unusable(format!(
                "has results in several formats; name the folder of one: {}",
                names.join(", ")
            )))
        }
    }
}
