//! Finds the files of results by the names of scans.
//!
//! ```text
//! NNNNNN.END              the scan of this number, if the data set has one drive; also in data or predictions
//! DRIVE/NNNNNN.END        also in DRIVE/data, DRIVE/predictions, DRIVE/labels, below data or sequences
//! DRIVE.END               a whole drive; also in data
//! ```
//!
//! Numbers have six digits, or ten as in KITTI's raw recordings. If scans are files with other names, these names serve as
//! well; if results have numbers, but none of a scan, the numbers are the positions of the scans.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::annotation::ScanId;
use crate::dataset::folder_name::folder_name;
use crate::dataset::on_disk::{entries_of, name_of};
use crate::dataset::{Dataset, DatasetError};

/// Files are searched for this many folders deep; more files than this are an error.
const MAX_DEPTH: usize = 4;
const MAX_FILES: usize = 1_000_000;

/// Folders of files within the folder of a drive, and folders around the latter.
const INNER_FOLDERS: [&str; 4] = ["", "predictions/", "data/", "labels/"];
const OUTER_FOLDERS: [&str; 3] = ["", "sequences/", "data/"];

/// The files at a path, by their names below it with `/` between folders.
#[derive(Debug, Clone)]
pub struct ResultFiles {
    root: PathBuf,
    paths: BTreeMap<String, PathBuf>,
    folders: BTreeSet<String>,
}

impl ResultFiles {
    /// Finds the files below `root`, or the file `root` itself. Hidden ones are ignored.
    pub fn below(root: &Path) -> Result<Self, DatasetError> {
        let mut files = Self { root: root.to_path_buf(), paths: BTreeMap::new(), folders: BTreeSet::new() };
        if root.is_file() {
            files.paths.insert(name_of(root), root.to_path_buf());
            files.folders.insert(String::new());
        } else {
            files.add_folder(root, "", 0)?;
        }
        Ok(files)
    }

    fn add_folder(&mut self, folder: &Path, name: &str, depth: usize) -> Result<(), DatasetError> {
        for path in entries_of(folder)? {
            let own_name = format!("{name}{}", name_of(&path));
            if !path.is_dir() {
                self.folders.insert(name.to_owned());
                self.paths.insert(own_name, path);
                if self.paths.len() > MAX_FILES {
                    let problem = format!("has more than {MAX_FILES} files; name the folder of the results");
                    return Err(DatasetError::UnusableResults { path: self.root.clone(), problem });
                }
            } else if depth < MAX_DEPTH {
                self.add_folder(&path, &format!("{own_name}/"), depth + 1)?;
            }
        }
        Ok(())
    }

    /// The file or folder that the user named.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// All files with this ending.
    pub fn ending_in<'a>(&'a self, ending: &'a str) -> impl Iterator<Item = (&'a str, &'a Path)> {
        self.paths
            .iter()
            .map(|(name, path)| (name.as_str(), path.as_path()))
            .filter(move |it| it.0.ends_with(ending))
    }

    /// The file of a whole drive.
    pub fn of_drive(&self, drive: &str, ending: &str) -> Option<(&str, &Path)> {
        let drive = folder_name(drive);
        self.first_of(["", "data/"].map(|folder| format!("{folder}{drive}{ending}")))
    }

    /// The file of each scan of `dataset` that has one, by its index in the data set.
    pub fn of_scans(&self, dataset: &dyn Dataset, ending: &str) -> BTreeMap<usize, PathBuf> {
        let mut folders_by_drive: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        let drives: BTreeSet<&str> = dataset.scan_ids().iter().map(|it| it.sequence.as_str()).collect();
        for &drive in &drives {
            folders_by_drive.insert(drive, self.folders_of(drive, drives.len() == 1));
        }
        let found_by = |name_of: &dyn Fn(usize, &ScanId) -> Vec<String>| -> BTreeMap<usize, PathBuf> {
            let ids = dataset.scan_ids().iter().enumerate();
            let found = ids.filter_map(|(scan_idx, id)| {
                let folders = &folders_by_drive[id.sequence.as_str()];
                Some((scan_idx, self.of_scan(folders, &name_of(scan_idx, id), ending)?))
            });
            found.collect()
        };
        let by_name = found_by(&|scan_idx, id| {
            let file_name = dataset.file_name(scan_idx).map(str::to_owned);
            names_of_number(id.index as usize).into_iter().chain(file_name).collect()
        });
        if by_name.is_empty() && dataset.file_name(0).is_some() {
            return found_by(&|scan_idx, _| names_of_number(scan_idx).to_vec());
        }
        by_name
    }

    /// The existing folders that may hold files of scans of `drive`.
    fn folders_of(&self, drive: &str, is_only: bool) -> Vec<String> {
        let drive = folder_name(drive);
        let of_drive =
            OUTER_FOLDERS.map(|outer| INNER_FOLDERS.map(|inner| format!("{outer}{drive}/{inner}")));
        let of_any = is_only.then(|| INNER_FOLDERS.map(str::to_owned));
        let folders = of_drive.into_iter().chain(of_any).flatten();
        folders.filter(|it| self.folders.contains(it)).collect()
    }

    fn of_scan(&self, folders: &[String], names: &[String], ending: &str) -> Option<PathBuf> {
        let paths = folders.iter().flat_map(|folder| {
            names.iter().map(|name| format!("{folder}{name}{ending}")).collect::<Vec<_>>()
        });
        self.first_of(paths).map(|(_, path)| path.to_path_buf())
    }

    fn first_of(&self, names: impl IntoIterator<Item = String>) -> Option<(&str, &Path)> {
        let found = names.into_iter().find_map(|name| self.paths.get_key_value(&name));
        found.map(|(name, path)| (name.as_str(), path.as_path()))
    }

    /// The names of files with this ending that are not among `taken`.
    pub fn left_over(&self, ending: &str, taken: &BTreeSet<&Path>) -> Vec<String> {
        self.ending_in(ending)
            .filter(|(_, path)| !taken.contains(path))
            .map(|(name, _)| name.to_owned())
            .collect()
    }
}

fn names_of_number(number: usize) -> [String; 2] {
    [format!("{number:06}"), format!("{number:010}")]
}

/// Whether `name` is that of the file of a scan or of a drive: a number, or one of `known`, the names of drives as
/// [`folder_name`] writes them and of files of scans.
pub fn is_named_after_scans(name: &str, ending: &str, known: &BTreeSet<String>) -> bool {
    let own_name = name.rsplit('/').next().unwrap_or_default();
    own_name.strip_suffix(ending).is_some_and(|stem| {
        let is_number = !stem.is_empty() && stem.bytes().all(|it| it.is_ascii_digit());
        is_number || known.contains(stem)
    })
}
