//! Counts of one detector in one task over the moments of the drives of a data set.

use std::collections::BTreeMap;

use crate::rows::counts::Counts;
use crate::streaming::machine_speed::MachineSpeed;
use crate::vocabulary::forecast::Forecast;
use crate::vocabulary::task::Task;

/// Data set, task and detector.
pub type StreamKey = (String, Task, String);

/// Sums by data set, task and detector.
pub type StreamSums = BTreeMap<StreamKey, DetectorSums>;

/// Counts over moments, and how old the answers were.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DetectorSums {
    /// With each forecast, on this machine.
    pub forecasts: BTreeMap<Forecast, Counts>,
    /// Of a detector that finds exactly what is labelled and answers as late.
    pub late_truth: Option<Counts>,
    /// With the car's motion, on machines of other speeds.
    pub by_machine: Vec<(MachineSpeed, Counts)>,
    /// Age of what was known at each moment, in milliseconds; only of moments at which something was.
    pub ages_ms: Vec<f64>,
    /// Times of detection of all scans in milliseconds.
    pub latencies_ms: Vec<f64>,
    /// How many scans were taken.
    pub n_taken: u64,
}

impl DetectorSums {
    /// Adds those of other drives.
    pub fn add(&mut self, other: Self) {
        for (forecast, counts) in other.forecasts {
            add(self.forecasts.entry(forecast).or_insert_with(none_of), counts);
        }
        if let Some(counts) = other.late_truth {
            add(self.late_truth.get_or_insert_with(none_of), counts);
        }
        for (speed, counts) in other.by_machine {
            match self.by_machine.iter_mut().find(|it| it.0 == speed) {
                Some((_, sum)) => add(sum, counts),
                None => self.by_machine.push((speed, counts)),
            }
        }
        self.ages_ms.extend(other.ages_ms);
        self.latencies_ms.extend(other.latencies_ms);
        self.n_taken += other.n_taken;
    }
}

/// No object, and no false detection.
pub fn none_of() -> Counts {
    Counts::new(0, 0, Some(0)).expect("nothing is found of nothing")
}

/// The lower median; `None` of nothing.
pub fn lower_median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

fn add(sum: &mut Counts, counts: Counts) {
    *sum += counts;
}
