//! Boxes of different fits around the same clusters, compared with the annotated boxes.

use std::collections::{BTreeMap, BTreeSet};

use detector::{Detection, Detector, DetectorOutput, OrientedBox};
use rayon::prelude::*;
use reports::numbers::blocks::{BlockCount, BlockKind, Blocks, DriveSecond, FEWEST_DRIVES};
use reports::numbers::box_errors::{BoxError, BoxErrorLine};
use reports::numbers::box_points::{BoxPoints, FramedPoints};
use reports::uncertainty::bootstrap::Resamples;
use reports::uncertainty::value_interval::{mean_within, median_within};
use reports::vocabulary::class::{AnnotationClass, Occlusion};
use reports::vocabulary::task::Task;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::scan_times::scan_times;

use crate::matching::assign::assign;
use crate::matching::eligibility::counts_as_vehicle;
use crate::matching::outcome::AnnotationOutcome;
use crate::metrics::box_errors::BoxErrors;
use crate::object_box::ObjectBox;
use crate::run::config::RunConfig;
use crate::run::detector_list::ListedDetector;
use crate::scan_pass::{PassedScan, ScanPass, ScanPassError};

/// Number of boxes around the same points.
pub const N_FITS: usize = ObjectBox::ALL.len() + 1;
/// Names of the boxes: those of the fits, and the one that the detector reports.
pub const FITS: [&str; N_FITS] = ["hull box", "PCA box", "closeness box", "outline box", "reported box"];
/// Slices by the number of points of the cluster, from and to (exclusive).
const POINTS: [[usize; 2]; 4] = [[0, 30], [30, 100], [100, 300], [300, usize::MAX]];

/// Ranges of the annotations, from and to in metres.
pub const RANGES_M: [[f64; 2]; 4] = [[0.0, 15.0], [15.0, 30.0], [30.0, 50.0], [50.0, 80.0]];
/// Occlusions, as annotated.
const OCCLUSIONS: [Option<Occlusion>; 4] =
    [Some(Occlusion::None), Some(Occlusion::Partly), Some(Occlusion::Largely), None];

/// An annotated vehicle with a matched cluster, and the errors of boxes around the cluster.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPair {
    /// The scan.
    pub scan: ScanId,
    /// Second of the drive, for the blocks of the intervals.
    pub second: DriveSecond,
    /// Class of the vehicle.
    pub class: AnnotationClass,
    /// Its number within the drive.
    pub track: Option<u32>,
    /// How much of it is hidden, if annotated.
    pub occlusion: Option<Occlusion>,
    /// Distance of its annotation from the sensor on the ground plan, in metres.
    pub range_m: f64,
    /// Points of the cluster.
    pub n_points: usize,
    /// The errors of the fits, as [`FITS`] has them.
    pub errors: [BoxErrors; N_FITS],
    /// Whether the detector is sure which end is the front, if it says so.
    pub is_front_sure: Option<bool>,
    /// The points in the frames of [`FRAMES`].
    pub framed: [FramedCluster; FRAMES.len()],
}

/// The boxes in whose frames points are shown. The hull box has no front of its own: it gets the end that is nearer to the
/// annotated front.
pub const FRAMES: [&str; 3] = ["annotated box", "hull box", "reported box"];

/// The points of a cluster in the frame of a box.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FramedCluster {
    /// Length and width of the box, in metres.
    pub length_width_m: [f32; 2],
    /// The points along the length and across, from the centre, in metres.
    pub positions_m: Vec<[f32; 2]>,
}

impl FramedCluster {
    fn new(frame: &OrientedBox, positions_m: &[[f32; 3]]) -> Self {
        let [length_m, width_m, _] = frame.length_width_height_m;
        let in_frame_m = |&position_m: &[f32; 3]| {
            let [along_m, across_m, _] = frame.in_box_frame(position_m);
            [along_m, across_m]
        };
        Self {
            length_width_m: [length_m, width_m],
            positions_m: positions_m.iter().map(in_frame_m).collect(),
        }
    }
}

/// All pairs of the scans of `pass`, in their order. The clusters are those of `listed` with `config`, matched as objects,
/// so that their predicted class does not matter.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn box_pairs(
    pass: ScanPass<'_>,
    listed: &ListedDetector,
    config: &RunConfig,
) -> Result<Vec<BoxPair>, ScanPassError> {
    let description = pass.dataset.description();
    let times = scan_times(pass.dataset);
    let new_detector = || listed.build(config, description.sensor_height_m);
    let of_scan = |detector: &mut Box<dyn Detector>, PassedScan { scan_idx, scan }: PassedScan<'_>| {
        let mut output = DetectorOutput::default();
        detector.detect(&scan.cloud, &mut output);
        let detections = &output.detections;
        let assignment = assign(scan, detections, Task::Objects, &description.annotated, &config.matching);
        let second = &times[scan_idx].second;
        let pairs = assignment.annotations.iter().enumerate().filter_map(|(annotation_idx, outcome)| {
            let AnnotationOutcome::Matched { detection_idx, .. } = *outcome else { return None };
            box_pair(scan, second, annotation_idx, detections.get(detection_idx))
        });
        pairs.collect::<Vec<BoxPair>>()
    };
    Ok(pass.over(new_detector, of_scan)?.into_iter().flatten().collect())
}

/// `None` if the annotation is no vehicle, or has no box.
fn box_pair(
    scan: &LabeledScan,
    second: &DriveSecond,
    annotation_idx: usize,
    detection: Detection<'_>,
) -> Option<BoxPair> {
    let annotation = &scan.annotations[annotation_idx];
    let annotated = annotation.bounding_box.filter(|_| counts_as_vehicle(annotation.class))?;
    let positions_m: Vec<[f32; 3]> =
        detection.point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
    let [hull, pca, closeness, outline] = ObjectBox::ALL.map(|it| it.around(&positions_m));
    let fitted = [hull?, pca?, closeness?, outline?, detection.bounding_box];
    Some(BoxPair {
        scan: scan.id.clone(),
        second: second.clone(),
        class: annotation.class,
        track: annotation.track,
        occlusion: annotation.occlusion,
        range_m: annotated.range_m().into(),
        n_points: positions_m.len(),
        errors: fitted.map(|it| BoxErrors::of(&it, &annotated)),
        is_front_sure: detection.box_details.seen.map(|it| it.is_front_sure),
        framed: [annotated, turned_to(fitted[0], &annotated), fitted[N_FITS - 1]]
            .map(|it| FramedCluster::new(&it, &positions_m)),
    })
}

/// Where the points of each class of `pairs` lie, class by class and within a class as [`FRAMES`] has them.
pub fn box_points(pairs: &[(&str, BoxPair)]) -> Vec<Vec<BoxPoints>> {
    let classes: BTreeSet<AnnotationClass> = pairs.iter().map(|it| it.1.class).collect();
    let of_class = |class: AnnotationClass| {
        let of_frame = |frame_idx: usize| {
            let here = pairs.iter().filter(|it| it.1.class == class).map(|it| &it.1.framed[frame_idx]);
            let vehicles = here.map(|FramedCluster { length_width_m, positions_m }| FramedPoints {
                length_width_m: *length_width_m,
                positions_m,
            });
            BoxPoints::of(class, FRAMES[frame_idx], vehicles)
        };
        (0..FRAMES.len()).map(of_frame).collect()
    };
    classes.into_iter().map(of_class).collect()
}

/// The box, turned by half a turn if its front is then nearer to the front of `other`.
fn turned_to(it: OrientedBox, other: &OrientedBox) -> OrientedBox {
    let is_against = (it.yaw_rad - other.yaw_rad).cos() < 0.0;
    if is_against { OrientedBox { yaw_rad: it.yaw_rad + std::f32::consts::PI, ..it } } else { it }
}

/// Kind of a slice, its name, and its pairs with the ids of their data sets.
type PairSlice<'a> = (&'a str, String, Vec<&'a (&'a str, BoxPair)>);

/// The medians of all errors, or the means of shares, over `pairs`, each with the id of its data set: over all, by
/// occlusion, range, class and number of points. `data` names the data.
pub fn box_error_lines(pairs: &[(&str, BoxPair)], data: &str, is_simulated: bool) -> Vec<BoxErrorLine> {
    let slices = slices_of(pairs);
    let drives: BTreeSet<(&str, &str)> = pairs.iter().map(|it| (it.0, it.1.second.drive())).collect();
    let kind = match Blocks::of(pairs.iter().map(|it| it.1.second.clone())).count().kind {
        kind @ (BlockKind::Named | BlockKind::Scans) => kind,
        _ if drives.len() >= FEWEST_DRIVES => BlockKind::Drives,
        _ => BlockKind::Tracks,
    };
    let lines_of = |(by, slice, pairs): &PairSlice<'_>| -> Vec<BoxErrorLine> {
        let line = |error: BoxError| {
            // All pairs, but for numbers that the detector does not report for each.
            let pairs: Vec<&(&str, BoxPair)> =
                pairs.iter().copied().filter(|it| absolute(&it.1, N_FITS - 1, error).is_some()).collect();
            let n_tracks = blocks(&pairs, BlockKind::Tracks).1.n_blocks;
            let (block_of_pair, count) = blocks(&pairs, kind);
            let resamples = Resamples::draw(data, count);
            let number = |fit_idx: usize| {
                let errors = pairs.iter().map(|it| absolute(&it.1, fit_idx, error));
                let of_blocks =
                    errors.zip(&block_of_pair).filter_map(|(error, block)| Some((error?, *block)));
                let of_blocks: Vec<(f64, usize)> = of_blocks.collect();
                let within = if error.is_share() { mean_within } else { median_within };
                within(&of_blocks, &resamples)
            };
            BoxErrorLine {
                data: data.to_owned(),
                is_simulated,
                by: (*by).to_owned(),
                slice: slice.clone(),
                error,
                n_pairs: pairs.len() as u64,
                n_tracks,
                fits: (0..).zip(FITS).map(|(idx, fit)| (fit, number(idx))).collect(),
            }
        };
        let shown = if *by == "all" { &BoxError::ALL[..] } else { &BoxError::OF_SLICES };
        shown.iter().map(|it| line(*it)).collect()
    };
    slices.par_iter().flat_map_iter(lines_of).collect()
}

/// All pairs, and those of each slice, with the names of what they are sliced by.
fn slices_of<'a>(pairs: &'a [(&'a str, BoxPair)]) -> Vec<PairSlice<'a>> {
    let mut slices: Vec<PairSlice<'_>> = vec![("all", String::new(), pairs.iter().collect())];
    for occlusion in OCCLUSIONS {
        let of_slice: Vec<_> = pairs.iter().filter(|it| it.1.occlusion == occlusion).collect();
        // The slice of unknown occlusion is left out if it is empty.
        if occlusion.is_some() || !of_slice.is_empty() {
            slices.push(("occlusion", occlusion.map_or("not said", Occlusion::name).to_owned(), of_slice));
        }
    }
    for [from_m, to_m] in RANGES_M {
        let of_slice = pairs.iter().filter(|it| (from_m..to_m).contains(&it.1.range_m)).collect();
        slices.push(("range", format!("{from_m}–{to_m} m"), of_slice));
    }
    let classes: BTreeSet<&str> = pairs.iter().map(|it| it.1.class.name()).collect();
    for class in classes {
        let of_slice = pairs.iter().filter(|it| it.1.class.name() == class).collect();
        slices.push(("class", class.to_owned(), of_slice));
    }
    for [from, to] in POINTS {
        let of_slice = pairs.iter().filter(|it| (from..to).contains(&it.1.n_points)).collect();
        let name = if to == usize::MAX { format!("{from} and more") } else { format!("{from}–{}", to - 1) };
        slices.push(("points", name, of_slice));
    }
    slices
}

/// Number of the drive or track of each pair, from 0, and how many there are. A pair without a track is a track of its own.
fn blocks(pairs: &[&(&str, BoxPair)], kind: BlockKind) -> (Vec<usize>, BlockCount) {
    let mut numbers = BTreeMap::new();
    let of_pairs = pairs.iter().enumerate().map(|(index, (dataset, pair))| {
        let own_idx = if pair.track.is_none() { Some(index) } else { None };
        let are_drives = matches!(kind, BlockKind::Drives | BlockKind::Named);
        let within_drive = if are_drives { None } else { Some((pair.track, own_idx)) };
        let next = numbers.len();
        *numbers.entry((*dataset, pair.second.drive(), within_drive)).or_insert(next)
    });
    let of_pairs: Vec<usize> = of_pairs.collect();
    (of_pairs, BlockCount::of_dataset(numbers.len() as u64, kind))
}

/// Value of `error` for a box of `pair`; 100 or 0 if it is a share. `None` if there is no value.
fn absolute(pair: &BoxPair, fit_idx: usize, error: BoxError) -> Option<f64> {
    let errors = &pair.errors[fit_idx];
    // Only for the reported box.
    let is_front_sure = pair.is_front_sure.filter(|_| fit_idx + 1 == N_FITS);
    let yaw_deg = errors.yaw_rad.to_degrees();
    let percent = |is_so: bool| if is_so { 100.0 } else { 0.0 };
    Some(match error {
        BoxError::Centre => errors.centre_m,
        BoxError::Length => errors.length_m.abs(),
        BoxError::Width => errors.width_m.abs(),
        BoxError::Yaw => yaw_deg,
        BoxError::Yaw5 => percent(yaw_deg <= 5.0),
        BoxError::Yaw10 => percent(yaw_deg <= 10.0),
        BoxError::Bev50 => percent(errors.bev_iou >= 0.5),
        BoxError::Bev70 => percent(errors.bev_iou >= 0.7),
        BoxError::Space50 => percent(errors.iou_3d >= 0.5),
        BoxError::Space70 => percent(errors.iou_3d >= 0.7),
        BoxError::Front => percent(errors.is_front_right),
        BoxError::FrontSure => percent(is_front_sure?),
        BoxError::SureFront => percent(is_front_sure.filter(|it| *it).map(|_| errors.is_front_right)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(sequence: &str, track: Option<u32>, range_m: f64, length_m: f64) -> (&'static str, BoxPair) {
        let errors = |factor: f64| BoxErrors {
            centre_m: factor,
            length_m: factor * length_m,
            width_m: 0.0,
            yaw_rad: 0.0,
            is_front_right: factor > 0.0,
            bev_iou: 0.6,
            iou_3d: 0.4,
        };
        let scan = ScanId { sequence: sequence.to_owned(), index: 0 };
        let occlusion = (range_m < 30.0).then_some(Occlusion::Partly);
        let class = AnnotationClass::Car;
        (
            "street",
            BoxPair {
                second: DriveSecond::of(sequence, 0.0),
                scan,
                class,
                track,
                occlusion,
                range_m,
                n_points: 30,
                errors: [errors(1.0), errors(-2.0), errors(1.0), errors(1.0), errors(1.0)],
                is_front_sure: track.map(|it| it == 1),
                framed: Default::default(),
            },
        )
    }

    #[test]
    fn fits_have_their_names() {
        assert!(ObjectBox::ALL.iter().zip(FITS).all(|(it, name)| it.name() == name));
    }

    #[test]
    fn of_ten_drives_whole_drives_are_drawn() {
        let names: Vec<String> = (0..10).map(|it| it.to_string()).collect();
        let of = |n: usize| {
            let pairs: Vec<_> =
                (0..3 * n).map(|it| pair(&names[it / 3], Some(it as u32), 10.0, it as f64)).collect();
            let lines = box_error_lines(&pairs, "street", true);
            let all = lines.iter().find(|it| it.by == "all").unwrap();
            (all.n_tracks, all.fits[0].1.unwrap().within.unwrap().blocks)
        };
        assert_eq!(of(10), (30, BlockCount::of_dataset(10, BlockKind::Drives)));
        assert_eq!(of(9), (27, BlockCount::of_dataset(27, BlockKind::Tracks)));
    }

    #[test]
    fn of_scans_without_times_nothing_is_sure() {
        let of = |block: Option<&str>| {
            let pairs: Vec<_> = (0..12)
                .map(|scan| {
                    let (dataset, pair) = pair("training", None, 10.0, f64::from(scan));
                    let second = DriveSecond::of_scan("training", scan, block, None);
                    (dataset, BoxPair { second, ..pair })
                })
                .collect();
            box_error_lines(&pairs, "kitti", false)[0].fits[0].1.unwrap().within.map(|it| it.blocks)
        };
        assert_eq!(of(None), Some(BlockCount::of_dataset(12, BlockKind::Scans)));
        // All pairs are in one block, so no interval can be estimated.
        assert_eq!(of(Some("crossing")), None);
    }

    #[test]
    fn a_sure_front_is_that_of_the_reported_box_and_right_or_not() {
        let mut pairs = [1, 1, 2].map(|track| pair("a", Some(track), 10.0, 1.0));
        pairs[0].1.errors[N_FITS - 1].is_front_right = false;
        let lines = box_error_lines(&pairs, "street", true);
        let of = |error: BoxError| {
            let line = lines.iter().find(|it| it.error == error).unwrap();
            [0, N_FITS - 1].map(|fit_idx| line.fits[fit_idx].1.map(|it| it.value.round()))
        };
        assert_eq!(of(BoxError::Front), [Some(100.0), Some(67.0)]);
        assert_eq!(of(BoxError::FrontSure), [None, Some(67.0)]);
        assert_eq!(of(BoxError::SureFront), [None, Some(50.0)]);
        let counts = |error: BoxError| {
            let line = lines.iter().find(|it| it.error == error).unwrap();
            (line.n_pairs, line.n_tracks)
        };
        assert_eq!((counts(BoxError::FrontSure), counts(BoxError::SureFront)), ((3, 2), (2, 1)));
    }

    #[test]
    fn a_box_is_turned_to_the_front_of_another() {
        let at =
            |yaw_rad| OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad };
        for (yaw_rad, expected_rad) in
            [(0.2, 0.2), (3.0, 3.0 + std::f32::consts::PI), (-3.1, -3.1 + std::f32::consts::PI)]
        {
            assert_eq!(turned_to(at(yaw_rad), &at(0.1)).yaw_rad, expected_rad);
        }
    }

    #[test]
    fn slices_hold_their_pairs_and_tracks_and_errors_have_no_sign() {
        let pairs = [
            pair("a", Some(1), 10.0, -1.0),
            pair("a", Some(1), 14.9, -3.0),
            pair("b", Some(1), 15.0, 2.0),
            pair("b", None, 60.0, 5.0),
            pair("b", None, 60.0, 5.0),
        ];
        let lines = box_error_lines(&pairs, "street", true);
        let line = |by: &str, slice: &str| {
            let error = if by == "all" { BoxError::Length } else { BoxError::Centre };
            lines.iter().find(|it| it.by == by && it.slice == slice && it.error == error).unwrap()
        };
        let numbers = |by, slice| (line(by, slice).n_pairs, line(by, slice).n_tracks);
        assert_eq!(numbers("all", ""), (5, 4));
        assert_eq!(numbers("range", "0–15 m"), (2, 1));
        assert_eq!(numbers("range", "15–30 m"), (1, 1));
        assert_eq!(numbers("range", "30–50 m"), (0, 0));
        assert_eq!(numbers("occlusion", "partly"), (3, 2));
        assert_eq!(numbers("occlusion", "not said"), (2, 2));
        let medians = line("all", "").fits.iter().map(|it| it.1.unwrap().value).collect::<Vec<_>>();
        assert_eq!(medians, [3.0, 6.0, 3.0, 3.0, 3.0]);
        assert_eq!(line("range", "30–50 m").fits[0].1, None);
    }
}
