//! Rerun's web viewer beside the page of a run.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use evaluation::run::scan_recorder::{Mark, MarksByDetector};
use flate2::read::GzDecoder;
use reports::facts::run_facts::RunFacts;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::read_rows;
use reports::files::new_file::make_folder;
use reports::files::regular_file::RegularFile;
use reports::files::whole_set::WholeSet;
use reports::pages::sweep_page::SweepPage;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::run_directory::{
    PARTIAL_CSV, RECORDING, RECORDINGS_JSON, SCANS_CSV, VIEWER, VIEWER_PLACES_JSON,
};
use reports::vocabulary::reason::ShownKind;
use reports::worst::recorded::{RecordedObject, Recordings};
use scans::dataset::checksum::sha256;

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::recorder::{record_marks, rerun_version};
use crate::plumbing::remote::local_name;
use crate::plumbing::scans_in_order::{ScanKey, scans_in_order};
use crate::plumbing::standard_streams::print_diagnostic;
use crate::verbs::run::setup::arguments_of;

/// Rerun publishes its web viewer in this package, for programs that serve it.
const ARCHIVE: &str =
    "https://static.crates.io/crates/re_web_viewer_server/re_web_viewer_server-0.36.3.crate";
const ARCHIVE_SHA256: &str = "82d1d7ba0b0f236a054ec1e2bf044fbf03f23f2ba408ebaff00b2d1bdc8275a5";
/// Its files.
const VIEWER_FILES: [&str; 2] = ["re_viewer.js", "re_viewer_bg.wasm"];
/// No file of it is larger.
const MOST_BYTES: u64 = 1 << 27;
/// What opens them.
const PAGE: &str = include_str!("viewer.html");

/// Writes the web viewer, from the file `archive` or else from its publisher by way of the folder `cache`, into the directory of a run, and pointers at its
/// worst mistakes into its recording.
pub fn add_viewer(directory: &Path, archive: Option<&Path>, cache: Option<&Path>) -> Result<(), Failure> {
    if rerun_version().is_none() {
        return Err(refused("it needs Rerun, but this program was built without it"));
    }
    if SweepPage::is_sweep(directory) || directory.join(PARTIAL_CSV).is_file() {
        return Err(refused(ONLY_RUNS));
    }
    let facts = RunFacts::read(directory).map_err(|error| Failure::damaged_run(directory, error))?;
    let places = places_of(directory, &facts)?;
    let archive = archive.map_or_else(|| fetched(cache), |it| Ok(it.to_owned()))?;
    let content = viewer_files(&archive)?;
    for (recording, marks) in marks_of(&facts, &places) {
        record_marks(&directory.join(recording), &marks)?;
    }
    let unwritten = |source| ArchiveError::Write { path: directory.join(VIEWER), source };
    let files = WholeSet::within(&make_folder(directory, VIEWER).map_err(unwritten)?)?;
    for (name, content) in content {
        files.write(name, &content)?;
    }
    files.write("index.html", PAGE.as_bytes())?;
    files.write(VIEWER_PLACES_JSON, Recordings::new(places).to_json().as_bytes())?;
    Ok(files.finish()?)
}

/// The archive of the viewer, from its publisher.
fn fetched(cache: Option<&Path>) -> Result<PathBuf, Failure> {
    print_diagnostic(format_args!("Rerun's web viewer, 14 MB, once for all runs: {ARCHIVE}"));
    let fetched = local_name(ARCHIVE, cache);
    if fetched.is_err() {
        print_diagnostic("Where there is no network, --with-viewer=FILE takes that archive");
    }
    Ok(PathBuf::from(fetched?.as_ref()))
}

/// The files of the viewer in the `archive`.
fn viewer_files(archive: &Path) -> Result<Vec<(&'static str, Vec<u8>)>, Failure> {
    let refused = |problem: String| Failure::from(Usage(format!("{}: {problem}", archive.display())));
    let unread = |error: std::io::Error| refused(error.to_string());
    let mut packed = Vec::new();
    RegularFile::open(archive).map_err(unread)?.take(MOST_BYTES).read_to_end(&mut packed).map_err(unread)?;
    let sum = sha256(&packed);
    if sum != ARCHIVE_SHA256 {
        return Err(refused(format!("its SHA-256 is {sum}, but that of {ARCHIVE} is {ARCHIVE_SHA256}")));
    }
    let mut files = Vec::new();
    let mut unpacked = tar::Archive::new(GzDecoder::new(&packed[..]));
    for entry in unpacked.entries().map_err(unread)? {
        let entry = entry.map_err(unread)?;
        let path = entry.path().map_err(unread)?.into_owned();
        if let Some(name) = VIEWER_FILES.iter().find(|it| path.ends_with(Path::new("web_viewer").join(it))) {
            let mut content = Vec::new();
            entry.take(MOST_BYTES).read_to_end(&mut content).map_err(unread)?;
            files.push((*name, content));
        }
    }
    Ok(files)
}

const ONLY_RUNS: &str = "only a page of `scanbench run` shows its mistakes in the viewer";

fn refused(problem: &str) -> Failure {
    Usage(format!("--with-viewer: {problem}")).into()
}

/// Where the worst mistakes are in the recordings of the run in `directory`: none where their scans are not recorded.
fn places_of(directory: &Path, facts: &RunFacts) -> Result<Vec<RecordedObject>, Failure> {
    let manifest = &facts.manifest;
    let Ok(arguments) = arguments_of(manifest) else { return Err(refused(ONLY_RUNS)) };
    let is_in_parts = directory.join(RECORDINGS_JSON).is_file();
    if !is_in_parts && !directory.join(RECORDING).is_dir() {
        return Err(refused("the run has no recording; make it without --no-rrd and --save-rrd=FILE"));
    }
    if manifest.datasets.iter().any(|it| !it.skipped_scans.is_empty()) {
        let problem =
            "damaged scans were left out, and the numbers of the others in the recording are not known";
        return Err(refused(problem));
    }
    let rows: Vec<ScanRow> =
        read_rows(&directory.join(SCANS_CSV)).map_err(|error| Failure::damaged_run(directory, error))?;
    let order = scans_in_order(&rows);
    let every = u64::from(arguments.stream.every(order.len()));
    let numbers: BTreeMap<ScanKey, u64> = order.into_iter().zip(0..).collect();
    let mut places: Vec<RecordedObject> = Vec::new();
    for (_, worst) in facts.worst() {
        let object = &worst.object;
        let place = if is_in_parts {
            facts.recorded(object).cloned()
        } else {
            let number = numbers.get(&(object.dataset.clone(), object.sequence.clone(), object.scan));
            number.filter(|it| it.is_multiple_of(every)).map(|&step| {
                let (object, recording) = (object.clone(), RECORDING.to_owned());
                RecordedObject { object, recording, step }
            })
        };
        let is_new = places.iter().all(|it| it.object != *object);
        // A recording in another directory is not served with the page.
        places
            .extend(place.filter(|it| {
                is_new && directory.join(&it.recording).is_dir() && !it.recording.contains('/')
            }));
    }
    if places.is_empty() {
        return Err(refused("none of its mistakes is in a recording in its directory"));
    }
    Ok(places)
}

/// Pointers at the mistakes, for each recording.
fn marks_of(facts: &RunFacts, places: &[RecordedObject]) -> BTreeMap<String, MarksByDetector> {
    let mut marks: BTreeMap<String, MarksByDetector> = BTreeMap::new();
    for (list, worst) in facts.worst() {
        let place = places.iter().find(|it| it.object == worst.object);
        let Some(RecordedObject { recording, step, .. }) = place.filter(|_| list.kind != ShownKind::Matched)
        else {
            continue;
        };
        let mark = Mark {
            position_m: worst.window.center_m,
            text: format!("{} {}: {}", list.kind, worst.class, worst.reason),
            change: None,
        };
        let of_detector =
            marks.entry(recording.clone()).or_default().entry(list.detector.clone()).or_default();
        let of_scan = of_detector.entry(*step as i64).or_default();
        if !of_scan.contains(&mark) {
            of_scan.push(mark);
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(feature = "viewer")]
    #[test]
    fn the_web_viewer_is_that_of_the_recordings() {
        let version = rerun_version().unwrap();
        assert!(ARCHIVE.ends_with(&format!("-{version}.crate")), "{version}");
    }

    #[test]
    fn another_archive_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let archive = folder.path().join("viewer.crate");
        std::fs::write(&archive, "theirs").unwrap();
        let refused = viewer_files(&archive).unwrap_err().to_string();
        assert!(refused.contains("its SHA-256 is"), "{refused}");
    }
}
