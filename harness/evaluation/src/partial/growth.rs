//! Growing objects for recordings, with the results of a bag of graphs for every part.

use std::sync::Arc;

use detector::PointCloud;
use detector::partial::decision::Choice;
use detector::partial::partial_classifier::PartialClassifier;
use detector::partial::partial_model::PartialModel;
use detector::partial::patterns::LabeledKeypoint;
use reports::rows::partial_row::Answer;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::object_cloud::growing_cloud::{GrowingCloud, Moment};
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::object_clouds::approach::Drive;

use super::methods::{TrainedMethod, UnknownClass};
use super::object_parts::{DRIVE, PartsSeen, parts_of};

/// One object, seen from one end.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Data set.
    pub data: String,
    /// The object.
    pub object: String,
    /// Its class.
    pub class: PartialClass,
    /// From which end it is seen: `below`, `above`, or `drive`.
    pub direction: &'static str,
    /// Moments, as more and more is seen.
    pub moments: Vec<GrowthMoment>,
}

/// The points seen up to one moment, and their predicted class.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowthMoment {
    /// The step from 1 to 10, or the centimetres driven since the first moment.
    pub at: i64,
    /// The points.
    pub cloud: PointCloud,
    /// Keypoints with their labels.
    pub keypoints: Vec<LabeledKeypoint>,
    /// Their graphs as line strips, in metres.
    pub graphs_m: Vec<Vec<[f32; 3]>>,
    /// Frequencies of the patterns that are most frequent at the last moment.
    pub bag: Vec<f32>,
    /// Its predicted class.
    pub answer: Answer,
    /// Position of the scanner, if the object is driven toward.
    pub scanner: Option<ScannerPosition>,
}

/// Position of a planar scanner on its drive along x toward an object at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScannerPosition {
    /// Its position in metres.
    pub position_m: [f32; 3],
    /// Rise of its plane, in metres per metre.
    pub slope: f32,
}

/// Most patterns of a bag that are kept.
const MOST_BARS: usize = 48;

/// Growths of the object `object_idx` of `set`, one for each end that `seen` shows; `drive` is the drive toward it.
///
/// # Errors
///
/// [`DatasetError`] if it cannot be read.
pub fn growths(
    set: &dyn ObjectCloudSet,
    object_idx: usize,
    seen: PartsSeen,
    drive: Option<Drive>,
    model: &GrowthModel,
    choice: Choice,
) -> Result<Vec<Growth>, DatasetError> {
    let growing = set.read(object_idx)?;
    let mut classifier = PartialClassifier::with_choice(Arc::clone(&model.model), choice);
    let mut classified = |at: i64, cloud: PointCloud, scanner: Option<ScannerPosition>| {
        let answer = model.method.of_graphs(&mut classifier, &cloud);
        GrowthMoment {
            at,
            keypoints: classifier.keypoints().to_vec(),
            graphs_m: classifier.graph_strips_m().collect(),
            bag: classifier.bag().to_vec(),
            answer,
            cloud,
            scanner,
        }
    };
    let of_end = |direction, moments| Growth {
        data: set.description().id.clone(),
        object: growing.whole.id.clone(),
        class: growing.whole.class,
        direction,
        moments: with_most_frequent(moments),
    };
    if seen == PartsSeen::Driven {
        let moments = growing.moments.iter().map(|moment| {
            let scanner = drive.and_then(|it| scanner_at(&it, moment));
            classified(driven_cm(&growing, moment), growing.seen_at(moment), scanner)
        });
        let moments = moments.collect();
        return Ok(vec![of_end(DRIVE, moments)]);
    }
    let parts = parts_of(object_idx, &growing, seen);
    let ends = parts.chunk_by(|a, b| a.direction == b.direction).map(|of_same| {
        let moments =
            of_same.iter().map(|it| classified(i64::from(it.step), it.cloud.clone(), None)).collect();
        of_end(of_same[0].direction, moments)
    });
    Ok(ends.collect())
}

/// A bag of graphs that classifies growing objects.
#[derive(Debug, Clone)]
pub struct GrowthModel {
    model: Arc<PartialModel>,
    method: TrainedMethod,
}

impl GrowthModel {
    /// A classifier with `model`.
    ///
    /// # Errors
    ///
    /// [`UnknownClass`] if it knows a class that no object has.
    pub fn new(model: Arc<PartialModel>) -> Result<Self, UnknownClass> {
        Ok(Self { method: TrainedMethod::of_model(Arc::clone(&model))?, model })
    }
}

/// Centimetres driven since the first moment.
fn driven_cm(growing: &GrowingCloud, moment: &Moment) -> i64 {
    let first = growing.moments.first().and_then(|it| it.distance_m);
    first.zip(moment.distance_m).map_or(0, |(first_m, here_m)| (100.0 * (first_m - here_m)).round() as i64)
}

fn scanner_at(drive: &Drive, moment: &Moment) -> Option<ScannerPosition> {
    let distance_m = moment.distance_m?;
    let before_m = (distance_m * distance_m - drive.aside_m * drive.aside_m).max(0.0).sqrt();
    let slope = drive.tilt_deg.to_radians().tan();
    Some(ScannerPosition { position_m: [-before_m, drive.aside_m, drive.height_m], slope })
}

/// Reduces the bags of `moments` to the patterns that are most frequent at the last moment, in their order.
fn with_most_frequent(mut moments: Vec<GrowthMoment>) -> Vec<GrowthMoment> {
    let last = moments.last().map(|it| it.bag.clone()).unwrap_or_default();
    let mut columns: Vec<usize> = (0..last.len()).filter(|&it| last[it] > 0.0).collect();
    columns.sort_by(|&a, &b| last[b].total_cmp(&last[a]).then(a.cmp(&b)));
    columns.truncate(MOST_BARS);
    columns.sort_unstable();
    for moment in &mut moments {
        moment.bag = columns.iter().map(|&it| moment.bag[it]).collect();
    }
    moments
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::object_clouds::simulated_objects::{ObjectPart, open_simulated_objects};

    fn model() -> GrowthModel {
        GrowthModel::new(PartialModel::shipped()).unwrap()
    }

    #[test]
    fn a_growing_object_is_classified_from_both_ends() {
        let set = open_simulated_objects("objects-around", ObjectPart::Development, 1).unwrap();
        let found = growths(&set, 0, PartsSeen::Uncovered, None, &model(), Choice::OfClasses).unwrap();
        assert_eq!(found.iter().map(|it| it.direction).collect::<Vec<_>>(), ["below", "above"]);
        for growth in &found {
            assert_eq!(
                growth.moments.iter().map(|it| it.at).collect::<Vec<_>>(),
                (1..=10).collect::<Vec<_>>()
            );
            let last = growth.moments.last().unwrap();
            assert!(last.bag.len() > 3 && last.bag.iter().all(|it| *it > 0.0), "{:?}", last.bag);
            assert!(!last.graphs_m.is_empty() && last.keypoints.len() == last.graphs_m.len());
        }
    }

    #[test]
    fn the_scanner_comes_nearer_along_its_course() {
        let set = open_simulated_objects("objects-approach", ObjectPart::Development, 1).unwrap();
        let drive = set.drive(2);
        let found = growths(&set, 2, PartsSeen::Driven, drive, &model(), Choice::OrNoneOfThese).unwrap();
        let [growth] = &found[..] else { panic!("one drive") };
        assert!(growth.moments.is_sorted_by_key(|it| it.at) && growth.moments[0].at == 0);
        let positions: Vec<[f32; 3]> =
            growth.moments.iter().map(|it| it.scanner.unwrap().position_m).collect();
        assert!(positions.is_sorted_by(|a, b| a[0] <= b[0]) && positions[0][0] < -1.0, "{positions:?}");
        assert!(
            positions.iter().all(|it| it[1] == drive.unwrap().aside_m && it[2] == drive.unwrap().height_m)
        );
    }
}
