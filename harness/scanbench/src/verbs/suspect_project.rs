//! Suspect labels as a project of an annotation tool.

use std::path::Path;
use std::sync::atomic::Ordering;

use detector::{DetectedClass, OrientedBox, PointCloud};
use evaluation::run::side_by_side::RunError;
use reports::files::csv_rows::to_csv_bytes;
use reports::rows::match_outcome::BoxFacts;
use reports::rows::suspect_row::{SuspectBoxRow, SuspectRow};
use reports::run_folder::manifest::Manifest;
use reports::vocabulary::class::AnnotationClass;
use reports::worst::mistakes::scan_address;
use scans::annotation::{Annotation, LabeledScan, PointRegion};
use scans::conversion::convert::sheet_of;
use scans::conversion::proposal_writer::{BoxOrigin, ProjectBox, ProposalFormat, ProposalWriter};

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_diagnostic;
use crate::verbs::worst_scans::{datasets_of, place_of};

/// Writes the scans of the suspects with their labels to the folder `output`, and a box where one may be missing. The file
/// `suspects.csv` in it says which boxes are suspect, the most unusual first.
pub fn write_project(
    manifest: &Manifest,
    is_trusted: bool,
    suspects: &[SuspectRow],
    (format, output): (ProposalFormat, &Path),
) -> Result<(), Failure> {
    let datasets = datasets_of(manifest, is_trusted)?;
    let scans = by_scan(&datasets, suspects)?;
    let [first, ..] = &scans[..] else { return Ok(()) };
    let dataset_idx = first.place[0];
    if scans.iter().any(|it| it.place[0] != dataset_idx) {
        let problem =
            "the suspects are in several data sets, and a project holds one: run the detectors on each alone";
        return Err(Usage(format!("--to: {problem}")).into());
    }
    let dataset = &datasets[dataset_idx].dataset;
    let mut writer = ProposalWriter::create(output, format, sheet_of(dataset.description()))?;
    let progress = progress_over_scans(scans.len(), "scans");
    let mut rows: Vec<SuspectBoxRow> = Vec::new();
    for (n_done, SuspectScan { place: [_, scan_idx], suspects }) in scans.iter().enumerate() {
        if interruption_flag().load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { n_done, n_scans: scans.len() }.into());
        }
        let scan = dataset.read_scan(*scan_idx)?;
        let (boxes, of_file) = boxes_of(&scan, suspects);
        let file = writer.write(&labelled_part(scan), &boxes)?;
        rows.extend(of_file.into_iter().map(|(rank, place, it)| SuspectBoxRow {
            rank,
            scan: scan_address(&it.dataset, &it.sequence, it.scan),
            file: file.clone(),
            place,
            kind: it.kind,
            class: it.class.clone(),
            reason: it.reason.clone(),
        }));
        progress.inc(1);
    }
    progress.finish_and_clear();
    rows.sort_by_key(|it| it.rank);
    writer.add("suspects.csv", &to_csv_bytes(&rows)?)?;
    writer.finish()?;
    let (n_boxes, n_scans, path) = (rows.len(), scans.len(), output.display());
    print_diagnostic(format_args!(
        "Project for {format}: {path}, {n_boxes} suspects in {n_scans} scans; its suspects.csv says which boxes they are"
    ));
    if n_boxes < suspects.len() {
        let n_without = suspects.len() - n_boxes;
        print_diagnostic(format_args!(
            "{n_without} suspects have no box to correct: their labels are points alone"
        ));
    }
    Ok(())
}

/// A scan with suspects.
struct SuspectScan<'a> {
    /// Indices of its data set, and of the scan in that.
    place: [usize; 2],
    /// The suspects with their ranks.
    suspects: Vec<(u32, &'a SuspectRow)>,
}

fn by_scan<'a>(
    datasets: &[OpenedDataset],
    suspects: &'a [SuspectRow],
) -> Result<Vec<SuspectScan<'a>>, Usage> {
    let mut scans: Vec<SuspectScan<'a>> = Vec::new();
    for suspect in (1..).zip(suspects) {
        let (_, SuspectRow { dataset, sequence, scan, .. }) = suspect;
        let place = place_of(datasets, (dataset, sequence, *scan))?;
        match scans.iter_mut().find(|it| it.place == place) {
            Some(of) => of.suspects.push(suspect),
            None => scans.push(SuspectScan { place, suspects: vec![suspect] }),
        }
    }
    Ok(scans)
}

/// The boxes of a scan, and of each suspect its rank and its place among them, from 1.
fn boxes_of<'a>(
    scan: &LabeledScan,
    suspects: &[(u32, &'a SuspectRow)],
) -> (Vec<ProjectBox>, Vec<(u32, u32, &'a SuspectRow)>) {
    let labelled = scan.annotations.iter().enumerate().filter_map(|(annotation_idx, it)| {
        let annotation = Annotation { point_indices: Vec::new(), ..it.clone() };
        let (bounding_box, origin) = (it.bounding_box?, BoxOrigin::Labelled);
        Some((annotation_idx as u64, ProjectBox { annotation, bounding_box, origin }))
    });
    let (ids, mut boxes): (Vec<u64>, Vec<ProjectBox>) = labelled.unzip();
    let mut of_file = Vec::new();
    for (rank, it) in suspects {
        let place = match (it.annotation_id, it.unlabelled_box()) {
            (Some(id), _) => ids.iter().position(|it| *it == id),
            (None, Some(BoxFacts { center_m, length_width_height_m, yaw_rad })) => {
                let bounding_box = OrientedBox { center_m, length_width_height_m, yaw_rad };
                let origin = BoxOrigin::Proposed { score: None };
                let annotation = Annotation::of(class_of(&it.class));
                boxes.push(ProjectBox { annotation, bounding_box, origin });
                Some(boxes.len() - 1)
            }
            (None, None) => None,
        };
        of_file.extend(place.map(|place| (*rank, place as u32 + 1, *it)));
    }
    (boxes, of_file)
}

/// `scan` with the points alone of which its labels say something: a project is labelled all round.
fn labelled_part(scan: LabeledScan) -> LabeledScan {
    let mut cloud = PointCloud::with_capacity(scan.cloud.len());
    let points = scan.cloud.positions_m().zip(scan.cloud.intensity()).zip(&scan.point_regions);
    for ((position_m, intensity), _) in points.filter(|(_, it)| **it != PointRegion::Outside) {
        cloud.push(position_m, *intensity);
    }
    LabeledScan::everywhere(scan.id, cloud, scan.annotations)
}

/// The class that is labelled where detectors see something of class `found`.
fn class_of(found: &str) -> AnnotationClass {
    if found == DetectedClass::Vehicle.name() {
        return AnnotationClass::Car;
    }
    AnnotationClass::met(found).unwrap_or(AnnotationClass::Misc)
}
