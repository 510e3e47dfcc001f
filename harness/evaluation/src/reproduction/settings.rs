//! Joint settings of the values that the papers leave open, and what comes of each.

use std::sync::atomic::{AtomicBool, Ordering};

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use reports::vocabulary::task::Task;
use scans::dataset::Dataset;
use scans::dataset::scan_times::scan_times;

use super::open_values::OpenValue;
use crate::metrics::counts::Counts;
use crate::process::problem::DetectorFailure;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::detector_list::ChosenDetector;
use crate::scan_pass::ScanPassError;
use crate::sweep::programs::Programs;
use crate::sweep::scan_at_point::{LookedAt, look_at_points};
use crate::sweep::sweep_plan::{SweepPlan, SweepPoint};
use crate::sweep::swept_values::SweptValues;

/// Why nothing is known of the settings.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// A scan could not be read, or the user asked for it.
    #[error(transparent)]
    Scans(#[from] ScanPassError),
    /// A detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorFailure),
}

/// A Latin hypercube of `n` joint settings of `values` over the parameters of `base`: each value takes every `n`th of its
/// range once, in an order of its own. `McKay`, Beckman, Conover 1979.
///
/// # Errors
///
/// [`ConfigError`] if a value cannot be worked with.
pub fn latin_hypercube(
    base: &RunConfig,
    values: &[OpenValue],
    n: usize,
    seed: u64,
) -> Result<Vec<SweepPoint>, ConfigError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut columns = Vec::new();
    for it in values {
        let mut strata: Vec<usize> = (0..n).collect();
        strata.shuffle(&mut rng);
        let shares = strata.into_iter().map(|stratum| (stratum as f64 + rng.random::<f64>()) / n as f64);
        columns.push(shares.map(|share| it.range.at(share)).collect::<Vec<_>>());
    }
    let names: Vec<&str> = values.iter().map(|it| it.parameter).collect();
    (0..n).map(|row| point(base, &names, columns.iter().map(|it| it[row].clone()).collect())).collect()
}

/// The parameters of `base` with these values of the parameters `names`.
///
/// # Errors
///
/// [`ConfigError`] if a value cannot be worked with.
pub fn point(base: &RunConfig, names: &[&str], values: Vec<String>) -> Result<SweepPoint, ConfigError> {
    let options = names.iter().zip(&values).map(|(name, value)| format!("{name}={value}").parse());
    let options: Vec<_> = options.collect::<Result<_, _>>().expect("names and values are options");
    Ok(SweepPoint { config: base.overridden(&options, &[])?, values })
}

/// What `detectors` make of these points of the parameters `names`.
pub fn plan(
    base: &RunConfig,
    detectors: Vec<ChosenDetector>,
    names: &[&str],
    points: Vec<SweepPoint>,
) -> SweepPlan {
    let of_name = |(idx, name): (usize, &&str)| SweptValues {
        name: (*name).to_owned(),
        values: points.iter().map(|it| it.values[idx].clone()).collect(),
    };
    let swept = names.iter().enumerate().map(of_name).collect();
    SweepPlan { detectors, swept, tied: Vec::new(), points, base: base.clone() }
}

/// The counts of a detector in each of [`Task::ALL`].
pub type TaskCounts = [Counts; Task::ALL.len()];

/// The counts of all scans `scan_indices` of `dataset` together: for each point of `plan` those of each detector.
///
/// `on_scan` is called after every scan, from several threads.
///
/// # Errors
///
/// [`SettingsError`] if a scan cannot be read (the first such scan), or once `interrupted` is set.
pub fn count(
    plan: &SweepPlan,
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    interrupted: &AtomicBool,
    on_scan: impl Fn() + Sync,
) -> Result<Vec<Vec<TaskCounts>>, SettingsError> {
    let description = dataset.description();
    let times = scan_times(dataset);
    let point_idxs: Vec<usize> = (0..plan.points.len()).collect();
    let look = |&scan_idx: &usize| {
        let scan = dataset.read_scan(scan_idx).map_err(ScanPassError::from)?;
        let looked_at = LookedAt { scan: &scan, time_s: times[scan_idx].time_s, official: None };
        let mut found = Vec::new();
        look_at_points(
            plan,
            &Programs::default(),
            description,
            looked_at,
            &point_idxs,
            |_, detectors, _| {
                if interrupted.load(Ordering::Relaxed) {
                    let (dataset, n_scans) = (description.id.clone(), scan_indices.len());
                    return Err(SettingsError::from(ScanPassError::Interrupted { dataset, n_scans }));
                }
                let of_detector =
                    |counts: Vec<Counts>| counts.try_into().expect("there is one for each task");
                found.push(
                    detectors.into_iter().map(|it| of_detector(it.counts)).collect::<Vec<TaskCounts>>(),
                );
                Ok(())
            },
        )?;
        on_scan();
        Ok(found)
    };
    // Collected before it is looked through for errors, so that the first in order is reported.
    let of_scans: Vec<Result<_, SettingsError>> = scan_indices.par_iter().with_max_len(1).map(look).collect();
    let mut sums = vec![vec![TaskCounts::default(); plan.detectors.len()]; plan.points.len()];
    for of_scan in of_scans {
        for (sums, of_point) in sums.iter_mut().zip(of_scan?) {
            for (sum, counts) in sums.iter_mut().flatten().zip(of_point.into_iter().flatten()) {
                *sum += counts;
            }
        }
    }
    Ok(sums)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::reproduction::open_values::{OPEN_VALUES, OpenRange};

    #[test]
    fn every_part_of_every_range_is_there_once() {
        let base = RunConfig::load(None).unwrap();
        let points = latin_hypercube(&base, &OPEN_VALUES, 20, 1).unwrap();
        assert_eq!(points.len(), 20);
        for (idx, open) in OPEN_VALUES.iter().enumerate() {
            let OpenRange::Numbers { low, high, is_whole: false, is_log } = open.range else { continue };
            let strata = points.iter().map(|it| {
                let number: f64 = it.values[idx].parse().unwrap();
                let share = if is_log {
                    (number / low).ln() / (high / low).ln()
                } else {
                    (number - low) / (high - low)
                };
                (share * 20.0).clamp(0.0, 19.9) as usize
            });
            // Values are rounded as they are written, over the border of a part now and then.
            assert!(strata.collect::<BTreeSet<_>>().len() >= 17, "{}", open.parameter);
        }
        let again = latin_hypercube(&base, &OPEN_VALUES, 20, 1).unwrap();
        assert!(points.iter().zip(&again).all(|(a, b)| a.values == b.values));
        assert_ne!(points[0].values, latin_hypercube(&base, &OPEN_VALUES, 20, 2).unwrap()[0].values);
    }
}
