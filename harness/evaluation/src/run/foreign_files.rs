//! The files that a foreign detector is made of, with checksums of their contents.

use std::collections::BTreeMap;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use reports::files::regular_file::RegularFile;
use scans::dataset::checksum::ContentChecksum;

/// A file of a detector cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {path:?}, which the detector is made of")]
pub struct ForeignFileError {
    /// The file.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: io::Error,
}

/// SHA-256 of the files that the words of `command` and of `parameters` name, relative to `folder`; by these names.
///
/// A word names a file, a file's function (`detector.py:dbscan`) or a module's (`detectors.mine:dbscan`, `-m
/// detectors.mine`). A program that is found on `PATH` counts only if no other file is named, so Python itself usually does
/// not. Imports of the files are not followed.
///
/// # Errors
///
/// [`ForeignFileError`] if one of them cannot be read.
pub fn files_of<'a>(
    command: &'a [String],
    parameters: impl IntoIterator<Item = &'a str>,
    folder: &Path,
) -> Result<BTreeMap<String, String>, ForeignFileError> {
    let Some((program, arguments)) = command.split_first() else { return Ok(BTreeMap::new()) };
    // Options of `python -m scanbench.serve`.
    let more_folders = arguments.array_windows().filter(|[it, _]| it == "--directory" || it == "--path");
    let folders = [folder.to_owned()].into_iter().chain(more_folders.map(|[_, it]| folder.join(it)));
    let folders: Vec<PathBuf> = folders.collect();
    let mut names: Vec<String> = Vec::new();
    names.extend(program.contains('/').then(|| program.clone()));
    for (argument_idx, word) in arguments.iter().enumerate() {
        let is_module = argument_idx.checked_sub(1).is_some_and(|it| arguments[it] == "-m");
        names.extend(names_in(word));
        names.extend(is_module.then(|| files_of_module(word)).into_iter().flatten());
    }
    names.extend(parameters.into_iter().map(str::to_owned));
    let mut files = BTreeMap::new();
    for name in names {
        if let Some(path) = folders.iter().map(|it| it.join(&name)).find(|it| it.is_file()) {
            files.insert(name, checksum(&path)?);
        }
    }
    if files.is_empty()
        && let Some(path) = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())
            .map(|it| it.join(program))
            .find(|it| it.is_file())
    {
        files.insert(program.clone(), checksum(&path)?);
    }
    Ok(files)
}

/// The files that an argument may name.
fn names_in(word: &str) -> Vec<String> {
    let mut names = vec![word.to_owned()];
    names.extend(word.split_once('=').map(|(_, value)| value.to_owned()));
    if let Some((before_colon, _)) = word.rsplit_once(':') {
        names.push(before_colon.to_owned());
        names.extend(files_of_module(before_colon));
    }
    names
}

fn files_of_module(name: &str) -> [String; 3] {
    let path = name.replace('.', "/");
    [format!("{path}.py"), format!("{path}/__init__.py"), format!("{path}/__main__.py")]
}

fn checksum(path: &Path) -> Result<String, ForeignFileError> {
    let refused = |source| ForeignFileError { path: path.to_owned(), source };
    let mut file = RegularFile::open(path).map_err(refused)?;
    let mut checksum = ContentChecksum::default();
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece).map_err(refused)? {
            0 => return Ok(checksum.finish()),
            n_bytes => checksum.add(&piece[..n_bytes]),
        }
    }
}

#[cfg(test)]
mod tests {
    use scans::dataset::checksum::sha256;

    use super::*;

    /// The files of `command` with a parameter `weights.pt`, in a folder with some.
    #[track_caller]
    fn check(command: &[&str], expected: &[&str]) {
        let folder = tempfile::tempdir().unwrap();
        for name in
            ["detector.py", "build/mine", "weights.pt", "pack/mod.py", "pack/__init__.py", "other/far.py"]
        {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, name).unwrap();
        }
        let command: Vec<String> = command.iter().map(|&it| it.to_owned()).collect();
        let files = files_of(&command, ["tree"], folder.path()).unwrap();
        let expected = expected.iter().map(|it| {
            let path = if *it == "far.py" { "other/far.py" } else { it };
            ((*it).to_owned(), sha256(path))
        });
        assert_eq!(files, expected.collect(), "{command:?}");
    }

    #[test]
    fn files_and_modules_are_found_by_what_the_command_says() {
        check(&["python3", "detector.py"], &["detector.py"]);
        check(&["python3", "-m", "scanbench.serve", "detector.py:dbscan"], &["detector.py"]);
        check(&["python3", "-m", "scanbench.serve", "pack.mod:Class.method"], &["pack/mod.py"]);
        check(&["python3", "-m", "pack"], &["pack/__init__.py"]);
        check(&["python3", "-m", "scanbench.serve", "--path", "other", "far:f"], &["far.py"]);
        check(&["build/mine", "--weights=weights.pt"], &["build/mine", "weights.pt"]);
        check(&["build/mine", "--level", "3"], &["build/mine"]);
        check(&["./nowhere"], &[]);
    }

    #[test]
    fn a_file_that_a_parameter_names_is_one_of_them() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("weights.pt"), "learned").unwrap();
        let files = files_of(&["./nowhere".to_owned()], ["weights.pt", ""], folder.path()).unwrap();
        assert_eq!(files, BTreeMap::from([("weights.pt".to_owned(), sha256("learned"))]));
    }

    #[test]
    fn a_program_on_the_path_is_one_only_where_nothing_else_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let files = |command: &[&str]| {
            let command: Vec<String> = command.iter().map(|&it| it.to_owned()).collect();
            files_of(&command, [], folder.path()).unwrap().into_keys().collect::<Vec<_>>()
        };
        assert_eq!(files(&["sh"]), ["sh"]);
        std::fs::write(folder.path().join("mine.sh"), "").unwrap();
        assert_eq!(files(&["sh", "mine.sh"]), ["mine.sh"]);
    }
}
