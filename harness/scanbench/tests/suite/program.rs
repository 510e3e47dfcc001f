//! The program `scanbench`, run from outside in a folder of its own.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;

use tempfile::TempDir;

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

    /// The content of the file `name`, which is no text.
    pub fn read_bytes(&self, name: &str) -> Vec<u8> {
        let path = self.path(name);
        std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// Writes the file `name`, which is no text.
    pub fn write_bytes(&self, name: &str, content: &[u8]) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Writes the file `name`.
    pub fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
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
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scanbench"));
        command.args(arguments).current_dir(self.folder());
        let variables = [
            "SCANBENCH_DATASETS",
            "RERUN",
            "NO_COLOR",
            "CLICOLOR",
            "CLICOLOR_FORCE",
            "GITHUB_STEP_SUMMARY",
            "COLUMNS",
        ];
        for variable in variables.into_iter().chain(["KITTI_TRACKING_ROOT", "KITTI_OBJECT_ROOT"]) {
            command.env_remove(variable);
        }
        command
    }

    /// Runs the program with `arguments` to its end.
    pub fn run(&self, arguments: &[&str]) -> Ended {
        Ended::from(self.command(arguments).output().unwrap())
    }

    /// Runs the program with `arguments`, which has to succeed.
    #[track_caller]
    pub fn succeed(&self, arguments: &[&str]) -> Ended {
        let ended = self.run(arguments);
        assert_eq!(ended.exit_code, Some(0), "{arguments:?}: {ended:#?}");
        ended
    }

    /// Starts the program with `arguments`, with its output captured.
    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
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
