//! Folders that are made for a result, and removed again if there is none.

use std::io;
use std::path::{Path, PathBuf};

use crate::files::unfinished::{Kind, Unfinished};

/// The folders that were made for a result, innermost first. Dropping it removes those that are empty.
#[derive(Debug)]
#[must_use = "the folders go when this is dropped, unless something is in them"]
pub struct NewFolders(Vec<NewFolder>);

#[derive(Debug)]
struct NewFolder {
    path: PathBuf,
    _unfinished: Unfinished,
}

impl NewFolders {
    /// Makes `folder` and all missing folders above it.
    ///
    /// # Errors
    ///
    /// If the operating system refuses.
    pub fn create(folder: &Path) -> io::Result<Self> {
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|it| !it.as_os_str().is_empty() && !it.exists()).collect();
        let mut new_folders = Self(Vec::new());
        for path in missing.into_iter().rev() {
            let make = || std::fs::create_dir(path);
            match Unfinished::begin(Kind::EmptyFolder, make, |()| path.to_path_buf()) {
                Ok((unfinished, ())) => {
                    let folder = NewFolder { path: path.to_path_buf(), _unfinished: unfinished };
                    new_folders.0.insert(0, folder);
                }
                // Another thread or program has made it meanwhile.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => {}
                Err(error) => return Err(error),
            }
        }
        // Fails if there is something other than a folder.
        std::fs::create_dir_all(folder)?;
        Ok(new_folders)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // Fails, as it should, where a result or something else is in it.
            let _ = std::fs::remove_dir(&folder.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_go_unless_something_is_in_them() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a/b/c");
        drop(NewFolders::create(&path).unwrap());
        assert!(!root.path().join("a").exists());
        let new_folders = NewFolders::create(&path).unwrap();
        std::fs::write(root.path().join("a/b/result"), "").unwrap();
        drop(new_folders);
        assert!(root.path().join("a/b").exists() && !path.exists());
    }

    #[test]
    fn folders_that_were_there_stay() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a");
        std::fs::create_dir(&path).unwrap();
        drop(NewFolders::create(&path).unwrap());
        drop(NewFolders::create(&path.join("b")).unwrap());
        assert!(path.exists() && !path.join("b").exists());
    }

    #[test]
    fn below_a_file_there_is_no_folder() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(NewFolders::create(&file).is_err());
        assert!(NewFolders::create(&file.join("a")).is_err());
    }
}
