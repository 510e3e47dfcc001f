//! The classes of road users that the detectors of this project tell apart.

use crate::detection::{DetectedClass, GivenClass};

/// A class of road users.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RoadUser {
    /// A car, van, truck or bus.
    Vehicle,
    /// A person on foot.
    Pedestrian,
    /// A bicycle or motorcycle with its rider.
    Cyclist,
}

/// Number of classes of road users.
pub const N_ROAD_USERS: usize = RoadUser::ALL.len();

impl RoadUser {
    /// All, in the order of arrays that hold something of each.
    pub const ALL: [Self; 3] = [Self::Vehicle, Self::Pedestrian, Self::Cyclist];

    /// Several of it, as in names of parts of models.
    pub fn in_plural(self) -> &'static str {
        match self {
            Self::Vehicle => "vehicles",
            Self::Pedestrian => "pedestrians",
            Self::Cyclist => "cyclists",
        }
    }

    /// Whether detections of it are vehicles.
    pub fn class(self) -> DetectedClass {
        match self {
            Self::Vehicle => DetectedClass::Vehicle,
            Self::Pedestrian | Self::Cyclist => DetectedClass::Object,
        }
    }

    /// The class that its detections are given; `None` for vehicles, of which nothing more is known.
    pub fn given(self) -> Option<GivenClass> {
        match self {
            Self::Vehicle => None,
            Self::Pedestrian => Some(GivenClass::PEDESTRIAN),
            Self::Cyclist => Some(GivenClass::CYCLIST),
        }
    }
}

/// The log odds of objects that no model needs to judge: less likely of the class than any object that is ranked as such.
const NONE: f32 = -10.0;

/// The logarithms of the odds that an object is each of [`RoadUser::ALL`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadUserOdds(pub [f32; N_ROAD_USERS]);

impl RoadUserOdds {
    /// Those of an object that no model needs to judge.
    pub const NONE: Self = Self([NONE; N_ROAD_USERS]);

    /// Those of a model that knows vehicles alone.
    pub fn of_vehicle(log_odds: f32) -> Self {
        Self([log_odds, NONE, NONE])
    }

    /// The log odds that it is `road_user`.
    pub fn of(self, road_user: RoadUser) -> f32 {
        self.0[road_user as usize]
    }
}

/// Thresholds by which an object that a model judged is a road user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadUserRule {
    /// Fewest points: models are trained on larger objects.
    pub least_points: usize,
    /// The log odds must be above those of its class.
    pub least_odds: RoadUserOdds,
}

impl RoadUserRule {
    /// The class of an object of `n_points`: of those with odds above the threshold the one with the greatest. `None` if it is
    /// none of them.
    pub fn road_user(&self, odds: RoadUserOdds, n_points: usize) -> Option<RoadUser> {
        let is_above = |it: &RoadUser| odds.of(*it) > self.least_odds.of(*it);
        let above = RoadUser::ALL.into_iter().filter(is_above);
        above
            .reduce(|a, b| if odds.of(b) > odds.of(a) { b } else { a })
            .filter(|_| n_points >= self.least_points)
    }
}

/// The classes that an object may have by its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MayBe(pub [bool; N_ROAD_USERS]);

impl MayBe {
    /// All.
    pub const ALL: Self = Self([true; N_ROAD_USERS]);

    /// Whether it may be `road_user`.
    pub fn allows(self, road_user: RoadUser) -> bool {
        self.0[road_user as usize]
    }

    /// Whether it may be any.
    pub fn allows_any(self) -> bool {
        self != Self([false; N_ROAD_USERS])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: RoadUserRule = RoadUserRule { least_points: 10, least_odds: RoadUserOdds([-0.5, 0.0, 1.0]) };

    #[track_caller]
    fn check(odds: [f32; 3], n_points: usize, expected: Option<RoadUser>) {
        assert_eq!(RULE.road_user(RoadUserOdds(odds), n_points), expected);
    }

    #[test]
    fn too_few_points_or_too_low_odds_are_no_road_user() {
        check([2.0, -9.0, -9.0], 9, None);
        check([-0.4, -9.0, -9.0], 10, Some(RoadUser::Vehicle));
        check([-0.5, -9.0, -9.0], 10, None);
        check([-0.5, 0.1, 0.9], 10, Some(RoadUser::Pedestrian));
    }

    #[test]
    fn of_two_classes_the_surer_one_is_given() {
        check([0.2, 1.4, 1.2], 10, Some(RoadUser::Pedestrian));
        check([0.2, 1.2, 1.4], 10, Some(RoadUser::Cyclist));
        check([3.0, 3.0, 1.4], 10, Some(RoadUser::Vehicle));
    }
}
