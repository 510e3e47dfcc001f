//! Sizes of the files of scans. Missing files, such as targets of links of git-annex or DVC before they are fetched, are
//! refused by name, not ignored.

use std::path::{Path, PathBuf};

use super::DatasetError;
use super::source::DamagePolicy;
use super::unpaired_files::few_of;

/// Collects files that cannot be read while sizes are taken.
#[derive(Debug, Clone, Default)]
pub struct ScanSizes {
    unreadable: Vec<PathBuf>,
}

impl ScanSizes {
    /// The size of the file at `path` in bytes; 0 if it is no file, which is noted.
    pub fn n_bytes_of(&mut self, path: &Path) -> u64 {
        match std::fs::metadata(path) {
            Ok(metadata) if metadata.is_file() => metadata.len(),
            _ => {
                self.unreadable.push(path.to_path_buf());
                0
            }
        }
    }

    /// Fails if files cannot be read; they are below `folder`.
    ///
    /// # Errors
    ///
    /// If there are any, unless damage is skipped: then they are errors when they are read.
    pub fn check(&self, folder: &Path, damage: DamagePolicy) -> Result<(), DatasetError> {
        if self.unreadable.is_empty() || damage == DamagePolicy::Skip {
            return Ok(());
        }
        let name = |path: &PathBuf| {
            let below = path.strip_prefix(folder).unwrap_or(path).display();
            match (std::fs::symlink_metadata(path), std::fs::metadata(path)) {
                (Ok(_), Err(_)) => format!("{below} (a link to what is not there)"),
                (_, Ok(_)) => format!("{below} (no file)"),
                (Err(_), _) => format!("{below} (not there)"),
            }
        };
        let names: Vec<String> = self.unreadable.iter().map(name).collect();
        let files = if names.len() == 1 { "1 file".to_owned() } else { format!("{} files", names.len()) };
        let problem = format!(
            "has {files} that cannot be read: {}; fetch them, or leave them out with --skip-damaged",
            few_of(&names)
        );
        Err(DatasetError::damaged(folder, problem))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_nothing_and_what_is_no_file_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.bin"), [0; 16]).unwrap();
        std::fs::create_dir(at("b.bin")).unwrap();
        std::os::unix::fs::symlink("elsewhere", at("c.bin")).unwrap();
        std::os::unix::fs::symlink("a.bin", at("d.bin")).unwrap();
        let mut sizes = ScanSizes::default();
        assert_eq!(["a.bin", "d.bin"].map(|it| sizes.n_bytes_of(&at(it))), [16, 16]);
        assert!(sizes.check(folder.path(), DamagePolicy::Refuse).is_ok());
        assert_eq!(["b.bin", "c.bin", "e.bin"].map(|it| sizes.n_bytes_of(&at(it))), [0, 0, 0]);
        assert!(sizes.check(folder.path(), DamagePolicy::Skip).is_ok());
        let error = sizes.check(folder.path(), DamagePolicy::Refuse).expect_err("three");
        let expected = "has 3 files that cannot be read: b.bin (no file), c.bin (a link to what is not there), e.bin \
                        (not there); fetch";
        assert!(error.to_string().contains(expected) && !error.is_usage_error(), "{error}");
    }
}
