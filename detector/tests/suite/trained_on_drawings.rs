//! A vehicle model that has seen nothing but drawings: enough to test what becomes of its decisions.

use detector::OrientedBox;
use detector::classify::nu_svc_solver::NuSvcParams;
use detector::classify::svm_training::train_svm;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::surroundings::Surroundings;
use detector::describe::trained_file::Provenance;
use detector::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use detector::pipeline::vehicle_model::{N_FEATURES, VehicleModel};

/// Drawn vehicles of all kinds and sizes against upright blocks from a pole to a stretch of wall.
pub fn vehicle_model() -> VehicleModel {
    let library = PrototypeLibrary::drawn();
    let mut describer = VehicleDescriber::new(library.clone());
    let (mut vectors, mut is_vehicle) = (Vec::new(), Vec::new());
    for prototype in library.prototypes() {
        for scale in [0.9, 0.95, 1.0, 1.05, 1.1] {
            let contour_m: Vec<[f32; 2]> =
                prototype.contour_m.iter().map(|it| it.map(|it| scale * it)).collect();
            vectors.push(features_of(&mut describer, &contour_m, 1.8 * scale));
            is_vehicle.push(true);
        }
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
    let params = NuSvcParams { gamma: 0.1078, nu: 0.0377, tolerance: 1e-3, max_steps: 100_000 };
    let made = Provenance {
        command: "cargo test".to_owned(),
        data: vec!["drawings".to_owned()],
        seed: 0,
        split: "nothing held out".to_owned(),
    };
    let named = (VehicleFeatures::NAMES, VehicleDescriber::name(&library));
    let svm = train_svm(&vectors, &is_vehicle, named, &params, made).expect("a classifier");
    VehicleModel::new(library, &svm)
}

/// The features of a profile that is drawn out to `width_m`.
fn features_of(describer: &mut VehicleDescriber, contour_m: &[[f32; 2]], width_m: f32) -> [f32; N_FEATURES] {
    let extent_m = |axis: usize| {
        contour_m.iter().fold([f32::MAX, f32::MIN], |[low, high], it| [low.min(it[axis]), high.max(it[axis])])
    };
    let [from_m, to_m] = extent_m(0);
    let [bottom_m, top_m] = extent_m(1);
    let bounding_box = OrientedBox {
        center_m: [f32::midpoint(from_m, to_m), 0.0, f32::midpoint(bottom_m, top_m)],
        length_width_height_m: [to_m - from_m, width_m, top_m - bottom_m],
        yaw_rad: 0.0,
    };
    let mut positions_m = Vec::new();
    for (from_m, to_m) in contour_m.iter().zip(contour_m.iter().cycle().skip(1)) {
        for step in 0..40 {
            let share = step as f32 / 40.0;
            let [along, up] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            positions_m.extend([-1.0, 0.0, 1.0].map(|side| [along, side * width_m / 2.0, up]));
        }
    }
    let surroundings = Surroundings::default();
    describer.describe(&bounding_box, &surroundings, positions_m.into_iter()).expect("features").values()
}
