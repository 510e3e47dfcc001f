//! `scanbench data prelabel`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use detector::{DetectedClass, Detection, DetectorOutput};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ListedDetector;
use evaluation::run::side_by_side::RunError;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::Annotation;
use scans::conversion::convert::sheet_of;
use scans::conversion::proposal_writer::{BoxOrigin, ProjectBox, ProposalWriter, sheet_of_proposals};
use scans::dataset::folder_name::folder_name;

use crate::cli::PrelabelArgs;
use crate::plumbing::config::{built_in_detectors, warn_of_unknown_sensor};
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::data::convert::folder_of_several;

/// Writes scans with the vehicles that a detector finds, as projects of an annotation tool.
pub fn data_prelabel(arguments: &PrelabelArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let names = std::slice::from_ref(&arguments.detector);
    let (detectors, mut config) = built_in_detectors(&arguments.config, names)?;
    let opened = open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &config.classes)?;
    let opened = look_first_at_all(opened, &mut config);
    let _new_folders = (opened.len() > 1).then(|| folder_of_several(&arguments.output)).transpose()?;
    for it in &opened {
        let path = path_of(&arguments.output, it, opened.len());
        prelabel(arguments, it, &path, &detectors[0], &config, interrupted)?;
    }
    Ok(())
}

fn path_of(output: &Path, opened: &OpenedDataset, n_datasets: usize) -> PathBuf {
    if n_datasets == 1 {
        return output.to_path_buf();
    }
    output.join(folder_name(&opened.dataset.description().id))
}

fn prelabel(
    arguments: &PrelabelArgs,
    opened: &OpenedDataset,
    path: &Path,
    listed: &ListedDetector,
    config: &RunConfig,
    interrupted: &AtomicBool,
) -> Result<(), Failure> {
    let description = opened.dataset.description();
    warn_of_unknown_sensor(config, description);
    let config = config.for_scans_of(description);
    let mut detector = listed.build(&config, description.sensor_height_m);
    let mut writer =
        ProposalWriter::create(path, arguments.to.format(), sheet_of_proposals(sheet_of(description)))?;
    let n_scans = opened.scan_indices.len();
    let progress = progress_over_scans(n_scans, &description.id);
    let (mut output, mut n_done, mut n_proposals) = (DetectorOutput::default(), 0, 0);
    for &scan_idx in &opened.scan_indices {
        if interrupted.load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { n_done, n_scans }.into());
        }
        progress.inc(1);
        let scan = match opened.dataset.read_scan(scan_idx) {
            Ok(scan) => scan,
            Err(error) => {
                let id = &opened.dataset.scan_ids()[scan_idx];
                progress.suspend(|| opened.on_damage(arguments.damage.policy(), id, error))?;
                continue;
            }
        };
        detector.detect(&scan.cloud, &mut output);
        let is_sure = |score: Option<f32>| match (score, arguments.min_score) {
            (Some(score), Some(least)) => score >= least,
            (None, Some(_)) => false,
            (_, None) => true,
        };
        let vehicles = output.detections.iter().filter(|it| it.class == DetectedClass::Vehicle);
        // Detectors of ours do not distinguish cars from vans.
        let proposal = |it: Detection<'_>| ProjectBox {
            annotation: Annotation::of(AnnotationClass::Car),
            bounding_box: it.bounding_box,
            origin: BoxOrigin::Proposed { score: it.score },
        };
        let proposals: Vec<ProjectBox> = vehicles.filter(|it| is_sure(it.score)).map(proposal).collect();
        writer.write(&scan, &proposals)?;
        n_done += 1;
        n_proposals += proposals.len();
    }
    writer.finish()?;
    progress.finish_and_clear();
    opened.warn_of_points_left_out();
    let simulated = if description.is_simulated() { ", simulated" } else { "" };
    let (path, tool) = (path.display(), arguments.to.format());
    print_result(format_args!("{path}  {n_done} scans  {n_proposals} proposals  {tool}{simulated}"))
}
