//! Cars of any body style.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::body_style::BodyStyle;
use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::Solid;
use super::vehicle_parts::{paint, pillars, prism, seats, wheels};

/// A passenger car of this style.
pub fn car_of_style(style: &BodyStyle, rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(style.length_m.clone());
    let height_m = rng.random_range(style.height_m.clone());
    let half_width_m = rng.random_range(style.width_m.clone()) / 2.0;
    let waist_m = height_m * rng.random_range(style.waist.clone());
    let clearance_m = height_m * rng.random_range(0.13..0.17);
    let paint = paint(rng);
    let x = |share: f32| length_m * (0.5 - share);

    let Profiles { body, cabin, roof } = Profiles::of(style, x, [clearance_m, waist_m, height_m]);
    let cabin_top_half_width_m = half_width_m * rng.random_range(0.68..0.76);
    let shoulder_half_width_m = half_width_m - 0.04;
    let solids = if style.has_bed {
        with_bed(&body, x(style.rear_window_foot), [waist_m * 0.62, waist_m], half_width_m, style)
    } else {
        rounded(&body, half_width_m, style.rounding_m)
    };
    let mut parts: Vec<_> = solids.into_iter().map(|solid| (solid, paint)).collect();
    parts.extend([
        (prism(cabin, shoulder_half_width_m, cabin_top_half_width_m), Material::GLASS),
        (prism(roof, cabin_top_half_width_m, cabin_top_half_width_m - 0.04), paint),
        (
            seats([x(style.roof_rear), x(style.roof_front)], [waist_m - 0.05, height_m], half_width_m),
            Material::RUBBER,
        ),
    ]);
    let heights_m = [waist_m - 0.02, height_m - 0.02];
    let half_widths_m = [shoulder_half_width_m + 0.005, cabin_top_half_width_m + 0.005];
    let middle = f32::midpoint(style.roof_front, style.roof_rear);
    for (foot, top) in [
        (style.windscreen_foot, style.roof_front),
        (middle, middle),
        (style.rear_window_foot - 0.015, style.roof_rear),
    ] {
        parts.extend(pillars([x(foot), x(top)], heights_m, half_widths_m).map(|pillar| (pillar, paint)));
    }
    parts.extend(lamps_and_plates([x(1.0), x(0.0)], waist_m, half_width_m - style.rounding_m));
    let wheel_radius_m = rng.random_range(style.wheel_radius_m.clone());
    parts.extend(wheels([x(0.19), x(0.80)], wheel_radius_m, half_width_m));
    ObjectShape::new(AnnotationClass::Car, parts)
}

/// Side views, x forward and z up, in metres.
struct Profiles {
    body: Vec<[f32; 2]>,
    cabin: Vec<[f32; 2]>,
    roof: Vec<[f32; 2]>,
}

impl Profiles {
    /// Profiles of a car; `x` gives positions along the length in metres for shares of it from the front.
    fn of(style: &BodyStyle, x: impl Fn(f32) -> f32, [clearance_m, waist_m, height_m]: [f32; 3]) -> Self {
        // The bonnet rises to the foot of the windscreen.
        let body = vec![
            [x(1.0), clearance_m + 0.12],
            [x(0.97), clearance_m],
            [x(0.03), clearance_m],
            [x(0.0), clearance_m + 0.10],
            [x(0.0), waist_m * (style.bonnet - 0.17)],
            [x(0.035), waist_m * style.bonnet],
            [x(style.windscreen_foot), waist_m],
            [x(style.rear_window_foot), waist_m * style.tail],
            [x(1.0), waist_m * style.tail * 0.86],
        ];
        let cabin = vec![
            [x(style.rear_window_foot), waist_m * style.tail - 0.02],
            [x(style.windscreen_foot), waist_m - 0.02],
            [x(style.roof_front), height_m - 0.02],
            [x(style.roof_rear), height_m - 0.02],
        ];
        let roof = vec![
            [x(style.roof_rear), height_m - 0.05],
            [x(style.roof_front), height_m - 0.05],
            [x(style.roof_front) - 0.1, height_m],
            [x(style.roof_rear) + 0.1, height_m],
        ];
        Self { body, cabin, roof }
    }
}

/// A body of this profile whose corners are cut off by `rounding_m` on the ground plan, in steps.
fn rounded(profile_m: &[[f32; 2]], half_width_m: f32, rounding_m: f32) -> Vec<Solid> {
    let xs = || profile_m.iter().map(|it| it[0]);
    let [rear_m, front_m] = [xs().fold(f32::INFINITY, f32::min), xs().fold(f32::NEG_INFINITY, f32::max)];
    let length_m = front_m - rear_m;
    let steps = [(1.0, 0.0), (0.35, 0.04), (0.0, 0.1)];
    let n_steps = if rounding_m > 0.0 { steps.len() } else { 1 };
    let step = |(cut, from_end): (f32, f32)| {
        let reach_m = [rear_m + from_end * length_m, front_m - from_end * length_m];
        let half_m = half_width_m - cut * rounding_m;
        prism(part_between(profile_m, reach_m), half_m, half_m - 0.03)
    };
    steps[..n_steps].iter().map(|&it| step(it)).collect()
}

/// A rounded body that ends at `bed_front_m`, and an open load bed behind it, from its floor up to its sides.
fn with_bed(
    profile_m: &[[f32; 2]],
    bed_front_m: f32,
    [floor_m, side_m]: [f32; 2],
    half_width_m: f32,
    style: &BodyStyle,
) -> Vec<Solid> {
    let rear_m = profile_m.iter().map(|it| it[0]).fold(f32::INFINITY, f32::min);
    let in_front = part_between(profile_m, [bed_front_m, f32::INFINITY]);
    let below = vec![
        [rear_m, 0.55 * floor_m],
        [bed_front_m + 0.01, 0.4 * floor_m],
        [bed_front_m + 0.01, floor_m],
        [rear_m, floor_m],
    ];
    let mut solids = rounded(&in_front, half_width_m, style.rounding_m);
    solids.push(prism(below, half_width_m, half_width_m));
    let board_m = 0.07;
    for side in [-1.0, 1.0] {
        let edges_m = [side * half_width_m, side * (half_width_m - board_m)];
        solids.push(Solid::cuboid(
            [rear_m, edges_m[0].min(edges_m[1]), floor_m - 0.01],
            [bed_front_m, edges_m[0].max(edges_m[1]), side_m],
        ));
    }
    solids.push(Solid::cuboid(
        [rear_m, -half_width_m, floor_m - 0.01],
        [rear_m + board_m, half_width_m, side_m],
    ));
    solids
}

/// The part of a convex profile between two positions along the length, in metres.
pub(super) fn part_between(profile_m: &[[f32; 2]], [from_m, to_m]: [f32; 2]) -> Vec<[f32; 2]> {
    let cut = |corners: &[[f32; 2]], at_m: f32, keep: fn(f32, f32) -> bool| {
        let mut kept = Vec::new();
        for (&[ax, az], &[bx, bz]) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            if keep(ax, at_m) {
                kept.push([ax, az]);
            }
            let is_crossed = keep(ax, at_m) != keep(bx, at_m);
            if is_crossed && ax != at_m && bx != at_m {
                let share = (at_m - ax) / (bx - ax);
                kept.push([at_m, az + share * (bz - az)]);
            }
        }
        kept
    };
    let ahead = cut(profile_m, from_m, |x, at| x >= at);
    cut(&ahead, to_m, |x, at| x <= at)
}

/// A lamp in each corner of front and rear, and a number plate between: they flash back at any laser.
fn lamps_and_plates(
    [rear, front]: [f32; 2],
    waist_m: f32,
    half_width_m: f32,
) -> impl Iterator<Item = (Solid, Material)> {
    [(rear, -1.0_f32), (front, 1.0)].into_iter().flat_map(move |(end, outward)| {
        // A finger's breadth before the sheet metal, flush with the bumper.
        let [inner, outer] = [end - outward * 0.12, end + outward * 0.01];
        let slab = |side_m: [f32; 2], height_m: [f32; 2]| {
            Solid::cuboid(
                [inner.min(outer), side_m[0], height_m[0]],
                [inner.max(outer), side_m[1], height_m[1]],
            )
        };
        let lamp_m = [waist_m * 0.58, waist_m * 0.74];
        [
            slab([half_width_m * 0.58, half_width_m * 0.95], lamp_m),
            slab([half_width_m * -0.95, half_width_m * -0.58], lamp_m),
            slab([-0.26, 0.26], [waist_m * 0.4, waist_m * 0.4 + 0.11]),
        ]
        .map(|solid| (solid, Material::RETROREFLECTOR))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_cut_off_and_the_whole_is_as_long_and_wide() {
        let profile_m = vec![[-2.0, 0.2], [2.0, 0.2], [2.0, 0.8], [1.0, 1.0], [-2.0, 1.0]];
        let steps = rounded(&profile_m, 0.9, 0.2);
        let reaches: Vec<_> = steps
            .iter()
            .map(|it| match it {
                Solid::Prism(prism) => {
                    assert!(prism.is_convex());
                    let xs = prism.profile_m.iter().map(|it| it[0]);
                    (xs.fold(0.0, f32::max), prism.bottom_half_width_m)
                }
                _ => panic!("a body is of prisms"),
            })
            .collect();
        let expected = [(2.0, 0.7), (1.84, 0.83), (1.6, 0.9)];
        for (found, expected) in reaches.iter().zip(expected) {
            assert!(
                (found.0 - expected.0).abs() < 1e-5 && (found.1 - expected.1).abs() < 1e-5,
                "{reaches:?}"
            );
        }
        assert_eq!(rounded(&profile_m, 0.9, 0.0).len(), 1);
        // A cut through the slope of the bonnet.
        let part = part_between(&profile_m, [-1.0, 1.5]);
        assert!(part.contains(&[1.5, 0.9]) && part.contains(&[-1.0, 0.2]), "{part:?}");
    }
}
