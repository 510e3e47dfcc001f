//! The bodies of cars, as they are seen in the streets of a European and of a North American town.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// What cars of one body style measure. Positions along the length are shares of it from the front.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyStyle {
    /// How many of a hundred cars are like this.
    pub percent: u32,
    /// Lengths over all.
    pub length_m: Range<f32>,
    /// Heights over the road.
    pub height_m: Range<f32>,
    /// Widths without mirrors.
    pub width_m: Range<f32>,
    /// Height of the waist over the height.
    pub waist: Range<f32>,
    /// Where the windscreen begins.
    pub windscreen_foot: f32,
    /// Where it ends.
    pub roof_front: f32,
    /// Where the rear window begins.
    pub roof_rear: f32,
    /// Where it ends.
    pub rear_window_foot: f32,
    /// Height of the tail over the height of the waist.
    pub tail: f32,
    /// Height of the bonnet's front edge over the height of the waist.
    pub bonnet: f32,
    /// By how much the corners of the ground plan are cut off, in metres.
    pub rounding_m: f32,
    /// Whether there is a load bed behind the cabin.
    pub has_bed: bool,
    /// Radii of the wheels.
    pub wheel_radius_m: Range<f32>,
}

impl BodyStyle {
    /// One of `styles`, as often as they say.
    pub fn any<'a>(styles: &'a [Self], rng: &mut ChaCha8Rng) -> &'a Self {
        let mut drawn = rng.random_range(0..styles.iter().map(|it| it.percent).sum::<u32>());
        let is_drawn = |style: &&Self| {
            let is_it = drawn < style.percent;
            drawn = drawn.saturating_sub(style.percent);
            is_it
        };
        styles.iter().find(is_drawn).unwrap_or(&styles[0])
    }
}

/// A small car; what is not said of others is as here.
const SMALL: BodyStyle = BodyStyle {
    percent: 0,
    length_m: 3.5..4.0,
    height_m: 1.42..1.55,
    width_m: 1.58..1.68,
    waist: 0.60..0.66,
    windscreen_foot: 0.25,
    roof_front: 0.43,
    roof_rear: 0.89,
    rear_window_foot: 0.99,
    tail: 0.98,
    bonnet: 0.79,
    rounding_m: 0.0,
    has_bed: false,
    wheel_radius_m: 0.28..0.33,
};

/// What stands in the streets of a European town: mostly small cars.
pub const EUROPEAN: [BodyStyle; 6] = [
    // Small hatchback.
    BodyStyle { percent: 34, ..SMALL },
    // Hatchback.
    BodyStyle {
        percent: 26,
        length_m: 3.95..4.3,
        height_m: 1.42..1.52,
        width_m: 1.68..1.77,
        windscreen_foot: 0.27,
        roof_front: 0.44,
        roof_rear: 0.88,
        ..SMALL
    },
    // Saloon.
    BodyStyle {
        percent: 12,
        length_m: 4.3..4.85,
        height_m: 1.40..1.48,
        width_m: 1.70..1.82,
        windscreen_foot: 0.28,
        roof_front: 0.44,
        roof_rear: 0.70,
        rear_window_foot: 0.85,
        ..SMALL
    },
    // Estate.
    BodyStyle {
        percent: 13,
        length_m: 4.3..4.8,
        height_m: 1.42..1.52,
        width_m: 1.70..1.80,
        windscreen_foot: 0.27,
        roof_front: 0.43,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
        ..SMALL
    },
    // Off-roader.
    BodyStyle {
        percent: 5,
        length_m: 4.0..4.7,
        height_m: 1.62..1.80,
        width_m: 1.74..1.86,
        windscreen_foot: 0.27,
        roof_front: 0.41,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
        ..SMALL
    },
    // People carrier.
    BodyStyle {
        percent: 10,
        length_m: 3.9..4.6,
        height_m: 1.56..1.72,
        width_m: 1.68..1.80,
        windscreen_foot: 0.17,
        roof_front: 0.38,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
        ..SMALL
    },
];

/// What most of the North American cars have in common: larger, higher at the bonnet, rounder at the corners.
const LARGE: BodyStyle = BodyStyle {
    length_m: 4.5..5.0,
    height_m: 1.42..1.50,
    width_m: 1.78..1.88,
    bonnet: 0.82,
    rounding_m: 0.16,
    wheel_radius_m: 0.31..0.36,
    ..SMALL
};

/// What stands in the streets of a North American town: more than half of it is 1.6 m high or higher.
pub const NORTH_AMERICAN: [BodyStyle; 6] = [
    // Saloon.
    BodyStyle {
        percent: 30,
        windscreen_foot: 0.28,
        roof_front: 0.44,
        roof_rear: 0.71,
        rear_window_foot: 0.86,
        ..LARGE
    },
    // Hatchback.
    BodyStyle {
        percent: 9,
        length_m: 4.05..4.4,
        height_m: 1.44..1.55,
        width_m: 1.74..1.82,
        windscreen_foot: 0.26,
        roof_front: 0.43,
        ..LARGE
    },
    // Crossover.
    BodyStyle {
        percent: 30,
        length_m: 4.35..4.85,
        height_m: 1.60..1.74,
        width_m: 1.80..1.92,
        windscreen_foot: 0.27,
        roof_front: 0.42,
        roof_rear: 0.9,
        bonnet: 0.86,
        wheel_radius_m: 0.34..0.38,
        ..LARGE
    },
    // Large off-roader.
    BodyStyle {
        percent: 12,
        length_m: 4.8..5.5,
        height_m: 1.76..1.96,
        width_m: 1.92..2.06,
        windscreen_foot: 0.27,
        roof_front: 0.4,
        roof_rear: 0.94,
        rear_window_foot: 0.995,
        tail: 0.99,
        bonnet: 0.89,
        wheel_radius_m: 0.37..0.42,
        ..LARGE
    },
    // People carrier.
    BodyStyle {
        percent: 5,
        length_m: 4.95..5.25,
        height_m: 1.72..1.82,
        width_m: 1.94..2.02,
        windscreen_foot: 0.18,
        roof_front: 0.38,
        roof_rear: 0.93,
        rear_window_foot: 0.995,
        tail: 0.99,
        wheel_radius_m: 0.33..0.37,
        ..LARGE
    },
    // Pickup.
    BodyStyle {
        percent: 14,
        length_m: 5.2..6.2,
        height_m: 1.78..2.0,
        width_m: 1.86..2.05,
        waist: 0.64..0.68,
        windscreen_foot: 0.25,
        roof_front: 0.36,
        roof_rear: 0.56,
        rear_window_foot: 0.6,
        tail: 1.0,
        bonnet: 0.9,
        has_bed: true,
        wheel_radius_m: 0.37..0.42,
        ..LARGE
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn styles_add_up_to_a_hundred() {
        for styles in [&EUROPEAN, &NORTH_AMERICAN] {
            assert_eq!(styles.iter().map(|it| it.percent).sum::<u32>(), 100);
        }
    }
}
