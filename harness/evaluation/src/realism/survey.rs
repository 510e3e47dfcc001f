//! Numbers of the scans of a data set for all statistics.

use detector::grid::ring_density::RingCounts;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::foreground;
use detector::pipeline::stage_list::Pipeline;
use detector::segment::foreground::Foreground;
use detector::{Detector, DetectorOutput};
use scans::annotation::LabeledScan;

use super::cell_classes::CellCounts;
use super::height_histogram::HeightCounts;
use super::points_per_car::CarsInScan;
use super::whole_scans::{GroundCount, cluster_ranges_m, n_returns};
use crate::scan_pass::{ScanPass, ScanPassError};

/// Numbers of one scan for all statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyedScan {
    /// Number of returns.
    pub n_returns: u64,
    /// Points of the ground.
    pub ground: GroundCount,
    /// Points by range.
    pub rings: RingCounts,
    /// Annotated cars.
    pub cars: CarsInScan,
    /// How far away the clusters are, in metres.
    pub cluster_ranges_m: Vec<f64>,
    /// Points by height.
    pub heights: HeightCounts,
    /// Cells by class.
    pub cells: CellCounts,
}

/// Surveys the scans of `pass`, in their order. The ground is found by the stages and parameters of the hierarchical
/// detector, whatever the data set.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn survey(pass: ScanPass<'_>) -> Result<Vec<SurveyedScan>, ScanPassError> {
    let mut params = HierarchicalParams::shipped().front_end();
    // A density curve belongs to one sensor, so clutter is not judged by one here.
    params.density_weighting.enabled = false;
    let sensor_height_m = pass.dataset.description().sensor_height_m;
    let new_stages = || foreground(&params, sensor_height_m);
    pass.over(new_stages, |stages, it| SurveyedScan::of(it.scan, stages))
}

impl SurveyedScan {
    /// Surveys `scan`; `stages` find its ground and foreground.
    fn of(scan: &LabeledScan, stages: &mut Pipeline<Foreground>) -> Self {
        let cloud = &scan.cloud;
        stages.detect(cloud, &mut DetectorOutput::default());
        let frame = &stages.frame;
        Self {
            n_returns: n_returns(cloud),
            ground: GroundCount::of(frame),
            rings: RingCounts::of(cloud),
            cars: CarsInScan::of(scan),
            cluster_ranges_m: cluster_ranges_m(cloud, frame),
            heights: HeightCounts::of(cloud, frame),
            cells: CellCounts::of(frame),
        }
    }
}
