//! The widths of a road with its parking lanes and pavements.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::ground::{Banks, CrossSection, Ground, Road};
use super::road_axis::{RoadAxis, RoadAxisShape, RoadPosition};
use super::roadside::{Roadside, Side};
use super::street_conditions::StreetConditions;
use super::world::Course;

/// Length of a street before and after the drive, in metres: as far as a sensor sees.
pub const MARGIN_M: f32 = 130.0;

/// The widths of a road, from the axis outward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadPlan {
    /// Its number among the roads of the street.
    pub road_idx: usize,
    /// Distance of the outer edge of the lanes from the axis, in metres.
    pub lanes_m: f32,
    /// How vehicles park on the left and on the right.
    pub parking: [Parking; 2],
    /// Width of both pavements in metres.
    pub pavement_width_m: f32,
    /// Where the road begins and ends, in metres along it.
    pub reach_m: [f32; 2],
}

/// How vehicles park on one side of a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parking {
    /// Not at all.
    Nowhere,
    /// Along the kerb, in a lane of this width in metres.
    AlongKerb {
        /// Width of the lane.
        width_m: f32,
    },
    /// Along the kerb, in a lane so wide that some stop in a second row beside those at the kerb.
    InTwoRows {
        /// Width of the lane.
        width_m: f32,
        /// Share of the vehicles at the kerb that are blocked by one in the second row, 0 to 1.
        blocked_share: f64,
    },
    /// With the nose to the kerb, side by side.
    Askew {
        /// Angle between the vehicles and the road, in radians.
        turned_rad: f32,
    },
}

impl RoadPlan {
    /// How vehicles park on `side`.
    pub fn parking(&self, side: Side) -> Parking {
        match side {
            Side::Left => self.parking[0],
            Side::Right => self.parking[1],
        }
    }

    /// The drive along the road, from its beginning and `left_m` to the left of its axis.
    pub fn drive(&self, left_m: f32, speed_m_per_s: f32) -> Course {
        Course::along(self.road_idx, RoadPosition { along_m: 0.0, left_m }, speed_m_per_s, self.reach_m)
    }

    /// One side of the road over its whole length.
    pub fn roadside(&self, side: Side) -> Roadside {
        let kerb_m = self.lanes_m + self.parking(side).width_m();
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

    /// The ground of a street of this road alone, whose axis has `shape`.
    pub fn ground(
        &self,
        shape: RoadAxisShape,
        conditions: &StreetConditions,
        rng: &mut ChaCha8Rng,
    ) -> Ground {
        let axis = RoadAxis::new(&conditions.road(shape));
        let section = conditions.section(self.cross_section(rng));
        let banks = Banks::any(section.left_kerb_m.max(section.right_kerb_m) + self.pavement_width_m, rng);
        let roads = vec![Road { axis, section, banks }];
        Ground { roads, pavement_width_m: self.pavement_width_m, corner_radius_m: 0.0 }
    }
}

impl Parking {
    /// Draws a lane for parking along the kerb.
    pub fn along_kerb(rng: &mut ChaCha8Rng) -> Self {
        Self::AlongKerb { width_m: rng.random_range(2.2..2.6) }
    }

    /// Draws a lane for parking in two rows.
    pub fn in_two_rows(rng: &mut ChaCha8Rng) -> Self {
        Self::InTwoRows { width_m: rng.random_range(4.4..5.0), blocked_share: rng.random_range(0.1..0.3) }
    }

    /// Draws how vehicles park, if at all: not with the chance `absent`, else askew with the chance `askew`.
    pub fn any(absent: f64, askew: f64, rng: &mut ChaCha8Rng) -> Self {
        if rng.random_bool(absent) {
            Self::Nowhere
        } else if rng.random_bool(askew) {
            Self::Askew { turned_rad: rng.random_range(0.75..1.2) }
        } else {
            Self::along_kerb(rng)
        }
    }

    /// This way to park, in a lane that is wider by `more_m` if it is along the kerb.
    #[must_use = "parking itself stays as it is"]
    pub fn widened(self, more_m: f32) -> Self {
        match self {
            Self::Nowhere | Self::Askew { .. } => self,
            Self::AlongKerb { width_m } => Self::AlongKerb { width_m: width_m + more_m },
            Self::InTwoRows { width_m, blocked_share } => {
                Self::InTwoRows { width_m: width_m + more_m, blocked_share }
            }
        }
    }

    /// Width of the lane that is needed, in metres.
    pub fn width_m(self) -> f32 {
        match self {
            Self::Nowhere => 0.0,
            Self::AlongKerb { width_m } | Self::InTwoRows { width_m, .. } => width_m,
            Self::Askew { .. } => 5.5,
        }
    }
}
