//! Drawn objects of classes that are easy to distinguish: trees, poles and boxes, no two alike.

use detector::describe::trained_file::Provenance;
use detector::partial::partial_model::PartialModel;
use detector::partial::partial_params::PartialParams;
use detector::partial::training::{TrainingCloud, train};

/// What can be drawn.
pub const CLASSES: [&str; 3] = ["tree", "pole", "box"];

/// Numbers in 0 to 1 from a seed.
struct Draws(u64);

impl Draws {
    fn share(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.share()
    }
}

/// An object of class `class_idx` with so many points; another one for every seed.
pub fn drawn_object(class_idx: usize, n_points: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut draws = Draws(seed.wrapping_mul(97).wrapping_add(class_idx as u64));
    let height_m = draws.within(2.5, 5.0);
    let radius_m = draws.within(0.8, 1.6);
    let position = |draws: &mut Draws| match class_idx {
        // A trunk below a ball of leaves.
        0 if draws.share() < 0.2 => on_cylinder(draws, 0.15, height_m - radius_m),
        0 => loop {
            let [x, y, z] = [0; 3].map(|_| draws.within(-radius_m, radius_m));
            if x * x + y * y + z * z < radius_m * radius_m {
                break [x, y, height_m + z];
            }
        },
        1 => on_cylinder(draws, 0.06 + 0.02 * radius_m, height_m),
        _ => on_box(draws, [2.5 * radius_m, 1.2 * radius_m, 1.4]),
    };
    (0..n_points).map(|_| position(&mut draws)).collect()
}

fn on_cylinder(draws: &mut Draws, radius_m: f32, height_m: f32) -> [f32; 3] {
    let (sine, cosine) = draws.within(0.0, std::f32::consts::TAU).sin_cos();
    let off_m = radius_m + draws.within(-0.01, 0.01);
    [off_m * cosine, off_m * sine, draws.within(0.0, height_m)]
}

fn on_box(draws: &mut Draws, size_m: [f32; 3]) -> [f32; 3] {
    let mut at = size_m.map(|it| draws.within(-0.5, 0.5) * it);
    let side = (draws.share() * 3.0) as usize;
    at[side] = 0.5 * size_m[side] * if draws.share() < 0.5 { -1.0 } else { 1.0 } + draws.within(-0.01, 0.01);
    [at[0], at[1], at[2] + 0.5 * size_m[2]]
}

/// A model of all classes, trained on eight objects of each.
pub fn drawn_model(params: &PartialParams) -> PartialModel {
    let objects = (0..8 * CLASSES.len()).map(|it| (it % CLASSES.len(), it));
    let clouds: Vec<TrainingCloud> = objects
        .map(|(class_idx, object_idx)| {
            let positions_m = drawn_object(class_idx, 400, object_idx as u64);
            TrainingCloud::described(positions_m.into_iter(), class_idx, object_idx, 0, params)
        })
        .collect();
    train(&CLASSES.map(str::to_owned), &clouds, params, Provenance::default())
        .expect("all classes have objects")
}
