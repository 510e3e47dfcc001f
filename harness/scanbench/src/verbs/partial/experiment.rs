//! The experiment of `scanbench partial` on a set of objects, and predictions of other people's programs.

use detector::partial::partial_params::PartialParams;
use evaluation::partial::experiment::{Knowledge, ObjectsOf, PartialExperiment, PartialExperimentError};
use evaluation::partial::methods::Method;
use evaluation::partial::object_parts::PartsSeen;
use reports::files::causes::with_causes;
use reports::partial_study::peer_rows::{PeerError, read_peer_rows};
use reports::rows::partial_row::PartialRow;
use reports::run_folder::partial_entry::SHIPPED;
use reports::vocabulary::partial_class::PartialClass;
use scans::object_cloud::class_of_folder::class_of_folder;

use crate::cli::PartialArgs;
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::verbs::partial::sets::{Compared, Known, trained_on};

/// Hands `work` the experiment that `arguments` ask for, over these objects of `set`.
pub fn with_experiment<T>(
    set: &Compared,
    object_indices: &[usize],
    arguments: &PartialArgs,
    work: impl FnOnce(&PartialExperiment<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let methods =
        if arguments.ablation { Method::ablation(&PartialParams::shipped()) } else { Method::all() };
    let (trained_on, of_training) = (trained_on(arguments), set.training_indices());
    let model_name = arguments.model.as_ref().map_or(SHIPPED, |_| "model");
    work(&PartialExperiment {
        knowledge: match &set.known {
            Known::Model(model) => Knowledge::Model { model, trained_on: model_name },
            Known::Objects { training, .. } => Knowledge::Learned {
                training: ObjectsOf { set: &**training, object_indices: &of_training },
                trained_on: &trained_on,
                methods: &methods,
            },
        },
        judged: ObjectsOf { set: &*set.judged, object_indices },
        judged_parts: if arguments.drives { PartsSeen::Driven } else { PartsSeen::Uncovered },
        classes: if arguments.others { &PartialClass::ALL } else { &PartialClass::LEARNT },
    })
}

/// Predictions of other people's programs for the same objects.
pub fn peer_rows(arguments: &PartialArgs, ours: &[PartialRow]) -> Result<Vec<PartialRow>, Failure> {
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

impl From<PartialExperimentError> for Failure {
    fn from(error: PartialExperimentError) -> Self {
        match error {
            PartialExperimentError::Dataset(error) => error.into(),
            PartialExperimentError::Model(error) => Self::Usage(error.into()),
            error @ PartialExperimentError::Method { .. } => {
                NothingEvaluated { reason: with_causes(&error) }.into()
            }
        }
    }
}
