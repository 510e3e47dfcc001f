//! Classification of objects of which only a part has been seen.

use std::sync::Arc;

use super::decision::{Choice, DecidedBy, Judgement, Verdict};
use super::keypoint_description::KeypointDescriber;
use super::partial_model::PartialModel;
use super::patterns::{LabeledKeypoint, N_VERTICES, Patterns};

/// A trained bag of graphs with buffers for one cloud after another: nothing is allocated once the first clouds have sized
/// them.
///
/// ```
/// use detector::describe::trained_file::Provenance;
/// use detector::partial::decision::Verdict;
/// use detector::partial::partial_classifier::PartialClassifier;
/// use detector::partial::partial_params::PartialParams;
/// use detector::partial::training::{TrainingCloud, train};
///
/// // A thin thing and a broad one, each three times, a bit larger every time.
/// let line = |n: u32| (0..40 * n).map(|it| [0.0, 0.0, it as f32 * 0.1]).collect::<Vec<[f32; 3]>>();
/// let sheet = |n: u32| (0..400 * n).map(|it| [(it % 20) as f32 * 0.1, (it / 20) as f32 * 0.1, 1.0]).collect();
/// let of_class = |class_idx: usize, points_m: Vec<[f32; 3]>, object_idx: usize| (class_idx, points_m, object_idx);
/// let objects: Vec<_> = (1..4).flat_map(|n| [of_class(0, line(n), n as usize), of_class(1, sheet(n), n as usize)]).collect();
///
/// let params = PartialParams::of_paper();
/// let clouds: Vec<TrainingCloud> = objects
///     .iter()
///     .map(|(class_idx, points_m, object_idx)| {
///         TrainingCloud::described(points_m.iter().copied(), *class_idx, *object_idx, 0, &params)
///     })
///     .collect();
/// let made = Provenance { command: "an example".into(), data: vec![], seed: 1, split: "none".into() };
/// let classes = ["line".to_owned(), "sheet".to_owned()];
/// let model = train(&classes, &clouds, &params, made)?;
///
/// let mut classifier = PartialClassifier::new(model.into());
/// assert_eq!(classifier.classify(sheet(2).into_iter()).verdict, Verdict::Class(1));
/// # Ok::<(), detector::partial::training::TrainingError>(())
/// ```
#[derive(Debug, Clone)]
pub struct PartialClassifier {
    model: Arc<PartialModel>,
    choice: Choice,
    rejected_idx: Option<usize>,
    describer: KeypointDescriber,
    keypoints: Vec<LabeledKeypoint>,
    patterns: Patterns,
    bag: Vec<f32>,
    judgement: Judgement,
}

impl PartialClassifier {
    /// A classifier that decides by `model`, and may decide for none of its classes.
    pub fn new(model: Arc<PartialModel>) -> Self {
        Self::with_choice(model, Choice::OrNoneOfThese)
    }

    /// A classifier that decides by `model`, with these possible decisions.
    pub fn with_choice(model: Arc<PartialModel>, choice: Choice) -> Self {
        Self {
            choice,
            rejected_idx: model.rejected_idx(),
            judgement: Judgement::of_nothing(model.classes.len()),
            model,
            describer: KeypointDescriber::default(),
            keypoints: Vec::new(),
            patterns: Patterns::default(),
            bag: Vec::new(),
        }
    }

    /// The model that it decides by.
    pub fn model(&self) -> &PartialModel {
        &self.model
    }

    /// Judges the points of an object, in metres, in a frame with z up and the ground at z = 0. Points that are not finite
    /// are treated as absent.
    ///
    /// Paper: BG section 3.
    pub fn classify(&mut self, positions_m: impl Iterator<Item = [f32; 3]>) -> &Judgement {
        let PartialModel { params, labeler, vocabulary, decision, .. } = &*self.model;
        let described = self.describer.describe(positions_m, params);
        self.keypoints.clear();
        self.keypoints.extend(described.keypoints.iter().map(|it| {
            let label = labeler.label_of(&it.descriptor);
            LabeledKeypoint { position_m: it.position_m, label }
        }));
        self.patterns.fill(&self.keypoints, &described.extents, &described.shape, &params.patterns);
        vocabulary.fill_bag(self.patterns.patterns(), &params.bag, &mut self.bag);
        let by = DecidedBy { params: &params.decision, rejected_idx: self.rejected_idx, choice: self.choice };
        decision.judge(&self.bag, self.keypoints.len(), &by, &mut self.judgement);
        &self.judgement
    }

    /// The latest judgement.
    pub fn judgement(&self) -> &Judgement {
        &self.judgement
    }

    /// The name of the class of the latest cloud; `None` if it was not judged, or is of none of the classes.
    pub fn class_name(&self) -> Option<&str> {
        match self.judgement.verdict {
            Verdict::Class(class_idx) => Some(&self.model.classes[class_idx]),
            Verdict::NoneOfThese | Verdict::TooLittleSeen => None,
        }
    }

    /// The keypoints of the last cloud with their labels.
    pub fn keypoints(&self) -> &[LabeledKeypoint] {
        &self.keypoints
    }

    /// The graphs of the last cloud as line strips in metres: out to each neighbour and back to the keypoint.
    pub fn graph_strips_m(&self) -> impl Iterator<Item = Vec<[f32; 3]>> + '_ {
        let position =
            |it: u32| self.keypoints.get(it as usize).map(|it| it.position_m.map(|value| value as f32));
        self.patterns.graphs().iter().map(move |graph: &[u32; N_VERTICES]| {
            let center_m = position(graph[0]);
            let neighbors = graph[1..].iter().filter_map(|&it| position(it));
            center_m.into_iter().chain(neighbors.flat_map(|it| [Some(it), center_m]).flatten()).collect()
        })
    }

    /// The bag of the last cloud: a number for each pattern of the model's vocabulary.
    pub fn bag(&self) -> &[f32] {
        &self.bag
    }
}
