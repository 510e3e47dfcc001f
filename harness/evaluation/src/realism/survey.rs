//! What all statistics take from the scans of a data set.

use std::sync::atomic::{AtomicBool, Ordering};

use detector::detector::StageClock;
use detector::grid::ring_density::RingCounts;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use rayon::prelude::*;
use scans::annotation::LabeledScan;
use scans::dataset::{Dataset, DatasetError};

use super::cell_classes::CellCounts;
use super::clusters_per_scan::n_clusters;
use super::ground_share::GroundCount;
use super::height_histogram::HeightCounts;
use super::points_per_car::CarsInScan;
use super::returns_per_scan::n_returns;

/// What all statistics take from one scan.
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
    /// Number of clusters.
    pub n_clusters: u64,
    /// Points by height.
    pub heights: HeightCounts,
    /// Cells by class.
    pub cells: CellCounts,
}

/// Why scans could not be surveyed.
#[derive(Debug, thiserror::Error)]
pub enum SurveyError {
    /// A scan could not be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The user asked for it.
    #[error("interrupted while measuring the {n_scans} scans of {dataset:?}")]
    Interrupted {
        /// The data set.
        dataset: String,
        /// Scans that were asked for.
        n_scans: usize,
    },
}

/// Looks at the scans `scan_indices` of `dataset`, several at once, and returns what it saw in their order.
///
/// The ground is found by the stages and parameters of the hierarchical detector, whatever the data set. `on_scan` is
/// called after every scan, from several threads.
///
/// # Errors
///
/// [`SurveyError`] if a scan cannot be read (the first such scan), or once `interrupted` is set.
pub fn survey(
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    interrupted: &AtomicBool,
    on_scan: impl Fn() + Sync,
) -> Result<Vec<SurveyedScan>, SurveyError> {
    let description = dataset.description();
    let mut params = HierarchicalParams::shipped();
    // What is clutter follows no curve here, which belongs to one sensor.
    params.density_weighting.enabled = false;
    let new_stages = || ForegroundStages::new(params.clone(), description.sensor_height_m);
    let look = |stages: &mut ForegroundStages, &scan_idx: &usize| {
        if interrupted.load(Ordering::Relaxed) {
            let (dataset, n_scans) = (description.id.clone(), scan_indices.len());
            return Err(SurveyError::Interrupted { dataset, n_scans });
        }
        let surveyed = SurveyedScan::of(&dataset.read_scan(scan_idx)?, stages);
        on_scan();
        Ok(surveyed)
    };
    // Collected before it is looked through for errors, so that the first in order is reported.
    let surveyed: Vec<_> = scan_indices.par_iter().map_init(new_stages, look).collect();
    surveyed.into_iter().collect()
}

impl SurveyedScan {
    /// Looks at `scan`, whose ground and foreground `stages` find.
    fn of(scan: &LabeledScan, stages: &mut ForegroundStages) -> Self {
        let cloud = &scan.cloud;
        stages.run(cloud, &mut StageClock::start(), &mut Vec::new());
        Self {
            n_returns: n_returns(cloud),
            ground: GroundCount::of(stages),
            rings: RingCounts::of(cloud),
            cars: CarsInScan::of(scan),
            n_clusters: n_clusters(cloud, stages),
            heights: HeightCounts::of(cloud, stages),
            cells: CellCounts::of(stages),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    fn street() -> Box<dyn Dataset> {
        open_dataset("street-main-road", &OpenOptions::default(), &built_in_catalogue().unwrap()).unwrap()
    }

    #[test]
    fn scans_are_seen_in_order_whatever_the_number_of_threads() {
        let survey_with = |n_threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| survey(&*street(), &[2, 0], &AtomicBool::new(false), || ()).unwrap())
        };
        let seen = survey_with(1);
        let n_points = |scan_idx: usize| street().read_scan(scan_idx).unwrap().cloud.len() as u64;
        assert_eq!([seen[0].n_returns, seen[1].n_returns], [n_points(2), n_points(0)]);
        assert_eq!(seen, survey_with(3));
    }

    #[test]
    fn an_interruption_ends_the_survey() {
        let error = survey(&*street(), &[0], &AtomicBool::new(true), || ()).unwrap_err();
        assert!(matches!(error, SurveyError::Interrupted { n_scans: 1, .. }), "{error}");
    }
}
