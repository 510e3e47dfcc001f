//! The ten-step experiment: methods learn from one set of objects and are judged by another.

use detector::describe::trained_file::Provenance;
use reports::rows::partial_row::{PartialRow, SeenPart};
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;

use super::methods::{Method, MethodError};
use super::object_parts::{ObjectPart, PartsSeen, object_parts};

/// Objects of a set.
#[derive(Clone, Copy)]
pub struct ObjectsOf<'a> {
    /// The set.
    pub set: &'a dyn ObjectCloudSet,
    /// Which of its objects.
    pub object_indices: &'a [usize],
}

/// What methods learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrainedOn {
    /// Whole clouds, as in the paper.
    Whole,
    /// All steps of uncovering.
    Parts,
    /// All steps of a drive.
    Drives,
}

impl TrainedOn {
    /// The name used in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Parts => "parts",
            Self::Drives => "drives",
        }
    }

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
    /// A method learned nothing.
    #[error("{method} learned nothing from {dataset}")]
    Method {
        /// Its name.
        method: String,
        /// What it should have learned from.
        dataset: String,
        /// Why.
        source: MethodError,
    },
}

/// What is done.
#[derive(Clone, Copy)]
pub struct PartialExperiment<'a> {
    /// What methods learn from.
    pub training: ObjectsOf<'a>,
    /// What they are judged by.
    pub judged: ObjectsOf<'a>,
    /// Which parts of them are shown: [`PartsSeen::Uncovered`] or [`PartsSeen::Driven`].
    pub judged_parts: PartsSeen,
    /// Which classes take part.
    pub classes: &'a [PartialClass],
    /// What methods are trained on, in turn.
    pub trained_on: &'a [TrainedOn],
    /// The methods.
    pub methods: &'a [Method],
}

/// Has every method learn and judge. Rows are in the order of training, method and part. `on_method` is called with the name of
/// each before it learns.
///
/// The same objects give the same rows, with any number of threads.
///
/// # Errors
///
/// [`PartialExperimentError`] if an object cannot be read, or a method learns nothing.
///
/// Paper: BG section 4.
pub fn run(
    experiment: &PartialExperiment<'_>,
    mut on_method: impl FnMut(&str),
) -> Result<Vec<PartialRow>, PartialExperimentError> {
    let PartialExperiment { training, judged, judged_parts, classes, trained_on, methods } = *experiment;
    let parts_of = |objects: ObjectsOf<'_>, seen| -> Result<Vec<ObjectPart>, DatasetError> {
        let of_classes = |it: &&usize| classes.contains(&objects.set.classes()[**it]);
        let indices: Vec<usize> = objects.object_indices.iter().filter(of_classes).copied().collect();
        object_parts(objects.set, &indices, seen)
    };
    let shown = parts_of(judged, judged_parts)?;
    let data = &judged.set.description().id;
    let learned_from = &training.set.description().id;
    let mut rows = Vec::new();
    for &trained_on in trained_on {
        let learned = parts_of(training, trained_on.parts_seen())?;
        for method in methods {
            on_method(&method.name);
            let made = provenance(learned_from, trained_on);
            let trained = method.learn(&learned, made).map_err(|source| PartialExperimentError::Method {
                method: method.name.clone(),
                dataset: learned_from.clone(),
                source,
            })?;
            for (part, answer) in shown.iter().zip(trained.answers(&shown)) {
                rows.push(PartialRow::new(
                    &seen_part(data, part),
                    (&method.name, trained_on.name()),
                    &answer,
                ));
            }
        }
    }
    Ok(rows)
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
    use crate::partial::methods::OURS;
    use reports::partial_study::partial_curves::PartialCurve;
    use simulator::object_clouds::simulated_objects::{ObjectPart as Purpose, open_simulated_objects};

    #[test]
    fn simulated_objects_are_told_apart_and_the_same_rows_come_out_with_any_number_of_threads() {
        let n_per_class = 6;
        let [training, judged] = [Purpose::Training, Purpose::Development]
            .map(|part| open_simulated_objects("objects-around", part, n_per_class).unwrap());
        let all: Vec<usize> = (0..5 * n_per_class as usize).collect();
        let methods: Vec<Method> =
            Method::all().into_iter().filter(|it| it.name != "bag of graphs (paper)").collect();
        let experiment = PartialExperiment {
            training: ObjectsOf { set: &training, object_indices: &all },
            judged: ObjectsOf { set: &judged, object_indices: &all[..] },
            judged_parts: PartsSeen::Uncovered,
            classes: &PartialClass::LEARNT,
            trained_on: &[TrainedOn::Parts],
            methods: &methods,
        };
        let rows_of = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| run(&experiment, |_| ()).unwrap())
        };
        let rows = rows_of(2);
        assert_eq!(rows.len(), 4 * 6 * 20 * methods.len());
        assert_eq!(rows, rows_of(1));
        for curve in PartialCurve::all(&rows) {
            let recall = curve.steps.last().and_then(|it| it.mean_recall).unwrap();
            assert!(recall > if curve.method == OURS { 0.7 } else { 0.4 }, "{} {recall}", curve.method);
        }
    }
}
