//! A stretch along one side of a road, and where things stand on it.

use super::road_axis::RoadPosition;
use super::world::{Placement, Stance};

/// Which side of a road, looking along its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Positive offsets from the axis.
    Left,
    /// Negative offsets.
    Right,
}

/// A stretch along one side of a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roadside {
    /// Which road.
    pub road_idx: usize,
    /// Which side of it.
    pub side: Side,
    /// Where it begins and ends, in metres along the axis.
    pub reach_m: [f32; 2],
    /// Distance of the kerb from the axis in metres.
    pub kerb_m: f32,
    /// Distance of the line where houses and front gardens begin from the axis, in metres.
    pub building_line_m: f32,
}

impl Side {
    /// 1 on the left, −1 on the right: the sign of offsets from the axis.
    pub fn sign(self) -> f32 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

impl Roadside {
    /// The position `along_m` along the axis and `from_axis_m` away from it on this side.
    pub fn position(&self, along_m: f32, from_axis_m: f32) -> RoadPosition {
        RoadPosition { along_m, left_m: self.side.sign() * from_axis_m }
    }

    /// Placement of an upright thing there, whose x points along the traffic of this side and y toward the road.
    pub fn facing_road(&self, along_m: f32, from_axis_m: f32) -> Placement {
        self.along_traffic(along_m, from_axis_m, Stance::Upright)
    }

    /// Placement of a thing there that faces the way the traffic of this side goes (on the right).
    pub fn along_traffic(&self, along_m: f32, from_axis_m: f32, stance: Stance) -> Placement {
        let turned_rad = match self.side {
            Side::Left => std::f32::consts::PI,
            Side::Right => 0.0,
        };
        Placement {
            road_idx: self.road_idx,
            position: self.position(along_m, from_axis_m),
            turned_rad,
            stance,
        }
    }
}
