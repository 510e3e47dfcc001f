//! The same streets under one condition after another.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use detector::{Detector, DetectorOutput};
use rayon::prelude::*;
use reports::numbers::condition_scores::{ConditionScores, DetectorCounts};
use reports::vocabulary::task::Task;

use crate::annotation::LabeledScan;
use crate::dataset::simulated_street::{Shutter, StreetDrive, open_simulated_street};
use crate::dataset::{Dataset, DatasetError};
use crate::matching::assign::assign;
use crate::metrics::counts::{Counts, FalseDetections};
use crate::run::config::RunConfig;
use crate::run::detector_list::ListedDetector;
use crate::run::side_by_side::RunError;
use crate::simulator::StreetKind;
use crate::simulator::street_conditions::StreetConditions;

/// One condition: what it changes of the standard drive.
#[derive(Debug, Clone)]
pub struct Condition {
    /// What conditions of this kind have in common.
    pub group: &'static str,
    /// Its name.
    pub name: &'static str,
    change: fn(&mut StreetDrive),
}

/// Turns of the sensor from one scan to the next.
const TURNS_PER_SCAN: u32 = 30;

/// Every condition, in the order of the table. Nothing is tuned for any of them: detectors learn which sensor it is and how
/// high it is mounted, and nothing else.
pub const CONDITIONS: &[Condition] = &[
    Condition { group: "standard", name: "hdl-64e-s2, 1.73 m", change: |_| {} },
    Condition { group: "road", name: "level", change: |it| it.conditions = even(0.0) },
    Condition { group: "road", name: "5 % even", change: |it| it.conditions = even(0.05) },
    Condition { group: "road", name: "10 % even", change: |it| it.conditions = even(0.10) },
    Condition { group: "road", name: "hills to 5 %", change: |it| it.conditions = hills(0.05) },
    Condition { group: "road", name: "hills to 10 %", change: |it| it.conditions = hills(0.10) },
    Condition { group: "kerb", name: "3 cm", change: |it| it.conditions.kerb_height_m = Some(0.03) },
    Condition { group: "kerb", name: "15 cm", change: |it| it.conditions.kerb_height_m = Some(0.15) },
    Condition { group: "kerb", name: "25 cm", change: |it| it.conditions.kerb_height_m = Some(0.25) },
    Condition {
        group: "truck ahead",
        name: "3.0 m",
        change: |it| it.conditions.truck_ahead_height_m = Some(3.0),
    },
    Condition { group: "mounted at", name: "1.0 m", change: |it| it.sensor_height_m = Some(1.0) },
    Condition { group: "mounted at", name: "2.5 m", change: |it| it.sensor_height_m = Some(2.5) },
    Condition { group: "sensor", name: "hdl-32e", change: |it| "hdl-32e".clone_into(&mut it.sensor) },
    Condition { group: "sensor", name: "vlp-16", change: |it| "vlp-16".clone_into(&mut it.sensor) },
    Condition { group: "sensor", name: "os1-128", change: |it| "os1-128".clone_into(&mut it.sensor) },
    Condition { group: "weather", name: "rain, 10 mm/h", change: |it| it.rain_mm_per_h = Some(10.0) },
    Condition { group: "weather", name: "rain, 50 mm/h", change: |it| it.rain_mm_per_h = Some(50.0) },
    Condition { group: "shutter", name: "rolling", change: |it| it.shutter = Shutter::Rolling },
];

fn even(gradient: f32) -> StreetConditions {
    StreetConditions { gradient: Some(gradient), ..StreetConditions::default() }
}

fn hills(greatest: f32) -> StreetConditions {
    StreetConditions { hill_gradient: Some(greatest), ..StreetConditions::default() }
}

/// What is run under every condition.
pub struct Robustness<'a> {
    /// The detectors.
    pub detectors: &'a [ListedDetector],
    /// Their parameters.
    pub config: &'a RunConfig,
    /// Scans of each kind of street.
    pub n_scans: u32,
    /// Seed of the streets, the same under every condition.
    pub seed: u64,
}

impl Condition {
    /// The drive through a street of this kind under the condition.
    pub fn drive(&self, street: StreetKind, seed: u64, n_scans: u32) -> StreetDrive {
        let mut drive = StreetDrive {
            street,
            seed,
            n_scans,
            turns_per_scan: TURNS_PER_SCAN,
            scans_per_drive: None,
            sensor: "hdl-64e-s2".to_owned(),
            shutter: Shutter::Instant,
            rain_mm_per_h: None,
            sensor_height_m: None,
            conditions: StreetConditions::default(),
            labeled_to_either_side_deg: None,
        };
        (self.change)(&mut drive);
        drive
    }
}

impl Robustness<'_> {
    /// Number of scans under each condition.
    pub fn n_scans_per_condition(&self) -> usize {
        StreetKind::ALL.len() * self.n_scans as usize
    }

    /// Runs all detectors on all scans under `condition`, several scans at once, and counts; `on_scan` is told of each.
    /// Nothing is timed.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a scan cannot be made, or once `interrupted` is set.
    pub fn run(
        &self,
        condition: &Condition,
        interrupted: &AtomicBool,
        on_scan: impl Fn() + Sync,
    ) -> Result<ConditionScores, RunError> {
        let open = |street: StreetKind| {
            open_simulated_street(street.name(), &condition.drive(street, self.seed, self.n_scans))
        };
        let datasets: Vec<Box<dyn Dataset>> =
            StreetKind::ALL.into_iter().map(open).collect::<Result<_, DatasetError>>()?;
        let scans: Vec<(usize, usize)> = (0..datasets.len())
            .flat_map(|dataset_idx| {
                (0..datasets[dataset_idx].scan_ids().len()).map(move |it| (dataset_idx, it))
            })
            .collect();
        let height_m = datasets[0].description().sensor_height_m;
        let n_done = AtomicUsize::new(0);
        // Whose density is not known is taken for the paper's sensor, as in any run.
        let sensor = &datasets[0].description().sensor;
        let config = self.config.for_sensor(sensor).unwrap_or_else(|| self.config.clone());
        let build = || self.detectors.iter().map(|it| it.build(&config, height_m)).collect();
        let look = |detectors: &mut Vec<Box<dyn Detector>>, &(dataset_idx, scan_idx): &(usize, usize)| {
            if interrupted.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted {
                    n_done: n_done.load(Ordering::Relaxed),
                    n_scans: scans.len(),
                });
            }
            let counts = self.count(&datasets[dataset_idx].read_scan(scan_idx)?, detectors);
            n_done.fetch_add(1, Ordering::Relaxed);
            on_scan();
            Ok(counts)
        };
        // Collected before it is looked through for errors, so that the first in order is reported.
        let counted: Vec<Result<Vec<[Counts; 2]>, RunError>> =
            scans.par_iter().map_init(build, look).collect();
        let mut sums = vec![[Counts::default(); 2]; self.detectors.len()];
        for counts in counted {
            for (sum, counts) in sums.iter_mut().zip(counts?) {
                for (sum, counts) in sum.iter_mut().zip(counts) {
                    *sum += counts;
                }
            }
        }
        let scored = |(listed, [objects, vehicles]): (&ListedDetector, [Counts; 2])| DetectorCounts {
            detector: listed.name.to_owned(),
            objects: objects.scored(FalseDetections::Known),
            vehicles: vehicles.scored(FalseDetections::Known),
        };
        Ok(ConditionScores {
            group: condition.group.to_owned(),
            condition: condition.name.to_owned(),
            n_scans: scans.len() as u64,
            detectors: self.detectors.iter().zip(sums).map(scored).collect(),
        })
    }

    fn count(&self, scan: &LabeledScan, detectors: &mut [Box<dyn Detector>]) -> Vec<[Counts; 2]> {
        let mut output = DetectorOutput::default();
        let annotated = crate::dataset::AnnotatedClasses::EveryObject;
        let of_detector = |detector: &mut Box<dyn Detector>| {
            detector.detect(&scan.cloud, &mut output);
            let found = &output.detections;
            Task::ALL.map(|task| Counts::of(&assign(scan, found, task, &annotated, &self.config.matching)))
        };
        detectors.iter_mut().map(of_detector).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::detector_list::detectors_named;

    fn scores_of(name: &str) -> ConditionScores {
        let config = RunConfig::load(None).unwrap();
        let detectors = detectors_named(&["hierarchical".to_owned()]).unwrap();
        let robustness = Robustness { detectors: &detectors, config: &config, n_scans: 1, seed: 5 };
        let condition = CONDITIONS.iter().find(|it| it.name == name).unwrap();
        robustness.run(condition, &AtomicBool::new(false), || ()).unwrap()
    }

    #[test]
    fn conditions_have_names_of_their_own_and_make_drives_that_can_be() {
        let names: std::collections::BTreeSet<_> = CONDITIONS.iter().map(|it| (it.group, it.name)).collect();
        assert_eq!(names.len(), CONDITIONS.len());
        for condition in CONDITIONS {
            let drive = condition.drive(StreetKind::MainRoad, 1, 1);
            assert_eq!(drive.conditions.check(), Ok(()), "{}", condition.name);
            assert!(open_simulated_street("street", &drive).is_ok());
        }
    }

    #[test]
    fn conditions_are_felt() {
        let standard = scores_of("hdl-64e-s2, 1.73 m");
        assert_eq!(standard.n_scans, 3);
        assert!(standard.detectors[0].objects.no() > 20);
        for other in ["10 % even", "25 cm", "3.0 m", "1.0 m", "vlp-16", "rain, 50 mm/h", "rolling"] {
            assert_ne!(scores_of(other).detectors, standard.detectors, "{other}");
        }
    }
}
