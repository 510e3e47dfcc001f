//! The widths of a road with its parking lanes and pavements.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::ground::CrossSection;
use super::roadside::{Roadside, Side};

/// How far a street goes on before and after the drive, in metres: what a sensor can see.
pub const MARGIN_M: f32 = 130.0;

/// The widths of a road, from the axis outward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadPlan {
    /// Its number among the roads of the street.
    pub road_idx: usize,
    /// Distance of the outer edge of the lanes from the axis, in metres.
    pub lanes_m: f32,
    /// Width of the parking lane on the left and on the right in metres; 0 where none is.
    pub parking_width_m: [f32; 2],
    /// Width of both pavements in metres.
    pub pavement_width_m: f32,
    /// Where the road begins and ends, in metres along it.
    pub reach_m: [f32; 2],
}

impl RoadPlan {
    /// Whether vehicles park on `side`.
    pub fn has_parking(&self, side: Side) -> bool {
        self.parking_width_m(side) > 0.0
    }

    /// One side of the road over its whole length.
    pub fn roadside(&self, side: Side) -> Roadside {
        let kerb_m = self.lanes_m + self.parking_width_m(side);
        let building_line_m = kerb_m + self.pavement_width_m;
        Roadside { road_idx: self.road_idx, side, reach_m: self.reach_m, kerb_m, building_line_m }
    }

    /// The cross-section, with a crown and kerbs drawn from what is usual.
    pub fn cross_section(&self, rng: &mut ChaCha8Rng) -> CrossSection {
        CrossSection {
            left_kerb_m: self.roadside(Side::Left).kerb_m,
            right_kerb_m: self.roadside(Side::Right).kerb_m,
            crown: rng.random_range(0.01..0.03),
            kerb_height_m: rng.random_range(0.06..0.15),
        }
    }

    fn parking_width_m(&self, side: Side) -> f32 {
        match side {
            Side::Left => self.parking_width_m[0],
            Side::Right => self.parking_width_m[1],
        }
    }
}

/// Draws the width of a parking lane; 0 if there is none, which has the chance `absent`.
pub fn parking_width_m(absent: f64, rng: &mut ChaCha8Rng) -> f32 {
    if rng.random_bool(absent) { 0.0 } else { rng.random_range(2.2..2.6) }
}
