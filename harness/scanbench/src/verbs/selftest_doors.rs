//! `scanbench selftest`: annotations on every way that detections come from elsewhere, with their classes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use detector::{Detection, DetectorOutput};
use evaluation::matching::assign::{MatchingParams, assign};
use evaluation::matching::criterion::Criterion;
use evaluation::matching::eligibility::EligibilityParams;
use evaluation::metrics::counts::{Counts, FalseDetections};
use evaluation::protocols::chosen_protocols::ScanUnderProtocols;
use evaluation::protocols::official_objects::OfficialScanView;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::foreign_detector::{ForeignDetector, ForeignProcess, ForeignWork, VehicleRule};
use evaluation::run::running_detector::RunningDetector;
use evaluation::run::scan_in_drive::ScanInDrive;
use reports::files::hidden_folder::HiddenFolder;
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::WrittenWords;
use reports::vocabulary::named::named;
use reports::vocabulary::task::Task;
use reports::vocabulary::taxonomy::class_named;
use scans::annotation::LabeledScan;
use scans::conversion::results::result_folder::{ResultFolder, ResultOutput};
use scans::conversion::whole_folder::WholeFolder;
use scans::dataset::folder_name::folder_name;
use scans::foreign::foreign_results::{MissingResults, ResultRequest, open_results};

use crate::cli::RESULTS;
use crate::plumbing::failure::Failure;
use crate::plumbing::named_box::NamedBox;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::progress::progress_over_scans;
use crate::verbs::selftest_checked::{Checked, largest_cost};

named! {
    /// A way on which detections come from elsewhere.
    pub enum Door {
        /// A program that runs beside this one.
        Process = "a process",
        /// Files of boxes of our own.
        Csv = "files of CSV",
        /// KITTI's files.
        Kitti = "KITTI's files",
        /// nuScenes' submission.
        Nuscenes = "nuScenes' file",
        /// Argoverse 2's table.
        Argoverse2 = "Argoverse 2's file",
    }
}

/// What this way has for a class.
type WordOf = fn(&WrittenWords) -> &Option<String>;

impl Door {
    fn output(self) -> Option<ResultOutput> {
        match self {
            Self::Process | Self::Csv => None,
            Self::Kitti => Some(ResultOutput::Kitti),
            Self::Nuscenes => Some(ResultOutput::NuScenes),
            Self::Argoverse2 => Some(ResultOutput::Argoverse2),
        }
    }

    /// The class that a detection of `class` has behind this way; `None` if none comes through.
    fn class_behind(self, class: AnnotationClass) -> Option<AnnotationClass> {
        let word: WordOf = match self {
            Self::Process | Self::Csv | Self::Kitti => return Some(class),
            Self::Nuscenes => |it| &it.nuscenes,
            Self::Argoverse2 => |it| &it.argoverse2,
        };
        class_named(word(&class.traits().written).as_ref()?)
    }

    /// Most that a centre may be off behind it, in metres: files have so many decimals.
    fn rounding_m(self) -> f64 {
        match self {
            Self::Process | Self::Csv => 1e-4,
            Self::Kitti | Self::Nuscenes | Self::Argoverse2 => 0.02,
        }
    }
}

/// The doors of a data set, with the detections that came through them.
pub struct Doors {
    detectors: Vec<(Door, Box<dyn RunningDetector>)>,
    // Files that detectors read as long as they run.
    _folder: HiddenFolder,
    // The classes that the words of the labels say: a bicycle with a rider may be called like one without.
    said: BTreeSet<AnnotationClass>,
    annotated: BTreeSet<AnnotationClass>,
    checks: BTreeMap<(Door, Task), Counts>,
    largest_cost_m: BTreeMap<(Door, Task), f64>,
}

impl Doors {
    /// Writes the annotations of `opened` for every way that there is for its scans; `None` if none has a box.
    pub fn open(opened: &OpenedDataset) -> Result<Option<Self>, Failure> {
        let cannot = |error| Failure::internal("cannot write the echoed annotations", error);
        let folder = HiddenFolder::beside(&std::env::temp_dir().join("scanbench-selftest"), "partial");
        let folder = folder.map_err(cannot)?;
        let dataset = &*opened.dataset;
        // A damaged scan is reported when it is judged.
        let mut frames =
            opened.scan_indices.iter().filter_map(|it| Some((*it, dataset.foreign_frame(*it).ok()?)));
        let Some((first, frame)) = frames.next() else { return Ok(None) };
        let id = &dataset.scan_ids()[first];
        let runs_here = |door: &Door| *door != Door::Process || cfg!(target_os = "linux");
        let is_open =
            |door: &Door| runs_here(door) && door.output().is_none_or(|it| it.check(id, &frame).is_ok());
        let doors: Vec<Door> = Door::ALL.into_iter().filter(is_open).collect();
        let path_of = |door: Door| folder.path().join(format!("{door:?}"));
        let mut written: Vec<ResultFolder> = Vec::new();
        for door in &doors {
            let Some(output) = door.output() else { continue };
            let mut results = ResultFolder::create(&path_of(*door), output, false)?;
            results.begin_dataset(dataset.description());
            written.push(results);
        }
        let said = write_echo(opened, &path_of(Door::Csv), written)?;
        let Some(said) = said else { return Ok(None) };
        let detectors = doors.into_iter().map(|door| {
            let path = match door {
                Door::Process | Door::Csv => path_of(Door::Csv),
                Door::Kitti | Door::Nuscenes | Door::Argoverse2 => path_of(door).join(LABELS),
            };
            Ok((door, detector_of(door, &path, opened)?))
        });
        let detectors = detectors.collect::<Result<Vec<_>, Failure>>()?;
        let (checks, largest_cost_m) = (BTreeMap::new(), BTreeMap::new());
        Ok(Some(Self {
            detectors,
            _folder: folder,
            said,
            annotated: BTreeSet::new(),
            checks,
            largest_cost_m,
        }))
    }

    /// The rows under protocols of what comes through each door.
    pub fn rows(
        &mut self,
        scan: &LabeledScan,
        under: &ScanUnderProtocols<'_>,
    ) -> Result<Vec<OfficialRows>, Failure> {
        let mut output = DetectorOutput::default();
        let rows = self.detectors.iter_mut().map(|(door, detector)| {
            detector.detect(&ScanInDrive::alone(scan), &mut output)?;
            Ok(under.rows(door.name(), &**detector, &output))
        });
        rows.collect()
    }

    /// Judges what comes through each door of `scan`.
    pub fn judge(&mut self, opened: &OpenedDataset, scan: &LabeledScan) -> Result<(), Failure> {
        let annotated = &opened.dataset.description().annotated;
        let params =
            MatchingParams { criterion: Criterion::CENTRE, eligibility: EligibilityParams::STANDARD };
        let classes = scan.annotations.iter().map(|it| it.class).filter(|it| *it != AnnotationClass::Misc);
        let mut tasks: Vec<Task> = Task::ALL.into_iter().chain(classes.map(Task::Class)).collect();
        tasks.sort_unstable();
        tasks.dedup();
        tasks.retain(|it| it.class().is_none_or(|it| self.said.contains(&it)));
        self.annotated.extend(scan.annotations.iter().map(|it| it.class));
        let mut output = DetectorOutput::default();
        for (door, detector) in &mut self.detectors {
            detector.detect(&ScanInDrive::alone(scan), &mut output)?;
            for task in tasks.iter().filter(|it| door.carries(**it)) {
                let assignment = assign(scan, &output.detections, *task, annotated, &params);
                *self.checks.entry((*door, *task)).or_default() += Counts::of(&assignment);
                let largest = self.largest_cost_m.entry((*door, *task)).or_default();
                *largest = largest.max(largest_cost(&assignment));
            }
        }
        Ok(())
    }

    /// The doors that are open.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.detectors.iter().map(|(door, _)| door.name())
    }

    /// Whether an annotation of the class `it` may be called `class` behind `door`.
    fn is_called(&self, door: Door, it: AnnotationClass, class: AnnotationClass) -> bool {
        let is_unsaid = !self.said.contains(&it) && it.group() == class.group();
        is_unsaid || door.class_behind(it) == Some(class)
    }

    /// The checks of everything that was judged.
    pub fn checked(&self, opened: &OpenedDataset) -> Vec<Checked> {
        let description = opened.dataset.description();
        let check = |((door, task), counts): (&(Door, Task), &Counts)| {
            // Others that the words call the same are false detections of it.
            let is_shared = task.class().is_some_and(|class| {
                let others = self.annotated.iter().filter(|it| **it != class);
                { others }.any(|it| self.is_called(*door, *it, class))
            });
            let cost_m = self.largest_cost_m.get(&(*door, *task)).copied().unwrap_or_default();
            Checked {
                dataset: description.id.clone(),
                task: *task,
                criterion: Criterion::CENTRE,
                through: Some(door.name()),
                counts: *counts,
                false_detections: match FalseDetections::of(&description.annotated, *task) {
                    FalseDetections::Known if is_shared => FalseDetections::Unknowable,
                    known => known,
                },
                most_cost: door.rounding_m(),
                largest_cost: cost_m,
            }
        };
        self.checks.iter().filter(|(_, counts)| counts.n_annotations > 0).map(check).collect()
    }
}

/// Writes the annotations of `opened` as CSV into `folder`, and as the results that are being `written`. Returns the classes
/// that their words say; `None` if no annotation has a box.
fn write_echo(
    opened: &OpenedDataset,
    folder: &Path,
    mut written: Vec<ResultFolder>,
) -> Result<Option<BTreeSet<AnnotationClass>>, Failure> {
    let boxes = WholeFolder::create(folder)?;
    let (mut n_boxes, mut said) = (0, BTreeSet::new());
    let progress = progress_over_scans(opened.scan_indices.len(), &opened.dataset.description().id);
    for &scan_idx in &opened.scan_indices {
        progress.inc(1);
        // Damage is reported when the scan is judged.
        let Ok(scan) = opened.dataset.read_scan(scan_idx) else { continue };
        let output = OfficialScanView::new(&*opened.dataset, scan_idx, &scan)?.echoed_output();
        n_boxes += output.detections.len();
        let name = format!("{}/{:06}.csv", folder_name(&scan.id.sequence), scan.id.index);
        boxes.write(&name, &box_table(&output)?)?;
        said.extend(output.detections.iter().filter_map(|it| AnnotationClass::from_name(it.given?.name())));
        let frame = opened.dataset.foreign_frame(scan_idx)?;
        written.iter_mut().try_for_each(|it| it.add(LABELS, &scan, &frame, &output))?;
    }
    progress.finish_and_clear();
    boxes.finish()?;
    for mut results in written {
        results.end_dataset()?;
        results.finish()?;
    }
    Ok((n_boxes > 0).then_some(said))
}

impl Door {
    /// Whether all annotations that `task` asks for come through.
    fn carries(self, task: Task) -> bool {
        match (self, task) {
            (Self::Nuscenes | Self::Argoverse2, Task::Objects) => false,
            (_, Task::Objects | Task::Vehicles) => true,
            (_, Task::Class(class)) => self.class_behind(class) == Some(class),
        }
    }
}

/// Name of the detector that the annotations are said to be of.
const LABELS: &str = "labels";

fn detector_of(door: Door, path: &Path, opened: &OpenedDataset) -> Result<Box<dyn RunningDetector>, Failure> {
    let work = match door {
        Door::Process => ForeignWork::Process(process_of(path)?),
        _ => ForeignWork::Results(path.to_path_buf()),
    };
    let foreign =
        ForeignDetector { name: door.name(), folder: PathBuf::from("."), work, vehicles: VehicleRule::Size };
    let config =
        RunConfig::without_vehicle_models().map_err(|it| Failure::internal("built-in values", it))?;
    let compared = ComparedDetector::of(ChosenDetector::Foreign(foreign), &config);
    let description = opened.dataset.description();
    if door == Door::Process {
        return Ok(compared.begin(description));
    }
    let request = ResultRequest {
        scan_indices: &opened.scan_indices,
        classes: &opened.classes,
        missing: MissingResults::AreEmpty,
    };
    let results = open_results(path, &*opened.dataset, &request)?;
    Ok(compared.begin_with_results(description, results))
}

fn process_of(folder: &Path) -> Result<ForeignProcess, Failure> {
    let program =
        std::env::current_exe().map_err(|error| Failure::internal("cannot find this program", error))?;
    let words = [program.as_path(), Path::new("serve"), Path::new(RESULTS), Path::new("--results"), folder];
    Ok(ForeignProcess {
        command: words.map(|it| it.to_string_lossy().into_owned()).to_vec(),
        start_limit: Duration::from_mins(1),
        time_limit: Duration::from_mins(1),
        threads: 1,
        sandbox: false,
        files: BTreeMap::new(),
        introduction: Arc::default(),
    })
}

/// The boxes of `output`, each with the word of its detector.
fn box_table(output: &DetectorOutput) -> Result<Vec<u8>, Failure> {
    let cannot = |error: csv::Error| Failure::internal("cannot write the echoed annotations", error);
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(NamedBox::COLUMNS).map_err(cannot)?;
    for it in output.detections.iter().map(|it| named_box(&it)) {
        writer.serialize(it).map_err(cannot)?;
    }
    writer
        .into_inner()
        .map_err(|error| Failure::internal("cannot write the echoed annotations", error.into_error()))
}

fn named_box(detection: &Detection<'_>) -> NamedBox {
    let [center_x_m, center_y_m, center_z_m] = detection.bounding_box.center_m;
    let [length_m, width_m, height_m] = detection.bounding_box.length_width_height_m;
    let class = detection.given.map_or("object", |it| it.word()).to_owned();
    let yaw_rad = detection.bounding_box.yaw_rad;
    NamedBox { class, center_x_m, center_y_m, center_z_m, length_m, width_m, height_m, yaw_rad }
}
