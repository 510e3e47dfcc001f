//! The program `scanbench`, run from outside in a folder of its own.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::drawn_dataset::DrawnDataset;

/// A command: a line as it is typed, word by word where a word has a space, or several of these, one after the other.
pub trait Words {
    /// Its words.
    fn words(&self) -> Vec<&str>;
}

impl Words for str {
    fn words(&self) -> Vec<&str> {
        self.split_whitespace().collect()
    }
}

impl Words for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Words for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Words for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Words for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

impl<T: Words + ?Sized> Words for &T {
    fn words(&self) -> Vec<&str> {
        T::words(self)
    }
}

impl<A: Words, B: Words> Words for (A, B) {
    fn words(&self) -> Vec<&str> {
        [self.0.words(), self.1.words()].concat()
    }
}

impl<A: Words, B: Words, C: Words> Words for (A, B, C) {
    fn words(&self) -> Vec<&str> {
        [self.0.words(), self.1.words(), self.2.words()].concat()
    }
}

impl<A: Words, B: Words, C: Words, D: Words> Words for (A, B, C, D) {
    fn words(&self) -> Vec<&str> {
        [self.0.words(), self.1.words(), self.2.words(), self.3.words()].concat()
    }
}

/// A row of a CSV file, by the names of its columns.
pub type Row = BTreeMap<String, String>;

/// A folder that the program runs in and that goes away with the test.
pub struct Workplace {
    folder: TempDir,
}

/// How the program ended.
#[derive(Debug)]
pub struct Ended {
    /// `None` if a signal ended it.
    pub exit_code: Option<i32>,
    /// What it printed as results.
    pub stdout: String,
    /// Everything else it printed.
    pub stderr: String,
}

impl Workplace {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// A folder with a drive `street` of `n_scans` drawn scans.
    pub fn with_drive(n_scans: u32) -> Self {
        let workplace = Self::new();
        DrawnDataset::tracking(workplace.folder(), n_scans);
        workplace
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Where the file `name` is.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The content of the text file `name`.
    pub fn read(&self, name: &str) -> String {
        let path = self.path(name);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// The content of the JSON file `name`.
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The rows of the CSV file `name`.
    pub fn table(&self, name: &str) -> Vec<Row> {
        let mut reader =
            csv::Reader::from_path(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        reader.deserialize().map(|row| row.unwrap_or_else(|error| panic!("{name}: {error}"))).collect()
    }

    /// A column of the CSV file `name`, row by row.
    pub fn column(&self, name: &str, column: &str) -> Vec<String> {
        let cell = |mut row: Row| row.remove(column).unwrap_or_else(|| panic!("no {column} in {name}"));
        self.table(name).into_iter().map(cell).collect()
    }

    /// The content of the file `name`, which is no text.
    pub fn read_bytes(&self, name: &str) -> Vec<u8> {
        let path = self.path(name);
        std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// Writes the file `name`, in new folders if need be.
    pub fn write(&self, name: &str, content: &(impl AsRef<[u8]> + ?Sized)) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }

    /// All files and folders below the folder, hidden ones too.
    pub fn names(&self) -> BTreeSet<PathBuf> {
        let mut names = BTreeSet::new();
        let mut folders = vec![self.folder().to_owned()];
        while let Some(folder) = folders.pop() {
            // A folder may vanish while the program runs.
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                names.insert(entry.path().strip_prefix(self.folder()).unwrap().to_owned());
                if entry.file_type().is_ok_and(|it| it.is_dir()) {
                    folders.push(entry.path());
                }
            }
        }
        names
    }

    /// The names right in the folder.
    pub fn top_names(&self) -> Vec<String> {
        let names = self.names().into_iter().filter(|it| it.components().count() == 1);
        names.map(|it| it.to_string_lossy().into_owned()).collect()
    }

    /// The program with `arguments`, about to run here, free of the environment of whoever runs the tests.
    pub fn command(&self, arguments: &(impl Words + ?Sized)) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scanbench"));
        command.args(arguments.words()).current_dir(self.folder());
        let variables = [
            "SCANBENCH_DATASETS",
            "RERUN",
            "NO_COLOR",
            "CLICOLOR",
            "CLICOLOR_FORCE",
            "GITHUB_STEP_SUMMARY",
            "COLUMNS",
            "SCANBENCH_CACHE",
            "XDG_CACHE_HOME",
            "AWS_ACCESS_KEY_ID",
            "AWS_SKIP_SIGNATURE",
            "AWS_ENDPOINT_URL",
        ];
        // Servers of tests are on this machine.
        let proxies = ["http_proxy", "HTTP_PROXY", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"];
        let roots = ["KITTI_TRACKING_ROOT", "KITTI_OBJECT_ROOT", "KITTI_RAW_ROOT", "NUSCENES_ROOT"];
        for variable in variables.into_iter().chain(roots).chain(proxies) {
            command.env_remove(variable);
        }
        command
    }

    /// Runs the program with `arguments` to its end.
    pub fn run(&self, arguments: &(impl Words + ?Sized)) -> Ended {
        Ended::from(self.command(arguments).output().unwrap())
    }

    /// The same with these variables of the environment.
    pub fn run_with(&self, variables: &[(&str, &str)], arguments: &(impl Words + ?Sized)) -> Ended {
        Ended::from(self.command(arguments).envs(variables.iter().copied()).output().unwrap())
    }

    /// Runs the program with `arguments`, which has to succeed.
    #[track_caller]
    pub fn succeed(&self, arguments: &(impl Words + ?Sized)) -> Ended {
        let ended = self.run(arguments);
        assert_eq!(ended.exit_code, Some(0), "{:?}: {ended:#?}", arguments.words());
        ended
    }

    /// Runs the program with `arguments`, which it refuses with `exit_code` and a message that has all `parts`; it prints no
    /// result and leaves nothing behind.
    #[track_caller]
    pub fn refuse(&self, arguments: &(impl Words + ?Sized), exit_code: i32, parts: &[&str]) -> Ended {
        let before = self.names();
        let ended = self.run(arguments);
        ended.check_refusal(exit_code, parts);
        assert_eq!(self.names(), before, "{:?} leaves something behind", arguments.words());
        ended
    }

    /// Runs the program with `arguments`, which ends with `exit_code` and says all `parts` beside its results.
    #[track_caller]
    pub fn end_with(&self, arguments: &(impl Words + ?Sized), exit_code: i32, parts: &[&str]) -> Ended {
        let ended = self.run(arguments);
        assert_eq!(ended.exit_code, Some(exit_code), "{:?}: {ended:#?}", arguments.words());
        ended.check_stderr(parts);
        ended
    }

    /// The file `name` has all `parts`.
    #[track_caller]
    pub fn check_file(&self, name: &str, parts: &[&str]) {
        let text = self.read(name);
        for part in parts {
            assert!(text.contains(part), "no {part:?} in {name}:\n{text}");
        }
    }

    /// Size of the file `name` in bytes; 0 if it is not there.
    pub fn n_bytes(&self, name: &str) -> u64 {
        self.path(name).metadata().map_or(0, |it| it.len())
    }

    /// Number of lines of the file `name`; 0 if it is not there.
    pub fn n_lines(&self, name: &str) -> usize {
        std::fs::read_to_string(self.path(name)).map_or(0, |it| it.lines().count())
    }

    /// Starts the program with `arguments`, and returns once `is_so`.
    #[track_caller]
    pub fn start_until(&self, arguments: &(impl Words + ?Sized), is_so: impl Fn(&Self) -> bool) -> Child {
        let child = self.start(arguments);
        let started = Instant::now();
        while !is_so(self) {
            assert!(started.elapsed() < Duration::from_mins(2), "{:?} does not get on", arguments.words());
            std::thread::sleep(Duration::from_millis(2));
        }
        child
    }

    /// Starts the program with `arguments`, with its output captured.
    pub fn start(&self, arguments: &(impl Words + ?Sized)) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }
}

impl Ended {
    /// The directory that it says it has written.
    #[track_caller]
    pub fn named_directory(&self) -> String {
        let mut lines = self.stderr.lines();
        lines.find_map(|it| it.strip_prefix("Run directory: ")).expect("its name").to_owned()
    }

    /// It ended with `exit_code`, without a result, and with an error that has all `parts`.
    #[track_caller]
    pub fn check_refusal(&self, exit_code: i32, parts: &[&str]) {
        assert_eq!((self.exit_code, self.stdout.as_str()), (Some(exit_code), ""), "{self:#?}");
        assert!(self.stderr.contains("error: ") && !self.stderr.contains("panicked"), "{self:#?}");
        for part in parts {
            assert!(self.stderr.contains(part), "no {part:?} in {self:#?}");
        }
    }

    /// It printed all `parts` among its results.
    #[track_caller]
    pub fn check_stdout(&self, parts: &[&str]) -> &Self {
        for part in parts {
            assert!(self.stdout.contains(part), "no {part:?} in {self:#?}");
        }
        self
    }

    /// It printed all `parts` beside its results.
    #[track_caller]
    pub fn check_stderr(&self, parts: &[&str]) -> &Self {
        for part in parts {
            assert!(self.stderr.contains(part), "no {part:?} in {self:#?}");
        }
        self
    }
}

/// Sends a signal to a running program.
pub fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}

/// Copies all files below the folder `from`.
pub fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let copied = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &copied);
        } else {
            std::fs::copy(entry.path(), copied).unwrap();
        }
    }
}

/// What several tests begin with: made by the first of them, and copied for each.
pub struct Prepared {
    files: OnceLock<Vec<(PathBuf, Vec<u8>)>>,
}

impl Prepared {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self { files: OnceLock::new() }
    }

    /// A workplace with the files that `prepare` leaves in one.
    pub fn workplace(&self, prepare: impl FnOnce(&Workplace)) -> Workplace {
        let files = self.files.get_or_init(|| {
            let workplace = Workplace::new();
            prepare(&workplace);
            let files = workplace.names().into_iter().filter(|it| workplace.folder().join(it).is_file());
            files.map(|it| (it.clone(), std::fs::read(workplace.folder().join(it)).unwrap())).collect()
        });
        let workplace = Workplace::new();
        for (name, content) in files {
            let path = workplace.folder().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, content).unwrap();
        }
        workplace
    }
}

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        Self {
            exit_code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}
