//! Origins of the scans of KITTI's object benchmark: their raw drives and times, as the development kit lists them.
//!
//! ```text
//! mapping/train_rand.txt      numbers with commas between them: the i-th, from 0, is the line of scan i
//! mapping/train_mapping.txt   lines, from 1: date, drive, number of the scan within the drive from 0, such as
//!                             2011_09_26 2011_09_26_drive_0005_sync 0000000109
//! ```

use std::path::{Path, PathBuf};

use crate::dataset::DatasetError;
use crate::dataset::text_file::{TextLine, quoted, read_text_file, text_lines};

/// The folders beside the split that may hold both files: the kit unpacked there, with or without a folder of its own.
const FOLDERS: [&str; 2] = ["mapping", "devkit_object/mapping"];
/// The file with a line for each scan.
const MAPPING: &str = "train_mapping.txt";
/// The file with a permutation of the lines.
const RAND: &str = "train_rand.txt";

/// KITTI's scanner turns ten times a second.
const SCAN_PERIOD_NS: u64 = 100_000_000;

/// The raw scan that is a scan of the benchmark.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct RawScan {
    /// The drive, such as `2011_09_26_drive_0005_sync`.
    pub drive: String,
    /// When it was taken, in nanoseconds since the first scan of the drive.
    pub time_ns: u64,
}

/// Raw scans by their numbers in the benchmark.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawMapping {
    scans: Vec<RawScan>,
    rand: PathBuf,
}

impl RawMapping {
    /// The mapping beside the split `training`; `None` if there is none, or for another split, since no other has a mapping.
    pub fn beside(split: &Path) -> Result<Option<Self>, DatasetError> {
        // `.` and `..` have no name of their own, and a folder with this name may be a link to another one.
        let canonical = split.canonicalize().unwrap_or_else(|_| split.to_path_buf());
        let splits = [split, canonical.as_path()]
            .into_iter()
            .filter(|it| it.file_name().is_some_and(|it| it == "training"));
        let folders = splits.filter_map(Path::parent).flat_map(|parent| FOLDERS.map(|it| parent.join(it)));
        let has_any = |it: &PathBuf| [MAPPING, RAND].iter().any(|name| it.join(name).exists());
        { folders }.find(has_any).map(|it| Self::read(&it)).transpose()
    }

    fn read(folder: &Path) -> Result<Self, DatasetError> {
        let [mapping_path, rand_path] = [MAPPING, RAND].map(|it| folder.join(it));
        let [mapping, rand] = [read_text_file(&mapping_path)?, read_text_file(&rand_path)?];
        let raw_scans: Vec<RawScan> =
            text_lines(&mapping_path, &mapping).map(raw_scan).collect::<Result<_, _>>()?;
        let of_line = |(scan, line): (usize, &str)| {
            let problem = |problem: String| DatasetError::Line { path: rand_path.clone(), line: 1, problem };
            let line_number: usize = line.trim().parse().map_err(|_| {
                problem(format!("the line of scan {scan:06}, {}, is not a valid whole number", quoted(line)))
            })?;
            let raw_scan = line_number.checked_sub(1).and_then(|it| raw_scans.get(it));
            raw_scan.cloned().ok_or_else(|| {
                problem(format!(
                    "scan {scan:06} is in line {line_number} of {MAPPING}, which has {} lines",
                    raw_scans.len()
                ))
            })
        };
        let numbers = rand.trim().trim_end_matches(',').split(',').enumerate();
        let scans = numbers.map(of_line).collect::<Result<_, _>>()?;
        Ok(Self { scans, rand: rand_path })
    }

    /// The raw scan that scan `number` is.
    pub fn raw_scan(&self, number: u32) -> Result<&RawScan, DatasetError> {
        self.scans.get(number as usize).ok_or_else(|| DatasetError::Line {
            path: self.rand.clone(),
            line: 1,
            problem: format!("has {} numbers, and none of scan {number:06}", self.scans.len()),
        })
    }
}

fn raw_scan(mut line: TextLine<'_>) -> Result<RawScan, DatasetError> {
    line.word("date")?;
    let drive = line.word("drive")?.to_owned();
    let number: u32 = line.integer("number of the scan")?;
    line.end()?;
    Ok(RawScan { drive, time_ns: u64::from(number) * SCAN_PERIOD_NS })
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: &str = "2011_09_26 2011_09_26_drive_0001_sync 0000000007\n\
        2011_09_26 2011_09_26_drive_0005_sync 0000000109\n2011_09_28 2011_09_28_drive_0106_sync 0000000048\n";

    /// The mapping of these files in `folder` beside the split `split`.
    fn read(folder: &str, split: &str, files: [Option<&str>; 2]) -> Result<Option<RawMapping>, String> {
        let root = tempfile::tempdir().unwrap();
        let [mapping_folder, split] = [folder, split].map(|it| root.path().join(it));
        for folder in [&mapping_folder, &split] {
            std::fs::create_dir_all(folder).unwrap();
        }
        for (name, text) in [MAPPING, RAND].into_iter().zip(files) {
            if let Some(text) = text {
                std::fs::write(mapping_folder.join(name), text).unwrap();
            }
        }
        RawMapping::beside(&split).map_err(|it| it.to_string())
    }

    #[test]
    fn the_permutation_says_which_line_is_of_which_scan() {
        for folder in FOLDERS {
            let mapping = read(folder, "training", [Some(THREE), Some("3, 1,2\n")]).unwrap().unwrap();
            let raw = |number| {
                let raw = mapping.raw_scan(number).map_err(|it| it.to_string())?;
                Ok::<_, String>((raw.drive.as_str(), raw.time_ns))
            };
            assert_eq!(raw(0), Ok(("2011_09_28_drive_0106_sync", 4_800_000_000)));
            assert_eq!(raw(1), Ok(("2011_09_26_drive_0001_sync", 700_000_000)));
            assert_eq!(raw(2), Ok(("2011_09_26_drive_0005_sync", 10_900_000_000)));
            let message = raw(3).unwrap_err();
            assert!(message.ends_with("line 1: has 3 numbers, and none of scan 000003"), "{message}");
        }
    }

    #[test]
    fn no_other_split_and_no_other_folder_has_a_mapping() {
        assert_eq!(read("mapping", "testing", [Some(THREE), Some("3,1,2")]), Ok(None));
        assert_eq!(read("training/mapping", "training", [Some(THREE), Some("3,1,2")]), Ok(None));
        assert_eq!(read("mapping", "training", [None, None]), Ok(None));
    }

    #[cfg(unix)]
    #[test]
    fn the_split_may_be_a_link_beside_the_kit() {
        let root = tempfile::tempdir().unwrap();
        let [kit, data] = ["kitti/mapping", "disk/objects"].map(|it| root.path().join(it));
        for made in [&kit, &data] {
            std::fs::create_dir_all(made).unwrap();
        }
        std::fs::write(kit.join(MAPPING), THREE).unwrap();
        std::fs::write(kit.join(RAND), "3,1,2").unwrap();
        let split = root.path().join("kitti/training");
        std::os::unix::fs::symlink(&data, &split).unwrap();
        assert!(RawMapping::beside(&split).unwrap().is_some());
    }

    #[test]
    fn damaged_files_are_refused_with_their_position() {
        for (mapping, rand, expected) in [
            (Some(THREE), None, "train_rand.txt"),
            (None, Some("1"), "train_mapping.txt"),
            (Some(THREE), Some("3,4,1"), "scan 000001 is in line 4 of train_mapping.txt, which has 3 lines"),
            (Some(THREE), Some("0"), "scan 000000 is in line 0 of train_mapping.txt, which has 3 lines"),
            (Some(THREE), Some("1,x"), "the line of scan 000001, \"x\", is not a valid whole number"),
            (Some("2011_09_26 drive\n"), Some("1"), "line 1: ends before its number of the scan"),
            (Some("a b 1\na b c\n"), Some("1"), "line 2: number of the scan \"c\" is not a valid whole"),
        ] {
            let message = read("mapping", "training", [mapping, rand]).expect_err("it is damaged");
            assert!(message.contains(expected), "{message}");
        }
    }
}
