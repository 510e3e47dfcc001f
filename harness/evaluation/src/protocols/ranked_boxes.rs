//! Rows under a protocol that matches boxes class by class, by the distance of their centres.

use std::cmp::Ordering;

use reports::rows::official_rows::OfficialRows;
use reports::rows::ranked_box_row::{BoxKind, BoxState, PairErrors, RankedBox, RankedBoxRow};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::protocol::{ERROR_DISTANCE, PAIR_DISTANCES_M, Protocol};
use reports::vocabulary::taxonomy::{class_named, plain_name};
use scans::dataset::official::OfficialObject;

use super::official_protocol::{FoundInScan, OfficialProtocol};

/// For each of [`PAIR_DISTANCES_M`] the index of the annotation that a detection finds; `None` if it finds none.
pub(super) type Pairs = [Option<usize>; PAIR_DISTANCES_M.len()];

/// Rules that differ between such protocols. Centres are relative to the origin of ranges.
pub(super) trait RankedRules {
    /// The protocol.
    const PROTOCOL: Protocol;

    /// The evaluated class of objects that files call `name`; `None` if they are not evaluated.
    fn class_of(name: &str) -> Option<&'static str>;

    /// Whether `name` is a name of the makers of the protocol: then [`Self::class_of`] decides.
    fn is_own_name(name: &str) -> bool;

    /// State of a label or a detection of `class` in a scan with these labels.
    fn state(class: &'static str, object: &OfficialObject, labels: &[OfficialObject]) -> BoxState;

    /// The most detections of a class that are evaluated in a scan.
    const MOST_DETECTIONS: usize;

    /// Pairs of the detections of one class, which come best first.
    fn pairs(detections: &[&OfficialObject], annotations: &[&OfficialObject]) -> Vec<Pairs>;

    /// Errors of a detection of `class` against the annotation that it finds.
    fn errors(class: &'static str, detection: &OfficialObject, annotation: &OfficialObject) -> PairErrors;
}

impl<Rules: RankedRules + Sync> OfficialProtocol for Rules {
    fn protocol(&self) -> Protocol {
        Rules::PROTOCOL
    }

    fn rows(&self, found: &FoundInScan<'_>) -> OfficialRows {
        OfficialRows { boxes: rows_by::<Rules>(found), ..OfficialRows::default() }
    }
}

/// An object of a class that is evaluated.
struct Candidate {
    class: &'static str,
    state: BoxState,
    object: OfficialObject,
}

/// The rows of a scan: annotations, then detections, each by their numbers.
fn rows_by<Rules: RankedRules>(found: &FoundInScan<'_>) -> Vec<RankedBoxRow> {
    let labels = found.view.labels();
    let annotations = candidates::<Rules>(labels.clone(), &labels);
    let mut detections = candidates::<Rules>(found.objects.to_vec(), &labels);
    for class in Rules::PROTOCOL.ranked_classes() {
        let counted = detections.iter_mut().filter(|it| it.class == *class && it.state == BoxState::Counts);
        counted.skip(Rules::MOST_DETECTIONS).for_each(|it| it.state = BoxState::BeyondNumber);
    }
    let mut kinds: Vec<BoxKind> = detections.iter().map(|it| unmatched(&it.object)).collect();
    for class in Rules::PROTOCOL.ranked_classes() {
        match_class::<Rules>(class, &annotations, &detections, &mut kinds);
    }
    let annotations = annotations.into_iter().map(|it| (it, BoxKind::Annotation)).zip(0..);
    let detections = detections.into_iter().zip(kinds).zip(0..);
    let row = |((candidate, kind), id): ((Candidate, BoxKind), u32)| RankedBoxRow {
        scan: found.name.clone(),
        detector: found.detector.to_owned(),
        protocol: Rules::PROTOCOL,
        ranked_box: ranked_box(candidate, kind, id),
    };
    annotations.chain(detections).map(row).collect()
}

/// Those of `objects` whose class is evaluated, from the best score down. Equal scores are sorted by the other values of the
/// objects, so that their order in a file does not matter.
fn candidates<Rules: RankedRules>(objects: Vec<OfficialObject>, labels: &[OfficialObject]) -> Vec<Candidate> {
    let candidate = |object: OfficialObject| {
        let class = class_evaluated::<Rules>(&object.name)?;
        Some(Candidate { class, state: Rules::state(class, &object, labels), object })
    };
    let mut candidates: Vec<Candidate> = objects.into_iter().filter_map(candidate).collect();
    candidates.sort_by(|a, b| order(&a.object, &b.object));
    candidates
}

/// The evaluated class of objects that files call `name`: by the makers of the protocol, in any spelling or, for a name of
/// another data set, by our class for it.
pub(super) fn class_evaluated<Rules: RankedRules>(name: &str) -> Option<&'static str> {
    let in_any_spelling = || {
        let (plain, classes) = (plain_name(name), Rules::PROTOCOL.ranked_classes());
        classes.iter().copied().find(|it| plain_name(it) == plain)
    };
    let of_others = || Rules::class_of(common_name(name, Rules::PROTOCOL)?);
    Rules::class_of(name)
        .or_else(|| if Rules::is_own_name(name) { None } else { in_any_spelling().or_else(of_others) })
}

/// A name that `protocol` knows for a `name` of another data set: that of our class, if this is specific enough, or the word
/// that the user gave a class of theirs. Our classes put bicycles, motorcycles and scooters together, and cones and barrels.
fn common_name(name: &str, protocol: Protocol) -> Option<&'static str> {
    use AnnotationClass as Class;
    let plain = plain_name(name);
    match class_named(name)? {
        class
        @ (Class::Car | Class::Van | Class::Truck | Class::Bus | Class::Trailer | Class::Pedestrian) => {
            Some(class.name())
        }
        Class::Cyclist | Class::ParkedCycle if plain.contains("motorcycl") => Some("motorcycle"),
        class @ (Class::Cyclist | Class::ParkedCycle)
            if plain.contains("bicycl") && !plain.contains("rack") =>
        {
            Some(class.name())
        }
        Class::StreetFurniture if plain.contains("cone") => Some("traffic_cone"),
        class @ Class::Own(_) => {
            let written = &class.traits().written;
            match protocol {
                Protocol::Argoverse2 => written.argoverse2.as_deref(),
                _ => written.nuscenes.as_deref(),
            }
        }
        _ => None,
    }
}

fn order(a: &OfficialObject, b: &OfficialObject) -> Ordering {
    let numbers = |it: &OfficialObject| {
        let [x, y, z] = it.center_m;
        let [length, width, height] = it.length_width_height_m;
        let [along, across] = it.velocity_m_per_s.unwrap_or_default();
        [-it.score.unwrap_or(0.0), x, y, z, length, width, height, it.yaw_rad, along, across]
    };
    let by_numbers = numbers(a).into_iter().zip(numbers(b)).map(|(a, b)| a.total_cmp(&b));
    let by_numbers = by_numbers.fold(Ordering::Equal, Ordering::then);
    by_numbers.then_with(|| a.name.cmp(&b.name)).then_with(|| a.attribute.cmp(&b.attribute))
}

fn unmatched(object: &OfficialObject) -> BoxKind {
    BoxKind::Detection {
        score: object.score.unwrap_or_default(),
        pairs: [None; PAIR_DISTANCES_M.len()],
        errors: None,
    }
}

/// Matches the annotations and detections of `class` that count, and writes the pairs to the `kinds` of the detections.
fn match_class<Rules: RankedRules>(
    class: &'static str,
    annotations: &[Candidate],
    detections: &[Candidate],
    kinds: &mut [BoxKind],
) {
    let indices = |of: &[Candidate]| -> Vec<usize> {
        let counts = |it: &Candidate| it.class == class && it.state == BoxState::Counts;
        (0..of.len()).filter(|index| counts(&of[*index])).collect()
    };
    let (of_annotations, of_detections) = (indices(annotations), indices(detections));
    let labelled: Vec<&OfficialObject> = of_annotations.iter().map(|it| &annotations[*it].object).collect();
    let found: Vec<&OfficialObject> = of_detections.iter().map(|it| &detections[*it].object).collect();
    let pairs = Rules::pairs(&found, &labelled);
    for ((index, found), pairs) in of_detections.into_iter().zip(&found).zip(pairs) {
        let errors = pairs[ERROR_DISTANCE].map(|it| Rules::errors(class, found, labelled[it]));
        let pairs = pairs.map(|it| it.map(|it| of_annotations[it] as u32));
        kinds[index] = BoxKind::Detection { score: found.score.unwrap_or_default(), pairs, errors };
    }
}

fn ranked_box(candidate: Candidate, kind: BoxKind, id: u32) -> RankedBox {
    let Candidate { class, state, object } = candidate;
    RankedBox {
        id,
        name: object.name,
        class,
        state,
        center_m: object.center_m,
        length_width_height_m: object.length_width_height_m,
        yaw_rad: object.yaw_rad,
        velocity_m_per_s: object.velocity_m_per_s.filter(|it| !it.iter().any(|it| it.is_nan())),
        attribute: object.attribute,
        n_points: object.n_points,
        kind,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::argoverse2::Argoverse2;
    use crate::protocols::nuscenes::Nuscenes;
    use crate::protocols::official_objects::OfficialScanView;
    use detector::{BoxDetails, DetectedClass, Detection, DetectorOutput, OrientedBox, PointCloud};
    use proptest::prelude::*;
    use reports::rows::scan_name::ScanName;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::class_traits::{ClassTraits, WrittenWords};
    use scans::annotation::{Annotation, LabeledScan, ScanId};

    /// Cars of one point at these positions.
    fn scan(positions_m: &[[f32; 2]]) -> LabeledScan {
        let annotation = |[x_m, y_m]: &[f32; 2]| Annotation {
            bounding_box: Some(OrientedBox {
                center_m: [*x_m, *y_m, 0.0],
                length_width_height_m: [4.0, 2.0, 1.5],
                yaw_rad: 0.1,
            }),
            point_indices: vec![0],
            ..Annotation::of(AnnotationClass::Car)
        };
        let id = ScanId { sequence: "drawn".to_owned(), index: 0 };
        LabeledScan::everywhere(id, PointCloud::default(), positions_m.iter().map(annotation).collect())
    }

    fn rows_of<Rules: RankedRules>(scan: &LabeledScan, objects: &[OfficialObject]) -> Vec<RankedBoxRow> {
        let view = OfficialScanView::of_annotations(scan);
        rows_by::<Rules>(&FoundInScan {
            name: ScanName { dataset: "drawn".to_owned(), sequence: "drawn".to_owned(), scan: 0 },
            detector: "mine",
            view: &view,
            output: &DetectorOutput::default(),
            kitti_objects: None,
            objects,
        })
    }

    fn n_found(rows: &[RankedBoxRow]) -> usize {
        let is_found = |it: &&RankedBoxRow| {
            matches!(it.ranked_box.kind, BoxKind::Detection { pairs: [Some(_), ..], errors: Some(_), .. })
        };
        rows.iter().filter(is_found).count()
    }

    #[test]
    fn names_of_other_makers_stand_for_what_our_classes_say() {
        #[track_caller]
        fn check(name: &str, nuscenes: Option<&str>, argoverse2: Option<&str>) {
            let found = (class_evaluated::<Nuscenes>(name), class_evaluated::<Argoverse2>(name));
            assert_eq!(found, (nuscenes, argoverse2), "{name}");
        }
        // Argoverse 2's names.
        check("REGULAR_VEHICLE", Some("car"), Some("REGULAR_VEHICLE"));
        check("BOX_TRUCK", Some("truck"), Some("BOX_TRUCK"));
        check("SCHOOL_BUS", Some("bus"), Some("SCHOOL_BUS"));
        check("MOTORCYCLE", Some("motorcycle"), Some("MOTORCYCLE"));
        check("BICYCLIST", Some("bicycle"), Some("BICYCLIST"));
        check("CONSTRUCTION_CONE", Some("traffic_cone"), Some("CONSTRUCTION_CONE"));
        check("CONSTRUCTION_BARREL", None, Some("CONSTRUCTION_BARREL"));
        check("WHEELED_DEVICE", None, Some("WHEELED_DEVICE"));
        check("SIGN", None, Some("SIGN"));
        // Its makers do not evaluate it.
        check("OFFICIAL_SIGNALER", Some("pedestrian"), None);
        // Those of nuScenes.
        check("vehicle.car", Some("car"), Some("REGULAR_VEHICLE"));
        check("vehicle.bus.bendy", Some("bus"), Some("BUS"));
        check("vehicle.motorcycle", Some("motorcycle"), Some("MOTORCYCLE"));
        check("vehicle.bicycle", Some("bicycle"), Some("BICYCLE"));
        check("human.pedestrian.child", Some("pedestrian"), Some("PEDESTRIAN"));
        check("human.pedestrian.wheelchair", None, None);
        check("static_object.bicycle_rack", None, None);
        check("movable_object.trafficcone", Some("traffic_cone"), Some("CONSTRUCTION_CONE"));
        check("movable_object.barrier", Some("barrier"), None);
        // Nor these.
        check("vehicle.emergency.police", None, Some("REGULAR_VEHICLE"));
        // Other spellings of them.
        check("construction vehicle", Some("construction_vehicle"), None);
        check("traffic-cone", Some("traffic_cone"), Some("CONSTRUCTION_CONE"));
        check("Box Truck", Some("truck"), Some("BOX_TRUCK"));
        check("construction cone", Some("traffic_cone"), Some("CONSTRUCTION_CONE"));
        // A class of a user, whose word for the one is known, and for the other not.
        let written = WrittenWords { nuscenes: Some("truck".to_owned()), ..WrittenWords::default() };
        AnnotationClass::define("tow-tractor", ClassTraits { written, ..ClassTraits::default() }).unwrap();
        check("tow-tractor", Some("truck"), None);
        // Ours.
        check("car", Some("car"), Some("REGULAR_VEHICLE"));
        check("parked-cycle", Some("bicycle"), Some("BICYCLE"));
        check("tram", None, None);
        check("tree", None, None);
    }

    #[test]
    fn a_hundred_of_a_class_are_evaluated_by_argoverse() {
        let scan = scan(&[[5.0, 0.0]]);
        let echoed = OfficialScanView::of_annotations(&scan).echoed();
        let rows = rows_of::<Argoverse2>(&scan, &vec![echoed[0].clone(); 103]);
        let n_of = |state| rows.iter().filter(|it| it.ranked_box.state == state).count();
        assert_eq!((n_of(BoxState::Counts), n_of(BoxState::BeyondNumber), n_found(&rows)), (101, 3, 1));
    }

    #[test]
    fn vehicles_are_ranked_by_their_boxes() {
        let scan = scan(&[[5.0, 0.0]]);
        let bounding_box = scan.annotations[0].bounding_box.unwrap();
        let mut output = DetectorOutput::default();
        for box_score in [Some(-2.0), None] {
            let box_details = BoxDetails { score: box_score, ..BoxDetails::default() };
            let vehicle = Detection::new(&[0], bounding_box, DetectedClass::Vehicle, Some(1.0));
            output.detections.push(Detection { box_details, ..vehicle });
        }
        let found = OfficialScanView::of_annotations(&scan).found(&output, &[]);
        assert_eq!(found.iter().map(|it| it.score).collect::<Vec<_>>(), [Some(-2.0), Some(1.0)]);
    }

    proptest! {
        #[test]
        fn the_order_of_labels_and_detections_changes_nothing(
            positions_m in prop::collection::vec(prop::array::uniform2(-9.0_f32..9.0), 1..12),
            moved_m in prop::collection::vec(-2.0_f64..2.0, 12),
            n_turns in 0..12_usize,
        ) {
            let (mut turned, n) = (positions_m.clone(), positions_m.len());
            turned.rotate_left(n_turns % n);
            let [scan, other] = [scan(&positions_m), scan(&turned)];
            let mut objects = OfficialScanView::of_annotations(&scan).echoed();
            for (object, moved_m) in objects.iter_mut().zip(&moved_m) {
                object.center_m[0] += moved_m;
                object.score = Some((2.0 * moved_m).round());
            }
            let mut reversed = objects.clone();
            reversed.reverse();
            prop_assert_eq!(rows_of::<Nuscenes>(&scan, &objects), rows_of::<Nuscenes>(&other, &reversed));
            prop_assert_eq!(rows_of::<Argoverse2>(&scan, &objects), rows_of::<Argoverse2>(&other, &reversed));
        }

        #[test]
        fn labels_find_themselves(positions_m in prop::collection::vec(prop::array::uniform2(-9.0_f32..9.0), 1..12)) {
            let scan = scan(&positions_m);
            let echoed = OfficialScanView::of_annotations(&scan).echoed();
            prop_assert_eq!(n_found(&rows_of::<Nuscenes>(&scan, &echoed)), positions_m.len());
            prop_assert_eq!(n_found(&rows_of::<Argoverse2>(&scan, &echoed)), positions_m.len());
        }
    }
}
