//! Properties of every scene, drawn at random: few positions, sizes and scores, so that many points are shared and many
//! pairs are tied.

use std::collections::BTreeSet;

use detector::{DetectedClass, Detection, OrientedBox};
use proptest::prelude::*;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledArea, PointRegion};

use super::*;
use crate::matching::drawn_labels::{annotation, labeled, standard};
use crate::metrics::counts::{Counts, FalseDetections};
use crate::metrics::segmentation_quality::segmentation_quality;

use AnnotationClass::{Car, Pedestrian, Pole, Tram, Tree};

const N_POINTS: usize = 48;
const EVERYTHING: AnnotatedClasses = AnnotatedClasses::EveryObject;

/// A drawn detection.
#[derive(Debug, Clone, PartialEq)]
struct Drawn {
    point_indices: Vec<u32>,
    bounding_box: OrientedBox,
    class: DetectedClass,
    score: Option<f32>,
}

fn detections_of(drawn: &[Drawn]) -> Detections {
    let mut all = Detections::default();
    for Drawn { point_indices, bounding_box, class, score } in drawn {
        all.push(Detection::new(point_indices, *bounding_box, *class, *score));
    }
    all
}

fn any_box() -> impl Strategy<Value = OrientedBox> {
    let sizes = prop::sample::select(vec![[2.0, 1.0], [1.0, 1.0], [3.0, 2.0]]);
    let turns = prop::sample::select(vec![0.0, 0.5, std::f32::consts::FRAC_PI_2]);
    (-4..8_i8, -3..3_i8, sizes, prop::sample::select(vec![1.0, 9.0]), turns).prop_map(
        |(x, y, [length_m, width_m], height_m, yaw_rad)| OrientedBox {
            center_m: [f32::from(x), f32::from(y), height_m / 2.0],
            length_width_height_m: [length_m, width_m, height_m],
            yaw_rad,
        },
    )
}

/// None, a run of points, or some more.
fn any_points() -> impl Strategy<Value = Vec<u32>> {
    let run = (0..N_POINTS as u32, 1..14_u32)
        .prop_map(|(first, n)| (first..(first + n).min(N_POINTS as u32)).collect::<BTreeSet<u32>>());
    let scattered = prop::collection::btree_set(0..N_POINTS as u32, 0..6);
    prop_oneof![2 => run, 1 => scattered].prop_map(|it| it.into_iter().collect())
}

fn any_drawn() -> impl Strategy<Value = Drawn> {
    let class = prop::sample::select(vec![DetectedClass::Vehicle, DetectedClass::Object]);
    let score = prop::sample::select(vec![None, Some(0.25), Some(0.5)]);
    (any_points(), any_box(), class, score).prop_map(|(point_indices, bounding_box, class, score)| Drawn {
        point_indices,
        bounding_box,
        class,
        score,
    })
}

fn any_annotation() -> impl Strategy<Value = Annotation> {
    let class = prop::sample::select(vec![Car, Car, Car, Pedestrian, Tram, Tree, Pole]);
    (class, prop::option::weighted(0.8, any_box()), any_points())
        .prop_map(|(class, bounding_box, point_indices)| annotation(class, bounding_box, point_indices))
}

fn any_scan() -> impl Strategy<Value = LabeledScan> {
    use PointRegion::{Labeled, Outside, Unscorable};
    let regions = vec![Labeled, Labeled, Labeled, Labeled, Unscorable, Outside];
    let area =
        vec![LabeledArea::Everywhere, LabeledArea::AsPoints, LabeledArea::Ahead { to_either_side_deg: 60.0 }];
    (
        prop::collection::vec(any_annotation(), 0..6),
        prop::collection::vec(prop::sample::select(regions), N_POINTS),
        prop::sample::select(area),
    )
        .prop_map(|(annotations, point_regions, labeled_area)| {
            let position = |it: usize| [(it % 12) as f32 - 4.0, (it / 12) as f32 - 2.0, (it % 5) as f32];
            LabeledScan { point_regions, labeled_area, ..labeled((0..N_POINTS).map(position), annotations) }
        })
}

fn any_criterion() -> impl Strategy<Value = Criterion> {
    let loose = [Criterion::Points { min_iou: 0.1 }, Criterion::BevIou { min_iou: 0.1 }];
    prop::sample::select([&Criterion::ALL[..], &loose].concat())
}

/// Two points are enough, and some positions are beyond the range.
fn params(criterion: Criterion) -> MatchingParams {
    let eligibility = EligibilityParams { min_points: 2, max_range_m: 6.0, ..EligibilityParams::STANDARD };
    MatchingParams { criterion, eligibility }
}

fn judged(scan: &LabeledScan, drawn: &[Drawn], task: Task, criterion: Criterion) -> Assignment {
    assign(scan, &detections_of(drawn), task, &EVERYTHING, &params(criterion))
}

fn rates(assignment: &Assignment) -> [Option<f64>; 3] {
    let scored = Counts::of(assignment).scored(FalseDetections::Known);
    [scored.f_rate(), scored.precision(), scored.recall()]
}

/// Identity of a drawn detection: two with equal identities cannot be distinguished.
fn identity(drawn: &Drawn) -> String {
    format!("{drawn:?}")
}

/// All outcomes of a scene, without indices of detections.
fn said_without_indices(drawn: &[Drawn], it: &Assignment) -> (Vec<String>, Vec<String>, Vec<String>) {
    let annotation = |outcome: &AnnotationOutcome| match outcome {
        AnnotationOutcome::Matched { detection_idx, cost } => {
            format!("{cost:?} {}", identity(&drawn[*detection_idx]))
        }
        other => format!("{other:?}"),
    };
    let detection =
        |(drawn, outcome): (&Drawn, &DetectionOutcome)| format!("{} {outcome:?}", identity(drawn));
    let mut detections: Vec<String> = drawn.iter().zip(&it.detections).map(detection).collect();
    detections.sort();
    let tall = it.found_tall.iter();
    let tall =
        tall.map(|it| format!("{} {:?} {}", it.annotation_idx, it.cost, identity(&drawn[it.detection_idx])));
    (it.annotations.iter().map(annotation).collect(), detections, tall.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn the_order_of_detections_changes_nothing(
        scan in any_scan(),
        (drawn, shuffled) in prop::collection::vec(any_drawn(), 0..8)
            .prop_flat_map(|it| (Just(it.clone()), Just(it).prop_shuffle())),
        criterion in any_criterion(),
        task in prop::sample::select(Task::ALL.to_vec()),
    ) {
        let [one, other] = [&drawn, &shuffled].map(|it| judged(&scan, it, task, criterion));
        prop_assert_eq!(Counts::of(&one), Counts::of(&other));
        prop_assert_eq!(said_without_indices(&drawn, &one), said_without_indices(&shuffled, &other));
        let quality = |drawn: &[Drawn], it: &Assignment| segmentation_quality(&scan, &detections_of(drawn), it);
        // To the last bit.
        prop_assert_eq!(quality(&drawn, &one), quality(&shuffled, &other));
    }

    #[test]
    fn more_boxes_of_nothing_never_raise_a_rate(
        scan in any_scan(),
        drawn in prop::collection::vec(any_drawn(), 0..6),
        boxes in prop::collection::vec(any_box(), 1..20),
        criterion in any_criterion(),
        task in prop::sample::select(Task::ALL.to_vec()),
    ) {
        let before = judged(&scan, &drawn, task, criterion);
        let empty = |bounding_box: OrientedBox| Drawn {
            point_indices: Vec::new(),
            bounding_box,
            class: DetectedClass::Vehicle,
            score: Some(0.1),
        };
        let empty: Vec<Drawn> = boxes.into_iter().map(empty).collect();
        let alone = detections_of(&empty);
        let pairs = criterion.admissible_pairs(&scan, &alone, &PointOverlap::count(&scan, &alone));
        let counts = |annotation_idx: usize| {
            matches!(before.annotations[annotation_idx], AnnotationOutcome::Matched { .. } | AnnotationOutcome::Missed(_))
        };
        let mut is_of_nothing = vec![true; empty.len()];
        for pair in pairs.iter().filter(|it| counts(it.annotation_idx)) {
            is_of_nothing[pair.detection_idx] = false;
        }
        let is_by_points = matches!(criterion, Criterion::Points { .. });
        prop_assert!(!is_by_points || is_of_nothing.iter().all(|it| *it));
        let added = empty.into_iter().zip(is_of_nothing).filter(|(_, it)| *it).map(|(it, _)| it);
        let more: Vec<Drawn> = drawn.iter().cloned().chain(added).collect();
        let after = judged(&scan, &more, task, criterion);
        for (before, after) in rates(&before).into_iter().zip(rates(&after)) {
            prop_assert!(before.is_none() || after <= before, "{before:?} became {after:?}");
        }
    }

    #[test]
    fn annotations_fed_back_score_exactly_one(
        scan in any_scan(),
        criterion in any_criterion(),
        task in prop::sample::select(Task::ALL.to_vec()),
    ) {
        // Each point belongs to at most one annotation, and no two annotations have the same position.
        let mut scan = scan;
        let mut is_taken = [false; N_POINTS];
        for annotation in &mut scan.annotations {
            annotation.point_indices.retain(|it| !std::mem::replace(&mut is_taken[*it as usize], true));
        }
        let mut positions = Vec::new();
        let cloud = scan.cloud.clone();
        scan.annotations.retain(|it| {
            let is_new = it.center_m(&cloud).is_some_and(|it| !positions.contains(&[it[0], it[1]]));
            positions.extend(it.center_m(&cloud).map(|it| [it[0], it[1]]));
            is_new
        });
        let seen = scan.annotations.iter().filter(|it| !it.point_indices.is_empty());
        let echo = |it: &Annotation| Drawn {
            point_indices: it.point_indices.clone(),
            bounding_box: it.bounding_box.unwrap_or(OrientedBox {
                center_m: it.center_m(&scan.cloud).expect("it has points"),
                length_width_height_m: [0.0; 3],
                yaw_rad: 0.0,
            }),
            class: DetectedClass::Vehicle,
            score: None,
        };
        // Background is not echoed as a vehicle.
        let asked = seen.filter(|it| task == Task::Objects || !matches!(it.class, Pedestrian | Tree | Pole));
        let echoed: Vec<Drawn> = asked.map(echo).collect();
        let it = judged(&scan, &echoed, task, criterion);
        let counts = Counts::of(&it);
        prop_assert_eq!((counts.n_matched, counts.n_false), (counts.n_annotations, 0));
        for outcome in &it.annotations {
            if let AnnotationOutcome::Matched { cost, .. } = outcome {
                prop_assert_eq!(*cost, 0.0);
            }
        }
    }
}

/// Tiling the plane with empty boxes finds the annotation and is false nearly everywhere.
#[test]
fn tiling_the_plane_is_paid_for() {
    let bounding_box =
        OrientedBox { center_m: [3.0, 1.0, 0.5], length_width_height_m: [2.0, 1.0, 1.0], yaw_rad: 0.0 };
    let positions_m = (0..20).map(|it| [2.5 + 0.05 * it as f32, 1.0, 0.5]);
    let scan = labeled(positions_m, [annotation(Car, Some(bounding_box), 0..20)]);
    let tile = |it: i32| Drawn {
        point_indices: Vec::new(),
        bounding_box: OrientedBox {
            center_m: [(it % 100 - 50) as f32, (it / 100 - 50) as f32, 0.5],
            ..bounding_box
        },
        class: DetectedClass::Vehicle,
        score: Some(0.1),
    };
    let tiles: Vec<Drawn> = (0..10_000).map(tile).collect();
    for criterion in Criterion::ALL {
        let it = assign(&scan, &detections_of(&tiles), Task::Vehicles, &EVERYTHING, &standard(criterion));
        let counts = Counts::of(&it);
        let n_found = u64::from(!matches!(criterion, Criterion::Points { .. }));
        assert_eq!((counts.n_matched, counts.n_false), (n_found, 10_000 - n_found), "{}", criterion.name());
    }
}
