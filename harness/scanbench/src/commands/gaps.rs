//! `scanbench gaps`.

use evaluation::metrics::pair_separation::SEPARATED;
use evaluation::run::gap_experiment::{GAPS_DM, GapExperiment, RANGES_M};
use evaluation::run::gap_picture::gap_picture;
use reports::csv_rows::CsvRowWriter;
use reports::gap_curve::{GapBin, gap_curves};
use reports::gap_row::GapRow;
use reports::plot::gap_plot::gap_plot;
use reports::plot::plan_plot::plan_plot;
use reports::run_directory::{MANIFEST_JSON, RunDirectory};
use reports::table::gap_table::gap_table;
use simulator::object_pair::{PairKind, PairLayout};
use simulator::simulated_street::sensor_named;

use crate::cli::GapsArgs;
use crate::commands::experiment::Experiment;
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::progress::progress_over_scans;
use crate::commands::standard_streams::{print_diagnostic, print_result};

/// The ablation, the method, its rival.
const DETECTORS: [&str; 3] = ["simple-grid", "hierarchical", "kd-tree"];

/// Simulates pairs of objects with growing gaps, writes who separates them, and prints the table.
///
/// # Errors
///
/// If anything asked for is not there, or the output cannot be written; nothing is left behind then.
pub fn gaps(arguments: &GapsArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let sensor = sensor_named(&arguments.sensor)?;
    let asked = Experiment::begin(&arguments.detectors, &DETECTORS)?;
    let directory = asked.begin_directory(&arguments.output, "gaps")?;
    // Whose density is not known is taken for the paper's sensor, as in any run.
    let config = asked.config.for_sensor(&arguments.sensor).unwrap_or_else(|| asked.config.clone());
    let experiment = GapExperiment {
        detectors: &asked.detectors,
        config: &config,
        sensor: &sensor,
        n_pairs: arguments.pairs,
        seed: asked.seed,
    };
    let progress = progress_over_scans(experiment.stagings().len(), "pairs of objects");
    let bins = experiment.run(interrupted, || progress.inc(1))?;
    progress.finish_and_clear();
    let details = serde_json::json!({
        "sensor": sensor,
        "n_pairs": arguments.pairs,
        "pairs": PairKind::ALL.map(PairKind::name),
        "layouts": PairLayout::ALL.map(PairLayout::name),
        "ranges_m": RANGES_M,
        "gaps_dm": GAPS_DM.collect::<Vec<_>>(),
        "separated": SEPARATED,
    });
    directory.write_file(MANIFEST_JSON, asked.manifest(details).to_json().as_bytes())?;
    write_curves(&directory, &bins)?;
    let of_detector = |name: &str| asked.detectors.iter().position(|it| it.name == name);
    if let Some((simple, hierarchical)) = of_detector("simple-grid").zip(of_detector("hierarchical")) {
        write_picture(&directory, &experiment, simple, hierarchical)?;
    }
    let finished = directory.finish()?;
    let printed = print_result(gap_table(&gap_curves(&bins), SEPARATED));
    // Also where nobody takes the table: the curves are there.
    print_diagnostic(format_args!("Curves and plots: {}", finished.display()));
    printed
}

fn write_curves(directory: &RunDirectory, bins: &[GapBin]) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file("gaps.csv")?)?;
    for bin in bins {
        rows.write(&GapRow::simulated(bin))?;
    }
    rows.finish()?;
    let plot = gap_plot(&gap_curves(bins), "Separated pairs of objects (simulated; bars: 95 % intervals)");
    directory.write_file("gaps.svg", plot.as_bytes())?;
    for kind in PairKind::ALL.map(PairKind::name) {
        let curves = gap_curves(bins.iter().filter(|it| it.pair == kind));
        let plot = gap_plot(&curves, &format!("Separated pairs: {kind} (simulated; bars: 95 % intervals)"));
        directory.write_file(&format!("gaps_{kind}.svg"), plot.as_bytes())?;
    }
    Ok(())
}

fn write_picture(
    directory: &RunDirectory,
    experiment: &GapExperiment<'_>,
    joining: usize,
    separating: usize,
) -> Result<(), Failure> {
    let Some(picture) = gap_picture(experiment, joining, separating) else {
        print_diagnostic(
            "No pair.svg: there is no pair that simple-grid joins and hierarchical separates without fragments.",
        );
        return Ok(());
    };
    let title = format!(
        "{}, {} m apart, seen from above (simulated); one marker per detection, grey cells",
        picture.pair, picture.gap_m
    );
    directory.write_file("pair.svg", plan_plot(&picture.plans, &title).as_bytes())?;
    Ok(())
}
