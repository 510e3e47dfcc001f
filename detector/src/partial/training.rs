//! Training of a bag of graphs on clouds of known classes.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::bag::Vocabulary;
use super::class_weights::{TrainingBag, learn_class_weights};
use super::decision::{Center, Centers, Decision, DecisionRule, evidence_bin, strangeness};
use super::keypoint_description::{DescribedCloud, KeypointDescriber};
use super::labels::Labeler;
use super::partial_model::PartialModel;
use super::partial_params::PartialParams;
use super::patch_descriptor::Descriptor;
use super::patterns::{LabeledKeypoint, Pattern, Patterns};
use super::sharpness::{HeldOutScores, learn_sharpness};
use crate::describe::trained_file::Provenance;

/// A cloud to learn from.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingCloud {
    /// Its class.
    pub class_idx: usize,
    /// Its object: clouds of one object are held out together.
    pub object_idx: usize,
    /// The seen part of the object; clouds of the same part of objects of a class have a mean bag of their own.
    pub part: usize,
    /// The way in which the object was looked at: within a class, all ways weigh the same.
    pub way_idx: usize,
    /// Its keypoints and extents.
    pub described: DescribedCloud,
}

impl TrainingCloud {
    /// The cloud of these points, in metres, in a frame with z up and the ground at z = 0.
    pub fn described(
        positions_m: impl Iterator<Item = [f32; 3]>,
        class_idx: usize,
        object_idx: usize,
        part: usize,
        params: &PartialParams,
    ) -> Self {
        let described = KeypointDescriber::default().describe(positions_m, params).clone();
        Self { class_idx, object_idx, part, way_idx: 0, described }
    }
}

/// Why nothing was learned.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TrainingError {
    /// Fewer than two classes.
    #[error("there are {n_classes} classes; at least 2 are needed")]
    Classes {
        /// Number of classes.
        n_classes: usize,
    },
    /// A class that has nothing to learn from.
    #[error("no cloud of class {class:?} has a keypoint")]
    NoCloud {
        /// Its name.
        class: String,
    },
    /// A cloud of no class.
    #[error("cloud {cloud_idx} is of class {class_idx}, but there are {n_classes}")]
    UnknownClass {
        /// Index of the cloud.
        cloud_idx: usize,
        /// Its class.
        class_idx: usize,
        /// Number of classes.
        n_classes: usize,
    },
}

/// Learns to predict `classes` from `clouds`, which were described with the same parameters. Clouds without keypoints are
/// left out.
///
/// Clouds of objects held out in turn show how sure decisions are; labels and patterns are learned from all. The same clouds
/// in the same order give the same model to the bit, on every machine and with any number of threads.
///
/// # Errors
///
/// [`TrainingError`] if a class has no clouds.
///
/// Paper: BG section 3.
pub fn train(
    classes: &[String],
    clouds: &[TrainingCloud],
    params: &PartialParams,
    made: Provenance,
) -> Result<PartialModel, TrainingError> {
    check(classes, clouds)?;
    let clouds: Vec<&TrainingCloud> = clouds.iter().filter(|it| !it.described.keypoints.is_empty()).collect();
    let descriptors: Vec<Descriptor> =
        clouds.iter().flat_map(|it| &it.described.keypoints).map(|it| it.descriptor).collect();
    let labeler = Labeler::learned(&descriptors, &params.labels);
    let patterns_of_clouds = patterns_of(&clouds, &labeler, params);
    let vocabulary = Vocabulary::learned(&of_objects(&clouds, &patterns_of_clouds), &params.bag);
    let mut learner = Learner {
        clouds: &clouds,
        bags: Vec::new(),
        n_classes: classes.len(),
        rejected_idx: classes.iter().position(|it| *it == params.decision.rejected_class),
        n_columns: vocabulary.patterns().len(),
        params,
    };
    let mut bag = Vec::new();
    for patterns in &patterns_of_clouds {
        vocabulary.fill_bag(patterns, &params.bag, &mut bag);
        let is_there = |&(_, value): &(u32, f32)| value != 0.0;
        learner.bags.push((0..).zip(bag.iter().copied()).filter(is_there).collect());
    }
    let decision = learner.decision();
    let (params, classes) = (params.clone(), classes.to_vec());
    Ok(PartialModel { made, params, classes, labeler, vocabulary, decision })
}

fn check(classes: &[String], clouds: &[TrainingCloud]) -> Result<(), TrainingError> {
    let n_classes = classes.len();
    if n_classes < 2 {
        return Err(TrainingError::Classes { n_classes });
    }
    if let Some(cloud_idx) = clouds.iter().position(|it| it.class_idx >= n_classes) {
        let class_idx = clouds[cloud_idx].class_idx;
        return Err(TrainingError::UnknownClass { cloud_idx, class_idx, n_classes });
    }
    let has_cloud =
        |class_idx| clouds.iter().any(|it| it.class_idx == class_idx && !it.described.keypoints.is_empty());
    match (0..n_classes).find(|&it| !has_cloud(it)) {
        Some(class_idx) => Err(TrainingError::NoCloud { class: classes[class_idx].clone() }),
        None => Ok(()),
    }
}

/// The patterns of every cloud.
fn patterns_of(clouds: &[&TrainingCloud], labeler: &Labeler, params: &PartialParams) -> Vec<Vec<Pattern>> {
    let of_cloud = |patterns: &mut Patterns, cloud: &&TrainingCloud| {
        let labeled = cloud
            .described
            .keypoints
            .iter()
            .map(|it| LabeledKeypoint { position_m: it.position_m, label: labeler.label_of(&it.descriptor) });
        let DescribedCloud { extents, shape, .. } = &cloud.described;
        patterns.fill(&labeled.collect::<Vec<_>>(), extents, shape, &params.patterns);
        patterns.patterns().to_vec()
    };
    clouds.par_iter().map_init(Patterns::default, of_cloud).collect()
}

/// The patterns of all clouds of each object.
fn of_objects(clouds: &[&TrainingCloud], patterns_of_clouds: &[Vec<Pattern>]) -> Vec<Vec<Pattern>> {
    let mut order: Vec<usize> = (0..clouds.len()).collect();
    order.sort_by_key(|&it| clouds[it].object_idx);
    let of_same = order.chunk_by(|&a, &b| clouds[a].object_idx == clouds[b].object_idx);
    of_same.map(|object| object.iter().flat_map(|&it| patterns_of_clouds[it].clone()).collect()).collect()
}

/// Clouds with their bags.
struct Learner<'a> {
    clouds: &'a [&'a TrainingCloud],
    bags: Vec<Vec<(u32, f32)>>,
    n_classes: usize,
    rejected_idx: Option<usize>,
    n_columns: usize,
    params: &'a PartialParams,
}

impl Learner<'_> {
    fn decision(&self) -> Decision {
        let all: Vec<usize> = (0..self.clouds.len()).collect();
        let mut decision = self.learned_from(&all);
        let params = &self.params.decision;
        let mut by_evidence = vec![(Vec::new(), Vec::new()); params.evidence_edges.len() + 1];
        for HeldOutCloud { cloud_idx, strangeness, scores } in self.held_out() {
            let bin = evidence_bin(self.clouds[cloud_idx].described.keypoints.len(), &params.evidence_edges);
            if Some(scores.class_idx) != self.rejected_idx {
                by_evidence[bin].0.push(strangeness);
            }
            by_evidence[bin].1.push(scores);
        }
        for (strangeness, scores) in &mut by_evidence {
            decision.sharpness.push(learn_sharpness(scores));
            decision.strangest.push(nearest_share(strangeness, params.near_share));
        }
        decision
    }

    /// The decision learned from some clouds, without its sharpness and limits of strangeness.
    fn learned_from(&self, cloud_indices: &[usize]) -> Decision {
        let weights = match self.params.decision.rule {
            DecisionRule::Nearest => Vec::new(),
            DecisionRule::Weighted => {
                let bags = self.training_bags(cloud_indices);
                learn_class_weights(&bags, self.n_classes, self.n_columns, &self.params.decision.weights)
            }
        };
        Decision {
            centers: self.centers(cloud_indices),
            weights,
            sharpness: Vec::new(),
            strangest: Vec::new(),
        }
    }

    fn centers(&self, cloud_indices: &[usize]) -> Vec<Center> {
        let key = |it: usize| match self.params.decision.centers {
            Centers::OfClass => (self.clouds[it].class_idx, 0),
            Centers::OfParts => (self.clouds[it].class_idx, self.clouds[it].part),
        };
        let mut order = cloud_indices.to_vec();
        order.sort_by_key(|&it| (key(it), it));
        let mean = |group: &[usize]| {
            let mut sums = vec![0.0_f64; self.n_columns];
            for &(column, value) in group.iter().flat_map(|&it| &self.bags[it]) {
                sums[column as usize] += f64::from(value);
            }
            let bag = sums.iter().map(|it| (it / group.len() as f64) as f32).collect();
            Center { class_idx: self.clouds[group[0]].class_idx, bag }
        };
        order.chunk_by(|&a, &b| key(a) == key(b)).map(mean).collect()
    }

    /// All classes weigh the same, and within a class all ways of looking.
    fn training_bags(&self, cloud_indices: &[usize]) -> Vec<TrainingBag> {
        let kind = |it: usize| (self.clouds[it].class_idx, self.clouds[it].way_idx);
        let mut n_of_kind = BTreeMap::new();
        for &it in cloud_indices {
            *n_of_kind.entry(kind(it)).or_insert(0.0) += 1.0;
        }
        let mut n_ways = vec![0.0; self.n_classes];
        for &(class_idx, _) in n_of_kind.keys() {
            n_ways[class_idx] += 1.0;
        }
        let bag = |&it: &usize| {
            let class_idx = self.clouds[it].class_idx;
            let weight = 1.0 / (self.n_classes as f64 * n_ways[class_idx] * n_of_kind[&kind(it)]);
            TrainingBag { class_idx, weight, entries: self.bags[it].clone() }
        };
        cloud_indices.iter().map(bag).collect()
    }

    /// Clouds with their scores by decisions that were learned from other objects.
    fn held_out(&self) -> Vec<HeldOutCloud> {
        let n_folds = self.params.decision.n_folds;
        let mut found = Vec::new();
        let mut bag = vec![0.0; self.n_columns];
        let (mut distances, mut scores) = (vec![0.0; self.n_classes], vec![0.0; self.n_classes]);
        for fold in 0..n_folds {
            let (held_out, others): (Vec<usize>, Vec<usize>) =
                (0..self.clouds.len()).partition(|&it| self.clouds[it].object_idx % n_folds == fold);
            let is_learned = |class_idx| others.iter().any(|&it| self.clouds[it].class_idx == class_idx);
            if held_out.is_empty() || !(0..self.n_classes).all(is_learned) {
                continue;
            }
            let decision = self.learned_from(&others);
            for cloud_idx in held_out {
                bag.fill(0.0);
                for &(column, value) in &self.bags[cloud_idx] {
                    bag[column as usize] = value;
                }
                decision.scores(&bag, &mut distances, &mut scores);
                let class_idx = self.clouds[cloud_idx].class_idx;
                found.push(HeldOutCloud {
                    cloud_idx,
                    strangeness: strangeness(&distances, &scores, self.rejected_idx),
                    scores: HeldOutScores { scores: scores.clone(), class_idx },
                });
            }
        }
        found
    }
}

/// A cloud with its scores by a decision that was learned from other objects.
struct HeldOutCloud {
    cloud_idx: usize,
    strangeness: f32,
    scores: HeldOutScores,
}

/// The number that `share` of all do not exceed; infinite if `share` is 1, and without numbers.
fn nearest_share(numbers: &mut [f32], share: f64) -> f32 {
    numbers.sort_by(f32::total_cmp);
    let n_near = (share * numbers.len() as f64).ceil() as usize;
    if share >= 1.0 || numbers.is_empty() { f32::INFINITY } else { numbers[n_near.saturating_sub(1)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial::decision::WeightParams;
    use crate::partial::keypoint_description::DescribedKeypoint;
    use crate::partial::patch_descriptor::N_DESCRIPTOR_VALUES;

    /// A cloud of one keypoint with this value.
    fn cloud(class_idx: usize, object_idx: usize, value: f64) -> TrainingCloud {
        let mut descriptor = [0.0; N_DESCRIPTOR_VALUES];
        descriptor[8] = value;
        let keypoints = vec![DescribedKeypoint { position_m: [0.0; 3], descriptor }];
        let described = DescribedCloud { keypoints, ..DescribedCloud::default() };
        TrainingCloud { class_idx, object_idx, part: 0, way_idx: 0, described }
    }

    fn params() -> PartialParams {
        let mut params = PartialParams::of_paper();
        params.labels.n_labels = 2;
        params
    }

    fn names() -> Vec<String> {
        ["low", "high"].map(str::to_owned).to_vec()
    }

    #[test]
    fn the_mean_bags_are_those_of_the_classes() {
        let clouds: Vec<TrainingCloud> =
            (0..4).flat_map(|it| [cloud(0, it, 0.0), cloud(1, it, 1.0)]).collect();
        let model = train(&names(), &clouds, &params(), Provenance::default()).unwrap();
        assert_eq!((model.vocabulary.patterns().len(), model.decision.centers.len()), (2, 2));
        let [low, high] = [0, 1].map(|it| &model.decision.centers[it].bag);
        assert_eq!(low.iter().zip(high).map(|(a, b)| (a - b).abs()).sum::<f32>(), 2.0);
        assert_eq!(model, train(&names(), &clouds, &params(), Provenance::default()).unwrap());
    }

    #[test]
    fn ways_of_looking_weigh_the_same_however_many_parts_they_show() {
        let mut params = params();
        params.decision.rule = DecisionRule::Weighted;
        params.decision.weights = WeightParams { penalty: 1e-3, n_steps: 100, step_size: 0.1 };
        let of_way = |way_idx: usize, it: TrainingCloud| TrainingCloud { way_idx, ..it };
        // The value 1 is `high` in many clouds of one way, and `low` in few of another.
        let clouds = |n_of_first: usize| -> Vec<TrainingCloud> {
            let first = (0..n_of_first).flat_map(|it| [cloud(0, it, 0.0), cloud(1, it, 1.0)]);
            let second = (0..4).flat_map(|it| [cloud(0, it, 1.0), cloud(1, it, 0.0)]);
            first.map(|it| of_way(0, it)).chain(second.map(|it| of_way(1, it))).collect()
        };
        let weight = |clouds: &[TrainingCloud]| {
            train(&names(), clouds, &params, Provenance::default()).unwrap().decision.weights[1].of_columns[1]
                .abs()
        };
        assert!(weight(&clouds(40)) < 0.02, "{}", weight(&clouds(40)));
        let mut of_one_way = clouds(40);
        for it in &mut of_one_way {
            it.way_idx = 0;
        }
        assert!(weight(&of_one_way) > 0.1, "{}", weight(&of_one_way));
    }

    #[test]
    fn nothing_is_learned_of_classes_without_clouds() {
        let error = |names: &[String], clouds: &[TrainingCloud]| {
            train(names, clouds, &params(), Provenance::default()).unwrap_err()
        };
        assert_eq!(error(&names()[..1], &[]), TrainingError::Classes { n_classes: 1 });
        assert_eq!(error(&names(), &[cloud(0, 0, 0.0)]), TrainingError::NoCloud { class: "high".to_owned() });
        let empty = TrainingCloud { described: DescribedCloud::default(), ..cloud(1, 1, 0.0) };
        assert_eq!(
            error(&names(), &[cloud(0, 0, 0.0), empty]),
            TrainingError::NoCloud { class: "high".to_owned() }
        );
        let unknown = TrainingError::UnknownClass { cloud_idx: 0, class_idx: 7, n_classes: 2 };
        assert_eq!(error(&names(), &[cloud(7, 0, 0.0)]), unknown);
    }

    #[test]
    fn the_share_of_near_clouds_bounds_what_is_far() {
        assert_eq!(nearest_share(&mut [3.0, 1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(nearest_share(&mut [3.0, 1.0], 1.0), f32::INFINITY);
        assert_eq!(nearest_share(&mut [], 0.5), f32::INFINITY);
    }
}
