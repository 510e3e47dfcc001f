//! `scanbench fit-density`.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use detector::grid::density_curve::{CurveOrigin, DensityCurve};
use detector::grid::ring_density::RingCounts;
use evaluation::density_survey::{count_rings, density_curves};
use evaluation::run::config::RunConfig;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::to_csv_bytes;
use reports::files::whole_file::WholeFile;
use reports::files::whole_set::WholeSet;
use reports::numbers::curve_pair::Sides;
use reports::plots::curve_plot::curve_plot;
use reports::tables::studies::curve_row::CurveRow;
use scans::dataset::class_table::ClassTable;
use simulator::simulated_street::StreetDrive;

use crate::cli::DatasetArgs;
use crate::cli::help_text::OUTPUT;
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::first_look::{UNKNOWN_SENSOR, look_first};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets};
use crate::plumbing::reproducible_command::reproducible_command;
use crate::plumbing::standard_streams::print_result_in;

/// Arguments of `scanbench fit-density`.
#[derive(Debug, Args)]
#[command(after_help = FIT_DENSITY_EXAMPLES)]
pub struct FitDensityArgs {
    /// The scans, all of one sensor.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// File to write, for --config
    #[arg(short, long, help_heading = OUTPUT, value_name = "FILE", default_value = "density.toml")]
    pub output: PathBuf,
    /// Directory for the measured and the fitted curve, as CSV and SVG
    #[arg(long, help_heading = OUTPUT, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Replace file and directory if they exist
    #[arg(long, help_heading = OUTPUT)]
    pub overwrite: bool,
}

const FIT_DENSITY_EXAMPLES: &str = "\
Examples:
  scanbench fit-density ~/data/kitti_tracking -o density.toml --figures figures
  scanbench fit-density training-streets --seed 1000 --simulated-scans 40 --sensor my-sensor.toml
  scanbench run ~/data/kitti_tracking --config density.toml

The curve says how the density of points falls with the range. All scans must be of
one sensor. The program has curves for hdl-64e-s2, hdl-32e, vlp-16, os1-128 and
argoverse2. For another sensor, `scanbench run` learns one from five scans.";

/// One row for every ring of both figures.
const DENSITY_CSV: &str = "density.csv";

/// Learns how the density of points falls with the range, and writes it for `scanbench run --config`.
pub fn fit_density(arguments: &FitDensityArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let path = arguments.output.as_path();
    for target in [Some(path), arguments.figures.as_deref()].into_iter().flatten() {
        if target.exists() && !arguments.overwrite {
            return Err(Usage(format!(
                "{} exists; choose another name, or replace it with --overwrite",
                target.display()
            ))
            .into());
        }
    }
    let opened = open_datasets(&arguments.data, &ClassTable::default())?;
    let mut config = RunConfig::without_vehicle_models()?;
    // A simulated sensor is known but for the density that is fitted here.
    let look = |it: OpenedDataset| {
        if it.dataset.description().is_simulated() { it } else { look_first(it, &mut config) }
    };
    let opened: Vec<OpenedDataset> = opened.into_iter().map(look).collect();
    let origin = origin(&opened, &arguments.data)?;
    // Now, so that a folder that is not there is not found out after all scans are read.
    let mut file = WholeFile::create(path)?;
    let mut scans = Vec::new();
    for it in &opened {
        scans.extend(it.look(interrupted, count_rings)?);
    }
    let curve =
        DensityCurve::fit(&scans, origin).map_err(|error| NothingEvaluated { reason: error.to_string() })?;
    let written = file.write_all(curve.to_toml().as_bytes()).and_then(|()| file.flush());
    written.map_err(|source| ArchiveError::Write { path: path.to_owned(), source })?;
    let name = name_of(&opened, scans.len());
    let figures =
        arguments.figures.as_ref().map(|it| write_figures(it, &curve, &scans, &name)).transpose()?;
    file.finish()?;
    figures.map_or(Ok(()), WholeSet::finish)?;
    print_result_in("Density curve", path, summary(&curve))
}

/// Origin of the curve. All scans have to be of one sensor.
fn origin(opened: &[OpenedDataset], arguments: &DatasetArgs) -> Result<CurveOrigin, Failure> {
    let descriptions = || opened.iter().map(|it| it.dataset.description());
    // Drives of unknown sensors are taken to be of one.
    let name = |it| if str::starts_with(it, UNKNOWN_SENSOR) { "unknown" } else { it };
    let sensors: BTreeSet<&str> = descriptions().map(|it| name(&it.sensor)).collect();
    let one_sensor = sensors.first().filter(|_| sensors.len() == 1);
    let Some(sensor) = one_sensor else {
        let names = sensors.into_iter().collect::<Vec<_>>().join(", ");
        return Err(Usage(format!(
            "the scans are of several sensors ({names}), but a density curve is of one"
        ))
        .into());
    };
    Ok(CurveOrigin {
        sensor: (*sensor).to_owned(),
        datasets: descriptions().map(|it| it.id.clone()).collect(),
        seeds: descriptions().filter_map(|it| Some(StreetDrive::of(it)?.seed)).collect(),
        command: reproducible_command("fit-density", arguments, &[]),
    })
}

fn name_of(opened: &[OpenedDataset], n_scans: usize) -> String {
    let of_one = |it: &OpenedDataset| {
        let description = it.dataset.description();
        let simulated = if description.is_simulated() { " (simulated)" } else { "" };
        format!("{}{simulated}", description.id)
    };
    let names: Vec<String> = opened.iter().map(of_one).collect();
    format!("measured, {}, {n_scans} scans", names.join(" + "))
}

/// The figures, which have yet to take their names.
fn write_figures(
    folder: &Path,
    curve: &DensityCurve,
    scans: &[RingCounts],
    name: &str,
) -> Result<WholeSet, Failure> {
    let set = WholeSet::within(folder)?;
    let names = Sides { left: name, right: "fitted, exponential of a polynomial of the sixth degree" };
    let mut rows = Vec::new();
    for pair in density_curves(curve, scans) {
        rows.extend(CurveRow::of_curves(&pair, names));
        set.write(&format!("{}.svg", pair.statistic), curve_plot(&pair, names).as_bytes())?;
    }
    set.write(DENSITY_CSV, &to_csv_bytes(&rows)?)?;
    Ok(set)
}

/// The curve at a few ranges.
fn summary(curve: &DensityCurve) -> String {
    let mut lines = vec![
        format!("Sensor {}, {} scans", curve.sensor, curve.n_scans),
        format!("Densest ring: {} points/m² per scan", curve.peak_points_per_m2),
    ];
    let weights =
        [5, 10, 20, 40, 80].map(|range_m| format!("{:.2e} at {range_m} m", curve.weight(f64::from(range_m))));
    lines.push(format!("Weight: {}", weights.join(", ")));
    lines.join("\n")
}
