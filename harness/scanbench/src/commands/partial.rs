//! `scanbench partial`.

use detector::partial::partial_params::PartialParams;
use evaluation::partial::experiment::{
    Knowledge, ObjectsOf, PartialExperiment, PartialExperimentError, PartialResults, TrainedOn, run,
};
use evaluation::partial::methods::{Method, OURS};
use evaluation::partial::object_parts::PartsSeen;
use jiff::Timestamp;
use reports::files::causes::with_causes;
use reports::pages::partial_page::PartialPage;
use reports::partial_study::peer_rows::{PeerError, read_peer_rows};
use reports::rows::partial_row::PartialRow;
use reports::run_folder::partial_manifest::SHIPPED;
use reports::run_folder::run_directory::PARTIAL_RRD;
use reports::run_folder::run_target::LatestPointer;
use reports::vocabulary::partial_class::PartialClass;
use scans::object_cloud::class_of_folder::class_of_folder;

use crate::cli::{LearnedFrom, PartialArgs};
use crate::commands::failure::{Failure, NothingEvaluated, Usage};
use crate::commands::partial_files::{manifest, write_files};
use crate::commands::partial_growths::first_growths;
use crate::commands::partial_sets::{Compared, Known, open_all};
use crate::commands::progress::progress_over_results;
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::{record_growths, records_growths};
use crate::commands::run_directory::begin_run_directory;
use crate::commands::standard_streams::{print_diagnostic, print_result};

/// Has methods tell what objects are of which a part has been seen, and writes rows, tables, figures, a page and a recording.
///
/// # Errors
///
/// If there are no such objects or no such model, they are damaged or too few, an option says nothing about them, or the output
/// cannot be written.
pub fn partial(arguments: &PartialArgs) -> Result<(), Failure> {
    let started = Timestamp::now();
    let unnamed = format!("{}-partial", compact_utc(started));
    let sets = open_all(arguments)?;
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let (mut rows, mut growths) = (Vec::new(), Vec::new());
    for set in &sets {
        let results = results(set, arguments)?;
        rows.extend(results.rows);
        if let Some(model) = results.model.filter(|_| records_growths(arguments)) {
            growths.extend(first_growths(arguments, set, &model)?);
        }
    }
    if rows.is_empty() {
        return Err(NothingEvaluated { reason: "no object is of a class that is judged".to_owned() }.into());
    }
    rows.extend(peer_rows(arguments, &rows)?);
    let manifest = manifest(arguments, &sets, started)?;
    let table = write_files(&directory, &manifest, &rows)?;
    if !growths.is_empty() {
        record_growths(&directory.path_of(PARTIAL_RRD), &manifest.title(), &growths)?;
    }
    PartialPage::of(directory.folder(), OURS)?.write(directory.folder())?;
    let finished = directory.finish()?;
    let printed = print_result(table);
    print_diagnostic(format_args!("Partial: {}", finished.display()));
    printed
}

fn results(set: &Compared, arguments: &PartialArgs) -> Result<PartialResults, Failure> {
    let methods =
        if arguments.ablation { Method::ablation(&PartialParams::shipped()) } else { Method::all() };
    let trained_on = trained_on(arguments);
    let (of_judged, of_training) = (set.judged_indices(), set.training_indices());
    let model_name = arguments.model.as_ref().map_or(SHIPPED, |_| "model");
    let experiment = PartialExperiment {
        knowledge: match &set.known {
            Known::Model(model) => Knowledge::Model { model, trained_on: model_name },
            Known::Objects { training, .. } => Knowledge::Learned {
                training: ObjectsOf { set: &**training, object_indices: &of_training },
                trained_on: &trained_on,
                methods: &methods,
            },
        },
        judged: ObjectsOf { set: &*set.judged, object_indices: &of_judged },
        judged_parts: if arguments.drives { PartsSeen::Driven } else { PartsSeen::Uncovered },
        classes: if arguments.others { &PartialClass::ALL } else { &PartialClass::LEARNT },
    };
    let progress = progress_over_results(experiment.n_answers(), 0, &set.judged.description().id);
    let results = run(&experiment, || progress.inc(1));
    progress.finish_and_clear();
    results.map_err(|error| match error {
        PartialExperimentError::Dataset(error) => error.into(),
        PartialExperimentError::Model(error) => Failure::Usage(error.into()),
        error @ PartialExperimentError::Method { .. } => {
            NothingEvaluated { reason: with_causes(&error) }.into()
        }
    })
}

fn trained_on(arguments: &PartialArgs) -> Vec<TrainedOn> {
    let parts = if arguments.drives { TrainedOn::Drives } else { TrainedOn::Parts };
    if arguments.trained_on.is_empty() {
        return vec![TrainedOn::Whole, parts];
    }
    let trained_on = arguments.trained_on.iter().map(|it| match it {
        LearnedFrom::Whole => TrainedOn::Whole,
        LearnedFrom::Parts => parts,
    });
    trained_on.collect()
}

/// What programs of others told the same objects to be.
fn peer_rows(arguments: &PartialArgs, ours: &[PartialRow]) -> Result<Vec<PartialRow>, Failure> {
    let mut rows: Vec<PartialRow> = Vec::new();
    for peer in &arguments.peer_results {
        if ours.iter().chain(&rows).any(|it| it.method() == peer.name) {
            return Err(Usage(format!("two methods are called {:?}", peer.name)).into());
        }
        rows.extend(read_peer_rows(&peer.file, &peer.name, ours, class_of_folder)?);
    }
    Ok(rows)
}

impl From<PeerError> for Failure {
    fn from(error: PeerError) -> Self {
        Self::Data(error.into())
    }
}
