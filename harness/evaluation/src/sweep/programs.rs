//! Detectors that are programs, kept running from point to point of a sweep.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use scans::dataset::DatasetDescription;

use crate::run::running_detector::{BegunConversation, RunningDetector};

/// Programs that nobody speaks to at the moment, by data set and detector.
#[derive(Default)]
pub struct Programs {
    idle: Mutex<BTreeMap<(String, &'static str), Vec<BegunConversation>>>,
}

impl Programs {
    /// One of `detector` for `dataset`, for whoever asks; `None` if all are busy.
    pub fn take(&self, dataset: &DatasetDescription, detector: &'static str) -> Option<BegunConversation> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.get_mut(&(dataset.id.clone(), detector))?.pop()
    }

    /// Keeps the program of `running`, if it is one, for the next point.
    pub fn put_back(
        &self,
        dataset: &DatasetDescription,
        detector: &'static str,
        running: Box<dyn RunningDetector>,
    ) {
        let Some(program) = running.into_conversation() else { return };
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.entry((dataset.id.clone(), detector)).or_default().push(program);
    }
}
