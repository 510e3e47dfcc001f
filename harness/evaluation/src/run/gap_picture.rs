//! A pair, seen from above, that one detector joins and another separates.
//!
//! Paper: HG Fig. 7.

use detector::DetectorOutput;
use detector::grid::hierarchical_grid::HierarchicalGrid;
use reports::plots::plan_plot::Plan;
use scans::annotation::LabeledScan;
use scans::dataset::Dataset as _;
use simulator::object_pair::{PairKind, PairLayout};

use crate::metrics::pair_separation::{PairOutcome, judge_pairs};
use crate::process::problem::DetectorFailure;
use crate::run::compared_detector::ComparedDetector;
use crate::run::gap_experiment::{StagedPairs, Staging};
use crate::run::running_detector::RunningDetector;
use crate::run::scan_in_drive::ScanInDrive;

/// Kind and layout of the shown pair, which is at the nearest range.
const SHOWN: (PairKind, PairLayout) = (PairKind::CarAndPedestrian, PairLayout::Beside);
/// Gaps of the searched pairs in this order, in decimetres.
const SHOWN_GAPS_DM: [u16; 4] = [5, 4, 6, 3];
/// Distance from the pair up to which points are drawn, in metres.
const ROOM_M: f32 = 0.5;
/// Most points of a detection that are drawn: more would only be a blot.
const MOST_POSITIONS: usize = 250;

/// A pair as two detectors find it.
#[derive(Debug, Clone, PartialEq)]
pub struct GapPicture {
    /// Name of the kind of the pair.
    pub pair: &'static str,
    /// The gap in metres.
    pub gap_m: f64,
    /// The detections of the detector that joins, then of the one that separates.
    pub plans: [Plan; 2],
}

/// The first of `n_pairs` pairs of which the first of `compared_detectors` makes one object and the second two; `None` if
/// there is no such pair.
///
/// # Errors
///
/// [`DetectorFailure`] if a detector gives no answer.
pub fn gap_picture(
    pairs: &StagedPairs,
    n_pairs: u32,
    compared_detectors: [&ComparedDetector; 2],
) -> Result<Option<GapPicture>, DetectorFailure> {
    let mut detectors = compared_detectors.map(|it| it.begin(pairs.description()));
    let (kind, layout) = SHOWN;
    let stagings = SHOWN_GAPS_DM
        .iter()
        .flat_map(|&gap_dm| (0..n_pairs).map(move |pair_idx| Staging { kind, layout, gap_dm, pair_idx }));
    for staging in stagings {
        let scan = pairs.scan(&staging);
        let mut look = |detector_idx: usize| {
            let detector: &mut dyn RunningDetector = detectors[detector_idx].as_mut();
            let mut output = DetectorOutput::default();
            detector.detect(&ScanInDrive::alone(&scan), &mut output)?;
            let outcomes =
                judge_pairs(&scan, &output.detections, &[[0, 1]], &compared_detectors[0].config.matching);
            Ok::<_, DetectorFailure>((
                outcomes[0],
                plan(compared_detectors[0], &scan, detector.name(), &output),
            ))
        };
        let ((joined, of_joining), (separated, of_separating)) = (look(0)?, look(1)?);
        // One object for both and one for each, without fragments: they would hide the point.
        let is_plain = of_joining.groups.len() == 1 && of_separating.groups.len() == 2;
        if (joined, separated) == (PairOutcome::Joined, PairOutcome::Separated) && is_plain {
            let gap_m = f64::from(staging.gap_dm) / 10.0;
            let plans = [of_joining, of_separating];
            return Ok(Some(GapPicture { pair: kind.name(), gap_m, plans }));
        }
    }
    Ok(None)
}

/// The detections that hold points of the first pair of `scan`.
fn plan(
    compared_detector: &ComparedDetector,
    scan: &LabeledScan,
    name: &str,
    output: &DetectorOutput,
) -> Plan {
    let of_pair = scan.annotations.iter().filter(|it| matches!(it.track, Some(0 | 1)));
    let is_of_pair =
        |point_idx: &u32| of_pair.clone().any(|it| it.point_indices.binary_search(point_idx).is_ok());
    let ends_m = of_pair.clone().flat_map(|it| &it.point_indices).fold(
        [[f32::INFINITY, f32::NEG_INFINITY]; 2],
        |ends, &point_idx| {
            let position_m = scan.cloud.position_m(point_idx as usize);
            [0, 1].map(|axis| [ends[axis][0].min(position_m[axis]), ends[axis][1].max(position_m[axis])])
        },
    );
    let is_near = |position_m: &[f32; 3]| {
        (0..2).all(|axis| (ends_m[axis][0] - ROOM_M..=ends_m[axis][1] + ROOM_M).contains(&position_m[axis]))
    };
    let holding = || output.detections.iter().filter(|it| it.point_indices.iter().any(is_of_pair));
    let positions = |point_indices: &[u32]| {
        let thinned = point_indices.iter().step_by(point_indices.len().div_ceil(MOST_POSITIONS).max(1));
        let positions_m = thinned.map(|&point_idx| scan.cloud.position_m(point_idx as usize));
        positions_m.filter(is_near).map(|[x_m, y_m, _]| [f64::from(x_m), f64::from(y_m)]).collect()
    };
    let grid = HierarchicalGrid::new(compared_detector.config.hierarchical.grid.clone());
    let cell_size_m = grid.params().cell_size_m;
    let n_found = holding().count();
    Plan {
        title: format!("{name}: {n_found} {}", if n_found == 1 { "object" } else { "objects" }),
        groups: holding().map(|it| positions(it.point_indices)).collect(),
        outlines: holding()
            .map(|it| it.bounding_box.footprint_m().map(|it| it.map(f64::from)).to_vec())
            .collect(),
        cell_sizes_m: vec![f64::from(cell_size_m) / f64::from(grid.params().xi), f64::from(cell_size_m)],
        grid_origin_m: grid.center_m(0).map(|it| f64::from(it - cell_size_m / 2.0)),
    }
}
