//! The objects of `scanbench partial`, and the sources of what methods know.

use std::path::Path;
use std::sync::Arc;

use detector::partial::partial_model::PartialModel;
use evaluation::partial::experiment::TrainedOn;
use evaluation::partial::model_training::APPROACHED;
use reports::files::regular_file::{MOST_OF_MODEL, read_bytes};
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::object_clouds::open_objects::ObjectOptions;
use simulator::object_clouds::simulated_objects::ObjectPart;

use crate::cli::{LearnedFrom, PartialArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::object_sets::{ObjectOpening, refuse_idle_options};

/// Objects that are judged, and the source of what methods know.
pub struct Compared {
    pub judged: Box<dyn ObjectCloudSet>,
    pub known: Known,
}

/// Source of what methods know.
pub enum Known {
    /// They learn from these objects.
    Objects {
        training: Box<dyn ObjectCloudSet>,
        /// Whether they are the recorded ones that are judged, too: then half of them are learned from.
        are_same: bool,
    },
    Model(Arc<PartialModel>),
}

/// Opens all objects before anything is judged, so that a misspelled last name costs nothing.
pub fn open_all(arguments: &PartialArgs) -> Result<Vec<Compared>, Failure> {
    let learned_from: Vec<String> = arguments.train.iter().cloned().collect();
    refuse_idle_options(&arguments.objects, &learned_from, &arguments.choice, &arguments.source)?;
    if let Some(name) = arguments.objects.iter().find(|it| arguments.drives && *it != APPROACHED) {
        return Err(Usage(format!("--drives is for {APPROACHED}; nobody drove toward {name:?}")).into());
    }
    if !arguments.peer_results.is_empty() && arguments.objects.len() != 1 {
        let problem = "--peer-results are of one set of objects, and several are given";
        return Err(Usage(problem.to_owned()).into());
    }
    let opening = ObjectOpening::of(&arguments.source)?;
    let model = match (&arguments.model, &arguments.train) {
        (_, Some(_)) => None,
        (Some(path), None) => Some(Arc::new(read_model(path)?)),
        (None, None) => Some(PartialModel::shipped()),
    };
    let compared = |name: &String| -> Result<Compared, Failure> {
        let judged = opening.open(name, &arguments.choice.options())?;
        let known = match (&model, &arguments.train) {
            (Some(model), _) => Known::Model(Arc::clone(model)),
            (None, train) => {
                let of_training = train.as_deref().unwrap_or(name);
                let options = ObjectOptions { part: ObjectPart::Training, ..arguments.choice.options() };
                let training = opening.open(of_training, &options)?;
                let are_same = of_training == name && training.description() == judged.description();
                Known::Objects { are_same: are_same && !judged.description().is_simulated(), training }
            }
        };
        Ok(Compared { judged, known })
    };
    arguments.objects.iter().map(compared).collect()
}

fn read_model(path: &Path) -> Result<PartialModel, Failure> {
    let cannot = || format!("cannot use the model {}", path.display());
    let bytes = read_bytes(path, MOST_OF_MODEL).map_err(|error| Failure::usage(cannot(), error))?;
    PartialModel::from_bytes(&bytes).map_err(|error| Failure::usage(cannot(), error))
}

/// Whether methods learn from whole objects, from their parts or from drives; if from several, in turn.
pub fn trained_on(arguments: &PartialArgs) -> Vec<TrainedOn> {
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

impl Compared {
    /// The objects that are judged: all, or every second one of those that are learned from, too.
    pub fn judged_indices(&self) -> Vec<usize> {
        let all = 0..self.judged.classes().len();
        match self.known {
            Known::Objects { are_same: true, .. } => all.skip(1).step_by(2).collect(),
            Known::Objects { .. } | Known::Model(_) => all.collect(),
        }
    }

    pub fn training_indices(&self) -> Vec<usize> {
        match &self.known {
            Known::Objects { training, are_same } => {
                (0..training.classes().len()).step_by(if *are_same { 2 } else { 1 }).collect()
            }
            Known::Model(_) => Vec::new(),
        }
    }
}
