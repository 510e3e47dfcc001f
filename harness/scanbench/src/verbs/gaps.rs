//! `scanbench gaps`.

use std::cell::RefCell;

use clap::Args;
use evaluation::metrics::pair_separation::SEPARATED;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::gap_experiment::{GAPS_DM, PairTally, RANGES_M, StagedPairs};
use evaluation::run::gap_picture::gap_picture;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::gap_curve::{GapBin, gap_curves};
use reports::plots::gap_plot::gap_plot;
use reports::plots::plan_plot::plan_plot;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::gap_table::{GapRow, GapTable};
use reports::vocabulary::study::Study;
use simulator::object_pair::{PairKind, PairLayout};
use simulator::simulated_street::sensor_named;

use crate::cli::help_text::DATA;
use crate::cli::{ExperimentArgs, NoRecordingArgs, OutputArgs, sensor_help};
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::paper_files::write_figure;
use crate::plumbing::recorder::say_that_none_is_written;
use crate::plumbing::scan_study::{ScanStudy, StagedScenes};
use crate::plumbing::shards::watched_study::execute_watched;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::{print_diagnostic, print_result_in, terminal};

/// Arguments of `scanbench gaps`.
#[derive(Debug, Args)]
#[command(after_help = GAPS_EXAMPLES)]
pub struct GapsArgs {
    /// Pairs of each kind, layout and range; each is simulated with every gap
    #[arg(long, help_heading = DATA, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub pairs: u32,
    /// Sensor.
    #[arg(long, help_heading = DATA, value_name = "SENSOR", default_value = "hdl-64e-s2", help = sensor_help())]
    pub sensor: String,
    /// The detectors, in the order of tables and plots.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Where curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// That it has no recording.
    #[command(flatten)]
    pub recording: NoRecordingArgs,
}

const GAPS_EXAMPLES: &str = "\
Examples:
  scanbench gaps
  scanbench gaps --pairs 100 --seed 7 -o runs/gaps
  scanbench gaps -d hierarchical,pca --sensor os1-128

Simulates pairs on an empty road: two cars, a car and a pedestrian, two pedestrians,
a car and a sign, a car and a bin; side by side and one behind the other, 0.2 to
1.2 m apart, 5 to 30 m away. Writes gaps.csv with every bin and its denominator,
gaps.svg and one plot for each kind of pair, pair.svg (a pair from above, as
simple-grid and hierarchical segment it) and the files of a run on these scans.";

/// The ablation, the method and its rival.
const DETECTORS: [&str; 3] = ["simple-grid", "hierarchical", "kd-tree"];

/// Simulates pairs of objects with growing gaps, writes a run directory with the separated pairs, and prints the table.
pub fn gaps(arguments: &GapsArgs) -> Result<(), Failure> {
    say_that_none_is_written(&arguments.recording, "gaps");
    let sensor = sensor_named(&arguments.sensor)?;
    let output = WorkOutput::claim(Study::Gaps, None, &arguments.output)?;
    let (started, named) = (output.started, &arguments.output);
    let mut study = ScanStudy::of_simulated_scans(&arguments.detectors, &DETECTORS, named, started)?;
    let pairs = StagedPairs::new(&arguments.sensor, sensor, arguments.pairs, arguments.detectors.seed);
    let tally = RefCell::new(PairTally::new(pairs.stagings(), study.config.matching));
    study.datasets = vec![OpenedDataset::whole(Box::new(pairs.clone()))];
    study.staged = Some(StagedScenes {
        drawn: "pairs",
        seed: arguments.detectors.seed,
        scenes: scenes(arguments, &pairs),
    });
    study.pairs = Some(&tally);
    let Some((made, _)) = execute_watched(&mut study, output)? else { return Ok(()) };
    let bins = tally.borrow().bins();
    write_curves(&made.directory, &bins)?;
    if let Some((simple, hierarchical)) =
        study.compared_detector("simple-grid").zip(study.compared_detector("hierarchical"))
    {
        write_picture(&made.directory, &pairs, arguments.pairs, [simple, hierarchical])?;
    }
    let finished = made.finish()?.0;
    print_result_in(
        "Curves and plots",
        &finished,
        terminal().text(&GapTable { curves: &gap_curves(&bins), definition: SEPARATED }),
    )
}

fn scenes(arguments: &GapsArgs, pairs: &StagedPairs) -> serde_json::Value {
    serde_json::json!({
        "sensor": pairs.sensor(),
        "n_pairs": arguments.pairs,
        "pairs": PairKind::ALL.map(PairKind::name),
        "layouts": PairLayout::ALL.map(PairLayout::name),
        "ranges_m": RANGES_M,
        "gaps_dm": GAPS_DM.collect::<Vec<_>>(),
        "separated": SEPARATED,
    })
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
    joining_and_separating: [&ComparedDetector; 2],
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
