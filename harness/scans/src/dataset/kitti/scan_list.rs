//! Lists of scans that belong together, as splits of KITTI's object benchmark are published: one number per line.

use std::collections::BTreeSet;
use std::path::Path;

use crate::dataset::DatasetError;
use crate::dataset::text_file::{read_text_file, text_lines};

/// The numbers in the list at `path`, in any order, with or without leading zeros.
pub fn read_scan_list(path: &Path) -> Result<BTreeSet<u32>, DatasetError> {
    let text = read_text_file(path)?;
    let mut numbers = BTreeSet::new();
    for mut line in text_lines(path, &text) {
        let number = line.integer("number of a scan")?;
        line.clone().end()?;
        if !numbers.insert(number) {
            return Err(line.error(format!("has scan {number:06}, which is there already")));
        }
    }
    if numbers.is_empty() {
        return Err(DatasetError::no_scans(path));
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<BTreeSet<u32>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("val.txt");
        std::fs::write(&path, text).unwrap();
        read_scan_list(&path).map_err(|it| it.to_string())
    }

    #[test]
    fn numbers_are_read_whatever_their_order() {
        assert_eq!(read("000004\n000001\r\n\n7").unwrap(), BTreeSet::from([1, 4, 7]));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, expected) in [
            ("1\ntwo", "number of a scan \"two\" is not a valid whole number"),
            ("1\n2 3", "3"),
            ("1\n-2", "\"-2\""),
            ("1\n2\n000001", "has scan 000001, which is there already"),
            ("\n", "val.txt"),
        ] {
            let message = read(text).expect_err("a mistake");
            assert!(message.contains(expected), "{message}");
        }
    }
}
