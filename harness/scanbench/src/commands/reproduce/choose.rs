//! Choosing the values that the papers leave open, as their authors had to.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use evaluation::reproduction::open_values::open_values_of;
use evaluation::reproduction::settings::{count, latin_hypercube, plan, point};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{ChosenDetector, built_in_named};
use evaluation::sweep::sweep_plan::SweepPlan;
use reports::vocabulary::task::Task;

use crate::cli::{ChosenFor, ReproduceArgs};
use crate::commands::failure::Failure;
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::interruption_flag;
use crate::commands::judged_streets::refuse_judged;
use crate::commands::open_datasets::{OpenedDataset, open_datasets};
use crate::commands::progress::progress_over_scans;
use crate::commands::standard_streams::print_result;

/// Tries joint settings of all values of `detector` but the criterion, and prints the ten with the greatest mean rate, and
/// the shipped one.
pub fn choose(arguments: &ReproduceArgs, detector: ChosenFor) -> Result<(), Failure> {
    let mut config = RunConfig::load(None)?;
    let datasets = open_datasets(&arguments.data, &config.classes)?;
    refuse_judged(&datasets)?;
    let datasets = look_first_at_all(datasets, &mut config);
    let values = open_values_of(detector.name());
    let n = arguments.settings as usize;
    let mut points = latin_hypercube(&config, values, n, arguments.settings_seed)?;
    let names: Vec<&str> = values.iter().map(|it| it.parameter).collect();
    let shipped = names.iter().map(|it| config.value_of(it).expect("the list is tested").to_string());
    points.push(point(&config, &names, shipped.collect())?);
    let method = built_in_named(&[detector.name().to_owned()], &config)?[0];
    let plan = plan(&config, vec![ChosenDetector::from(method)], &names, points);
    let rates = rates(&plan, detector.tasks(), &datasets, interruption_flag())?;
    let mean = |rates: &[(String, f64)]| rates.iter().map(|it| it.1).sum::<f64>() / rates.len() as f64;
    let mut order: Vec<usize> = (0..plan.points.len()).collect();
    order.sort_by(|&a, &b| mean(&rates[b]).total_cmp(&mean(&rates[a])).then(a.cmp(&b)));
    let mut text = String::new();
    for &point_idx in order.iter().take(10).chain([&n]) {
        let rates_text: Vec<String> =
            rates[point_idx].iter().map(|(name, it)| format!("{name} {:.1}", 100.0 * it)).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:.1}: {}", 100.0 * mean(&rates[point_idx]), rates_text.join(", "));
        for (name, value) in names.iter().zip(&plan.points[point_idx].values) {
            let _ = writeln!(text, "    {name} = {value}");
        }
    }
    print_result(text)
}

/// Of every point the rates by data set and each of `tasks`: the F-rate, or the recall where false detections are not known.
fn rates(
    plan: &SweepPlan,
    tasks: &[Task],
    datasets: &[OpenedDataset],
    interrupted: &AtomicBool,
) -> Result<Vec<Vec<(String, f64)>>, Failure> {
    let mut rates: Vec<Vec<(String, f64)>> = vec![Vec::new(); plan.points.len()];
    for it in datasets {
        let description = it.dataset.description();
        let progress = progress_over_scans(it.scan_indices.len(), &description.id);
        let counts = count(plan, &*it.dataset, &it.scan_indices, interrupted, || progress.inc(1))?;
        progress.finish_and_clear();
        for (rates, counts) in rates.iter_mut().zip(counts) {
            for (task, counts) in Task::ALL.into_iter().zip(counts[0]).filter(|it| tasks.contains(&it.0)) {
                if let Some(rate) = counts.f_rate().or_else(|| counts.recall()) {
                    rates.push((format!("{} {task}", description.id), rate));
                }
            }
        }
    }
    Ok(rates)
}
