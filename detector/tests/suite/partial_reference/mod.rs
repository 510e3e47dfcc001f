//! The bag of graphs once more: every point compared with every other, in sorted maps.

mod points;
mod surfaces;
mod patches;
mod graphs;

use detector::partial::decision::Judgement;
use detector::partial::partial_classifier::PartialClassifier;
use detector::partial::partial_model::PartialModel;

/// Numbers that go through eigenvectors and least squares differ by as much, at most.
const BOUND: f64 = 1e-6;

/// Checks that `classifier` finds in `positions_m` what the reference finds: the same keypoints, descriptors within the
/// bound, the same labels, graphs and patterns, distances within the bound. Returns how many keypoints there are.
#[track_caller]
pub fn check_same(classifier: &mut PartialClassifier, positions_m: &[[f32; 3]], name: &str) -> usize {
    let Judgement { distances, .. } = classifier.classify(positions_m.iter().copied()).clone();
    let model = classifier.model().clone();
    let found = judged(&model, positions_m);
    assert_eq!(classifier.keypoints().len(), found.keypoints.len(), "keypoints of {name}");
    for (keypoint, expected) in classifier.keypoints().iter().zip(&found.keypoints) {
        assert_eq!(keypoint.position_m, expected.position_m, "{name}");
        assert_eq!(keypoint.label, expected.label, "{name}");
    }
    let strips: Vec<Vec<[f32; 3]>> = classifier.graph_strips_m().collect();
    assert_eq!(strips, found.strips_m, "{name}");
    for (distance, expected) in distances.iter().zip(&found.distances) {
        assert!((f64::from(*distance) - expected).abs() < BOUND * 100.0, "{name}: {distance} {expected}");
    }
    found.keypoints.len()
}

/// What the reference finds.
pub struct Judged {
    keypoints: Vec<graphs::Vertex>,
    strips_m: Vec<Vec<[f32; 3]>>,
    distances: Vec<f64>,
}

fn judged(model: &PartialModel, positions_m: &[[f32; 3]]) -> Judged {
    let params = &model.params;
    let points_m = points::ordered(points::thinned(positions_m, &params.thinning), params.surface.radius_m);
    let surfaces = surfaces::surfaces(&points_m, &params.surface);
    let keypoints = patches::keypoints(&points_m, &surfaces, params);
    let vertices: Vec<graphs::Vertex> = keypoints
        .into_iter()
        .map(|point_idx| graphs::Vertex {
            position_m: points_m[point_idx],
            label: graphs::label(
                &model.labeler,
                &patches::descriptor(&points_m, &surfaces, point_idx, params),
            ),
        })
        .collect();
    let graphs = graphs::graphs(&vertices);
    let bag = graphs::bag(&vertices, &graphs, &points_m, &points::all(positions_m), model);
    Judged {
        strips_m: graphs::strips_m(&vertices, &graphs),
        distances: graphs::distances(&bag, model),
        keypoints: vertices,
    }
}

/// The descriptors of the reference, keypoint by keypoint.
pub fn descriptors(
    positions_m: &[[f32; 3]],
    params: &detector::partial::partial_params::PartialParams,
) -> Vec<[f64; 12]> {
    let points_m = points::ordered(points::thinned(positions_m, &params.thinning), params.surface.radius_m);
    let surfaces = surfaces::surfaces(&points_m, &params.surface);
    let keypoints = patches::keypoints(&points_m, &surfaces, params);
    keypoints.into_iter().map(|it| patches::descriptor(&points_m, &surfaces, it, params)).collect()
}
