//! `scanbench boxes`.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use clap::Args;
use evaluation::metrics::box_errors::BoxErrors;
use evaluation::run::box_study::{BoxPair, FITS, box_error_lines, box_pairs, box_points};
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ListedDetector;
use jiff::Timestamp;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::box_errors::BoxErrorLine;
use reports::plots::box_plot::box_plot;
use reports::plots::box_points_plot::box_points_plot;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::box_error_row::{BoxErrorRow, BoxPointsRow, FittedBoxRow, MatchedVehicle};
use reports::tables::studies::box_table::BoxTable;

use crate::cli::{BlocksArgs, ConfigArgs, DatasetArgs, MatchingArgs, NoRecordingArgs, OutputArgs};
use crate::plumbing::config::{built_in_detectors, choose_matching, warn_of_unknown_sensor};
use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::named_blocks::with_named_blocks;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::recorder::say_that_none_is_written;
use crate::plumbing::run_directory::begin_run_directory;
use crate::plumbing::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::plumbing::standard_streams::{print_result_in, terminal};

/// Arguments of `scanbench boxes`.
#[derive(Debug, Args)]
#[command(after_help = BOXES_EXAMPLES)]
pub struct BoxesArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
    /// Parameters of the hierarchical detector and of matching.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How clusters are matched.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where tables and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// That it has no recording.
    #[command(flatten)]
    pub recording: NoRecordingArgs,
}

const BOXES_EXAMPLES: &str = "\
Examples:
  scanbench boxes
  scanbench boxes streets ~/data/kitti_tracking -o runs/boxes

Fits boxes to each cluster of the hierarchical detector that matches an annotated car,
van, truck or bus: to its convex hull, along its principal axes, closest to its points,
and along the outline that the sensor sees. The fifth is the reported box. Writes
boxes.csv with every box; box_errors.csv and box_errors.md with median errors and
shares by class, occlusion, range and number of points, and 95 % intervals;
box_points.csv with the positions of points in the boxes of each class; a plot and a
picture of these points for simulated data and each recorded data set; manifest.json.";

/// Fewer vehicles of a class than this make no picture of their points.
const FEWEST_SHOWN: usize = 10;
const NOTES: [&str; 2] = [
    "centre, length, width, yaw: medians of absolute errors; the others are shares. pairs: clusters of the \
     hierarchical detector that match an annotated car, van, truck or bus; all boxes are fitted to the same points. \
     centre: distance seen from above; yaw: modulo 180 degrees, so at most 90; front right: within 90 degrees of the annotated heading. \
     reported box: that of the detector, whole where it classifies the cluster as a vehicle; the other boxes are of what is seen, \
     and have no front. front sure: of the reported boxes that are whole.",
    "Annotated boxes contain the whole vehicle, also the sides that the sensor does not see. A box around the visible \
     points is therefore shorter or narrower, even if it is right.",
];

/// Fits boxes in several ways to the same matched clusters, and writes and prints how far they are from annotated ones.
pub fn boxes(arguments: &BoxesArgs) -> Result<(), Failure> {
    say_that_none_is_written(&arguments.recording, "boxes");
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let (detectors, mut config) = built_in_detectors(&arguments.config, &["hierarchical".to_owned()])?;
    choose_matching(&mut config, &arguments.matching)?;
    let opened = open_datasets(&arguments.data, &config.classes)?;
    let opened = with_named_blocks(opened, arguments.blocks.blocks.as_deref())?;
    let opened = look_first_at_all(opened, &mut config);
    let unnamed = format!("{}-boxes-{}", compact_utc(started), ids_of(&opened));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let groups = collect_all(&opened, &detectors[0], &config, interrupted)?;
    if groups.iter().all(|it| it.pairs.is_empty()) {
        return Err(NothingEvaluated { reason: "no cluster matches an annotated vehicle".to_owned() }.into());
    }
    let lines: Vec<Vec<BoxErrorLine>> =
        groups.iter().map(|it| box_error_lines(&it.pairs, &it.name, it.is_simulated)).collect();
    let manifest = run_manifest(RunSettings {
        selection: arguments.data.scans.as_deref(),
        n_warmup: 0,
        n_repeats: NonZeroUsize::MIN,
        config: &config,
        detectors: vec![detector_entry(&ComparedDetector::of(detectors[0], &config))],
        datasets: &opened,
        protocols: &[],
        started,
    });
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    write_pairs(&directory, &groups)?;
    write_points(&directory, &groups)?;
    for (group, lines) in groups.iter().zip(&lines) {
        let title = format!(
            "Boxes of matched vehicles, {}: median errors and shares, with 95 % intervals",
            group.file_stem()
        );
        write_figure(&directory, &format!("boxes_{}", group.file_stem()), &box_plot(lines, &title))?;
    }
    let lines = lines.concat();
    write_lines(&directory, &lines)?;
    let finished = directory.finish()?;
    print_result_in(
        "Tables and plots",
        &finished,
        terminal().text(&BoxTable { lines: &lines, notes: &NOTES }),
    )
}

/// Pairs that are looked at together: all simulated ones, or those of a recorded data set.
struct Group<'a> {
    name: String,
    is_simulated: bool,
    /// Pairs with the ids of their data sets.
    pairs: Vec<(&'a str, BoxPair)>,
}

impl Group<'_> {
    fn file_stem(&self) -> &str {
        if self.is_simulated { "simulated" } else { &self.name }
    }
}

fn collect_all<'a>(
    opened: &'a [OpenedDataset],
    listed: &ListedDetector,
    config: &RunConfig,
    interrupted: &AtomicBool,
) -> Result<Vec<Group<'a>>, Failure> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for it in opened {
        let description = it.dataset.description();
        warn_of_unknown_sensor(config, description);
        let of_sensor = config.for_scans_of(description);
        let found = it.look(interrupted, |pass| box_pairs(pass, listed, &of_sensor))?;
        let found = found.into_iter().map(|it| (description.id.as_str(), it));
        let is_simulated = description.is_simulated();
        match groups.iter_mut().find(|it| is_simulated && it.is_simulated) {
            Some(group) => {
                group.name = format!("{}, {}", group.name, description.id);
                group.pairs.extend(found);
            }
            None => groups.push(Group { name: description.id.clone(), is_simulated, pairs: found.collect() }),
        }
    }
    Ok(groups)
}

fn write_pairs(directory: &RunDirectory, groups: &[Group<'_>]) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file("boxes.csv")?)?;
    for group in groups {
        for (dataset, pair) in &group.pairs {
            let scan = pair.scan.to_string();
            let vehicle = MatchedVehicle {
                data: dataset,
                is_simulated: group.is_simulated,
                scan: &scan,
                class: pair.class,
                track: pair.track,
                occlusion: pair.occlusion,
                range_m: pair.range_m,
                n_points: pair.n_points,
            };
            for (fit, errors) in FITS.iter().zip(&pair.errors) {
                let BoxErrors { centre_m, length_m, width_m, yaw_rad, is_front_right, bev_iou, iou_3d } =
                    *errors;
                let errors = [centre_m, length_m, width_m, yaw_rad.to_degrees(), bev_iou, iou_3d];
                let is_front_sure = pair.is_front_sure.filter(|_| *fit == FITS[FITS.len() - 1]);
                rows.write(&FittedBoxRow::new(vehicle, fit, errors, is_front_right, is_front_sure))?;
            }
        }
    }
    rows.finish()?;
    Ok(())
}

/// Where points lie in their boxes, as rows and as a picture of each group.
fn write_points(directory: &RunDirectory, groups: &[Group<'_>]) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file("box_points.csv")?)?;
    for group in groups {
        let points = box_points(&group.pairs);
        for of_frame in points.iter().flatten() {
            for row in BoxPointsRow::of(&group.name, group.is_simulated, of_frame) {
                rows.write(&row)?;
            }
        }
        let stem = group.file_stem();
        let shown: Vec<_> = points.into_iter().filter(|it| it[0].n_vehicles >= FEWEST_SHOWN).collect();
        if shown.is_empty() {
            continue;
        }
        let title = format!(
            "Points of matched vehicles in the frames of boxes, {stem}: each shade is half as full as the next fuller one"
        );
        write_figure(directory, &format!("box_points_{stem}"), &box_points_plot(&shown, &title))?;
    }
    rows.finish()?;
    Ok(())
}

fn write_lines(directory: &RunDirectory, lines: &[BoxErrorLine]) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file("box_errors.csv")?)?;
    for row in lines.iter().flat_map(BoxErrorRow::of) {
        rows.write(&row)?;
    }
    rows.finish()?;
    write_table(directory, "box_errors", &BoxTable { lines, notes: &NOTES })?;
    Ok(())
}
