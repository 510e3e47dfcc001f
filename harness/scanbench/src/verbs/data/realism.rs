//! `scanbench data realism`.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

use evaluation::realism::comparison::compare;
use evaluation::realism::survey::{SurveyedScan, survey};
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::curve_pair::{CurvePair, Sides};
use reports::plots::curve_plot::curve_plot;
use reports::run_folder::comparison_manifest::{ComparedScans, ComparisonManifest};
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::agreement::AgreementTable;
use reports::tables::studies::curve_row::CurveRow;
use scans::dataset::class_table::ClassTable;
use simulator::simulated_street::StreetDrive;

use crate::cli::{DatasetArgs, RealismArgs, SourceArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::plumbing::paper_files::write_figure;
use crate::plumbing::provenance::{command_line, compact_utc, git_state, rfc3339_utc, rustc_version};
use crate::plumbing::run_directory::begin_run_directory;
use crate::plumbing::run_manifest::{dataset_entry, seeds};
use crate::plumbing::standard_streams::{print_result_in, terminal};

/// One row for every bin of every statistic.
const REALISM_CSV: &str = "realism.csv";

/// Compares statistics of scans with those of others, writes curves and plots, and prints how well they agree.
pub fn data_realism(arguments: &RealismArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let arguments_of_side = Sides { left: arguments.data.clone(), right: against(arguments) };
    let opened = Sides {
        left: open_datasets(&arguments_of_side.left, &ClassTable::default())?,
        right: open_datasets(&arguments_of_side.right, &ClassTable::default())?,
    };
    let directory = begin_directory(arguments, &opened, started)?;
    let scans = Sides {
        left: survey_all(&opened.left, interrupted)?,
        right: survey_all(&opened.right, interrupted)?,
    };
    let curves = compare(&scans);
    let names = opened.as_ref().map(|side| name_of(side));
    let names = Sides { left: names.left.as_str(), right: names.right.as_str() };
    let manifest = manifest(&opened, &arguments_of_side, started);
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    write_curves(&directory, &curves, names)?;
    let finished = directory.finish()?;
    print_result_in(
        "Curves and plots",
        &finished,
        terminal().text(&AgreementTable { names, curves: &curves }),
    )
}

/// Arguments that open the other side. Options of the simulator are for the side that is judged.
fn against(arguments: &RealismArgs) -> DatasetArgs {
    DatasetArgs {
        datasets: vec![arguments.against.clone()],
        scans: arguments.against_scans.clone(),
        source: SourceArgs {
            format: arguments.against_format.clone(),
            topic: None,
            annotation_topic: None,
            classes: arguments.data.source.classes.clone(),
            seed: None,
            simulated_scans: None,
            sensor: None,
            sensor_height: None,
            labels_ahead: None,
            transform: None,
            columns: None,
            cache: arguments.data.source.cache.clone(),
            catalogue: arguments.data.source.catalogue.clone(),
        },
    }
}

fn begin_directory(
    arguments: &RealismArgs,
    opened: &Sides<Vec<OpenedDataset>>,
    started: Timestamp,
) -> Result<RunDirectory, Failure> {
    let ids = opened.as_ref().map(|side| ids_of(side));
    let unnamed = format!("{}-realism-{}-against-{}", compact_utc(started), ids.left, ids.right);
    begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)
}

fn survey_all(side: &[OpenedDataset], interrupted: &AtomicBool) -> Result<Vec<SurveyedScan>, Failure> {
    let mut scans = Vec::new();
    for it in side {
        scans.extend(it.look(interrupted, survey)?);
    }
    Ok(scans)
}

/// Ids of the data sets of a side, whether they are simulated, and the number of scans.
fn name_of(side: &[OpenedDataset]) -> String {
    let descriptions = || side.iter().map(|it| it.dataset.description());
    let ids: Vec<&str> = descriptions().map(|it| it.id.as_str()).collect();
    let seeds: BTreeSet<Option<u64>> = descriptions().map(|it| Some(StreetDrive::of(it)?.seed)).collect();
    let n_simulated = descriptions().filter(|it| it.is_simulated()).count();
    let simulated = match (n_simulated, seeds.first()) {
        (0, _) => String::new(),
        (n, Some(Some(seed))) if n == side.len() && seeds.len() == 1 => format!(" (simulated, seed {seed})"),
        (n, _) if n == side.len() => " (simulated)".to_owned(),
        _ => " (partly simulated)".to_owned(),
    };
    let n_scans: usize = side.iter().map(|it| it.scan_indices.len()).sum();
    format!("{}{simulated}, {n_scans} scans", ids.join(" + "))
}

fn manifest(
    opened: &Sides<Vec<OpenedDataset>>,
    arguments: &Sides<DatasetArgs>,
    started: Timestamp,
) -> ComparisonManifest {
    let compared = |side: &[OpenedDataset], arguments: &DatasetArgs| ComparedScans {
        datasets: side.iter().map(|it| dataset_entry(it, arguments.scans.as_deref())).collect(),
        seeds: seeds(side),
    };
    ComparisonManifest {
        schema: SCHEMA,
        scanbench_version: env!("CARGO_PKG_VERSION").to_owned(),
        created: rfc3339_utc(started),
        argv: command_line(),
        left: compared(&opened.left, &arguments.left),
        right: compared(&opened.right, &arguments.right),
        git: git_state(),
        rustc_version: rustc_version(),
    }
}

fn write_curves(directory: &RunDirectory, curves: &[CurvePair], names: Sides<&str>) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file(REALISM_CSV)?)?;
    for pair in curves {
        for row in CurveRow::of_curves(pair, names) {
            rows.write(&row)?;
        }
        write_figure(directory, pair.statistic, &curve_plot(pair, names))?;
    }
    rows.finish()?;
    Ok(())
}
