//! The methods that classify objects: the bag of graphs in several forms, and its rivals.

use std::sync::Arc;

use baselines::pca_features::N_PCA_FEATURES;
use detector::PointCloud;
use detector::classify::nu_svc_solver::NuSvcError;
use detector::describe::trained_file::Provenance;
use detector::partial::decision::{Centers, Choice, DecisionRule, Verdict};
use detector::partial::partial_classifier::PartialClassifier;
use detector::partial::partial_model::PartialModel;
use detector::partial::partial_params::PartialParams;
use detector::partial::patterns::PatternKind;
use detector::partial::training::{TrainingCloud, TrainingError, train};
use rayon::prelude::*;
use reports::rows::partial_row::{Answer, OfClasses, Predicted};
use reports::vocabulary::partial_class::PartialClass;

use super::object_parts::ObjectPart;
use super::pairwise_svm::PairwiseSvm;
use super::rival_values::{N_EXTENTS, N_VEHICLE_VALUES, extent_values, pca_values, vehicle_values};

/// A method before training.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// The name used in tables.
    pub name: String,
    /// Its kind.
    pub kind: MethodKind,
}

/// Kind of a method.
#[derive(Debug, Clone, PartialEq)]
pub enum MethodKind {
    /// A bag of graphs with these parameters.
    BagOfGraphs(Box<PartialParams>),
    /// Extents and heights, with support vector machines.
    Extents,
    /// The values of `pca`, with support vector machines.
    Pca,
    /// The values of our vehicle model, with support vector machines.
    VehicleValues,
}

/// Name of a variant, and its change of the parameters.
type Variant<'a> = (&'a str, &'a dyn Fn(&mut PartialParams));

/// The name of our method in tables.
pub const OURS: &str = "bag of graphs";

impl Method {
    /// The bag of graphs as it comes with the program and to the letter of the paper, and the rivals.
    pub fn all() -> Vec<Self> {
        let rivals = [
            ("extents", MethodKind::Extents),
            ("pca values", MethodKind::Pca),
            ("vehicle values", MethodKind::VehicleValues),
        ];
        let rivals = rivals.map(|(name, kind)| Self { name: name.to_owned(), kind });
        let ours = Self::graphs(OURS, PartialParams::shipped());
        [ours, Self::of_paper()].into_iter().chain(rivals).collect()
    }

    /// The bag of graphs to the letter of the paper.
    pub fn of_paper() -> Self {
        Self::graphs("bag of graphs (paper)", PartialParams::of_paper())
    }

    fn graphs(name: &str, params: PartialParams) -> Self {
        Self { name: name.to_owned(), kind: MethodKind::BagOfGraphs(Box::new(params)) }
    }

    /// The whole bag of graphs, and variants without each of its parts.
    pub fn ablation(whole: &PartialParams) -> Vec<Self> {
        let variants: [Variant<'_>; 12] = [
            (OURS, &|_| ()),
            ("without graphs", &|it| {
                it.patterns.kinds.retain(|kind| *kind != PatternKind::Graph);
            }),
            ("without keypoints by themselves", &|it| {
                it.patterns.kinds.retain(|kind| *kind != PatternKind::Keypoint);
            }),
            ("without shape statistics", &|it| {
                it.patterns.kinds.retain(|kind| *kind != PatternKind::ShapeStatistics);
            }),
            ("without shape statistics and extents", &|it| {
                it.patterns
                    .kinds
                    .retain(|kind| !matches!(kind, PatternKind::Extents | PatternKind::ShapeStatistics));
            }),
            ("without heights", &|it| it.patterns.height_edges_m.clear()),
            ("without volumes", &|it| it.patterns.volume_edges_m3.clear()),
            ("without weights: the nearest mean of a part", &|it| {
                it.decision.rule = DecisionRule::Nearest;
                it.decision.centers = Centers::OfParts;
            }),
            ("without weights: the nearest mean", &|it| it.decision.rule = DecisionRule::Nearest),
            ("k halved", &|it| it.labels.n_labels = (it.labels.n_labels / 2).max(1)),
            ("r halved", &|it| it.surface.radius_m *= 0.5),
            ("r doubled", &|it| it.surface.radius_m *= 2.0),
        ];
        let variant = |(name, change): Variant<'_>| {
            let mut params = whole.clone();
            change(&mut params);
            Self::graphs(name, params)
        };
        variants.into_iter().map(variant).collect()
    }
}

/// Why a method failed to learn.
#[derive(Debug, thiserror::Error)]
pub enum MethodError {
    /// The bag of graphs.
    #[error("the bag of graphs learned nothing")]
    BagOfGraphs(#[from] TrainingError),
    /// A rival.
    #[error("a rival learned nothing")]
    Rival(#[from] NuSvcError),
}

/// A model knows a class that no object has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the model knows the class {name:?}, which is none of tree, car, pole, pedestrian and other")]
pub struct UnknownClass {
    /// Name of the class in the model.
    pub name: String,
}

/// A trained method.
#[derive(Debug, Clone)]
pub struct TrainedMethod {
    classes: Vec<PartialClass>,
    kind: TrainedKind,
}

#[derive(Debug, Clone)]
enum TrainedKind {
    BagOfGraphs(Arc<PartialModel>),
    Extents(PairwiseSvm<N_EXTENTS>),
    Pca(PairwiseSvm<N_PCA_FEATURES>),
    VehicleValues(PairwiseSvm<N_VEHICLE_VALUES>),
}

impl Method {
    /// Trains the method on `parts`; a class counts if there is an object of it.
    ///
    /// # Errors
    ///
    /// [`MethodError`] if there are fewer than two classes, or two of them cannot be separated.
    pub fn learn(&self, parts: &[ObjectPart], made: Provenance) -> Result<TrainedMethod, MethodError> {
        let is_there = |class: &PartialClass| parts.iter().any(|it| it.class == *class);
        let classes: Vec<PartialClass> = PartialClass::ALL.into_iter().filter(is_there).collect();
        let kind = match &self.kind {
            MethodKind::BagOfGraphs(params) => {
                TrainedKind::BagOfGraphs(Arc::new(bag_of_graphs(parts, &classes, params, made)?))
            }
            MethodKind::Extents => TrainedKind::Extents(svm(parts, &classes, extent_values)?),
            MethodKind::Pca => TrainedKind::Pca(svm(parts, &classes, pca_values)?),
            MethodKind::VehicleValues => TrainedKind::VehicleValues(svm(parts, &classes, vehicle_values)?),
        };
        Ok(TrainedMethod { classes, kind })
    }
}

/// Trains a bag of graphs of `classes` on parts of objects. All threads describe parts; their number does not change the
/// model.
///
/// # Errors
///
/// [`TrainingError`] if a class has no training data.
pub fn bag_of_graphs(
    parts: &[ObjectPart],
    classes: &[PartialClass],
    params: &PartialParams,
    made: Provenance,
) -> Result<PartialModel, TrainingError> {
    let names: Vec<String> = classes.iter().map(|it| it.name().to_owned()).collect();
    let described = |part: &ObjectPart| {
        let class_idx = classes.iter().position(|it| *it == part.class)?;
        let positions_m = part.cloud.positions_m();
        Some(TrainingCloud::described(positions_m, class_idx, part.object_idx, part.index(), params))
    };
    let clouds: Vec<Option<TrainingCloud>> = parts.par_iter().map(described).collect();
    train(&names, &clouds.into_iter().flatten().collect::<Vec<_>>(), params, made)
}

fn svm<const D: usize>(
    parts: &[ObjectPart],
    classes: &[PartialClass],
    values: impl Fn(&PointCloud) -> Option<[f32; D]> + Sync,
) -> Result<PairwiseSvm<D>, NuSvcError> {
    let of_parts: Vec<Option<[f32; D]>> = parts.par_iter().map(|it| values(&it.cloud)).collect();
    let (mut vectors, mut class_indices, mut groups) = (Vec::new(), Vec::new(), Vec::new());
    for (part, vector) in parts.iter().zip(of_parts) {
        if let Some((vector, class_idx)) = vector.zip(classes.iter().position(|it| *it == part.class)) {
            vectors.push(vector);
            class_indices.push(class_idx);
            groups.push(part.object_idx);
        }
    }
    PairwiseSvm::learned(&vectors, &class_indices, &groups, classes.len())
}

impl TrainedMethod {
    /// A bag of graphs that was trained before.
    ///
    /// # Errors
    ///
    /// [`UnknownClass`] if it knows a class that no object has.
    pub fn of_model(model: Arc<PartialModel>) -> Result<Self, UnknownClass> {
        let class = |name: &String| PartialClass::from_name(name).ok_or(UnknownClass { name: name.clone() });
        let classes = model.classes.iter().map(class).collect::<Result<_, _>>()?;
        Ok(Self { classes, kind: TrainedKind::BagOfGraphs(model) })
    }

    /// Its model, if it is a bag of graphs.
    pub fn model(&self) -> Option<&Arc<PartialModel>> {
        match &self.kind {
            TrainedKind::BagOfGraphs(model) => Some(model),
            TrainedKind::Extents(_) | TrainedKind::Pca(_) | TrainedKind::VehicleValues(_) => None,
        }
    }

    /// Its answers to all parts, in their order.
    pub fn answers(&self, parts: &[ObjectPart], choice: Choice) -> Vec<Answer> {
        match &self.kind {
            TrainedKind::BagOfGraphs(model) => {
                let new_classifier = || PartialClassifier::with_choice(Arc::clone(model), choice);
                let of_part = |it: &mut _, part: &ObjectPart| self.of_graphs(it, &part.cloud);
                parts.par_iter().map_init(new_classifier, of_part).collect()
            }
            TrainedKind::Extents(svm) => {
                parts.par_iter().map(|it| self.of_svm(svm, extent_values(&it.cloud))).collect()
            }
            TrainedKind::Pca(svm) => {
                parts.par_iter().map(|it| self.of_svm(svm, pca_values(&it.cloud))).collect()
            }
            TrainedKind::VehicleValues(svm) => {
                parts.par_iter().map(|it| self.of_svm(svm, vehicle_values(&it.cloud))).collect()
            }
        }
    }

    /// Answer of a bag of graphs to a cloud.
    pub fn of_graphs(&self, classifier: &mut PartialClassifier, cloud: &PointCloud) -> Answer {
        let judgement = classifier.classify(cloud.positions_m());
        let predicted = match judgement.verdict {
            Verdict::TooLittleSeen => Predicted::NotJudged,
            Verdict::NoneOfThese => Predicted::NoneOfThese,
            Verdict::Class(class_idx) => self.classes[class_idx].into(),
        };
        if predicted == Predicted::NotJudged {
            return Answer { predicted, errors: [None; 5], chances: [None; 5] };
        }
        Answer {
            predicted,
            errors: self.of_classes(&judgement.distances),
            chances: self.of_classes(&judgement.probabilities),
        }
    }

    fn of_svm<const D: usize>(&self, svm: &PairwiseSvm<D>, vector: Option<[f32; D]>) -> Answer {
        let Some(vector) = vector else {
            return Answer { predicted: Predicted::NotJudged, errors: [None; 5], chances: [None; 5] };
        };
        let (class_idx, chances) = svm.judge(&vector);
        Answer {
            predicted: self.classes[class_idx].into(),
            errors: [None; 5],
            chances: self.of_classes(&chances),
        }
    }

    fn of_classes(&self, values: &[f32]) -> OfClasses {
        PartialClass::ALL.map(|class| {
            let index = self.classes.iter().position(|it| *it == class)?;
            Some(f64::from(values[index])).filter(|it| it.is_finite())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variant_is_another_one_that_can_be_used() {
        let variants = Method::ablation(&PartialParams::shipped());
        for (index, variant) in variants.iter().enumerate() {
            let MethodKind::BagOfGraphs(params) = &variant.kind else { panic!("{variant:?}") };
            params.validate().unwrap();
            assert!(variants[..index].iter().all(|it| it.kind != variant.kind && it.name != variant.name));
        }
    }
}
