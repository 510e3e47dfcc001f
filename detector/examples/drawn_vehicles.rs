//! Writes the prototypes of vehicles that are drawn, not seen: `src/describe/drawn_vehicles.toml`.
//!
//! ```text
//! cargo run --release -p detector --example drawn_vehicles > detector/src/describe/drawn_vehicles.toml
//! ```
//!
//! Each is a silhouette with the proportions of its kind, of which only what the foreground keeps is looked at, by the
//! same stage as the points of a scan.
#![allow(clippy::disallowed_methods, reason = "a drawing is no detection")]

use detector::OrientedBox;
use detector::describe::box_frame_points::BoxFramePoints;
use detector::describe::prototype_library::{Prototype, PrototypeLibrary};
use detector::describe::side_profile::SideProfile;
use detector::describe::trained_file::Provenance;
use detector::params::HierarchicalParams;

/// Paper: VM section 4, 20 cm.
const COLUMN_M: f32 = 0.2;

/// A vehicle seen from its right side.
struct Silhouette {
    name: &'static str,
    length_m: f32,
    wheel_radius_m: f32,
    /// Where the axles are, as shares of the length from the front.
    axles: [f32; 2],
    /// The outline from below the front bumper over the roof to below the tail: shares of the length from the front, and
    /// heights in metres.
    outline: &'static [[f32; 2]],
}

const SILHOUETTES: [Silhouette; 8] = [
    Silhouette {
        name: "hatchback",
        length_m: 4.0,
        wheel_radius_m: 0.31,
        axles: [0.19, 0.80],
        outline: &[
            [0.02, 0.22],
            [0.0, 0.55],
            [0.04, 0.74],
            [0.27, 0.95],
            [0.44, 1.46],
            [0.70, 1.48],
            [0.88, 1.42],
            [0.98, 0.95],
            [1.0, 0.60],
            [0.98, 0.25],
        ],
    },
    Silhouette {
        name: "saloon",
        length_m: 4.7,
        wheel_radius_m: 0.32,
        axles: [0.19, 0.79],
        outline: &[
            [0.02, 0.22],
            [0.0, 0.55],
            [0.04, 0.72],
            [0.28, 0.92],
            [0.44, 1.42],
            [0.68, 1.44],
            [0.85, 1.02],
            [0.98, 0.96],
            [1.0, 0.60],
            [0.98, 0.25],
        ],
    },
    Silhouette {
        name: "estate",
        length_m: 4.7,
        wheel_radius_m: 0.32,
        axles: [0.19, 0.78],
        outline: &[
            [0.02, 0.22],
            [0.0, 0.55],
            [0.04, 0.73],
            [0.27, 0.93],
            [0.43, 1.44],
            [0.75, 1.47],
            [0.92, 1.40],
            [0.995, 0.92],
            [1.0, 0.60],
            [0.98, 0.25],
        ],
    },
    Silhouette {
        name: "off-roader",
        length_m: 4.6,
        wheel_radius_m: 0.37,
        axles: [0.18, 0.79],
        outline: &[
            [0.02, 0.30],
            [0.0, 0.70],
            [0.03, 0.92],
            [0.27, 1.10],
            [0.41, 1.70],
            [0.75, 1.74],
            [0.93, 1.66],
            [0.995, 1.08],
            [1.0, 0.70],
            [0.98, 0.33],
        ],
    },
    Silhouette {
        name: "people carrier",
        length_m: 4.5,
        wheel_radius_m: 0.33,
        axles: [0.19, 0.80],
        outline: &[
            [0.02, 0.24],
            [0.0, 0.60],
            [0.04, 0.82],
            [0.17, 1.02],
            [0.38, 1.64],
            [0.70, 1.68],
            [0.92, 1.60],
            [0.995, 1.00],
            [1.0, 0.60],
            [0.98, 0.27],
        ],
    },
    Silhouette {
        name: "van",
        length_m: 5.5,
        wheel_radius_m: 0.34,
        axles: [0.16, 0.81],
        outline: &[
            [0.02, 0.26],
            [0.0, 0.75],
            [0.13, 1.15],
            [0.24, 2.10],
            [0.30, 2.25],
            [0.99, 2.25],
            [1.0, 1.15],
            [0.99, 0.32],
        ],
    },
    Silhouette {
        name: "truck",
        length_m: 8.2,
        wheel_radius_m: 0.48,
        axles: [0.15, 0.80],
        outline: &[
            [0.01, 0.38],
            [0.0, 1.30],
            [0.025, 2.65],
            [0.06, 2.75],
            [0.24, 2.75],
            [0.25, 1.05],
            [0.275, 1.05],
            [0.275, 3.30],
            [1.0, 3.30],
            [1.0, 1.00],
            [0.97, 0.62],
        ],
    },
    Silhouette {
        name: "bus",
        length_m: 11.5,
        wheel_radius_m: 0.48,
        axles: [0.235, 0.74],
        outline: &[
            [0.01, 0.33],
            [0.0, 1.00],
            [0.015, 2.60],
            [0.03, 3.00],
            [0.99, 3.00],
            [1.0, 1.10],
            [0.99, 0.36],
        ],
    },
];

impl Silhouette {
    /// Its outline and wheels, as points (along, up) a finger's breadth apart; the front is at half the length.
    fn points_m(&self) -> Vec<[f32; 2]> {
        let corners_m: Vec<[f32; 2]> =
            self.outline.iter().map(|&[share, up_m]| [self.length_m * (0.5 - share), up_m]).collect();
        let mut points_m = Vec::new();
        for (&from_m, &to_m) in corners_m.iter().zip(corners_m.iter().cycle().skip(1)) {
            points_m.extend(between(from_m, to_m));
        }
        for axle in self.axles {
            let rim_m = |step: i32| {
                let angle_rad = step as f32 / 50.0 * std::f32::consts::TAU;
                let [x, z] = [angle_rad.cos(), angle_rad.sin()].map(|it| self.wheel_radius_m * it);
                [self.length_m * (0.5 - axle) + x, self.wheel_radius_m + z]
            };
            points_m.extend((0..50).map(rim_m));
        }
        points_m
    }
}

fn between(from_m: [f32; 2], to_m: [f32; 2]) -> impl Iterator<Item = [f32; 2]> {
    const SPACING_M: f32 = 0.02;
    let n_steps = ((to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]) / SPACING_M).ceil().max(1.0);
    (0..n_steps as usize).map(move |step| {
        [0, 1].map(|axis| from_m[axis] + step as f32 / n_steps * (to_m[axis] - from_m[axis]))
    })
}

/// The library of all of them.
///
/// # Errors
///
/// If a silhouette is drawn so that it goes around nothing.
pub fn drawn_vehicles() -> Result<PrototypeLibrary, Box<dyn std::error::Error>> {
    let params = HierarchicalParams::shipped();
    let mut profile = SideProfile::new(COLUMN_M);
    let prototypes = SILHOUETTES.iter().map(|silhouette| {
        let mut seen_m = silhouette.points_m();
        seen_m.retain(|&[_, up_m]| up_m >= params.foreground.clearance_m);
        let length_width_height_m = [silhouette.length_m, 1.8, 2.0];
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m, yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, seen_m.iter().map(|&[along_m, up_m]| [along_m, 0.0, up_m]));
        // Millimetres, so that the file can be read.
        let in_millimetres = |it: f32| (it * 1000.0).round() / 1000.0;
        let contour_m = profile.concave_contour(&points).iter().map(|it| it.map(in_millimetres)).collect();
        Prototype { name: silhouette.name.to_owned(), contour_m }
    });
    let made = Provenance {
        command: "cargo run --release -p detector --example drawn_vehicles".to_owned(),
        data: vec!["drawn silhouettes".to_owned()],
        seed: 0,
        split: "nothing held out".to_owned(),
    };
    Ok(PrototypeLibrary::new(made, COLUMN_M, prototypes.collect())?)
}

#[expect(clippy::print_stdout, reason = "it writes a file to where it is told")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", drawn_vehicles()?.to_toml());
    Ok(())
}
