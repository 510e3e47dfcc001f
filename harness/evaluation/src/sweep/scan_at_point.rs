//! What is kept of one scan at one point of a sweep.

use detector::DetectorOutput;
use detector::grid::cell_fitness::CellTally;
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use reports::numbers::blocks::DriveSecond;
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;
use scans::dataset::DatasetDescription;
use serde::{Deserialize, Serialize};

use crate::matching::assign::assign;
use crate::metrics::counts::Counts;
use crate::process::problem::DetectorFailure;
use crate::protocols::chosen_protocols::ScanUnderProtocols;
use crate::run::config::RunConfig;
use crate::run::detector_list::ChosenDetector;
use crate::run::entrant::Entrant;
use crate::sweep::programs::Programs;
use crate::sweep::sweep_plan::SweepPlan;

/// One scan at one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanAtPoint {
    /// Index of the data set among those of the sweep.
    pub dataset_idx: usize,
    /// Index of the scan among those taken from the data set.
    pub scan_idx: usize,
    /// Number of the scan within its drive.
    pub scan: u32,
    /// The drive.
    pub sequence: String,
    /// The second of its drive that it was taken in.
    pub second: DriveSecond,
    /// Index of the point in the plan.
    pub point_idx: usize,
    /// What each detector made of it, in the order of the plan.
    pub detectors: Vec<DetectorAtPoint>,
    /// The rows of protocols of others.
    #[serde(default, skip_serializing_if = "OfficialRows::is_empty")]
    pub official: OfficialRows,
}

impl ScanAtPoint {
    /// The order of results: data set, scan, point.
    pub fn key(&self) -> [usize; 3] {
        [self.dataset_idx, self.scan_idx, self.point_idx]
    }
}

/// A scan that is looked at.
#[derive(Clone, Copy)]
pub struct LookedAt<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// When it was taken, in seconds since the first of its drive.
    pub time_s: f64,
    /// The same under protocols of others, if it is to be evaluated by some.
    pub official: Option<&'a ScanUnderProtocols<'a>>,
}

/// What one detector made of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetectorAtPoint {
    /// For each of [`Task::ALL`].
    pub counts: Vec<Counts>,
    /// The cells of its grid, if it starts from one.
    pub cells: Option<CellTally>,
}

/// Lets all detectors look at a scan with the parameters of the points `point_idxs`; `on_point` is given what they made of
/// it at one point after the other, until it returns an error. Detectors that are programs are those of `programs`, started
/// where there is none.
///
/// # Errors
///
/// What `on_point` returns, or [`DetectorFailure`] of a detector that gives no answer.
pub fn look_at_points<E: From<DetectorFailure>>(
    plan: &SweepPlan,
    programs: &Programs,
    dataset: &DatasetDescription,
    looked_at: LookedAt<'_>,
    point_idxs: &[usize],
    mut on_point: impl FnMut(usize, Vec<DetectorAtPoint>, OfficialRows) -> Result<(), E>,
) -> Result<(), E> {
    let LookedAt { scan, time_s, official } = looked_at;
    let mut output = DetectorOutput::default();
    let mut cells = CellsOfScan::default();
    for &point_idx in point_idxs {
        let config = plan.points[point_idx].config.for_scans_of(dataset);
        let (mut looked, mut rows) = (Vec::new(), OfficialRows::default());
        for chosen in &plan.detectors {
            let entrant = Entrant::of(chosen.clone(), &plan.points[point_idx].config);
            let program = programs.take(dataset, entrant.name);
            let mut detector =
                entrant.begin_with(dataset, program).map_err(|it| plan.at_point(point_idx, it))?;
            detector.detect(scan, time_s, &mut output).map_err(|it| plan.at_point(point_idx, it))?;
            if let Some(official) = official {
                rows.append(official.rows(entrant.name, &*detector, &output));
            }
            programs.put_back(dataset, entrant.name, detector);
            let counts = Task::ALL.iter().map(|&task| {
                Counts::of(&assign(scan, &output.detections, task, &dataset.annotated, &config.matching))
            });
            let counts = counts.collect();
            let cells = grid_of(chosen, &config).map(|grid| cells.tally(scan, &grid, &config));
            looked.push(DetectorAtPoint { counts, cells });
        }
        on_point(point_idx, looked, rows)?;
    }
    Ok(())
}

/// The grid that a detector starts from; `None` if the cells of its clusters are no parameter of it.
fn grid_of(chosen: &ChosenDetector, config: &RunConfig) -> Option<GridParams> {
    match chosen.table().as_str() {
        "hierarchical" => Some(GridParams { xi: 1, ..config.hierarchical.grid.clone() }),
        "paper" => Some(GridParams { xi: 1, ..config.paper.grid.clone() }),
        "pca" => {
            let grid = &config.baselines.pca.grid;
            Some(GridParams { cell_size_m: grid.cell_size_m, xi: 1, extent_m: grid.extent_m })
        }
        _ => None,
    }
}

/// The cells of a scan on one grid after another. Most sweeps have the same grid at several points or in several detectors.
#[derive(Default)]
struct CellsOfScan {
    counted: Vec<(GridParams, f32, CellTally)>,
}

impl CellsOfScan {
    fn tally(&mut self, scan: &LabeledScan, params: &GridParams, config: &RunConfig) -> CellTally {
        let ground_extent_m = config.hierarchical.ground.max_ground_extent_m;
        let same = |it: &&(GridParams, f32, CellTally)| it.0 == *params && it.1 == ground_extent_m;
        if let Some((_, _, tally)) = self.counted.iter().find(same) {
            return *tally;
        }
        let mut grid = HierarchicalGrid::new(params.clone());
        grid.fill(&scan.cloud);
        let tally = CellTally::of(&grid, ground_extent_m);
        self.counted.push((params.clone(), ground_extent_m, tally));
        tally
    }
}
