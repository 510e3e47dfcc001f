//! All scores of labels, made of the labels of a scan and the results of a detector.

use std::borrow::Cow;

use detector::{Detections, PointCloud};
use reports::rows::label_score_row::LabelScore;
use reports::vocabulary::ground_definition::GroundDefinition;
use reports::vocabulary::protocol::{Protocol, ProtocolFamily};
use reports::vocabulary::thing_class::ThingClass;

use super::ground_points::ground_counts;
use super::instance_scores::instance_scores;
use super::label_numbers::{class_number, instance_number, is_ground, is_surface};
use super::same_label_clusters::same_label_clusters;
use super::segmentation_entropies::segmentation_entropies;
use super::thing_counts::thing_counts;
use crate::matching::detection_order::detection_ranks;

/// Whether a protocol scores labels of points.
pub fn scores_labels(protocol: Protocol) -> bool {
    matches!(protocol.family(), ProtocolFamily::Instances | ProtocolFamily::Ground)
}

/// A scan with the labels of its points.
pub struct LabeledPoints<'a> {
    cloud: &'a PointCloud,
    labels: Vec<u32>,
    // The object of every point; empty if no protocol needs it.
    objects: Vec<u32>,
}

/// Results of a detector for the points of a scan.
pub struct FoundPoints<'a> {
    /// Its detections.
    pub detections: &'a Detections,
    /// Label of every point, if it predicts labels: they are then its segments and classes.
    pub labels: Option<&'a [u32]>,
    /// Whether each point is ground, if it predicts ground directly.
    pub ground: Option<Vec<bool>>,
}

impl FoundPoints<'_> {
    /// Whether each point is predicted to be ground, directly or by its label; `None` if neither is predicted.
    pub fn predicted_ground(&self) -> Option<Cow<'_, [bool]>> {
        let of_labels = |it: &[u32]| it.iter().map(|label| is_surface(class_number(*label))).collect();
        self.ground.as_deref().map(Cow::Borrowed).or_else(|| self.labels.map(of_labels).map(Cow::Owned))
    }
}

impl<'a> LabeledPoints<'a> {
    /// `cloud` and the label of each of its points, for scores under `protocols`.
    pub fn new(cloud: &'a PointCloud, labels: Vec<u32>, protocols: &[Protocol]) -> Self {
        let is_asked = protocols.contains(&Protocol::SemanticKitti);
        let objects = if is_asked { same_label_clusters(cloud, &labels) } else { Vec::new() };
        Self { cloud, labels, objects }
    }

    /// Scores of `found` under `protocol`; empty if the protocol does not score labels, or scores ground and none is
    /// predicted.
    pub fn scores(&self, protocol: Protocol, found: &FoundPoints<'_>) -> Vec<LabelScore> {
        match protocol.family() {
            ProtocolFamily::Instances => self.of_segments(found),
            ProtocolFamily::Ground => {
                found.predicted_ground().map_or_else(Vec::new, |predicted| self.of_ground(&predicted))
            }
            ProtocolFamily::KittiObjects | ProtocolFamily::RankedBoxes => Vec::new(),
        }
    }

    /// Scores of the labels themselves under `protocol`, fed back as predictions: the best possible ones.
    pub fn echoed_scores(&self, protocol: Protocol) -> Vec<LabelScore> {
        match protocol.family() {
            ProtocolFamily::Instances => {
                let segments = segments_of(&self.labels);
                let things = ThingClass::ALL.into_iter().zip(thing_counts(&self.labels, &self.labels));
                let entropies = segmentation_entropies(&self.objects, &self.objects);
                let instances =
                    instance_scores(&self.labels, &segments).into_iter().map(LabelScore::Instance);
                instances
                    .chain(things.map(|(class, counts)| LabelScore::Things(class, counts)))
                    .chain([LabelScore::Entropies(entropies)])
                    .collect()
            }
            ProtocolFamily::Ground => {
                let points = || self.labels.iter().zip(self.cloud.z_m());
                let of = |definition| {
                    let is_ground = |(label, z_m): (&u32, &f32)| {
                        is_ground(definition, class_number(*label), *z_m) == Some(true)
                    };
                    let predicted: Vec<bool> = points().map(is_ground).collect();
                    let counts = ground_counts(definition, &self.labels, self.cloud.z_m(), &predicted);
                    LabelScore::Ground(definition, counts)
                };
                GroundDefinition::ALL.map(of).to_vec()
            }
            ProtocolFamily::KittiObjects | ProtocolFamily::RankedBoxes => Vec::new(),
        }
    }

    fn of_segments(&self, found: &FoundPoints<'_>) -> Vec<LabelScore> {
        let segments: Vec<u32> = match found.labels {
            Some(labels) => segments_of(labels),
            None => found_segments(found.detections, self.cloud.len()),
        };
        let instances = instance_scores(&self.labels, &segments).into_iter().map(LabelScore::Instance);
        let things = found.labels.map(|labels| thing_counts(&self.labels, labels));
        let things = things.into_iter().flat_map(|it| ThingClass::ALL.into_iter().zip(it));
        let entropies = segmentation_entropies(&self.objects, &segments);
        instances
            .chain(things.map(|(class, counts)| LabelScore::Things(class, counts)))
            .chain([LabelScore::Entropies(entropies)])
            .collect()
    }

    fn of_ground(&self, predicted: &[bool]) -> Vec<LabelScore> {
        let of = |definition| {
            let counts = ground_counts(definition, &self.labels, self.cloud.z_m(), predicted);
            LabelScore::Ground(definition, counts)
        };
        GroundDefinition::ALL.map(of).to_vec()
    }
}

/// The instance of every point, 0 for none.
fn segments_of(labels: &[u32]) -> Vec<u32> {
    labels.iter().map(|label| if instance_number(*label) == 0 { 0 } else { *label }).collect()
}

/// For every point of a scan of `n_points` the number of its detection, from 1; 0 for none.
///
/// Of several detections the first by [`detection_ranks`] counts, so that their order in a report changes nothing.
fn found_segments(detections: &Detections, n_points: usize) -> Vec<u32> {
    let ranks = detection_ranks(detections);
    let mut segments = vec![0; n_points];
    for (detection_idx, detection) in detections.iter().enumerate() {
        for &point_idx in detection.point_indices {
            let segment: &mut u32 = &mut segments[point_idx as usize];
            if *segment == 0 || ranks[detection_idx] < ranks[*segment as usize - 1] {
                *segment = detection_idx as u32 + 1;
            }
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use detector::{DetectedClass, Detection, OrientedBox};
    use reports::rows::label_score_row::InstanceScore;

    use super::*;

    const CAR: u32 = 10 + (3 << 16);

    fn scores(protocol: Protocol, found: &FoundPoints<'_>) -> Vec<LabelScore> {
        let cloud: PointCloud = (0..4).map(|it| [it as f32 * 0.1, 0.0, -1.0]).collect();
        LabeledPoints::new(&cloud, vec![CAR, CAR, 40, 0], &[protocol]).scores(protocol, found)
    }

    #[test]
    fn labels_are_segments_with_classes_and_detections_are_segments() {
        let nothing = Detections::default();
        let of_labels =
            FoundPoints { detections: &nothing, labels: Some(&[CAR, CAR, 40, CAR]), ground: None };
        let found = scores(Protocol::SemanticKitti, &of_labels);
        let car = InstanceScore { label: CAR, n_points: 2, association: 1.0, matched_iou: Some(1.0) };
        assert_eq!(found[0], LabelScore::Instance(car));
        assert_eq!(found.len(), 1 + ThingClass::ALL.len() + 1);
        let of_nothing = FoundPoints { detections: &nothing, labels: None, ground: None };
        let found = scores(Protocol::SemanticKitti, &of_nothing);
        let missed = InstanceScore { association: 0.0, matched_iou: None, ..car };
        assert_eq!((found[0], found.len()), (LabelScore::Instance(missed), 2));
    }

    #[test]
    fn ground_is_scored_where_it_is_predicted() {
        let nothing = Detections::default();
        let predicted = |ground| FoundPoints { detections: &nothing, labels: None, ground };
        assert_eq!(scores(Protocol::Ground, &predicted(None)), []);
        let found = scores(Protocol::Ground, &predicted(Some(vec![false, true, true, true])));
        assert_eq!(found.len(), 3);
        let LabelScore::Ground(definition, counts) = found[0] else { panic!("{found:?}") };
        assert_eq!(definition, GroundDefinition::Patchwork);
        assert_eq!((counts.n_found, counts.n_false, counts.n_missed, counts.n_others), (1, 1, 0, 1));
        let of_labels = FoundPoints { labels: Some(&[0, 40, 40, 40]), ..predicted(None) };
        assert_eq!(scores(Protocol::Ground, &of_labels), found);
    }

    #[test]
    fn a_point_of_several_detections_belongs_to_the_surest() {
        let bounding_box = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let detection = |point_indices, score| {
            Detection::new(point_indices, bounding_box, DetectedClass::Object, Some(score))
        };
        let (sure, unsure) = (detection(&[1, 2], 0.9), detection(&[0, 1], 0.1));
        let of = |all: [Detection<'_>; 2]| found_segments(&all.into_iter().collect(), 4);
        assert_eq!(of([sure, unsure]), [2, 1, 1, 0]);
        assert_eq!(of([unsure, sure]), [1, 2, 2, 0]);
    }
}
