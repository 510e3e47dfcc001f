//! Detectors at points of a sweep, one after the other. Detectors that are programs are kept running from point to point.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use scans::dataset::DatasetDescription;

use crate::process::problem::DetectorFailure;
use crate::run::compared_detector::ComparedDetector;
use crate::run::detector_list::ChosenDetector;
use crate::run::running_detector::{BegunConversation, RunningDetector};
use crate::sweep::sweep_plan::SweepPlan;

/// Idle programs, by data set and detector.
#[derive(Default)]
pub struct Programs {
    idle: Mutex<BTreeMap<(String, &'static str), Vec<BegunConversation>>>,
}

impl Programs {
    /// Calls `work` with every detector of `plan`, with the parameters of one of its points, for scans of `dataset`. Returns
    /// the results. The detectors take turns; a program is started if none is idle.
    ///
    /// # Errors
    ///
    /// [`DetectorFailure`] of a detector that gives no answer; it names the point.
    pub fn at_point<T>(
        &self,
        plan: &SweepPlan,
        point_idx: usize,
        dataset: &DatasetDescription,
        mut work: impl FnMut(&ComparedDetector, &mut dyn RunningDetector) -> Result<T, DetectorFailure>,
    ) -> Result<Vec<T>, DetectorFailure> {
        let of_detector = |chosen: &ChosenDetector| {
            let compared_detector = ComparedDetector::of(chosen.clone(), &plan.points[point_idx].config);
            let program = || (dataset.id.clone(), compared_detector.name);
            let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
            let before = idle.get_mut(&program()).and_then(Vec::pop);
            drop(idle);
            let mut detector = compared_detector.begin_with(dataset, before)?;
            let done = work(&compared_detector, &mut *detector)?;
            if let Some(begun) = detector.into_conversation() {
                let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
                idle.entry(program()).or_default().push(begun);
            }
            Ok(done)
        };
        let done: Result<Vec<T>, DetectorFailure> = plan.detectors.iter().map(of_detector).collect();
        done.map_err(|it| plan.at_point(point_idx, it))
    }
}
