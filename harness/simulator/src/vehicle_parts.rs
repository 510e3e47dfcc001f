//! Parts of vehicles of all kinds.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize as _, Deserializer};

use super::material::Material;
use super::solid::{Prism, Solid};

/// A range, written as its two ends.
pub fn range<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Range<f32>, D::Error> {
    let [from, to] = <[f32; 2]>::deserialize(deserializer)?;
    Ok(from..to)
}

/// Paints from black to white.
///
/// Under clear coat the light that is not sent back diffusely is mirrored away. Dark pigments send back next to nothing
/// diffusely: of a black car a scan shows the surfaces that face the sensor, lamps, plates and rims, and little of its
/// sides and bonnet.
pub fn paint(rng: &mut ChaCha8Rng) -> Material {
    const REFLECTIVITIES: [f32; 10] = [0.002, 0.002, 0.005, 0.012, 0.05, 0.12, 0.2, 0.3, 0.45, 0.65];
    Material::solid(REFLECTIVITIES[rng.random_range(0..REFLECTIVITIES.len())] * rng.random_range(0.8..1.2))
}

/// A prism in the middle of the width.
pub fn prism(profile_m: Vec<[f32; 2]>, bottom_half_width_m: f32, top_half_width_m: f32) -> Solid {
    Solid::Prism(Prism { profile_m, center_y_m: 0.0, bottom_half_width_m, top_half_width_m })
}

/// The block of seats that is seen through the panes.
pub fn seats([rear, front]: [f32; 2], [bottom, top]: [f32; 2], half_width_m: f32) -> Solid {
    let seat_top = bottom + 0.45 * (top - bottom);
    Solid::cuboid([rear + 0.3, -half_width_m * 0.65, bottom], [front - 0.35, half_width_m * 0.65, seat_top])
}

/// A post in the left and in the right side of a cabin, from the waist to the roof.
pub fn pillars(
    [foot_x, top_x]: [f32; 2],
    [foot_z, top_z]: [f32; 2],
    [foot_half_width_m, top_half_width_m]: [f32; 2],
) -> impl Iterator<Item = Solid> {
    [-1.0, 1.0].into_iter().map(move |side| {
        let inset_m = 0.035;
        Solid::cylinder(
            [foot_x, side * (foot_half_width_m - inset_m), foot_z],
            [top_x, side * (top_half_width_m - inset_m), top_z],
            0.045,
        )
    })
}

/// Four wheels that stand a little proud of the body.
pub fn wheels(
    axles_x: [f32; 2],
    radius_m: f32,
    body_half_width_m: f32,
) -> impl Iterator<Item = (Solid, Material)> {
    let sides = [-1.0, 1.0].into_iter();
    sides.flat_map(move |side| {
        axles_x.into_iter().map(move |x| {
            let outer_y = side * (body_half_width_m + 0.01);
            let inner_y = side * (body_half_width_m - 0.2);
            (Solid::cylinder([x, inner_y, radius_m], [x, outer_y, radius_m], radius_m), Material::RUBBER)
        })
    })
}
