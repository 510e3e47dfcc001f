//! A vehicle model that has seen nothing but drawings: enough to test what becomes of its decisions.

use detector::OrientedBox;
use detector::classify::nu_svc_solver::{NuSvcParams, Tolerance};
use detector::classify::paper_model::PaperModel;
use detector::classify::svm_training::train_svm;
use detector::describe::object_describer::ObjectDescriber as _;
use detector::describe::paper_features::{N_PAPER_FEATURES, PaperDescriber};
use detector::describe::prototype_library::{Prototype, PrototypeLibrary};
use detector::describe::trained_file::Provenance;

/// The outline of a hatchback, front forward.
pub const HATCHBACK_M: [[f32; 2]; 7] =
    [[-2.0, 0.22], [2.0, 0.22], [2.0, 0.75], [0.95, 1.0], [0.3, 1.46], [-1.5, 1.43], [-2.0, 1.09]];

/// How far ahead of the sensor the drawings stand, in metres.
const AHEAD_M: f32 = 7.0;

/// Drawn vehicles of all sizes against upright blocks from a pole to a stretch of wall.
pub fn vehicle_model() -> PaperModel {
    let hatchback = Prototype { name: "hatchback".to_owned(), contour_m: HATCHBACK_M.to_vec() };
    let library = PrototypeLibrary::new(Provenance::default(), 0.2, vec![hatchback]).expect("a library");
    let mut describer = PaperDescriber::new(library.clone());
    let (mut vectors, mut is_vehicle) = (Vec::new(), Vec::new());
    for scale in [0.9, 0.95, 1.0, 1.05, 1.1] {
        vectors.push(features_of(
            &mut describer,
            &HATCHBACK_M.map(|it| it.map(|it| scale * it)),
            1.8 * scale,
        ));
        is_vehicle.push(true);
    }
    for length_m in [0.3, 1.0, 2.0, 4.0, 5.0, 8.0, 12.0] {
        for height_m in [1.0, 1.5, 2.5, 3.0] {
            for width_m in [0.3, 1.8] {
                let contour_m = [[0.0, 0.2], [length_m, 0.2], [length_m, height_m], [0.0, height_m]];
                vectors.push(features_of(&mut describer, &contour_m, f32::min(width_m, length_m)));
                is_vehicle.push(false);
            }
        }
    }
    let params =
        NuSvcParams { gamma: 0.02, nu: 0.0377, tolerance: Tolerance::OfMargin(1e-3), max_steps: 100_000 };
    let svm = train_svm(&vectors, &is_vehicle, PaperDescriber::NAMES, &params).expect("a classifier");
    PaperModel::of(&PaperModel::file(&library, &svm, Provenance::default())).expect("a model")
}

/// The features of a profile that is drawn out to `width_m`.
fn features_of(
    describer: &mut PaperDescriber,
    contour_m: &[[f32; 2]],
    width_m: f32,
) -> [f32; N_PAPER_FEATURES] {
    let extent_m = |axis: usize| {
        contour_m.iter().fold([f32::MAX, f32::MIN], |[low, high], it| [low.min(it[axis]), high.max(it[axis])])
    };
    let [from_m, to_m] = extent_m(0);
    let [bottom_m, top_m] = extent_m(1);
    let bounding_box = OrientedBox {
        center_m: [AHEAD_M + f32::midpoint(from_m, to_m), 0.0, f32::midpoint(bottom_m, top_m)],
        length_width_height_m: [to_m - from_m, width_m, top_m - bottom_m],
        yaw_rad: 0.0,
    };
    let mut positions_m = Vec::new();
    for (from_m, to_m) in contour_m.iter().zip(contour_m.iter().cycle().skip(1)) {
        // The same number of points per metre on every contour, so that their number predicts nothing.
        let n_steps = (10.0 * (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1])).ceil();
        for step in 0..n_steps as usize {
            let share = step as f32 / n_steps;
            let [along, up] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            let sides = (0..=18).map(|it| it as f32 / 18.0 - 0.5);
            positions_m.extend(sides.map(|side| [AHEAD_M + along, side * width_m, up]));
        }
    }
    describer.describe(&bounding_box, positions_m.into_iter()).expect("features")
}
