//! Folders of files that are named after numbers, such as `000123.bin`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::DatasetError;
use super::on_disk::{entries_of, has_extension};

/// How a format writes numbers in names of files.
#[derive(Debug, Clone, Copy)]
pub struct Digits {
    n: usize,
    said: &'static str,
}

/// Digits in most of KITTI's benchmarks.
pub const SIX_DIGITS: Digits = Digits { n: 6, said: "a number of six digits, such as 000123" };

/// Digits in KITTI's raw recordings.
pub const TEN_DIGITS: Digits = Digits { n: 10, said: "a number of ten digits, such as 0000000123" };

/// The numbers of the files `NNNNNN.extension` in `folder`.
///
/// Files with other extensions and hidden files are ignored. A file of this extension with another kind of name is refused,
/// since its index among the others cannot be known.
pub fn numbered_files(folder: &Path, extension: &str, digits: Digits) -> Result<BTreeSet<u32>, DatasetError> {
    let files = entries_of(folder)?.into_iter().filter(|it| has_extension(it, extension));
    files
        .map(|path| number_of(&path, digits).ok_or_else(|| DatasetError::file_name(path, digits.said)))
        .collect()
}

/// The file of `number` in `folder`.
pub fn numbered_file(folder: &Path, number: u32, extension: &str) -> PathBuf {
    folder.join(format!("{number:06}.{extension}"))
}

fn number_of(path: &Path, digits: Digits) -> Option<u32> {
    let stem = path.file_stem()?.to_str()?;
    let number = stem.parse().ok()?;
    (stem == format!("{number:0width$}", width = digits.n)).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(names: &[&str], expected: Option<&[u32]>) {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), []).unwrap();
        }
        let numbers = numbered_files(folder.path(), "bin", SIX_DIGITS);
        match expected {
            Some(expected) => assert!(numbers.unwrap().iter().eq(expected)),
            None => assert!(numbers.unwrap_err().to_string().contains("has a wrong name"), "{names:?}"),
        }
    }

    #[test]
    fn numbers_ascend() {
        check(&["000010.bin", "000002.bin", "1234567.bin"], Some(&[2, 10, 1_234_567]));
    }

    #[test]
    fn other_files_are_not_looked_at() {
        check(&["000010.bin", "000011.txt", "._000010.bin", "readme"], Some(&[10]));
    }

    #[test]
    fn names_that_are_no_numbers_are_refused() {
        check(&["scan.bin"], None);
        check(&["10.bin"], None);
        check(&["+00010.bin"], None);
        check(&["99999999999.bin"], None);
    }
}
