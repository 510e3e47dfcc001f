//! The folder that a run leaves behind, written whole or not at all.

use std::fs::{File, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::archive::ArchiveError;
use crate::whole_file::{WholeFile, folder_of, write_whole};

/// The numbers of the run.
pub const REPORT_JSON: &str = "report.json";
/// How the run came about.
pub const MANIFEST_JSON: &str = "manifest.json";
/// One row for every scan, detector and task.
pub const SCANS_CSV: &str = "scans.csv";
/// One row for every matched pair, and for every annotation and detection that is in none.
pub const MATCHES_CSV: &str = "matches.csv";
/// Precision over recall, where detections have scores.
pub const PRECISION_RECALL_CSV: &str = "precision_recall.csv";
/// What the sensor saw around the worst mistakes.
pub const WORST_POINTS_JSON: &str = "worst_points.json";
/// The run as a page.
pub const REPORT_HTML: &str = "report.html";
/// Folder of the figures of the page, each as a file of its own.
pub const FIGURES: &str = "figures";
/// Rates of a sweep.
pub const SWEEP_CSV: &str = "sweep.csv";
/// Times of a sweep.
pub const SWEEP_TIMES_CSV: &str = "times.csv";
/// Points at the newest run beside it.
pub const LATEST: &str = "latest";

/// What to do when the target is there already. An empty folder is always taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExistingTarget {
    /// Leave it and fail.
    Refuse,
    /// Replace it, if it is the directory of an earlier run.
    Replace,
}

/// What to do with the name `latest` beside the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatestPointer {
    /// Let it point at this run.
    Update,
    /// Leave it alone.
    Leave,
}

/// A run directory in the making.
///
/// Until [`Self::finish`] everything is in a hidden folder beside the target, which is removed when this is dropped.
#[derive(Debug)]
#[must_use = "a run directory that is not finished is thrown away"]
pub struct RunDirectory {
    // Invariant: dropped, and so removed, before the folders around it: fields drop in the order of declaration.
    partial: TempDir,
    _new_parents: NewParents,
    target: PathBuf,
    existing: ExistingTarget,
    latest: LatestPointer,
}

/// Why a run directory cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RunDirectoryError {
    /// The path does not end in the name of a folder.
    #[error("{target:?} does not end in the name of a run; give one, such as runs/first")]
    NoName {
        /// Where the run was to be written.
        target: PathBuf,
    },
    /// There is something already.
    #[error("{target:?} exists; choose another name, remove it, or ask for it to be replaced")]
    Occupied {
        /// Where the run was to be written.
        target: PathBuf,
    },
    /// There is something already that is no run, and is not replaced.
    #[error(
        "{target:?} exists and is not the directory of a run (a folder with a {MANIFEST_JSON}), so it is not replaced"
    )]
    NotARun {
        /// Where the run was to be written.
        target: PathBuf,
    },
    /// The name `latest` is taken by something that does not point at a run.
    #[error("{path:?} should point at the newest run, but is something else; rename it")]
    LatestOccupied {
        /// What has that name.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("cannot write {path:?}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
}

impl RunDirectory {
    /// Begins the run directory `target`; missing folders above it are made.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if nothing can be written there, or if `target` exists and may not be replaced: at once, and
    /// not after a long run.
    pub fn create(
        target: &Path,
        existing: ExistingTarget,
        latest: LatestPointer,
    ) -> Result<Self, RunDirectoryError> {
        let name = target.file_name().ok_or_else(|| RunDirectoryError::NoName { target: target.into() })?;
        check_target(target, existing)?;
        let parent = folder_of(target);
        // A run that is itself called `latest` needs no pointer.
        let latest = if name == LATEST { LatestPointer::Leave } else { latest };
        if latest == LatestPointer::Update {
            check_latest(&parent.join(LATEST))?;
        }
        let new_parents = NewParents::create(parent)?;
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{}.partial-", name.to_string_lossy());
        builder.prefix(&prefix);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As for any other folder: the umask decides who may look into it.
            builder.permissions(std::fs::Permissions::from_mode(0o777));
        }
        let partial = builder.tempdir_in(parent).map_err(refused(parent))?;
        Ok(Self { partial, _new_parents: new_parents, target: target.into(), existing, latest })
    }

    /// Where the run will be.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Where all of it is written now.
    pub fn folder(&self) -> &Path {
        self.partial.path()
    }

    /// Where the file `name` is to be written now, for writers that open it themselves.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.partial.path().join(name)
    }

    /// Begins the file `name`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn begin_file(&self, name: &str) -> Result<WholeFile, ArchiveError> {
        WholeFile::create(&self.path_of(name))
    }

    /// Writes the file `name`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn write_file(&self, name: &str, content: &[u8]) -> Result<(), ArchiveError> {
        write_whole(&self.path_of(name), content)
    }

    /// Brings all files to the disk and the folder to its name, lets `latest` point at it if that was asked for, and
    /// returns where the run is.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if the disk does not take it, or if somebody else made the target meanwhile; nothing is left
    /// behind then, and an earlier run stays as it was. If `latest` alone fails, the run is in its place.
    pub fn finish(mut self) -> Result<PathBuf, RunDirectoryError> {
        let parent = folder_of(&self.target);
        sync_tree(self.partial.path())?;
        check_target(&self.target, self.existing)?;
        match move_into_place(self.partial.path(), &self.target)? {
            Moved::ToANewName => self.partial.disable_cleanup(true),
            // What is removed in the end is the earlier run, which now has the name of the hidden folder.
            Moved::InExchange => {}
        }
        sync_folder(parent)?;
        if self.latest == LatestPointer::Update {
            point_latest_at(&self.target)?;
        }
        Ok(self.target.clone())
    }
}

/// Turns what the operating system said about `path` into our error.
fn refused(path: &Path) -> impl FnOnce(io::Error) -> RunDirectoryError {
    let path = path.to_path_buf();
    move |source| RunDirectoryError::Io { path, source }
}

/// What is there, without following a link; `None` if nothing is.
fn metadata(path: &Path) -> Result<Option<Metadata>, RunDirectoryError> {
    match std::fs::symlink_metadata(path) {
        Ok(metadata) => Ok(Some(metadata)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(path)(error)),
    }
}

fn is_empty_folder(path: &Path, metadata: &Metadata) -> Result<bool, RunDirectoryError> {
    Ok(metadata.is_dir() && std::fs::read_dir(path).map_err(refused(path))?.next().is_none())
}

/// Fails if `target` exists and may not be replaced.
fn check_target(target: &Path, existing: ExistingTarget) -> Result<(), RunDirectoryError> {
    let Some(metadata) = metadata(target)? else { return Ok(()) };
    if is_empty_folder(target, &metadata)? {
        return Ok(());
    }
    match existing {
        ExistingTarget::Refuse => Err(RunDirectoryError::Occupied { target: target.into() }),
        // A slip of the keyboard must not cost a home directory.
        ExistingTarget::Replace if metadata.is_dir() && target.join(MANIFEST_JSON).is_file() => Ok(()),
        ExistingTarget::Replace => Err(RunDirectoryError::NotARun { target: target.into() }),
    }
}

/// Fails if `latest` is something that was not put there by [`point_latest_at`].
fn check_latest(latest: &Path) -> Result<(), RunDirectoryError> {
    match metadata(latest)? {
        Some(metadata) if cfg!(unix) && !metadata.is_symlink() || metadata.is_dir() => {
            Err(RunDirectoryError::LatestOccupied { path: latest.into() })
        }
        _ => Ok(()),
    }
}

/// How a folder came to its name.
enum Moved {
    /// Nobody had that name.
    ToANewName,
    /// The earlier run got the name of the new one's folder.
    InExchange,
}

/// Gives the finished folder its name; an earlier run of that name goes only once the new one is in its place.
fn move_into_place(partial: &Path, target: &Path) -> Result<Moved, RunDirectoryError> {
    let rename = |from: &Path, to: &Path| -> Result<Moved, RunDirectoryError> {
        std::fs::rename(from, to).map_err(refused(target)).map(|()| Moved::ToANewName)
    };
    let Some(metadata) = metadata(target)? else { return rename(partial, target) };
    if is_empty_folder(target, &metadata)? {
        // Where the system allows, in one step, so that no moment is without a folder of that name.
        if std::fs::rename(partial, target).is_ok() {
            return Ok(Moved::ToANewName);
        }
        std::fs::remove_dir(target).map_err(refused(target))?;
        return rename(partial, target);
    }
    if exchange(partial, target).is_ok() {
        return Ok(Moved::InExchange);
    }
    let parent = folder_of(target);
    let aside = tempfile::Builder::new().prefix(".replaced-").tempdir_in(parent).map_err(refused(parent))?;
    let old = aside.path().join("old");
    rename(target, &old)?;
    rename(partial, target).or_else(|error| rename(&old, target).and(Err(error)))
}

/// Lets two folders swap names in one step, so that whoever ends the program meanwhile leaves the one or the other.
#[cfg(target_os = "linux")]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

/// Not every system can.
#[cfg(not(target_os = "linux"))]
fn exchange(_one: &Path, _other: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Brings all files below `folder` to the disk.
fn sync_tree(folder: &Path) -> Result<(), RunDirectoryError> {
    for entry in std::fs::read_dir(folder).map_err(refused(folder))? {
        let entry = entry.map_err(refused(folder))?;
        let path = entry.path();
        if entry.file_type().map_err(refused(&path))?.is_dir() {
            sync_tree(&path)?;
        } else {
            let file = File::options().write(true).open(&path).map_err(refused(&path))?;
            file.sync_all().map_err(refused(&path))?;
        }
    }
    sync_folder(folder)
}

/// Brings the names in `folder` to the disk, where the system has that notion.
fn sync_folder(folder: &Path) -> Result<(), RunDirectoryError> {
    if cfg!(unix) {
        File::open(folder).and_then(|it| it.sync_all()).map_err(refused(folder))?;
    }
    Ok(())
}

/// Lets `latest` beside `target` point at it: as a link or, where there are none, as a text file with its name.
fn point_latest_at(target: &Path) -> Result<(), RunDirectoryError> {
    let latest = folder_of(target).join(LATEST);
    let name = target.file_name().ok_or_else(|| RunDirectoryError::NoName { target: target.into() })?;
    #[cfg(unix)]
    {
        // Made under another name and moved, so that there is no moment without `latest`.
        let link = tempfile::Builder::new()
            .prefix(".latest-")
            .make_in(folder_of(target), |path| std::os::unix::fs::symlink(name, path))
            .map_err(refused(&latest))?;
        link.persist(&latest).map_err(|it| refused(&latest)(it.error))?;
    }
    #[cfg(not(unix))]
    write_whole(&latest, name.to_string_lossy().as_bytes())?;
    Ok(())
}

/// The folders that were made for a run, innermost first. Dropping it removes those that are empty.
#[derive(Debug)]
struct NewParents(Vec<PathBuf>);

impl NewParents {
    /// Makes `folder` and all that is missing above it.
    fn create(folder: &Path) -> Result<Self, RunDirectoryError> {
        let missing =
            folder.ancestors().filter(|it| !it.as_os_str().is_empty()).take_while(|it| !it.exists());
        let new_parents = Self(missing.map(Path::to_path_buf).collect());
        std::fs::create_dir_all(folder).map_err(refused(folder))?;
        Ok(new_parents)
    }
}

impl Drop for NewParents {
    fn drop(&mut self) {
        for folder in &self.0 {
            // Fails, as it should, where a run or something else is in it.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|it| it.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn begin(target: &Path, existing: ExistingTarget) -> Result<RunDirectory, RunDirectoryError> {
        RunDirectory::create(target, existing, LatestPointer::Update)
    }

    /// Writes a run whose report holds `content`.
    fn write_run(
        target: &Path,
        existing: ExistingTarget,
        content: &str,
    ) -> Result<PathBuf, RunDirectoryError> {
        let run = begin(target, existing)?;
        run.write_file(MANIFEST_JSON, b"{}")?;
        std::fs::write(run.path_of(REPORT_JSON), content).unwrap();
        run.finish()
    }

    fn report_of(run: &Path) -> String {
        std::fs::read_to_string(run.join(REPORT_JSON)).unwrap()
    }

    #[test]
    fn a_finished_run_is_there_whole_and_latest_points_at_it() {
        let folder = tempfile::tempdir().unwrap();
        let runs = folder.path().join("deep").join("runs");
        for name in ["first", "second"] {
            let target = write_run(&runs.join(name), ExistingTarget::Refuse, name).unwrap();
            assert_eq!(target, runs.join(name));
            assert_eq!(names_in(&target), [MANIFEST_JSON, REPORT_JSON]);
            assert_eq!(report_of(&target), name);
            #[cfg(unix)]
            assert_eq!(std::fs::read_link(runs.join(LATEST)).unwrap(), Path::new(name));
        }
        assert_eq!(names_in(&runs), ["first", LATEST, "second"]);
    }

    #[test]
    fn a_run_that_is_dropped_leaves_nothing_not_even_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let run = begin(&folder.path().join("deep").join("runs").join("a"), ExistingTarget::Refuse).unwrap();
        run.write_file(MANIFEST_JSON, b"{}").unwrap();
        std::fs::create_dir(run.path_of("plots")).unwrap();
        let mut file = run.begin_file("plots/a.svg").unwrap();
        std::io::Write::write_all(&mut file, b"<svg>").unwrap();
        drop(run);
        assert!(names_in(folder.path()).is_empty());
    }

    #[test]
    fn latest_can_be_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        RunDirectory::create(&target, ExistingTarget::Refuse, LatestPointer::Leave)
            .unwrap()
            .finish()
            .unwrap();
        assert_eq!(names_in(folder.path()), ["a"]);
    }

    #[test]
    fn a_run_called_latest_is_no_pointer() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join(LATEST);
        write_run(&target, ExistingTarget::Refuse, "old").unwrap();
        write_run(&target, ExistingTarget::Replace, "new").unwrap();
        assert_eq!((names_in(folder.path()), report_of(&target).as_str()), (vec![LATEST.to_owned()], "new"));
    }

    #[test]
    fn an_empty_folder_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        std::fs::create_dir(&target).unwrap();
        write_run(&target, ExistingTarget::Refuse, "").unwrap();
        assert_eq!(names_in(&target), [MANIFEST_JSON, REPORT_JSON]);
    }

    #[test]
    fn an_earlier_run_is_replaced_only_when_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        write_run(&target, ExistingTarget::Refuse, "old").unwrap();
        let error = write_run(&target, ExistingTarget::Refuse, "new").unwrap_err();
        assert!(matches!(error, RunDirectoryError::Occupied { .. }), "{error}");
        assert_eq!(report_of(&target), "old");
        write_run(&target, ExistingTarget::Replace, "new").unwrap();
        assert_eq!(report_of(&target), "new");
        assert_eq!(names_in(folder.path()), ["a", LATEST]);
    }

    #[test]
    fn what_is_no_run_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        std::fs::create_dir(&home).unwrap();
        std::fs::write(home.join("thesis.tex"), "").unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        for target in [home, file] {
            let error = begin(&target, ExistingTarget::Replace).unwrap_err();
            assert!(matches!(error, RunDirectoryError::NotARun { .. }), "{error}");
        }
        assert_eq!(names_in(folder.path()), ["file", "home"]);
    }

    #[test]
    fn a_target_made_by_somebody_else_meanwhile_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let late = begin(&target, ExistingTarget::Refuse).unwrap();
        write_run(&target, ExistingTarget::Refuse, "theirs").unwrap();
        let error = late.finish().unwrap_err();
        assert!(matches!(error, RunDirectoryError::Occupied { .. }), "{error}");
        assert_eq!((report_of(&target).as_str(), names_in(folder.path()).len()), ("theirs", 2));
    }

    #[test]
    fn a_parent_that_cannot_be_written_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let target = file.join("a");
        let error = begin(&target, ExistingTarget::Refuse).unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {target:?}"));
    }

    #[test]
    fn a_path_without_a_name_is_an_error() {
        for target in [".", "..", "/"] {
            let error = begin(Path::new(target), ExistingTarget::Refuse).unwrap_err();
            assert!(matches!(error, RunDirectoryError::NoName { .. }), "{error}");
        }
    }

    #[test]
    fn a_folder_called_latest_is_an_error_before_the_run() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join(LATEST)).unwrap();
        let error = begin(&folder.path().join("a"), ExistingTarget::Refuse).unwrap_err();
        assert!(matches!(error, RunDirectoryError::LatestOccupied { .. }), "{error}");
        assert_eq!(names_in(folder.path()), [LATEST]);
    }
}
