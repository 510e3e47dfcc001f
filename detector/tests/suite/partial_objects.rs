//! The bag of graphs on drawn objects: what it decides, what does not matter to it, and what it makes of bad input.

use std::sync::Arc;

use detector::partial::decision::Verdict;
use detector::partial::keypoint_description::KeypointDescriber;
use detector::partial::partial_classifier::PartialClassifier;
use detector::partial::partial_model::PartialModel;
use detector::partial::partial_params::PartialParams;

use crate::drawn_objects::{CLASSES, drawn_model, drawn_object};
use crate::partial_reference::{check_same, descriptors};

fn classifier(params: &PartialParams) -> PartialClassifier {
    PartialClassifier::new(Arc::new(drawn_model(params)))
}

/// Few enough points for the reference, and no two spheres of one size.
fn small(mut params: PartialParams) -> PartialParams {
    params.descriptor.max_points = 16;
    params
}

#[test]
fn new_objects_are_classified_with_either_parameters() {
    // Mean bags of graphs alone know neither sizes nor what parts classes best.
    for (params, least) in [(PartialParams::shipped(), 27), (PartialParams::of_paper(), 18)] {
        let mut classifier = classifier(&params);
        let mut n_right = 0;
        for seed in 100..110 {
            for (class_idx, name) in CLASSES.iter().enumerate() {
                let judgement = classifier.classify(drawn_object(class_idx, 300, seed).into_iter()).clone();
                n_right += u32::from(judgement.verdict == Verdict::Class(class_idx));
                assert_eq!(
                    judgement.verdict == Verdict::Class(class_idx),
                    classifier.class_name() == Some(name)
                );
                assert!((judgement.probabilities.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            }
        }
        assert!(n_right >= least, "{n_right} of 30");
    }
}

#[test]
fn the_same_is_found_point_by_point() {
    for params in [small(PartialParams::shipped()), small(PartialParams::of_paper())] {
        let mut classifier = classifier(&params);
        let mut n_keypoints = 0;
        for seed in 200..204 {
            for (class_idx, name) in CLASSES.iter().enumerate() {
                let positions_m = drawn_object(class_idx, 120, seed);
                n_keypoints += check_same(&mut classifier, &positions_m, name);
                let mut describer = KeypointDescriber::default();
                let found = describer.describe(positions_m.iter().copied(), &params);
                for (found, expected) in found.keypoints.iter().zip(descriptors(&positions_m, &params)) {
                    for (value, expected) in found.descriptor.iter().zip(expected) {
                        assert!((value - expected).abs() < 1e-6, "{:?}\n{expected:?}", found.descriptor);
                    }
                }
            }
        }
        assert!(n_keypoints > 60, "{n_keypoints}");
    }
}

#[test]
fn the_order_of_points_changes_nothing() {
    let mut classifier = classifier(&PartialParams::shipped());
    for class_idx in 0..CLASSES.len() {
        let mut positions_m = drawn_object(class_idx, 500, 300);
        let judgement = classifier.classify(positions_m.iter().copied()).clone();
        positions_m.reverse();
        positions_m.rotate_left(123);
        assert_eq!(*classifier.classify(positions_m.into_iter()), judgement);
    }
}

#[test]
fn turned_objects_stay_what_they_are() {
    let mut classifier = classifier(&PartialParams::shipped());
    for class_idx in 0..CLASSES.len() {
        let positions_m = drawn_object(class_idx, 500, 400);
        let chance = classifier.classify(positions_m.iter().copied()).probabilities[class_idx];
        for turn in 1..8 {
            let (sine, cosine) = (0.8 * turn as f32).sin_cos();
            let turned =
                positions_m.iter().map(|&[x, y, z]| [cosine * x - sine * y, sine * x + cosine * y, z]);
            let judgement = classifier.classify(turned);
            assert_eq!(judgement.verdict, Verdict::Class(class_idx), "{judgement:?}");
            // Other points fall into one cube, and so other keypoints are found.
            assert!((judgement.probabilities[class_idx] - chance).abs() < 0.3, "{judgement:?} {chance}");
        }
    }
}

#[test]
fn bad_input_has_an_answer() {
    let mut classifier = classifier(&PartialParams::shipped());
    let nothing = classifier.classify(std::iter::empty()).clone();
    assert_eq!(nothing.verdict, Verdict::TooLittleSeen);
    assert_eq!(
        *classifier.classify([[f32::NAN; 3], [0.0, f32::INFINITY, 0.0], [1e30; 3]].into_iter()),
        nothing
    );
    let line = (0..500).map(|it| [0.0, 0.0, it as f32 * 0.01]).collect();
    let sheet = (0..900).map(|it| [(it % 30) as f32 * 0.1, (it / 30) as f32 * 0.1, 1.0]).collect();
    let cases: [Vec<[f32; 3]>; 5] =
        [vec![[1.0; 3]], vec![[1.0; 3]; 1000], line, sheet, vec![[-9_999.0; 3], [9_999.0; 3]]];
    for positions_m in cases {
        let judgement = classifier.classify(positions_m.into_iter());
        assert_ne!(judgement.verdict, Verdict::TooLittleSeen);
        assert!(judgement.distances.iter().chain(&judgement.probabilities).all(|it| it.is_finite()));
    }
}

#[test]
fn a_million_points_are_as_much_work_as_some_thousands() {
    let params = PartialParams::shipped();
    let mut describer = KeypointDescriber::default();
    let n_keypoints =
        describer.describe(drawn_object(0, 1_000_000, 500).into_iter(), &params).keypoints.len();
    assert!(n_keypoints > 3 && n_keypoints <= params.thinning.max_points, "{n_keypoints}");
}

#[test]
fn nothing_is_allocated_once_the_first_clouds_have_sized_the_buffers() {
    for params in [PartialParams::shipped(), PartialParams::of_paper()] {
        let mut classifier = classifier(&params);
        let objects: Vec<Vec<[f32; 3]>> = (0..CLASSES.len()).map(|it| drawn_object(it, 800, 600)).collect();
        let sizing = allocation_counter::measure(|| {
            for positions_m in &objects {
                classifier.classify(positions_m.iter().copied());
            }
        });
        assert!(sizing.count_total > 0, "the counter sees nothing");
        for positions_m in objects.iter().chain([&Vec::new()]) {
            let steady = allocation_counter::measure(|| {
                classifier.classify(positions_m.iter().copied());
            });
            assert_eq!((steady.count_total, steady.bytes_total), (0, 0), "allocations and their bytes");
        }
    }
}

#[test]
fn a_trained_model_comes_back_from_its_file_and_is_read_in_milliseconds() {
    let model = drawn_model(&PartialParams::shipped());
    let bytes = model.to_bytes();
    let started = std::time::Instant::now();
    assert_eq!(PartialModel::from_bytes(&bytes).unwrap(), model);
    assert!(started.elapsed().as_millis() < 500, "{:?} for {} bytes", started.elapsed(), bytes.len());
    assert_eq!(drawn_model(&PartialParams::shipped()).to_bytes(), bytes);
}
