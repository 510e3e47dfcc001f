//! Rerun's web viewer beside the page of a run.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use evaluation::run::scan_recorder::{Mark, MarksByScan};
use flate2::read::GzDecoder;
use reports::facts::run_facts::RunFacts;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::read_rows;
use reports::files::new_file::make_folder;
use reports::files::regular_file::RegularFile;
use reports::files::whole_set::WholeSet;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::run_directory::{RECORDING, SCANS_CSV, VIEWER, VIEWER_PLACES_JSON};
use reports::worst::objects::ObjectName;
use reports::worst::recorded::{RecordedObject, Recordings};
use scans::dataset::checksum::sha256;

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::recorder::record_marks;
use crate::plumbing::remote::local_name;
use crate::plumbing::scans_in_order::scans_in_order;
use crate::verbs::run::setup::arguments_of;

/// Rerun publishes its web viewer in this package, for programs that serve it.
const ARCHIVE: &str =
    "https://static.crates.io/crates/re_web_viewer_server/re_web_viewer_server-0.36.3.crate";
const ARCHIVE_SHA256: &str = "82d1d7ba0b0f236a054ec1e2bf044fbf03f23f2ba408ebaff00b2d1bdc8275a5";
/// Its files.
const VIEWER_FILES: [&str; 2] = ["re_viewer.js", "re_viewer_bg.wasm"];
/// More is in none of them.
const MOST_BYTES: u64 = 1 << 27;
/// What opens them.
const PAGE: &str = include_str!("viewer.html");

/// Writes the web viewer, from the file `archive` or else from its publisher, into the directory of a run, and pointers at its
/// worst mistakes into its recording.
pub fn add_viewer(directory: &Path, archive: Option<&Path>) -> Result<(), Failure> {
    let facts = RunFacts::read(directory).map_err(|error| Failure::damaged_run(directory, error))?;
    let places = places_of(directory, &facts)?;
    let fetched = if archive.is_some() { None } else { Some(local_name(ARCHIVE, None)?) };
    let archive = archive.map_or_else(|| PathBuf::from(fetched.unwrap_or_default().as_ref()), Path::to_owned);
    let content = viewer_files(&archive)?;
    record_marks(&directory.join(RECORDING), &marks_of(&facts, &places))?;
    let unwritten = |source| ArchiveError::Write { path: directory.join(VIEWER), source };
    let files = WholeSet::within(&make_folder(directory, VIEWER).map_err(unwritten)?)?;
    for (name, content) in content {
        files.write(name, &content)?;
    }
    files.write("index.html", PAGE.as_bytes())?;
    files.write(VIEWER_PLACES_JSON, Recordings::new(places).to_json().as_bytes())?;
    Ok(files.finish()?)
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

/// Where the worst mistakes are in the recordings of the run in `directory`.
fn places_of(directory: &Path, facts: &RunFacts) -> Result<Vec<RecordedObject>, Failure> {
    let refused = |problem: &str| Failure::from(Usage(format!("--with-viewer: {problem}")));
    if !directory.join(RECORDING).is_dir() {
        return Err(refused("the run has no recording; make it without --no-rrd and --save-rrd=FILE"));
    }
    let manifest = &facts.manifest;
    if manifest.datasets.iter().any(|it| !it.skipped_scans.is_empty()) {
        return Err(refused(
            "damaged scans were left out, and the numbers of the others in the recording are not known",
        ));
    }
    let rows: Vec<ScanRow> =
        read_rows(&directory.join(SCANS_CSV)).map_err(|error| Failure::damaged_run(directory, error))?;
    let order = scans_in_order(&rows);
    let every = arguments_of(manifest)?.stream.every(order.len());
    let numbers: BTreeMap<_, u64> = order.into_iter().zip(0..).collect();
    let mut places = Vec::new();
    for (_, worst) in facts.worst() {
        let ObjectName { dataset, sequence, scan, .. } = &worst.object;
        let place = match facts.recorded(&worst.object) {
            Some(recorded) => Some((recorded.recording.clone(), recorded.step)),
            None => numbers
                .get(&(dataset.clone(), sequence.clone(), *scan))
                .filter(|it| it.is_multiple_of(u64::from(every)))
                .map(|it| (RECORDING.to_owned(), *it)),
        };
        let is_new = places.iter().all(|it: &RecordedObject| it.object != worst.object);
        // One in another directory is not served with the page.
        if let Some((recording, step)) = place.filter(|(it, _)| is_new && !it.contains('/')) {
            places.push(RecordedObject { object: worst.object.clone(), recording, step });
        }
    }
    Ok(places)
}

/// Pointers at the mistakes that are in the first recording.
fn marks_of(facts: &RunFacts, places: &[RecordedObject]) -> MarksByScan {
    let mut marks = MarksByScan::new();
    for (list, worst) in facts.worst() {
        let place = places.iter().find(|it| it.object == worst.object && it.recording == RECORDING);
        let (Some(kind), Some(place)) = (list.kind, place) else { continue };
        let mark = Mark {
            position_m: worst.window.center_m,
            text: format!("{} {}: {}", kind.name(), worst.class, worst.reason),
            change: None,
        };
        let of_scan = marks.entry(list.detector.clone()).or_default().entry(place.step as i64).or_default();
        if !of_scan.contains(&mark) {
            of_scan.push(mark);
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plumbing::recorder::rerun_version;

    #[test]
    fn the_web_viewer_is_that_of_the_recordings() {
        let version = rerun_version().unwrap_or("0.36.3".to_owned());
        let version = version.split_whitespace().find(|it| it.starts_with(|it: char| it.is_ascii_digit()));
        assert!(ARCHIVE.ends_with(&format!("-{}.crate", version.unwrap_or_default())), "{version:?}");
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
