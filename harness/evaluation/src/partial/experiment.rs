//! The ten-step experiment: methods learn from one set of objects and are judged by another.

use std::sync::Arc;

use detector::describe::trained_file::Provenance;
use detector::partial::decision::Choice;
use detector::partial::partial_model::PartialModel;
use reports::rows::partial_row::{PartialRow, SeenPart};
use reports::vocabulary::named::named;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;

use super::methods::{Method, MethodError, OURS, TrainedMethod, UnknownClass};
use super::object_parts::{ObjectPart, PartsSeen, object_parts};

/// Some objects of a set.
#[derive(Clone, Copy)]
pub struct ObjectsOf<'a> {
    /// The set.
    pub set: &'a dyn ObjectCloudSet,
    /// Indices of its objects.
    pub object_indices: &'a [usize],
}

named! {
    /// What methods learn from.
    pub enum TrainedOn {
        /// Whole clouds, as in the paper.
        Whole = "whole",
        /// All steps of uncovering.
        Parts = "parts",
        /// All steps of a drive.
        Drives = "drives",
    }
}

impl TrainedOn {
    fn parts_seen(self) -> PartsSeen {
        match self {
            Self::Whole => PartsSeen::Whole,
            Self::Parts => PartsSeen::Uncovered,
            Self::Drives => PartsSeen::Driven,
        }
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum PartialExperimentError {
    /// An object cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A model knows an unknown class.
    #[error(transparent)]
    Model(#[from] UnknownClass),
    /// A method failed to learn.
    #[error("{method} learned nothing from {dataset}")]
    Method {
        /// Its name.
        method: String,
        /// Id of the training set.
        dataset: String,
        /// Why.
        source: MethodError,
    },
}

/// Source of the knowledge of the methods.
#[derive(Clone, Copy)]
pub enum Knowledge<'a> {
    /// A bag of graphs that was trained before.
    Model {
        /// The trained model.
        model: &'a Arc<PartialModel>,
        /// Its training data, as rows name it.
        trained_on: &'a str,
    },
    /// Methods are trained now.
    Learned {
        /// Training objects.
        training: ObjectsOf<'a>,
        /// Parts of them to learn from, one kind after the other.
        trained_on: &'a [TrainedOn],
        /// The methods.
        methods: &'a [Method],
    },
}

/// An experiment.
#[derive(Clone, Copy)]
pub struct PartialExperiment<'a> {
    /// Source of the knowledge of the methods.
    pub knowledge: Knowledge<'a>,
    /// Objects that the methods are judged by.
    pub judged: ObjectsOf<'a>,
    /// Parts of these objects that are shown: [`PartsSeen::Uncovered`] or [`PartsSeen::Driven`].
    pub judged_parts: PartsSeen,
    /// Classes that take part. With [`PartialClass::Other`] a method may decide for none of them.
    pub classes: &'a [PartialClass],
}

/// Answers of one method to all parts of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredObject {
    /// Number of the method, counted over all kinds of training parts and their methods.
    pub method_idx: usize,
    /// Index of the object in its set.
    pub object_idx: usize,
    /// A row for each part.
    pub rows: Vec<PartialRow>,
}

/// Number of objects that are read at once, by all threads.
const N_READ_AT_ONCE: usize = 32;

impl PartialExperiment<'_> {
    /// Number of pairs of a method and an object.
    pub fn n_answered_objects(&self) -> usize {
        let n_answering = match self.knowledge {
            Knowledge::Model { .. } => 1,
            Knowledge::Learned { trained_on, methods, .. } => trained_on.len() * methods.len(),
        };
        n_answering * self.indices_of(self.judged).len()
    }

    fn indices_of(&self, objects: ObjectsOf<'_>) -> Vec<usize> {
        let of_classes = |it: &&usize| self.classes.contains(&objects.set.classes()[**it]);
        objects.object_indices.iter().filter(of_classes).copied().collect()
    }
}

/// Trains every method, unless it is trained already, and hands its answers to each object to `on_object`, until that
/// returns an error. Pairs of a method and an object that are done by `is_done` are left out; a method that is not needed is
/// not trained. Returns the last trained model of our method, or the one that was trained before, if it was needed or is
/// `wanted`.
///
/// Equal objects give equal rows, with any number of threads.
///
/// # Errors
///
/// [`PartialExperimentError`] if an object cannot be read, or a method fails to learn, and errors of `on_object`.
///
/// Paper: BG section 4.
pub fn run<E: From<PartialExperimentError>>(
    experiment: &PartialExperiment<'_>,
    is_done: impl Fn(usize, usize) -> bool,
    wanted: bool,
    mut on_object: impl FnMut(AnsweredObject) -> Result<(), E>,
) -> Result<Option<Arc<PartialModel>>, E> {
    let PartialExperiment { judged, judged_parts, .. } = *experiment;
    let object_indices = experiment.indices_of(judged);
    let ours = experiment.last_of_ours().filter(|_| wanted);
    let is_needed =
        |it: usize| ours == Some(it) || object_indices.iter().any(|object_idx| !is_done(it, *object_idx));
    let judges = experiment.judges(is_needed)?;
    for object_indices in object_indices.chunks(N_READ_AT_ONCE) {
        let is_left = |it: &&Judge<'_>| object_indices.iter().any(|object_idx| !is_done(it.idx, *object_idx));
        let judges: Vec<&Judge<'_>> = judges.iter().filter(is_left).collect();
        if judges.is_empty() {
            continue;
        }
        let shown = object_parts(judged.set, object_indices, judged_parts);
        let shown = shown.map_err(PartialExperimentError::from)?;
        for judge in judges {
            let mut rows = judge.rows(experiment, &shown).into_iter();
            for parts in shown.chunk_by(|one, next| one.object_idx == next.object_idx) {
                let rows: Vec<PartialRow> = rows.by_ref().take(parts.len()).collect();
                let (method_idx, object_idx) = (judge.idx, parts[0].object_idx);
                if !is_done(method_idx, object_idx) {
                    on_object(AnsweredObject { method_idx, object_idx, rows })?;
                }
            }
        }
    }
    Ok(judges.iter().rev().find(|it| it.method == OURS).and_then(|it| it.trained.model().cloned()))
}

/// A trained method.
struct Judge<'a> {
    idx: usize,
    method: &'a str,
    trained_on: &'a str,
    trained: TrainedMethod,
}

impl Judge<'_> {
    /// Rows of its answers to the parts in `shown`.
    fn rows(&self, experiment: &PartialExperiment<'_>, shown: &[ObjectPart]) -> Vec<PartialRow> {
        let may_be_none = experiment.classes.contains(&PartialClass::Other);
        let choice = if may_be_none { Choice::OrNoneOfThese } else { Choice::OfClasses };
        let data = &experiment.judged.set.description().id;
        let answers = self.trained.answers(shown, choice);
        let row = |(part, it)| PartialRow::new(&seen_part(data, part), self.method, self.trained_on, &it);
        shown.iter().zip(answers).map(row).collect()
    }
}

impl PartialExperiment<'_> {
    /// Number of our method with the last kind of training parts; `None` if it does not take part.
    fn last_of_ours(&self) -> Option<usize> {
        match self.knowledge {
            Knowledge::Model { .. } => Some(0),
            Knowledge::Learned { trained_on, methods, .. } => {
                let index = methods.iter().position(|it| it.name == OURS)?;
                Some((trained_on.len() - 1) * methods.len() + index)
            }
        }
    }

    /// All methods that are needed by `is_needed`, which takes their numbers, after training.
    fn judges(&self, is_needed: impl Fn(usize) -> bool) -> Result<Vec<Judge<'_>>, PartialExperimentError> {
        let (training, trained_on, methods) = match self.knowledge {
            Knowledge::Model { .. } if !is_needed(0) => return Ok(Vec::new()),
            Knowledge::Model { model, trained_on } => {
                let trained = TrainedMethod::of_model(Arc::clone(model))?;
                return Ok(vec![Judge { idx: 0, method: OURS, trained_on, trained }]);
            }
            Knowledge::Learned { training, trained_on, methods } => (training, trained_on, methods),
        };
        let learned_from = &training.set.description().id;
        let mut judges = Vec::new();
        for (turn, &trained_on) in trained_on.iter().enumerate() {
            let numbers = (turn * methods.len()..).zip(methods);
            let needed: Vec<(usize, &Method)> = numbers.filter(|(idx, _)| is_needed(*idx)).collect();
            if needed.is_empty() {
                continue;
            }
            let learned = object_parts(training.set, &self.indices_of(training), trained_on.parts_seen())?;
            for (idx, method) in needed {
                let made = provenance(learned_from, trained_on);
                let trained =
                    method.learn(&learned, made).map_err(|source| PartialExperimentError::Method {
                        method: method.name.clone(),
                        dataset: learned_from.clone(),
                        source,
                    })?;
                judges.push(Judge { idx, method: &method.name, trained_on: trained_on.name(), trained });
            }
        }
        Ok(judges)
    }
}

fn seen_part<'a>(data: &'a str, part: &'a ObjectPart) -> SeenPart<'a> {
    SeenPart {
        data,
        object: &part.object,
        direction: part.direction,
        step: part.step,
        class: part.class,
        n_points: part.cloud.len(),
        share_of_points: part.share_of_points,
    }
}

fn provenance(learned_from: &str, trained_on: TrainedOn) -> Provenance {
    Provenance {
        command: "scanbench partial".to_owned(),
        data: vec![learned_from.to_owned()],
        seed: 1,
        split: format!("trained on {}", trained_on.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::partial_study::partial_curves::PartialCurve;
    use simulator::object_clouds::simulated_objects::{ObjectPart as Purpose, open_simulated_objects};

    #[test]
    fn simulated_objects_are_classified_and_the_same_rows_come_out_with_any_number_of_threads() {
        let n_per_class = 6;
        let [training, judged] = [Purpose::Training, Purpose::Development]
            .map(|part| open_simulated_objects("objects-around", part, n_per_class).unwrap());
        let all: Vec<usize> = (0..5 * n_per_class as usize).collect();
        let methods: Vec<Method> =
            Method::all().into_iter().filter(|it| it.name != "bag of graphs (paper)").collect();
        let experiment = PartialExperiment {
            knowledge: Knowledge::Learned {
                training: ObjectsOf { set: &training, object_indices: &all },
                trained_on: &[TrainedOn::Parts],
                methods: &methods,
            },
            judged: ObjectsOf { set: &judged, object_indices: &all[..] },
            judged_parts: PartsSeen::Uncovered,
            classes: &PartialClass::LEARNT,
        };
        let answered = |is_done: &(dyn Fn(usize, usize) -> bool + Sync)| {
            let mut found: Vec<AnsweredObject> = Vec::new();
            let keep = |it| {
                found.push(it);
                Ok::<(), PartialExperimentError>(())
            };
            assert!(run(&experiment, is_done, true, keep).unwrap().is_some());
            found
        };
        let rows_of = |mut found: Vec<AnsweredObject>| {
            found.sort_by_key(|it| (it.method_idx, it.object_idx));
            found.into_iter().flat_map(|it| it.rows).collect::<Vec<_>>()
        };
        let on_threads = |n_threads: usize, answer: &(dyn Fn() -> Vec<AnsweredObject> + Sync)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(answer)
        };
        let rows = rows_of(on_threads(2, &|| answered(&|_, _| false)));
        assert_eq!(rows.len(), 20 * experiment.n_answered_objects());
        assert_eq!(rows.len(), 4 * 6 * 20 * methods.len());
        // On one thread, and continued in the middle.
        let half = |method_idx: usize, object_idx: usize| method_idx == 1 || object_idx.is_multiple_of(3);
        let gone_on_with = || {
            let mut found = answered(&half);
            found.extend(answered(&|method_idx, object_idx| !half(method_idx, object_idx)));
            found
        };
        assert_eq!(rows, rows_of(on_threads(1, &gone_on_with)));
        assert!(answered(&|_, _| true).is_empty());
        for curve in PartialCurve::all(&rows) {
            let recall = curve.steps.last().and_then(|it| it.mean_recall).unwrap();
            assert!(recall > if curve.method == OURS { 0.7 } else { 0.4 }, "{} {recall}", curve.method);
        }
    }
}
