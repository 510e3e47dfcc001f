//! The annotated objects of a data set, each from one scan, or registered over all scans that show it.
//!
//! KITTI, nuScenes and Argoverse 2 have boxes, and so cars, vans and pedestrians; trees and poles only where they are
//! labelled. The point labels of SemanticKITTI have instances of cars and people; connected points are a pole. Trunks and
//! plants have no instances, so there are no trees, fences or hedges. The simulated streets have all classes.

use detector::PointCloud;
use nalgebra::Isometry3;
use reports::vocabulary::partial_class::PartialClass;

use super::ObjectCloud;
use super::cut_out::{CutOutParams, annotated_points, in_its_box, in_the_world};
use super::growing_cloud::{GrowingCloud, Moment};
use super::object_cloud_set::{ObjectCloudSet, ObjectSetDescription};
use crate::annotation::{Annotation, LabeledScan, ScanId, range_m};
use crate::dataset::{Dataset, DatasetError};

/// The points that make an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Registration {
    /// The points of one scan: an object appears once for each scan that shows it.
    EachScan,
    /// The points of all scans of a drive that show it, in the order of the scans.
    OverScans,
}

/// Objects that were cut out of scans, in memory.
#[derive(Debug)]
pub struct CutOutObjects {
    // Invariant: `classes` and `objects` have the same length and order.
    description: ObjectSetDescription,
    classes: Vec<PartialClass>,
    objects: Vec<GrowingCloud>,
}

/// Pieces of one class without a track that are at most this far apart in the world are one object, on the ground plan, in
/// metres.
const SAME_POSITION_M: f32 = 0.8;
/// A track without boxes begins anew once its points are farther than this from where they were first, in metres.
const MOVED_M: f32 = 3.0;

/// Cuts the objects out of the scans `scan_idxs` of `dataset`, in the order in which they appear.
///
/// Points of an annotation with a box are in the frame of the box, which registers them. Without a box they are in the
/// world, which rests, and are registered by the pose of the sensor; if the data set has no poses, they stay in the frame of
/// the sensor, each scan for itself.
pub fn cut_out_objects(
    dataset: &dyn Dataset,
    scan_idxs: &[usize],
    registration: Registration,
    params: &CutOutParams,
) -> Result<CutOutObjects, DatasetError> {
    let mut growing: Vec<Growing> = Vec::new();
    for &scan_idx in scan_idxs {
        let scan = dataset.read_scan(scan_idx)?;
        let pose = dataset.world_from_sensor(scan_idx)?;
        let time_ns = dataset.scan_time_ns(scan_idx);
        let is_annotated = annotated_points(&scan);
        for (annotation, index) in scan.annotations.iter().zip(0..) {
            let piece = Piece::of(&scan, &is_annotated, annotation, pose.as_ref(), params);
            if piece.cloud.is_empty() {
                continue;
            }
            let shown = Shown { id: &scan.id, annotation, index, time_ns };
            let known = growing
                .iter_mut()
                .find(|it| registration == Registration::OverScans && it.is_shown_by(&shown, &piece));
            let distance_m = annotation.center_m(&scan.cloud).map(|it| range_m(it) as f32);
            match known {
                Some(known) => known.add(&shown, &piece, distance_m),
                None => growing.push(Growing::new(&shown, &piece, distance_m)),
            }
        }
    }
    let is_large = |it: &GrowingCloud| it.whole.cloud.len() >= params.least_points;
    let objects: Vec<GrowingCloud> = growing.into_iter().map(Growing::finish).filter(is_large).collect();
    let source = dataset.description();
    let description = ObjectSetDescription {
        id: source.id.clone(),
        root: source.root.clone(),
        simulation: source.simulation.clone(),
    };
    Ok(CutOutObjects { description, classes: objects.iter().map(|it| it.whole.class).collect(), objects })
}

impl ObjectCloudSet for CutOutObjects {
    fn description(&self) -> &ObjectSetDescription {
        &self.description
    }

    fn classes(&self) -> &[PartialClass] {
        &self.classes
    }

    fn read(&self, object_idx: usize) -> Result<GrowingCloud, DatasetError> {
        Ok(self.objects[object_idx].clone())
    }
}

/// The part of an object that one scan shows.
struct Piece {
    cloud: PointCloud,
    ground_m: f32,
    frame: Frame,
}

impl Piece {
    fn of(
        scan: &LabeledScan,
        is_annotated: &[bool],
        annotation: &Annotation,
        world_from_sensor: Option<&Isometry3<f64>>,
        params: &CutOutParams,
    ) -> Self {
        if let Some(cloud) = in_its_box(scan, annotation, params) {
            return Self { cloud, ground_m: 0.0, frame: Frame::Box };
        }
        let (frame, pose) = match world_from_sensor {
            Some(pose) => (Frame::World, *pose),
            None => (Frame::Sensor, Isometry3::identity()),
        };
        let (cloud, ground_m) = in_the_world(scan, is_annotated, annotation, &pose, params);
        Self { cloud, ground_m, frame }
    }
}

/// The frame that the points of several scans share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Frame {
    Box,
    World,
    Sensor,
}

/// An annotation with its scan.
struct Shown<'a> {
    id: &'a ScanId,
    annotation: &'a Annotation,
    index: usize,
    time_ns: Option<u64>,
}

/// An object that grows with each scan.
struct Growing {
    sequence: String,
    track: Option<u32>,
    frame: Frame,
    // The scan that was added last: a scan shows an object once.
    last_scan: ScanId,
    began_ns: Option<u64>,
    // Of the points of the first scan, on the ground plan.
    first_middle_m: [f32; 2],
    grounds_m: Vec<f32>,
    object: GrowingCloud,
}

impl Growing {
    fn new(shown: &Shown<'_>, piece: &Piece, distance_m: Option<f32>) -> Self {
        let Shown { id, annotation, index, .. } = shown;
        let number = annotation.track.map_or_else(|| format!("at-{index}"), |it| it.to_string());
        let whole = ObjectCloud {
            id: format!("{id}/{}-{number}", annotation.class.name()),
            class: PartialClass::of_annotation(annotation.class),
            cloud: piece.cloud.clone(),
        };
        let extents_m = annotation.bounding_box.map(|it| it.length_width_height_m);
        Self {
            sequence: id.sequence.clone(),
            track: annotation.track,
            frame: piece.frame,
            last_scan: (*id).clone(),
            began_ns: shown.time_ns,
            first_middle_m: middle_m(&piece.cloud),
            grounds_m: vec![piece.ground_m],
            object: GrowingCloud::seen_at_once(whole, extents_m, distance_m),
        }
    }

    fn is_shown_by(&self, shown: &Shown<'_>, piece: &Piece) -> bool {
        let class = PartialClass::of_annotation(shown.annotation.class);
        let may_be = self.sequence == shown.id.sequence
            && self.last_scan != *shown.id
            && self.track == shown.annotation.track
            && self.frame == piece.frame
            && self.object.whole.class == class;
        may_be
            && match (self.frame, self.track) {
                (Frame::Box, track) => track.is_some(),
                (Frame::World, Some(_)) => self.is_within(piece, MOVED_M),
                (Frame::World, None) => self.is_within(piece, SAME_POSITION_M),
                (Frame::Sensor, _) => false,
            }
    }

    fn is_within(&self, piece: &Piece, most_m: f32) -> bool {
        let [[x0, y0], [x1, y1]] = [self.first_middle_m, middle_m(&piece.cloud)];
        (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0) <= most_m * most_m
    }

    fn add(&mut self, shown: &Shown<'_>, piece: &Piece, distance_m: Option<f32>) {
        let cloud = &mut self.object.whole.cloud;
        for (position_m, intensity) in piece.cloud.positions_m().zip(piece.cloud.intensity()) {
            cloud.push(position_m, *intensity);
        }
        self.grounds_m.push(piece.ground_m);
        self.last_scan = shown.id.clone();
        let since_ns = self.began_ns.zip(shown.time_ns).map(|(began, now)| now.saturating_sub(began));
        let before_s = self.object.moments.last().map_or(0.0, |it| it.time_s);
        let time_s = since_ns.map_or(before_s, |it| (it as f64 / 1e9).max(before_s));
        self.object.moments.push(Moment { n_points: cloud.len(), time_s, distance_m });
    }

    /// Counts heights from the ground: the median over the scans.
    fn finish(mut self) -> GrowingCloud {
        self.grounds_m.sort_unstable_by(f32::total_cmp);
        let ground_m = self.grounds_m[self.grounds_m.len() / 2];
        if ground_m != 0.0 {
            self.object.whole.cloud.move_points(|[x_m, y_m, z_m]| [x_m, y_m, z_m - ground_m]);
        }
        self.object
    }
}

/// The mean of the points on the ground plan, in metres.
fn middle_m(cloud: &PointCloud) -> [f32; 2] {
    let mean = |values: &[f32]| values.iter().map(|it| f64::from(*it)).sum::<f64>() / values.len() as f64;
    [mean(cloud.x_m()), mean(cloud.y_m())].map(|it| it as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{AnnotatedClasses, DatasetDescription, Listing};
    use detector::OrientedBox;
    use reports::vocabulary::class::AnnotationClass;

    /// A drive along x, 2 m from scan to scan, 1.7 m above level ground: a car with a box that drives ahead of it, and a
    /// pole that stands.
    struct Drive {
        listing: Listing,
        has_poses: bool,
    }

    const CAR_POINTS_M: [[f32; 3]; 3] = [[-1.0, 0.5, 0.05], [-1.0, 0.5, 0.5], [1.0, -0.5, 1.0]];

    impl Dataset for Drive {
        fn listing(&self) -> &Listing {
            &self.listing
        }

        fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
            let driven_m = 2.0 * scan_idx as f32;
            let car_m = [10.0 + driven_m, 3.0];
            let bounding_box = OrientedBox {
                center_m: [car_m[0], car_m[1], -0.95],
                length_width_height_m: [4.0, 2.0, 1.5],
                yaw_rad: 0.0,
            };
            let car = CAR_POINTS_M.map(|[x, y, z]| [car_m[0] + x, car_m[1] + y, z - 1.7]);
            let pole = [0.5, 2.0, 4.0].map(|z_m| [20.0 - driven_m, -3.0, z_m - 1.7]);
            let ground = (0..9).map(|it| [20.0 - driven_m + 0.1 * it as f32, -2.6, -1.7]);
            let cloud: PointCloud = car.into_iter().chain(pole).chain(ground).collect();
            let annotation = |class, bounding_box, point_indices, track| Annotation {
                bounding_box,
                point_indices,
                track,
                ..Annotation::of(class)
            };
            let annotations = vec![
                annotation(AnnotationClass::Van, Some(bounding_box), vec![0, 1, 2], Some(7)),
                annotation(AnnotationClass::Pole, None, vec![3, 4, 5], None),
            ];
            Ok(LabeledScan::everywhere(self.listing.scan_ids[scan_idx].clone(), cloud, annotations))
        }

        fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
            Some(5_000_000_000 + 100_000_000 * scan_idx as u64)
        }

        fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
            Ok(self.has_poses.then(|| Isometry3::translation(2.0 * scan_idx as f64, 0.0, 0.0)))
        }
    }

    fn cut_out(has_poses: bool, registration: Registration, least_points: usize) -> Vec<GrowingCloud> {
        let description = DatasetDescription {
            id: "drive".to_owned(),
            format: "none".to_owned(),
            root: None,
            annotated: AnnotatedClasses::EveryObject,
            sensor_height_m: 1.7,
            sensor: "vlp-16".to_owned(),
            licence: None,
            checksum: None,
            simulation: None,
        };
        let scan_ids = (0..3).map(|index| ScanId { sequence: "00".to_owned(), index }).collect();
        let drive = Drive { listing: Listing { description, scan_ids }, has_poses };
        let params = CutOutParams { least_points, ..CutOutParams::USUAL };
        let objects = cut_out_objects(&drive, &[0, 1, 2], registration, &params).unwrap();
        (0..objects.classes().len()).map(|it| objects.read(it).unwrap()).collect()
    }

    fn ids_and_sizes(objects: &[GrowingCloud]) -> Vec<(&str, usize)> {
        objects.iter().map(|it| (it.whole.id.as_str(), it.whole.cloud.len())).collect()
    }

    #[test]
    fn each_scan_shows_its_objects() {
        let objects = cut_out(false, Registration::EachScan, 1);
        let expected = [
            ("00/000000/van-7", 2),
            ("00/000000/pole-at-1", 3),
            ("00/000001/van-7", 2),
            ("00/000001/pole-at-1", 3),
            ("00/000002/van-7", 2),
            ("00/000002/pole-at-1", 3),
        ];
        assert_eq!(ids_and_sizes(&objects), expected);
        assert_eq!(objects[0].whole.class, PartialClass::Car);
        assert_eq!(ids_and_sizes(&cut_out(false, Registration::EachScan, 3)).len(), 3);
    }

    #[test]
    fn boxes_and_poses_put_scans_together() {
        let objects = cut_out(true, Registration::OverScans, 1);
        assert_eq!(ids_and_sizes(&objects), [("00/000000/van-7", 6), ("00/000000/pole-at-1", 9)]);
        let [car, pole] = &objects[..] else { panic!("{objects:?}") };
        // Points on the bottom of the box are ground; the car has not moved in its own frame.
        for (found, expected) in car.whole.cloud.positions_m().zip(CAR_POINTS_M[1..].iter().cycle()) {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
        }
        for ([x_m, y_m, z_m], expected_z_m) in
            pole.whole.cloud.positions_m().zip([0.5, 2.0, 4.0].iter().cycle())
        {
            assert!((x_m - 20.0).abs() < 1e-4 && (y_m + 3.0).abs() < 1e-4, "{x_m} {y_m}");
            assert!((z_m - expected_z_m).abs() < 1e-4, "{z_m} above the ground");
        }
        let moments: Vec<(usize, f64)> = car.moments.iter().map(|it| (it.n_points, it.time_s)).collect();
        assert_eq!(moments, [(2, 0.0), (4, 0.1), (6, 0.2)]);
        assert_eq!((car.extents_m, pole.extents_m), (Some([4.0, 2.0, 1.5]), None));
        assert_eq!(car.seen_at(&car.moments[1]).len(), 4);
    }

    #[test]
    fn without_poses_only_boxes_put_scans_together() {
        let objects = cut_out(false, Registration::OverScans, 1);
        assert_eq!(ids_and_sizes(&objects)[0], ("00/000000/van-7", 6));
        assert_eq!(objects.len(), 4);
        assert!(objects[1].whole.cloud.z_m().iter().zip([0.5, 2.0, 4.0]).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
