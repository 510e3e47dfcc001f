//! The folder that a run leaves behind, written whole or not at all.

use std::fs::File;
use std::path::{Path, PathBuf};

use crate::files::archive::ArchiveError;
use crate::files::hidden_folder::HiddenFolder;
use crate::files::whole_file::{WholeFile, folder_of, write_whole};
use crate::run_folder::finished_folder::move_to_target;
use crate::run_folder::run_target::{
    ClaimedTarget, ExistingTarget, LATEST, LatestPointer, RunDirectoryError, refused,
};
use crate::vocabulary::protocol::{Protocol, ProtocolFamily};

/// The numbers of the run.
pub const REPORT_JSON: &str = "report.json";
/// One row for every scan, detector and task.
pub const SCANS_CSV: &str = "scans.csv";
/// One row for every matched pair, and for every annotation and detection that is in none.
pub const MATCHES_CSV: &str = "matches.csv";
/// How long each stage of a detector took: one row for every scan, detector and stage.
pub const STAGES_CSV: &str = "stages.csv";
/// Where the sensor was: one row for every scan whose pose is known.
pub const POSES_CSV: &str = "poses.csv";
/// Precision over recall, where detections have scores.
pub const PRECISION_RECALL_CSV: &str = "precision_recall.csv";
/// Points that the sensor saw around the worst mistakes.
pub const WORST_POINTS_JSON: &str = "worst_points.json";
/// How often detectors are wrong for each reason, and what repairing it would gain.
pub const ERRORS_CSV: &str = "errors.csv";
/// Annotated classes by given classes, if a detector gives classes.
pub const CONFUSION_CSV: &str = "confusion.csv";
/// How far detectors agree on scans without labels.
pub const AGREEMENT_CSV: &str = "agreement.csv";
/// Folder of the recording for Rerun: a file for the scans, one for each detector, and one for the layout of the viewer.
pub const RECORDING: &str = "recording";
/// Folder of the web viewer of the page.
pub const VIEWER: &str = "viewer";
/// Where the worst mistakes are recorded, in [`VIEWER`].
pub const VIEWER_PLACES_JSON: &str = "places.json";
/// The folders of the recordings in the directory of a run, that of its first part first.
pub fn recordings_in(directory: &Path) -> Vec<String> {
    let later = (2..).map(|part| format!("{RECORDING}-{part}"));
    let is_there = |it: &String| directory.join(it).is_dir();
    // The first parts of a run may have been killed.
    let later = later.take(MOST_PARTS).filter(is_there);
    [RECORDING.to_owned()].into_iter().filter(is_there).chain(later).collect()
}

/// The recording of a sweep: one scan at all points.
pub const SWEEP_RRD: &str = "sweep.rrd";

/// Nobody looks for recordings of more parts.
const MOST_PARTS: usize = 1000;

/// Where the scans of the worst mistakes are recorded, of a run that was made in parts.
pub const RECORDINGS_JSON: &str = "recordings.json";
/// Times of a run that was made in parts on unlike processors, for each processor by itself.
pub const TIMES_OF_PROCESSORS_CSV: &str = "times_of_processors.csv";
/// The run as a page.
pub const REPORT_HTML: &str = "report.html";
/// The numbers under protocols of others.
pub const PROTOCOLS_JSON: &str = "protocols.json";
/// Every annotation and detection under protocols that rank boxes by distance, for each detector.
pub const PROTOCOL_BOXES_CSV: &str = "protocol_boxes.csv";
/// Annotations, detections and pairs of KITTI's evaluation of objects, for each detector.
pub const KITTI_OBJECT_CSV: &str = "protocol_kitti_object.csv";
/// Scores of labelled instances, things and ground points under protocols that score labels of points, for each detector.
pub const PROTOCOL_LABELS_CSV: &str = "protocol_labels.csv";
/// The files of rows under protocols of others.
pub const PROTOCOL_FILES: [&str; 3] = [PROTOCOL_BOXES_CSV, KITTI_OBJECT_CSV, PROTOCOL_LABELS_CSV];

/// The file of [`PROTOCOL_FILES`] with the rows under `protocol`.
pub fn protocol_file(protocol: Protocol) -> &'static str {
    match protocol.family() {
        ProtocolFamily::KittiObjects => KITTI_OBJECT_CSV,
        ProtocolFamily::RankedBoxes => PROTOCOL_BOXES_CSV,
        ProtocolFamily::Instances | ProtocolFamily::Ground => PROTOCOL_LABELS_CSV,
    }
}
/// Folder of the figures of the page, each as a file of its own.
pub const FIGURES: &str = "figures";
/// Verdicts on the claims of the papers.
pub const REPRODUCTION_JSON: &str = "reproduction.json";
/// Recommendations of a sweep, a text in each line.
pub const SWEEP_BEST_TXT: &str = "best.txt";
/// Rates at all points of a sweep.
pub const SWEEP_CSV: &str = "sweep.csv";
/// Times of a sweep.
pub const SWEEP_TIMES_CSV: &str = "times.csv";
/// Numbers of a sweep under protocols of others.
pub const SWEEP_PROTOCOLS_CSV: &str = "sweep_protocols.csv";
/// Numbers of a sweep under protocols of others, with all that is needed to read them.
pub const SWEEP_PROTOCOLS_JSON: &str = "sweep_protocols.json";
/// The log of a shard: an event a line.
pub const SHARD_LOG: &str = "shard.log";

/// The predicted classes of partly seen objects: one row for every object, step and method.
pub const PARTIAL_CSV: &str = "partial.csv";

/// How objects were seen and classified, for Rerun.
pub const PARTIAL_RRD: &str = "partial.rrd";

/// A run directory in the making.
///
/// Until [`Self::finish`] everything is in a hidden folder beside the target, which is removed when this is dropped.
#[derive(Debug)]
#[must_use = "a run directory that is not finished is thrown away"]
pub struct RunDirectory {
    // Invariant: dropped, and so removed, before the folders around it: fields drop in the order of declaration.
    partial: HiddenFolder,
    claimed: ClaimedTarget,
}

impl RunDirectory {
    /// Begins the run directory `target`; missing folders above it are made.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if nothing can be written there, or if `target` exists and may not be replaced, or another run
    /// is writing it: at once, and not after a long run.
    pub fn create(
        target: &Path,
        existing: ExistingTarget,
        latest: LatestPointer,
    ) -> Result<Self, RunDirectoryError> {
        Self::begin(ClaimedTarget::claim(target, existing, latest)?)
    }

    /// Begins the run directory whose path has been taken.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if nothing can be written there.
    pub fn begin(claimed: ClaimedTarget) -> Result<Self, RunDirectoryError> {
        let partial = HiddenFolder::beside(claimed.target(), "partial")
            .map_err(refused(folder_of(claimed.target())))?;
        Ok(Self { partial, claimed })
    }

    /// Path of the finished run.
    pub fn target(&self) -> &Path {
        self.claimed.target()
    }

    /// Folder in which all of it is written now.
    pub fn folder(&self) -> &Path {
        self.partial.path()
    }

    /// Path at which the file `name` is to be written now, for writers that open it themselves.
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

    /// Brings all files to the disk and the folder to its name, points `latest` at it if that was asked for, and returns the
    /// path of the run.
    ///
    /// # Errors
    ///
    /// [`RunDirectoryError`] if the disk does not take it, or if something was made at the target meanwhile; nothing is left
    /// behind then, and an earlier run stays as it was. If `latest` alone fails, the run is at its path.
    pub fn finish(self) -> Result<PathBuf, RunDirectoryError> {
        sync_tree(self.partial.path())?;
        let target = self.claimed.target().to_path_buf();
        // In one step, even if the program is ended: no run without the pointer that it is to have.
        self.partial.undisturbed(|| {
            self.claimed.check()?;
            // The hidden folder is gone by now or, after an exchange, the earlier run: that is removed in the end.
            move_to_target(self.partial.path(), &target)?;
            if self.claimed.latest() == LatestPointer::Update { point_latest_at(&target) } else { Ok(()) }
        })?;
        sync_folder(folder_of(&target))?;
        Ok(target)
    }
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

/// Brings the names in `folder` to the disk, where the system can do so.
fn sync_folder(folder: &Path) -> Result<(), RunDirectoryError> {
    if cfg!(unix) {
        File::open(folder).and_then(|it| it.sync_all()).map_err(refused(folder))?;
    }
    Ok(())
}

/// Lets `latest` beside `target` point at it: as a link or, where there are none, as a text file with its name.
fn point_latest_at(target: &Path) -> Result<(), RunDirectoryError> {
    let latest = folder_of(target).join(LATEST);
    let name = target.file_name().ok_or_else(|| RunDirectoryError::NoName(target.into()))?;
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
    std::fs::write(&latest, name.to_string_lossy().as_bytes()).map_err(refused(&latest))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_folder::run_target::MANIFEST_JSON;

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
        assert!(matches!(error, RunDirectoryError::Occupied(_)), "{error}");
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
            assert!(matches!(error, RunDirectoryError::NotARun(_)), "{error}");
        }
        assert_eq!(names_in(folder.path()), ["file", "home"]);
    }

    #[test]
    fn a_target_made_by_somebody_else_meanwhile_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let late = begin(&target, ExistingTarget::Refuse).unwrap();
        std::fs::create_dir(&target).unwrap();
        std::fs::write(target.join(REPORT_JSON), "theirs").unwrap();
        let error = late.finish().unwrap_err();
        assert!(matches!(error, RunDirectoryError::Occupied(_)), "{error}");
        assert_eq!((report_of(&target).as_str(), names_in(folder.path())), ("theirs", vec!["a".to_owned()]));
    }

    #[test]
    fn two_do_not_write_to_one_path() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        for existing in [ExistingTarget::Refuse, ExistingTarget::Replace] {
            let first = begin(&target, existing).unwrap();
            let error = begin(&target, existing).unwrap_err();
            assert!(matches!(error, RunDirectoryError::InUse(_)), "{error}");
            first.write_file(MANIFEST_JSON, b"{}").unwrap();
            first.finish().unwrap();
        }
        assert_eq!(names_in(folder.path()), ["a", LATEST]);
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
            assert!(matches!(error, RunDirectoryError::NoName(_)), "{error}");
        }
    }

    #[test]
    fn a_folder_called_latest_is_an_error_before_the_run() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join(LATEST)).unwrap();
        let error = begin(&folder.path().join("a"), ExistingTarget::Refuse).unwrap_err();
        assert!(matches!(error, RunDirectoryError::LatestOccupied(_)), "{error}");
        assert_eq!(names_in(folder.path()), [LATEST]);
    }
}
