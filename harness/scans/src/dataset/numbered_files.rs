//! Folders of files that are named after numbers, such as `000123.bin`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::DatasetError;

/// The numbers of the files `NNNNNN.extension` in `folder`.
///
/// Files with other extensions and hidden files are not looked at.
///
/// A file of this extension that is not named after a number of six digits is refused, since its place among the others cannot
/// be known.
pub fn numbered_files(folder: &Path, extension: &str) -> Result<BTreeSet<u32>, DatasetError> {
    let io_error = |source| DatasetError::Io { path: folder.to_path_buf(), source };
    let mut numbers = BTreeSet::new();
    for entry in std::fs::read_dir(folder).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if is_hidden(&path) || path.extension().is_none_or(|it| it != extension) {
            continue;
        }
        let number = number_of(&path)
            .ok_or(DatasetError::FileName { path, expected: "a number of six digits, such as 000123" })?;
        numbers.insert(number);
    }
    Ok(numbers)
}

/// The file of `number` in `folder`.
pub fn numbered_file(folder: &Path, number: u32, extension: &str) -> PathBuf {
    folder.join(format!("{number:06}.{extension}"))
}

/// Whether the name begins with a dot, as those of the copies that some systems leave beside a file.
pub fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn number_of(path: &Path) -> Option<u32> {
    let stem = path.file_stem()?.to_str()?;
    let number = stem.parse().ok()?;
    (stem == format!("{number:06}")).then_some(number)
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
        let numbers = numbered_files(folder.path(), "bin");
        match expected {
            Some(expected) => assert!(numbers.unwrap().iter().eq(expected)),
            None => assert!(matches!(numbers, Err(DatasetError::FileName { .. })), "{names:?}"),
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
