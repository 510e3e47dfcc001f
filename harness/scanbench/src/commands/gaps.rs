//! `scanbench gaps`.

use std::num::NonZeroUsize;

use evaluation::metrics::pair_separation::SEPARATED;
use evaluation::run::entrant::Entrant;
use evaluation::run::gap_experiment::{GAPS_DM, PairTally, RANGES_M, StagedPairs};
use evaluation::run::gap_picture::gap_picture;
use evaluation::run::side_by_side::OnDetectorFailure;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::gap_curve::{GapBin, gap_curves};
use reports::numbers::tally::Tally;
use reports::plots::gap_plot::gap_plot;
use reports::plots::plan_plot::plan_plot;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::gap_row::GapRow;
use reports::tables::studies::gap_table::GapTable;
use scans::dataset::source::DamagePolicy;
use simulator::object_pair::{PairKind, PairLayout};
use simulator::simulated_street::sensor_named;

use crate::cli::GapsArgs;
use crate::commands::experiment::Experiment;
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::opened_results::OpenedResults;
use crate::commands::paper_files::write_figure;
use crate::commands::progress::RunProgress;
use crate::commands::run_numbers::write_numbers;
use crate::commands::sinks::of_every_run::sinks_of_every_run;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::watched_run::{WatchedRun, WithoutLabels};

/// The ablation, the method, its rival.
const DETECTORS: [&str; 3] = ["simple-grid", "hierarchical", "kd-tree"];

/// Simulates pairs of objects with growing gaps, writes a run directory with who separates them, and prints the table.
pub fn gaps(arguments: &GapsArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let sensor = sensor_named(&arguments.sensor)?;
    let asked = Experiment::begin(&arguments.detectors, &DETECTORS)?;
    let directory = asked.begin_directory(&arguments.output, "gaps")?;
    let pairs = StagedPairs::new(&arguments.sensor, sensor, arguments.pairs, asked.seed);
    let datasets = [OpenedDataset::whole(Box::new(pairs.clone()))];
    let entrants = asked.entrants();
    let progress = RunProgress::new();
    let mut tally = Tally::default();
    let mut pair_tally = PairTally::new(pairs.stagings(), asked.config.matching);
    let mut sinks = sinks_of_every_run(&directory, &mut tally, &progress)?;
    sinks.push(Box::new(&mut pair_tally));
    let watched = WatchedRun {
        entrants: &entrants,
        results: &OpenedResults::default(),
        datasets: &datasets,
        damage: DamagePolicy::Refuse,
        n_warmup: Experiment::N_WARMUP,
        n_repeats: NonZeroUsize::MIN,
        n_jobs: std::thread::available_parallelism().map_or(1, NonZeroUsize::get),
        on_failure: OnDetectorFailure::Stop,
        interrupted,
        progress: &progress,
        without_labels: WithoutLabels::Refuse,
    };
    watched.run(sinks)?;
    write_numbers(&directory, &manifest(arguments, &asked, &pairs, &datasets), &tally)?;
    let bins = pair_tally.bins();
    write_curves(&directory, &bins)?;
    let named = |name: &str| entrants.iter().find(|it| it.name == name);
    if let Some((simple, hierarchical)) = named("simple-grid").zip(named("hierarchical")) {
        write_picture(&directory, &pairs, arguments.pairs, [simple, hierarchical])?;
    }
    let finished = directory.finish()?;
    let printed =
        print_result(terminal().text(&GapTable { curves: &gap_curves(&bins), definition: SEPARATED }));
    // Also where nobody takes the table: the curves are there.
    print_diagnostic(format_args!("Curves and plots: {}", finished.display()));
    printed
}

/// That of a run, with what was put up.
fn manifest(
    arguments: &GapsArgs,
    asked: &Experiment,
    pairs: &StagedPairs,
    datasets: &[OpenedDataset],
) -> Manifest {
    let experiment = serde_json::json!({
        "sensor": pairs.sensor(),
        "n_pairs": arguments.pairs,
        "pairs": PairKind::ALL.map(PairKind::name),
        "layouts": PairLayout::ALL.map(PairLayout::name),
        "ranges_m": RANGES_M,
        "gaps_dm": GAPS_DM.collect::<Vec<_>>(),
        "separated": SEPARATED,
    });
    asked.manifest("pairs", experiment, datasets)
}

fn write_curves(directory: &RunDirectory, bins: &[GapBin]) -> Result<(), Failure> {
    let rows: Vec<GapRow> = bins.iter().map(GapRow::simulated).collect();
    directory.write_file("gaps.csv", &to_csv_bytes(&rows)?)?;
    let plot = gap_plot(&gap_curves(bins), "Separated pairs of objects (simulated; bars: 95 % intervals)");
    write_figure(directory, "gaps", &plot)?;
    for kind in PairKind::ALL.map(PairKind::name) {
        let curves = gap_curves(bins.iter().filter(|it| it.pair == kind));
        let plot = gap_plot(&curves, &format!("Separated pairs: {kind} (simulated; bars: 95 % intervals)"));
        write_figure(directory, &format!("gaps_{kind}"), &plot)?;
    }
    Ok(())
}

fn write_picture(
    directory: &RunDirectory,
    pairs: &StagedPairs,
    n_pairs: u32,
    joining_and_separating: [&Entrant; 2],
) -> Result<(), Failure> {
    let Some(picture) = gap_picture(pairs, n_pairs, joining_and_separating)? else {
        print_diagnostic(
            "No pair.svg: there is no pair that simple-grid joins and hierarchical separates without fragments.",
        );
        return Ok(());
    };
    let title = format!(
        "{}, {} m apart, seen from above (simulated); one marker per detection, grey cells",
        picture.pair, picture.gap_m
    );
    Ok(write_figure(directory, "pair", &plan_plot(&picture.plans, &title))?)
}
