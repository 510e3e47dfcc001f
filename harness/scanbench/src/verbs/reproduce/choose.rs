//! Choosing the values that the papers leave open, as their authors had to.

use std::fmt::Write as _;

use evaluation::reproduction::coordinate_search::CoordinateSearch;
use evaluation::reproduction::open_values::{OpenValue, chosen_values_of};
use evaluation::reproduction::settings::{Shares, latin_hypercube, point, points_at};
use evaluation::run::config::RunConfig;
use evaluation::sweep::sweep_plan::SweepPoint;
use reports::numbers::tally::Tally;
use reports::vocabulary::task::Task;

use super::settings_study::FoundAtPoints;
use crate::cli::{ChosenFor, ReproduceArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::judged_streets::refuse_judged;
use crate::plumbing::open_datasets::open_datasets;
use crate::plumbing::standard_streams::print_result;

/// Tries joint settings of all values of `detector` but the criterion, and prints the ten with the greatest mean rate, and
/// the shipped one: a Latin hypercube first, then a search from its best setting, one value after another.
pub fn choose(arguments: &ReproduceArgs, detector: ChosenFor) -> Result<(), Failure> {
    let mut config = RunConfig::load(None)?;
    let datasets = open_datasets(&arguments.data, &config.classes)?;
    refuse_judged(&datasets)?;
    let datasets = look_first_at_all(datasets, &mut config);
    let values = chosen_values_of(detector.name());
    let names: Vec<&str> = values.iter().map(|it| it.parameter).collect();
    let tried = |points: Vec<SweepPoint>| -> Result<Vec<Tried>, Failure> {
        let values: Vec<_> = points.iter().map(|it| it.values.clone()).collect();
        let points = (names.as_slice(), points);
        let (detectors, empty) = ([detector.name()], Tally::default());
        let found = FoundAtPoints::of(&config, &detectors, points, &datasets, &empty, interruption_flag())?;
        let of_points = values.into_iter().zip(found.tallies());
        Ok(of_points.map(|(values, tally)| Tried { values, rates: rates(tally, detector) }).collect())
    };
    let shipped = names.iter().map(|it| config.value_of(it).expect("the list is tested").to_string());
    let shipped = tried(vec![point(&config, &names, shipped.collect())?])?;
    let mut all = searched(&values, arguments, |settings| tried(points_at(&config, &values, settings)?))?;
    // The first of equally good ones first.
    all.sort_by(|a, b| b.mean().total_cmp(&a.mean()));
    let mut text = String::new();
    for tried in all.iter().take(10).chain(&shipped) {
        let rates_text: Vec<String> =
            tried.rates.iter().map(|(name, it)| format!("{name} {:.1}", 100.0 * it)).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:.1}: {}", 100.0 * tried.mean(), rates_text.join(", "));
        for (name, value) in names.iter().zip(&tried.values) {
            let _ = writeln!(text, "    {name} = {value}");
        }
    }
    print_result(text)
}

/// A setting that was tried.
struct Tried {
    /// The values as they are written.
    values: Vec<String>,
    /// Rates by data set and task, 0 to 1.
    rates: Vec<(String, f64)>,
}

impl Tried {
    fn mean(&self) -> f64 {
        self.rates.iter().map(|it| it.1).sum::<f64>() / self.rates.len() as f64
    }
}

/// Tries as many settings of `values` as `arguments` say: half of them, rounded up, are drawn, the others found by a search
/// from the best of these. The search may end before.
fn searched(
    values: &[OpenValue],
    arguments: &ReproduceArgs,
    tried: impl Fn(&[Shares]) -> Result<Vec<Tried>, Failure>,
) -> Result<Vec<Tried>, Failure> {
    let n = arguments.settings as usize;
    let seed = arguments.settings_seed;
    let drawn = latin_hypercube(values.len(), n.div_ceil(2), seed);
    let mut all = tried(&drawn)?;
    let rates = all.iter().map(Tried::mean);
    let best = drawn.iter().zip(rates).reduce(|best, it| if it.1 > best.1 { it } else { best });
    let Some((setting, rate)) = best else { return Ok(all) };
    let mut search = CoordinateSearch::from(values, setting.clone(), rate, seed);
    loop {
        let settings = search.round(n - all.len());
        if settings.is_empty() {
            return Ok(all);
        }
        let of_round = tried(&settings)?;
        let rates: Vec<(Shares, f64)> = settings.into_iter().zip(of_round.iter().map(Tried::mean)).collect();
        search.take(&rates);
        all.extend(of_round);
    }
}

/// The rates by data set and task of `detector`: the F-rate, or the recall where false detections are not known.
fn rates(tally: &Tally, detector: ChosenFor) -> Vec<(String, f64)> {
    let of_dataset = |id: &String| {
        let rate = |task: &Task| {
            let counts = tally.counts(id, *task, detector.name())?;
            Some((format!("{id} {task}"), counts.f_rate().or_else(|| counts.recall())?))
        };
        detector.tasks().iter().filter_map(rate).collect::<Vec<_>>()
    };
    tally.datasets().iter().flat_map(of_dataset).collect()
}
