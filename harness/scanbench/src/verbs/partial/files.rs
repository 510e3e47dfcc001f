//! Files of `scanbench partial`.

use std::collections::BTreeMap;

use evaluation::partial::methods::OURS;
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::files::new_file::file_stem_of;
use reports::files::regular_file::read_bytes;
use reports::partial_study::partial_curves::PartialCurve;
use reports::plots::partial_plot::{partial_accuracy_plot, partial_calibration_plot, partial_error_plot};
use reports::rows::partial_row::PartialRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::partial_entry::{
    ModelEntry, ObjectSetEntry, PartialEntry, PartialSet, PartialSettings, SHIPPED,
};
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::tables::formats::format::Format as _;
use reports::tables::studies::partial_findings::partial_findings;
use reports::tables::studies::partial_table::PartialTable;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::checksum::sha256;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;

use crate::cli::PartialArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::provenance::{
    command_line, git_state, machine, project_state, rfc3339_utc, rustc_version,
};
use crate::plumbing::recorder::rerun_version;
use crate::plumbing::standard_streams::terminal;
use crate::verbs::partial::sets::{Compared, Known, trained_on};

/// The largest file of rows of a peer, in bytes.
const MOST_OF_ROWS: u64 = 1 << 32;

pub fn manifest(arguments: &PartialArgs, sets: &[Compared], started: Timestamp) -> Result<Manifest, Failure> {
    let of_set = |it: &Compared| PartialSet {
        judged: entry(&*it.judged),
        learned_from: match &it.known {
            Known::Objects { training, .. } => Some(entry(&**training)),
            Known::Model(_) => None,
        },
        halves: matches!(it.known, Known::Objects { are_same: true, .. }),
        model: match &it.known {
            Known::Objects { .. } => None,
            Known::Model(model) => Some(ModelEntry {
                name: arguments.model.as_ref().map_or(SHIPPED.to_owned(), |it| it.display().to_string()),
                made_by: model.made.command.clone(),
                data: model.made.data.clone(),
            }),
        },
    };
    let mut peers = BTreeMap::new();
    for peer in &arguments.peer_results {
        let content = read_bytes(&peer.file, MOST_OF_ROWS)
            .map_err(|error| Failure::usage(format!("cannot read {}", peer.file.display()), error))?;
        peers.insert(peer.name.clone(), sha256(&content));
    }
    let settings = PartialSettings {
        others: arguments.others,
        drives: arguments.drives,
        ablation: arguments.ablation,
        trained_on: trained_on(arguments).iter().map(|it| it.name().to_owned()).collect(),
    };
    let sets = sets.iter().map(of_set).collect();
    Ok(Manifest {
        schema: SCHEMA,
        scanbench_version: env!("CARGO_PKG_VERSION").to_owned(),
        created: rfc3339_utc(started),
        argv: command_line(),
        n_repeats: 1,
        git: git_state(),
        project: project_state(),
        rustc_version: rustc_version(),
        rerun_version: rerun_version(),
        machine: machine(),
        partial: Some(PartialEntry { sets, peers, settings: Some(settings) }),
        ..Manifest::default()
    })
}

fn entry(set: &dyn ObjectCloudSet) -> ObjectSetEntry {
    let it = set.description();
    let n_of = |class: PartialClass| set.classes().iter().filter(|it| **it == class).count();
    ObjectSetEntry {
        id: it.id.clone(),
        simulated: it.is_simulated(),
        simulation: it.simulation.as_ref().and_then(|it| serde_json::to_value(it).ok()),
        objects: PartialClass::ALL.into_iter().map(|it| (it.name().to_owned(), n_of(it))).collect(),
    }
}

/// Writes tables and figures of `rows` into `directory`, and returns the table as it is printed.
pub fn write_files(
    directory: &RunDirectory,
    manifest: &Manifest,
    rows: &[PartialRow],
) -> Result<String, Failure> {
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let partial = manifest.partial.clone().unwrap_or_default();
    let (title, curves) = (&partial.title(), PartialCurve::all(rows));
    let found = partial_findings(&partial, &curves, OURS);
    let table = PartialTable { title, curves: &curves, method: OURS, found: &found };
    write_table(directory, "partial", &table)?;
    write_figure(directory, "accuracy", &partial_accuracy_plot(&curves, title).svg(title))?;
    write_figure(directory, "calibration", &partial_calibration_plot(&curves, title).svg(title))?;
    for curve in curves.iter().filter(|it| it.method == OURS) {
        let PartialCurve { data, direction, trained_on, .. } = curve;
        let title = format!("Mean error to each class: {data} from {direction}, trained on {trained_on}");
        let stem = file_stem_of(&format!("errors_{data}_{direction}_{trained_on}"));
        write_figure(directory, &stem, &partial_error_plot(curve, &title).svg(&title))?;
    }
    Ok(terminal().text(&table))
}
