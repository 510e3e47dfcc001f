//! Joint settings of the values that the papers leave open, and what is found under each.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::sweep_entry::SweptParameter;
use reports::vocabulary::task::Task;
use scans::dataset::Dataset;

use super::open_values::OpenValue;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::detector_list::ChosenDetector;
use crate::scan_pass::ScanPassError;
use crate::sweep::quality_pass::{SweepError, SweepPass, SweptDataset};
use crate::sweep::sweep_plan::{SweepPlan, SweepPoint};

/// A Latin hypercube of `n` joint settings of `n_values` values, each a share of its range: each value takes every `n`th
/// part of its range once, in an order of its own. `McKay`, Beckman, Conover 1979.
pub fn latin_hypercube(n_values: usize, n: usize, seed: u64) -> Vec<Shares> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for _ in 0..n_values {
        let mut strata: Vec<usize> = (0..n).collect();
        strata.shuffle(&mut rng);
        let shares = strata.into_iter().map(|stratum| (stratum as f64 + rng.random::<f64>()) / n as f64);
        columns.push(shares.collect());
    }
    (0..n).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
}

/// A point for each setting: the parameters of `base`, with `values` at these shares of their ranges.
///
/// # Errors
///
/// [`ConfigError`] if a value cannot be used.
pub fn points_at(
    base: &RunConfig,
    values: &[OpenValue],
    settings: &[Shares],
) -> Result<Vec<SweepPoint>, ConfigError> {
    let names: Vec<&str> = values.iter().map(|value| value.parameter).collect();
    let written =
        |shares: &Shares| values.iter().zip(shares).map(|(value, share)| value.range.at(*share)).collect();
    settings.iter().map(|shares| point(base, &names, written(shares))).collect()
}

/// The parameters of `base` with these values of the parameters `names`.
///
/// # Errors
///
/// [`ConfigError`] if a value cannot be used.
pub fn point(base: &RunConfig, names: &[&str], values: Vec<String>) -> Result<SweepPoint, ConfigError> {
    let options = names.iter().zip(&values).map(|(name, value)| format!("{name}={value}").parse());
    let options: Vec<_> = options.collect::<Result<_, _>>().expect("names and values are options");
    Ok(SweepPoint { config: base.overridden(&options, &[])?, values })
}

/// Plan of a sweep of `detectors` over these points of the parameters `names`.
pub fn plan(
    base: &RunConfig,
    detectors: Vec<ChosenDetector>,
    names: &[&str],
    points: Vec<SweepPoint>,
) -> SweepPlan {
    let of_name = |(idx, name): (usize, &&str)| SweptParameter {
        name: (*name).to_owned(),
        values: points.iter().map(|it| it.values[idx].clone()).collect(),
    };
    let swept = names.iter().enumerate().map(of_name).collect();
    SweepPlan { detectors, swept, tied: Vec::new(), points, base: base.clone() }
}

/// A joint setting: for each value the share of its range, 0 to below 1.
pub type Shares = Vec<f64>;

/// Rows of `scans.csv` of all scans `scan_indices` of `dataset` at each point of `plan`, in the order of the scans, with the
/// names of the detectors.
///
/// `on_scan` is called after every scan, from several threads.
///
/// # Errors
///
/// [`SweepError`] if a scan cannot be read (the first such scan), a detector fails, or once `interrupted` is set.
pub fn rows_at_points(
    plan: &SweepPlan,
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    interrupted: &AtomicBool,
    on_scan: impl Fn() + Sync,
) -> Result<Vec<Vec<ScanRow>>, SweepError> {
    let (n_scans, n_points) = (scan_indices.len(), plan.points.len());
    let datasets = &[SweptDataset { dataset, scan_indices, part: 0..n_scans }];
    let pass = SweepPass { plan, datasets, protocols: None, interrupted };
    let kept = Mutex::new(BTreeMap::new());
    let counted = pass.count(&BTreeSet::new(), rayon::current_num_threads(), &|scan| {
        let is_last = scan.point_idx + 1 == n_points;
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert((scan.point_idx, scan.scan_idx), scan.scans);
        if is_last {
            on_scan();
        }
        Ok(())
    });
    counted.map_err(|error| match error {
        SweepError::Interrupted { .. } => {
            ScanPassError::Interrupted { dataset: dataset.description().id.clone(), n_scans }.into()
        }
        error => error,
    })?;
    let mut rows = vec![Vec::new(); n_points];
    for ((point_idx, _), of_scan) in kept.into_inner().unwrap_or_else(PoisonError::into_inner) {
        // A sweep names the values of the point with the detector.
        let names = plan.detectors.iter().flat_map(|it| [it.name(); Task::ALL.len()]);
        let named = of_scan.into_iter().zip(names);
        rows[point_idx].extend(named.map(|(row, name)| ScanRow { detector: name.to_owned(), ..row }));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduction::open_values::{OPEN_VALUES, OpenRange};

    #[test]
    fn every_part_of_every_range_is_there_once() {
        let base = RunConfig::load(None).unwrap();
        let drawn =
            |seed| points_at(&base, &OPEN_VALUES, &latin_hypercube(OPEN_VALUES.len(), 20, seed)).unwrap();
        let points = drawn(1);
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
            // Values are rounded when they are written, sometimes into the next part.
            assert!(strata.collect::<BTreeSet<_>>().len() >= 17, "{}", open.parameter);
        }
        assert!(points.iter().zip(&drawn(1)).all(|(a, b)| a.values == b.values));
        assert_ne!(points[0].values, drawn(2)[0].values);
    }
}
