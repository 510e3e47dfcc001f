//! Reads the results of another program for a data set from a path.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::argoverse2_table::Argoverse2Tables;
use super::detections::ForeignDetections;
use super::kitti_text::KittiText;
use super::nuscenes_json::NuScenesJson;
use super::own_files::{self, OwnFiles};
use super::points_in_boxes::PointsAlongX;
use super::recorded_detections::{RecordedDetections, split_topic};
use super::result_files::ResultFiles;
use super::result_format::{ResultFormat, format_of};
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use super::semantic_labels::{self, SemanticLabels};
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::checksum::{DatasetChecksum, sha256};
use crate::dataset::class_table::{ClassRules, ClassTable};
use crate::dataset::folder_name::folder_name;
use crate::dataset::on_disk::{bytes_of, entries_of, n_bytes_of};
use crate::dataset::{Dataset, DatasetError};

/// At most this many names are listed in messages.
const MAX_LISTED: usize = 10;

/// Boxes nearer than this should hold points, in metres.
const NEAR_M: f32 = 40.0;

/// If a greater share of boxes is empty, something is wrong with frames, calibration or times.
const MAX_EMPTY_SHARE: f64 = 0.5;

/// At most this many folders are searched for results.
const MAX_LOOKED_INTO: usize = 20;

/// At most this many boxes of a scan are counted for it.
const MAX_COUNTED: usize = 1000;

/// Handling of scans without results.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MissingResults {
    /// They are errors.
    #[default]
    Refuse,
    /// They count as scans without detections.
    AreEmpty,
}

/// The results that are asked for, and how to read them.
#[derive(Debug, Clone, Copy)]
pub struct ResultRequest<'a> {
    /// The scans that are asked for, as indices in [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// Classes of names, from the user.
    pub classes: &'a ClassTable,
    /// Handling of scans without results.
    pub missing: MissingResults,
}

/// Detections of another program in the scans of a data set.
pub struct ForeignResults {
    path: PathBuf,
    format: ResultFormat,
    dataset: String,
    checksum: String,
    files: BTreeMap<String, String>,
    opened: OpenResults,
    asked: BTreeMap<ScanId, usize>,
    missing: MissingResults,
    n_missing: usize,
    n_near_boxes: usize,
    n_empty_boxes: usize,
}

/// Opens the results at `path`, a file or folder whose format is recognised by its content; `recording.mcap:/topic` also
/// names a topic.
pub fn open_results(
    path: &Path,
    dataset: &dyn Dataset,
    request: &ResultRequest<'_>,
) -> Result<ForeignResults, DatasetError> {
    open_at(path, dataset, request).map_err(|mut error| {
        let said = match &mut error {
            DatasetError::UnusableResults { problem, .. } => Some(problem),
            DatasetError::MissingResults { n_missing, n_asked, first, .. } if n_missing == n_asked => {
                Some(first)
            }
            _ => None,
        };
        if let Some(said) = said {
            let folders = folders_with_results(path, dataset, request);
            let names: Vec<String> = folders.iter().map(|it| format!("{it:?}")).collect();
            if !names.is_empty() {
                let _ = write!(said, "; folders in it have results, name one of them: {}", listed(&names));
            }
        }
        error
    })
}

/// The folders in `path` with the results that are asked for, as `--detections-out` writes them: one for each detector, and
/// in it one for each data set.
fn folders_with_results(path: &Path, dataset: &dyn Dataset, request: &ResultRequest<'_>) -> Vec<PathBuf> {
    let mut folders = entries_of(path).unwrap_or_default();
    folders.retain(|it| it.is_dir());
    folders.truncate(MAX_LOOKED_INTO);
    let request = ResultRequest { missing: MissingResults::Refuse, ..*request };
    let of_dataset = folder_name(&dataset.description().id);
    let has_all = |it: &PathBuf| {
        [it.clone(), it.join(&of_dataset)].iter().any(|it| open_at(it, dataset, &request).is_ok())
    };
    folders.retain(has_all);
    folders
}

fn open_at(
    path: &Path,
    dataset: &dyn Dataset,
    request: &ResultRequest<'_>,
) -> Result<ForeignResults, DatasetError> {
    let (path, topic) = split_topic(path);
    let files = ResultFiles::below(&path)?;
    let rules = ClassRules { table: request.classes.clone(), ..ClassRules::default() };
    let of = ResultsOf::new(dataset, request.scan_indices, &rules)?;
    let (format, file) = format_of(&files, dataset)?;
    let opened = match format {
        ResultFormat::KittiText => KittiText::open(&files, of)?,
        ResultFormat::NuScenesJson => NuScenesJson::open(&file, &of)?,
        ResultFormat::Argoverse2Tables => Argoverse2Tables::open(&path, &format.files(&files, dataset), of)?,
        ResultFormat::SemanticLabels => SemanticLabels::open(&files, &of),
        ResultFormat::OwnFiles => OwnFiles::open(&files, &of),
        ResultFormat::Recording => RecordedDetections::open(&file, topic.as_deref(), &of)?,
    };
    let id_of = |&scan_idx: &usize| (dataset.scan_ids()[scan_idx].clone(), scan_idx);
    let (checksum, files) = checksums_of(format, &files, dataset, request.scan_indices)?;
    let mut results = ForeignResults {
        path,
        format,
        dataset: dataset.description().id.clone(),
        checksum,
        files,
        opened,
        asked: request.scan_indices.iter().map(id_of).collect(),
        missing: request.missing,
        n_missing: 0,
        n_near_boxes: 0,
        n_empty_boxes: 0,
    };
    results.check_presence()?;
    Ok(results)
}

/// Detections that are in memory, by scan.
struct InMemory(Vec<ForeignDetections>);

impl ResultReader for InMemory {
    fn has(&self, scan_idx: usize) -> bool {
        scan_idx < self.0.len()
    }

    fn read(&mut self, scan_idx: usize, _: &LabeledScan) -> FoundInScan {
        Ok(self.0.get(scan_idx).cloned())
    }
}

impl ForeignResults {
    /// The detections `found`, an entry for each scan of `dataset`, as files of our own have them.
    pub fn in_memory(dataset: &dyn Dataset, found: Vec<ForeignDetections>) -> Self {
        Self {
            path: PathBuf::from("memory"),
            format: ResultFormat::OwnFiles,
            dataset: dataset.description().id.clone(),
            checksum: String::new(),
            files: BTreeMap::new(),
            opened: OpenResults::new(InMemory(found), Vec::new()),
            asked: dataset.scan_ids().iter().cloned().zip(0..).collect(),
            missing: MissingResults::Refuse,
            n_missing: 0,
            n_near_boxes: 0,
            n_empty_boxes: 0,
        }
    }

    /// The format; its name is shown on screens.
    pub fn format(&self) -> ResultFormat {
        self.format
    }

    /// A checksum that changes with the results. Like that of a data set it covers the content of all files, but of
    /// recordings the size. If each scan has files of its own, it covers only those of the scans that are asked for.
    pub fn checksum(&self) -> &str {
        &self.checksum
    }

    /// The files that the checksum covers, by name: SHA-256 of their content, but of recordings the size.
    pub fn files(&self) -> &BTreeMap<String, String> {
        &self.files
    }

    /// Reads the detections in `scan`; `None` if there are no results for it, and that counts as no detections.
    pub fn read(&mut self, scan: &LabeledScan) -> Result<Option<ForeignDetections>, DatasetError> {
        let Some(&scan_idx) = self.asked.get(&scan.id) else {
            return Err(self.lacks(&[&scan.id], 1));
        };
        let Some(found) = self.opened.reader.read(scan_idx, scan)? else {
            return match self.missing {
                MissingResults::Refuse => Err(self.lacks(&[&scan.id], 1)),
                MissingResults::AreEmpty => Ok(None),
            };
        };
        found.check(scan.cloud.len()).map_err(|problem| {
            let problem = format!("has damaged results for scan {}: {problem}", scan.id);
            DatasetError::Damaged { path: self.path.clone(), problem }
        })?;
        self.count_boxes(scan, &found);
        Ok(Some(found))
    }

    /// Possible errors, a line each: after opening about results that are missing or left over, and after the last scan
    /// about its boxes.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let path = &self.path;
        let OpenResults { left_over, oddities, .. } = &self.opened;
        if !left_over.is_empty() {
            let (n, names) = (left_over.len(), listed(left_over));
            warnings
                .push(format!("{path:?} has results for {n} scans that the data set does not have: {names}"));
        }
        warnings.extend(oddities.iter().map(|it| format!("{path:?}: {it}")));
        if self.n_missing > 0 {
            warnings.push(format!(
                "{path:?} has no results for {} scans, which count as nothing found",
                self.n_missing
            ));
        }
        if self.n_empty_boxes as f64 > MAX_EMPTY_SHARE * self.n_near_boxes as f64 {
            warnings.push(format!(
                "{path:?}: {} of {} boxes nearer than {NEAR_M} m contain no point: the results and scans may differ in \
                 frame, calibration or time",
                self.n_empty_boxes, self.n_near_boxes
            ));
        }
        warnings
    }

    fn check_presence(&mut self) -> Result<(), DatasetError> {
        let missing = self.asked.iter().filter(|(_, scan_idx)| !self.opened.reader.has(**scan_idx));
        let missing: Vec<&ScanId> = missing.map(|(id, _)| id).collect();
        self.n_missing = missing.len();
        match self.missing {
            MissingResults::Refuse if !missing.is_empty() => Err(self.lacks(&missing, self.asked.len())),
            _ => Ok(()),
        }
    }

    fn lacks(&self, missing: &[&ScanId], n_asked: usize) -> DatasetError {
        let names: Vec<String> = missing.iter().map(ToString::to_string).collect();
        let others = match &self.opened.left_over[..] {
            [] => String::new(),
            left_over => format!("; it has others: {}", listed(left_over)),
        };
        let first =
            format!("{}{others}; --missing-detections empty counts them as nothing found", listed(&names));
        DatasetError::MissingResults {
            path: self.path.clone(),
            dataset: self.dataset.clone(),
            n_missing: missing.len(),
            n_asked,
            first,
        }
    }

    fn count_boxes(&mut self, scan: &LabeledScan, found: &ForeignDetections) {
        if scan.cloud.is_empty() {
            return;
        }
        let near = found.boxes.iter().filter(|it| it.bounding_box.range_m() < NEAR_M);
        let mut points = None;
        for it in near.take(MAX_COUNTED) {
            let points = points.get_or_insert_with(|| PointsAlongX::of(&scan.cloud));
            self.n_near_boxes += 1;
            self.n_empty_boxes += usize::from(!points.is_any_inside(&scan.cloud, &it.bounding_box));
        }
    }
}

/// The checksum of all files with results, and the checksum of each by its name.
fn checksums_of(
    format: ResultFormat,
    files: &ResultFiles,
    dataset: &dyn Dataset,
    scan_indices: &[usize],
) -> Result<(String, BTreeMap<String, String>), DatasetError> {
    let of_scans = |endings: &[&str]| {
        let of_ending = |ending: &&str| {
            let mut by_scan = files.of_scans(dataset, ending);
            scan_indices.iter().filter_map(|it| by_scan.remove(it)).collect::<Vec<_>>()
        };
        endings.iter().flat_map(of_ending).collect::<Vec<PathBuf>>()
    };
    let paths = match format {
        ResultFormat::SemanticLabels => of_scans(&[semantic_labels::ENDING]),
        ResultFormat::OwnFiles => of_scans(&own_files::ENDINGS),
        _ => format.files(files, dataset).into_iter().map(Path::to_path_buf).collect(),
    };
    let (mut checksum, mut of_files) = (DatasetChecksum::default(), BTreeMap::new());
    for path in paths {
        // Empty if the user named the file itself.
        let name = path.strip_prefix(files.root()).unwrap_or(&path).to_string_lossy().into_owned();
        let of_file = if format == ResultFormat::Recording {
            let n_bytes = n_bytes_of(&path)?;
            checksum.add_scan(&name, n_bytes);
            format!("{n_bytes} bytes")
        } else {
            let of_content = sha256(bytes_of(&path)?);
            checksum.add_hashed(&name, &of_content);
            of_content
        };
        let own_name = || path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        of_files.insert(if name.is_empty() { own_name() } else { name }, of_file);
    }
    Ok((checksum.finish(), of_files))
}

/// The first of `names`, and the number of the others.
fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(MAX_LISTED)].join(", ");
    match names.len().saturating_sub(MAX_LISTED) {
        0 => first,
        n_more => format!("{first} and {n_more} more"),
    }
}
