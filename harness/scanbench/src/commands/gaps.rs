//! `scanbench gaps`.

use std::cell::RefCell;
use std::path::Path;

use evaluation::metrics::pair_separation::SEPARATED;
use evaluation::run::entrant::Entrant;
use evaluation::run::gap_experiment::{GAPS_DM, PairTally, RANGES_M, StagedPairs};
use evaluation::run::gap_picture::gap_picture;
use evaluation::run::sink::Sinks;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::gap_curve::{GapBin, gap_curves};
use reports::plots::gap_plot::gap_plot;
use reports::plots::plan_plot::plan_plot;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::gap_table::{GapRow, GapTable};
use reports::vocabulary::study::Study;
use simulator::object_pair::{PairKind, PairLayout};
use simulator::simulated_street::sensor_named;

use crate::cli::GapsArgs;
use crate::commands::experiment::Experiment;
use crate::commands::failure::Failure;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::paper_files::write_figure;
use crate::commands::progress::RunProgress;
use crate::commands::shards::executor::{WatchedStudy, execute};
use crate::commands::shards::place::Place;
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::watched_run::WatchedRun;

/// The ablation, the method, its rival.
const DETECTORS: [&str; 3] = ["simple-grid", "hierarchical", "kd-tree"];

/// Simulates pairs of objects with growing gaps, writes a run directory with who separates them, and prints the table.
pub fn gaps(arguments: &GapsArgs) -> Result<(), Failure> {
    let sensor = sensor_named(&arguments.sensor)?;
    let place = Place::claim(Study::Gaps, None, &arguments.output)?;
    let asked = Experiment::begin((&arguments.detectors, &DETECTORS), place.started)?;
    let pairs = StagedPairs::new(&arguments.sensor, sensor, arguments.pairs, asked.seed);
    let mut study = Gaps {
        arguments,
        datasets: [OpenedDataset::whole(Box::new(pairs.clone()))],
        entrants: asked.entrants(),
        tally: RefCell::new(PairTally::new(pairs.stagings(), asked.config.matching)),
        asked,
        pairs: &pairs,
    };
    let Some(made) = execute(&mut study, place)? else { return Ok(()) };
    let bins = study.tally.borrow().bins();
    write_curves(&made.directory, &bins)?;
    let named = |name: &str| study.entrants.iter().find(|it| it.name == name);
    if let Some((simple, hierarchical)) = named("simple-grid").zip(named("hierarchical")) {
        write_picture(&made.directory, &pairs, arguments.pairs, [simple, hierarchical])?;
    }
    let finished = made.finish()?.0;
    let printed =
        print_result(terminal().text(&GapTable { curves: &gap_curves(&bins), definition: SEPARATED }));
    // Also where nobody takes the table: the curves are there.
    print_diagnostic(format_args!("Curves and plots: {}", finished.display()));
    printed
}

/// Who looks at which pairs.
struct Gaps<'a> {
    arguments: &'a GapsArgs,
    asked: Experiment,
    pairs: &'a StagedPairs,
    datasets: [OpenedDataset; 1],
    entrants: Vec<Entrant>,
    tally: RefCell<PairTally<'a>>,
}

impl WatchedStudy for Gaps<'_> {
    fn datasets(&self) -> &[OpenedDataset] {
        &self.datasets
    }

    fn datasets_mut(&mut self) -> &mut [OpenedDataset] {
        &mut self.datasets
    }

    /// That of a run, with what was put up.
    fn manifest(&self) -> Manifest {
        let experiment = serde_json::json!({
            "sensor": self.pairs.sensor(),
            "n_pairs": self.arguments.pairs,
            "pairs": PairKind::ALL.map(PairKind::name),
            "layouts": PairLayout::ALL.map(PairLayout::name),
            "ranges_m": RANGES_M,
            "gaps_dm": GAPS_DM.collect::<Vec<_>>(),
            "separated": SEPARATED,
        });
        self.asked.manifest("pairs", experiment, &self.datasets)
    }

    fn watched<'a>(&'a self, progress: &'a RunProgress) -> WatchedRun<'a> {
        WatchedRun::of_study(&self.entrants, &self.datasets, Experiment::timing(), progress)
    }

    fn sinks<'a>(&'a self, _: &'a Path) -> Result<Sinks<'a, Failure>, Failure> {
        Ok(vec![Box::new(&self.tally)])
    }

    /// Clusters of pairs are in no row.
    fn sees_all(&self) -> bool {
        true
    }
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
