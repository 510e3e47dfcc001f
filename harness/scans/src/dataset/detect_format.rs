//! Finds the data set at a path, and its format.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use super::DatasetError;
use super::dataset_format::DatasetFormat;
use super::formats::entry_of;
use super::on_disk::entries_of;
use super::scan_folder::folder::{has_labels, is_scan_folder};

/// At most this many folders are searched for one that may not be read.
const MOST_FOLDERS: usize = 1000;
/// No format has its scans further below the folder of the data set.
const MOST_LEVELS: usize = 4;

/// A data set on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundDataset {
    /// Its format.
    pub format: DatasetFormat,
    /// The folder that holds it in the layout of the format, or the file.
    pub path: PathBuf,
}

/// Finds the data set at `path`: `path` itself, a split in it (`training`, else `testing`), or, if it is neither, the
/// only one among the files and folders in it.
///
/// Only `formats` are looked for.
pub fn detect_format(path: &Path, formats: &[DatasetFormat]) -> Result<FoundDataset, DatasetError> {
    let mut found = found_in(path, formats);
    if found.is_empty() && !path.is_file() {
        found = entries_of(path)?.iter().flat_map(|entry| found_in(entry, formats)).collect();
    }
    if found.is_empty() && formats.contains(&DatasetFormat::ScanFolder) && is_scan_folder(path) {
        return Ok(FoundDataset { format: DatasetFormat::ScanFolder, path: path.to_path_buf() });
    }
    if found.is_empty() && path.is_dir() {
        refuse_unreadable(path)?;
    }
    match found.len() {
        0 => Err(DatasetError::UnrecognizedFormat {
            path: path.to_path_buf(),
            formats: formats.iter().map(|format| format.name().to_owned()).collect(),
        }),
        1 => Ok(found.remove(0)),
        _ => {
            let found: Vec<String> =
                found.iter().map(|it| format!("{} {}", it.format, it.path.display())).collect();
            Err(DatasetError::several_datasets(path, &found))
        }
    }
}

/// The folders in which labels of the scan in `file` may lie, as it is named and where it really is: that of the data set
/// around it or, if there is none, its own.
pub fn folders_around(file: &Path) -> Vec<PathBuf> {
    std::path::absolute(file).into_iter().chain(file.canonicalize()).map(|it| folder_around(&it)).collect()
}

fn folder_around(file: &Path) -> PathBuf {
    let folder = file.parent().unwrap_or(file);
    let is_data_set = |it: &&Path| DatasetFormat::ALL.iter().any(|format| (entry_of(*format).is_at)(it));
    let above = folder.ancestors().take(MOST_LEVELS).find(is_data_set);
    above.or(folder.parent().filter(|it| has_labels(it))).unwrap_or(folder).to_owned()
}

/// The formats that fit `path`; if there are none, those that fit its first split with any.
fn found_in(path: &Path, formats: &[DatasetFormat]) -> Vec<FoundDataset> {
    let folders = [path.to_path_buf(), path.join("training"), path.join("testing")];
    let found = folders.into_iter().map(|folder| -> Vec<FoundDataset> {
        let fitting = formats.iter().filter(|format| (entry_of(**format).is_at)(&folder));
        fitting.map(|&format| FoundDataset { format, path: folder.clone() }).collect()
    });
    found.into_iter().find(|found| !found.is_empty()).unwrap_or_default()
}

/// Fails if a folder at `path` or below may not be read, since its content is unknown.
fn refuse_unreadable(path: &Path) -> Result<(), DatasetError> {
    let mut folders = VecDeque::from([path.to_path_buf()]);
    for _ in 0..MOST_FOLDERS {
        let Some(folder) = folders.pop_front() else { break };
        // A link to a folder may lead back.
        let is_folder = |path: &PathBuf| path.is_dir() && !path.is_symlink();
        folders.extend(entries_of(&folder)?.into_iter().filter(is_folder));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes `files`, looks at `path` and compares with format and folder, or a part of the error.
    #[track_caller]
    fn check(files: &[&str], path: &str, expected: Result<(DatasetFormat, &str), &str>) {
        let root = tempfile::tempdir().unwrap();
        for file in files {
            let file = root.path().join(file);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, []).unwrap();
        }
        let found = detect_format(&root.path().join(path), &DatasetFormat::ALL);
        match (found, expected) {
            (Ok(found), Ok((format, folder))) => {
                assert_eq!(found, FoundDataset { format, path: root.path().join(folder) });
            }
            (Err(error), Err(part)) => assert!(error.to_string().contains(part), "{error}"),
            (found, expected) => panic!("{found:?}, expected {expected:?}"),
        }
    }

    const TRACKING: [&str; 2] = ["t/training/velodyne/0000/000000.bin", "t/training/label_02/0000.txt"];
    const OBJECT: [&str; 2] = ["o/training/velodyne/000000.bin", "o/training/label_2/000000.txt"];

    #[test]
    fn the_split_its_parent_and_the_parent_of_that_name_the_same() {
        for path in ["t/training", "t", ""] {
            check(&TRACKING, path, Ok((DatasetFormat::KittiTracking, "t/training")));
        }
        for path in ["o/training", "o", ""] {
            check(&OBJECT, path, Ok((DatasetFormat::KittiObject, "o/training")));
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_may_not_be_read_is_said_to_be_so() {
        use std::os::unix::fs::PermissionsExt as _;
        let root = tempfile::tempdir().unwrap();
        let inner = root.path().join("my/clouds");
        std::fs::create_dir_all(&inner).unwrap();
        let set_mode =
            |mode| std::fs::set_permissions(&inner, std::fs::Permissions::from_mode(mode)).unwrap();
        set_mode(0o000);
        let found = detect_format(root.path(), &DatasetFormat::ALL);
        let is_superuser = std::fs::read_dir(&inner).is_ok();
        set_mode(0o700);
        match found {
            Err(DatasetError::Io { path, source }) => {
                assert_eq!((path, source.kind()), (inner, std::io::ErrorKind::PermissionDenied));
            }
            // The superuser may read all.
            Err(DatasetError::UnrecognizedFormat { .. }) => assert!(is_superuser),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn drives_with_labels_a_point_are_semantic_kitti() {
        let files = ["s/sequences/00/velodyne/000000.bin", "s/sequences/00/labels/000000.label"];
        check(&files, "s", Ok((DatasetFormat::SemanticKitti, "s")));
        check(&files, "", Ok((DatasetFormat::SemanticKitti, "s")));
        check(&files, "s/sequences", Err("has no data set"));
    }

    #[test]
    fn days_drives_versions_and_captures_are_found() {
        let drive = "2011_09_26/2011_09_26_drive_0001_sync/velodyne_points/data/0000000000.bin";
        check(&[drive], "", Ok((DatasetFormat::KittiRaw, "")));
        check(&[drive], "2011_09_26", Ok((DatasetFormat::KittiRaw, "2011_09_26")));
        let tables = ["sample_data", "attribute", "calibrated_sensor", "category", "ego_pose"];
        let tables = tables.map(|it| format!("n/v1.0-mini/{it}.json"));
        let tables: Vec<&str> = tables.iter().map(String::as_str).collect();
        check(&tables, "n", Ok((DatasetFormat::NuScenes, "n")));
        check(&tables, "n/v1.0-mini", Ok((DatasetFormat::NuScenes, "n/v1.0-mini")));
        check(&tables[1..], "n/v1.0-mini", Err("has no data set"));
        let tool = ["s/lidar/000000.pcd", "s/label/000000.json"];
        check(&tool, "s", Ok((DatasetFormat::ScanFolder, "s")));
    }

    #[test]
    fn labels_of_a_scan_lie_in_the_data_set_around_it_or_in_its_folder() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().canonicalize().unwrap();
        for file in
            [&TRACKING[..], &OBJECT, &["mine/clouds/a.pcd", "mine/labels/a.json", "other/a.pcd"]].concat()
        {
            std::fs::create_dir_all(root.join(file).parent().unwrap()).unwrap();
            std::fs::write(root.join(file), []).unwrap();
        }
        for (scan, folder) in [
            (TRACKING[0], "t/training"),
            (OBJECT[0], "o/training"),
            ("mine/clouds/a.pcd", "mine"),
            ("other/a.pcd", "other"),
        ] {
            assert_eq!(folders_around(&root.join(scan)), [root.join(folder), root.join(folder)], "{scan}");
        }
    }

    #[test]
    fn training_comes_before_testing() {
        let files =
            ["testing/velodyne/000000.bin", "testing/calib/000000.txt", "training/label_2/000000.txt"];
        check(&files, "", Ok((DatasetFormat::KittiObject, "training")));
        check(&files[..2], "", Ok((DatasetFormat::KittiObject, "testing")));
    }

    #[test]
    fn of_several_data_sets_one_must_be_named() {
        check(
            &[TRACKING, OBJECT].concat(),
            "",
            Err("has several data sets; give the path of one: kitti-object"),
        );
    }

    #[test]
    fn a_folder_that_fits_two_formats_is_not_guessed() {
        check(&["label_2/000000.txt", "label_02/0000.txt"], "", Err("has several data sets"));
    }

    #[test]
    fn what_is_unknown_is_refused_with_the_formats_looked_for() {
        check(&["a/b.csv"], "", Err("has no data set in a known format (kitti-tracking, kitti-object, "));
        check(&["a/b.csv"], "nowhere", Err("cannot read"));
    }
}
