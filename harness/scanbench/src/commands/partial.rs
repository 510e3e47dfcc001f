//! `scanbench partial`.

use detector::partial::partial_params::PartialParams;
use evaluation::partial::experiment::{ObjectsOf, PartialExperiment, PartialExperimentError, TrainedOn, run};
use evaluation::partial::methods::{Method, OURS};
use evaluation::partial::object_parts::PartsSeen;
use jiff::Timestamp;
use reports::files::causes::with_causes;
use reports::files::csv_rows::to_csv_bytes;
use reports::partial_study::partial_curves::PartialCurve;
use reports::plots::partial_plot::{partial_accuracy_plot, partial_calibration_plot, partial_error_plot};
use reports::rows::partial_row::PartialRow;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::partial_table::PartialTable;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::class_table::ClassTable;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::object_clouds::open_objects::{ObjectOptions, open_objects};
use simulator::object_clouds::simulated_objects::ObjectPart;

use crate::cli::{LearnedFrom, PartialArgs};
use crate::commands::failure::{Failure, NothingEvaluated, Usage};
use crate::commands::open_datasets::{open_catalogue, open_options, refuse_scan_options};
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::progress::progress_over_results;
use crate::commands::provenance::{command_line, compact_utc, git_state, rfc3339_utc, rustc_version};
use crate::commands::run_directory::begin_run_directory;
use crate::commands::standard_streams::{print_diagnostic, print_result, terminal};

/// What a recorded set is learned from that no other objects are named for.
const USUAL_TRAINING: &str = "objects-around";

/// Has methods tell what objects are of which a part has been seen, and writes rows, tables and figures.
///
/// # Errors
///
/// If there are no such objects, they are damaged or too few, or the output cannot be written.
pub fn partial(arguments: &PartialArgs) -> Result<(), Failure> {
    let started = Timestamp::now();
    let unnamed = format!("{}-partial", compact_utc(started));
    let sets = arguments.objects.iter().map(|it| Compared::open(arguments, it));
    let sets = sets.collect::<Result<Vec<_>, _>>()?;
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let mut rows = Vec::new();
    for set in &sets {
        rows.extend(set.rows(arguments)?);
    }
    if rows.is_empty() {
        return Err(NothingEvaluated { reason: "no object is of a class that is judged".to_owned() }.into());
    }
    let title = title(&sets);
    directory.write_file(MANIFEST_JSON, manifest(&sets, started).as_bytes())?;
    let table = write_files(&directory, &rows, &title)?;
    let finished = directory.finish()?;
    let printed = print_result(table);
    print_diagnostic(format_args!("Partial: {}", finished.display()));
    printed
}

/// Objects that are judged, with those to learn from.
struct Compared {
    judged: Box<dyn ObjectCloudSet>,
    training: Box<dyn ObjectCloudSet>,
    /// Whether both are the same recorded objects, of which half are learned from.
    are_same: bool,
}

impl Compared {
    fn open(arguments: &PartialArgs, name: &str) -> Result<Self, Failure> {
        refuse_scan_options(name, &arguments.source)?;
        let catalogue = open_catalogue(arguments.source.catalogue.catalogue.as_deref())?;
        let options = open_options(&arguments.source, &ClassTable::default())?;
        let open = |name: &str, objects: &ObjectOptions| open_objects(name, objects, &options, &catalogue);
        let judged = open(name, &arguments.choice.options())?;
        let is_simulated = judged.description().is_simulated();
        if arguments.drives && name != "objects-approach" {
            return Err(
                Usage(format!("--drives is for objects-approach; nobody drove toward {name:?}")).into()
            );
        }
        let usual = if is_simulated && judged.description().root.is_none() { name } else { USUAL_TRAINING };
        let of_training = arguments.train.as_deref().unwrap_or(usual);
        let training_part = ObjectOptions { part: ObjectPart::Training, ..arguments.choice.options() };
        let training = open(of_training, &training_part)?;
        let are_same = of_training == name && training.description() == judged.description();
        Ok(Self { judged, training, are_same: are_same && !is_simulated })
    }

    fn rows(&self, arguments: &PartialArgs) -> Result<Vec<PartialRow>, Failure> {
        let indices = |set: &dyn ObjectCloudSet, remainder: usize| -> Vec<usize> {
            let all = 0..set.classes().len();
            all.filter(|it| !self.are_same || it % 2 == remainder).collect()
        };
        let (of_training, of_judged) = (indices(&*self.training, 0), indices(&*self.judged, 1));
        let methods =
            if arguments.ablation { Method::ablation(&PartialParams::shipped()) } else { Method::all() };
        let parts = if arguments.drives { TrainedOn::Drives } else { TrainedOn::Parts };
        let trained_on = arguments.trained_on.iter().map(|it| match it {
            LearnedFrom::Whole => TrainedOn::Whole,
            LearnedFrom::Parts => parts,
        });
        let trained_on: Vec<TrainedOn> = trained_on.collect();
        let experiment = PartialExperiment {
            training: ObjectsOf { set: &*self.training, object_indices: &of_training },
            judged: ObjectsOf { set: &*self.judged, object_indices: &of_judged },
            judged_parts: if arguments.drives { PartsSeen::Driven } else { PartsSeen::Uncovered },
            classes: if arguments.others { &PartialClass::ALL } else { &PartialClass::LEARNT },
            trained_on: &trained_on,
            methods: &methods,
        };
        let progress =
            progress_over_results(methods.len() * trained_on.len(), 0, &self.judged.description().id);
        let rows = run(&experiment, |_| progress.inc(1));
        progress.finish_and_clear();
        rows.map_err(|error| match error {
            PartialExperimentError::Dataset(error) => error.into(),
            error @ PartialExperimentError::Method { .. } => {
                NothingEvaluated { reason: with_causes(&error) }.into()
            }
        })
    }
}

fn named(set: &dyn ObjectCloudSet) -> String {
    let description = set.description();
    let simulated = if description.is_simulated() { " (simulated)" } else { "" };
    format!("{}{simulated}", description.id)
}

fn title(sets: &[Compared]) -> String {
    let pairs = sets.iter().map(|it| {
        let half = if it.are_same { ", the other half of it" } else { "" };
        format!("{}, learned from {}{half}", named(&*it.judged), named(&*it.training))
    });
    format!("Partial clouds: {}.", pairs.collect::<Vec<_>>().join("; "))
}

fn manifest(sets: &[Compared], started: Timestamp) -> String {
    let described = |set: &dyn ObjectCloudSet| {
        let it = set.description();
        let classes = PartialClass::ALL.map(|class| {
            let n = set.classes().iter().filter(|it| **it == class).count();
            (class.name().to_owned(), n)
        });
        serde_json::json!({
            "id": it.id, "simulated": it.is_simulated(), "simulation": it.simulation,
            "objects": classes.into_iter().collect::<std::collections::BTreeMap<_, _>>(),
        })
    };
    let sets = sets.iter().map(|it| {
        serde_json::json!({
            "judged": described(&*it.judged), "learned_from": described(&*it.training), "halves": it.are_same,
        })
    });
    let manifest = serde_json::json!({
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "created": rfc3339_utc(started),
        "argv": command_line(),
        "sets": sets.collect::<Vec<_>>(),
        "git": git_state(),
        "rustc_version": rustc_version(),
    });
    format!("{manifest:#}\n")
}

/// Writes everything, and returns the table as it is printed.
fn write_files(directory: &RunDirectory, rows: &[PartialRow], title: &str) -> Result<String, Failure> {
    directory.write_file("partial.csv", &to_csv_bytes(rows)?)?;
    let curves = PartialCurve::all(rows);
    let table = PartialTable { title, curves: &curves, method: OURS };
    write_table(directory, "partial", &table)?;
    write_figure(directory, "accuracy", &partial_accuracy_plot(&curves, title))?;
    write_figure(directory, "calibration", &partial_calibration_plot(&curves, title))?;
    for curve in curves.iter().filter(|it| it.method == OURS) {
        let PartialCurve { data, direction, trained_on, .. } = curve;
        let title = format!("Mean error to each class: {data} from {direction}, trained on {trained_on}");
        let safe = |it: char| if it.is_ascii_alphanumeric() || it == '-' { it } else { '_' };
        let stem: String = format!("errors_{data}_{direction}_{trained_on}").chars().map(safe).collect();
        write_figure(directory, &stem, &partial_error_plot(curve, &title))?;
    }
    Ok(terminal().text(&table))
}
