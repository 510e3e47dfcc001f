//! Conditions of a street that are set instead of drawn.

use std::ops::RangeInclusive;

use super::fleet::{Fleet, HAULAGE, NORTH_AMERICAN, TOWN, VARIED};
use super::ground::CrossSection;
use super::house_row::HouseRowParams;
use super::road_axis::{RoadAxisShape, Wave};

/// Conditions of a street that are set; all else is drawn as in any street. The same seed puts the same things at the
/// same positions along the road under all conditions but [`Self::haulage`], [`Self::north_american`] and
/// [`Self::varied_vehicles`], which draw other vehicles, and [`Self::gardens`], under which houses stand elsewhere.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own in a table of the catalogue")]
pub struct StreetConditions {
    /// Metres that all roads climb per metre, evenly; there are no hills then.
    pub gradient: Option<f32>,
    /// Greatest gradient of hills of which the next begins after 120 m; the roads are level but for these.
    pub hill_gradient: Option<f32>,
    /// How high kerbs stand, in metres.
    pub kerb_height_m: Option<f32>,
    /// Whether broad trees stand along the pavements of all roads, with crowns that hang over parked vehicles.
    #[serde(default)]
    pub avenue: bool,
    /// Whether half of the vehicles that drive and wait, and a third of those parked along kerbs, are trucks and buses, as
    /// where goods are handled. Lanes for parking are wider there.
    #[serde(default)]
    pub haulage: bool,
    /// Whether cars are those of a North American town: off-roaders, pickups and large saloons. Lanes for parking are wider
    /// there.
    #[serde(default)]
    pub north_american: bool,
    /// Whether vehicles are of many places: small and high vans, light, open and articulated trucks, buses of all lengths.
    /// Lanes for parking are wider there.
    #[serde(default)]
    pub varied_vehicles: bool,
    /// Whether bridges cross the road, so low that trucks just pass.
    #[serde(default)]
    pub bridges: bool,
    /// Whether wires hang over the road, with lamps.
    #[serde(default)]
    pub wires: bool,
    /// Whether garages stand at the pavement, some of them with doors that stand out over it.
    #[serde(default)]
    pub garages: bool,
    /// Whether houses stand back behind front gardens with walls, banks, bushes, sheds and cars in driveways.
    #[serde(default)]
    pub gardens: bool,
    /// Whether works go on along the roads: barriers, heaps, containers and other clutter as large as a vehicle.
    #[serde(default)]
    pub works: bool,
    /// Whether pavements are crowded: cycles and scooters in racks, children, groups, people who sit.
    #[serde(default)]
    pub crowd: bool,
    /// Whether the sides of cars and vans curve toward both ends, and have mirrors.
    #[serde(default)]
    pub rounded_bodies: bool,
    /// A truck of this height in metres drives ahead of the sensor.
    pub truck_ahead_height_m: Option<f32>,
}

/// Allowed gradients.
pub const GRADIENTS: RangeInclusive<f32> = -0.2..=0.2;
/// Allowed heights of kerbs, in metres.
pub const KERB_HEIGHTS_M: RangeInclusive<f32> = 0.0..=0.4;
/// Allowed heights of trucks, in metres.
pub const TRUCK_HEIGHTS_M: RangeInclusive<f32> = 2.0..=4.5;

/// From one hill to the next, in metres.
const HILL_LENGTH_M: f32 = 120.0;

impl StreetConditions {
    /// Whether all values can be; the text says which cannot.
    pub fn check(&self) -> Result<(), String> {
        let values = [
            ("gradient", self.gradient, GRADIENTS),
            ("hill_gradient", self.hill_gradient, GRADIENTS),
            ("kerb_height_m", self.kerb_height_m, KERB_HEIGHTS_M),
            ("truck_ahead_height_m", self.truck_ahead_height_m, TRUCK_HEIGHTS_M),
        ];
        values.into_iter().try_for_each(|(name, value, range)| check_range(name, value, &range))?;
        if self.gradient.is_some() && self.hill_gradient.is_some() {
            return Err("a street has either an even gradient or hills".to_owned());
        }
        if [self.haulage, self.north_american, self.varied_vehicles].into_iter().filter(|it| *it).count() > 1
        {
            return Err(
                "a street has only one of haulage, north_american and varied_vehicles, which say what drives"
                    .to_owned(),
            );
        }
        Ok(())
    }

    /// A road of this shape under the conditions.
    pub(super) fn road(&self, drawn: RoadAxisShape) -> RoadAxisShape {
        let hills = |greatest: f32| Wave {
            amplitude_m: greatest * HILL_LENGTH_M / std::f32::consts::TAU,
            length_m: HILL_LENGTH_M,
            phase: drawn.hills.phase,
        };
        match (self.gradient, self.hill_gradient) {
            (Some(gradient), _) => RoadAxisShape { gradient, hills: Wave::FLAT, ..drawn },
            (None, Some(greatest)) => RoadAxisShape { gradient: 0.0, hills: hills(greatest), ..drawn },
            (None, None) => drawn,
        }
    }

    /// The vehicles of the street and their shares.
    pub(super) fn fleet(&self) -> &'static Fleet {
        match (self.haulage, self.north_american, self.varied_vehicles) {
            (true, ..) => &HAULAGE,
            (_, true, _) => &NORTH_AMERICAN,
            (.., true) => &VARIED,
            _ => &TOWN,
        }
    }

    /// Extra width of lanes for parking along kerbs, beyond the drawn width, in metres.
    pub(super) fn parking_room_m(&self) -> f32 {
        self.fleet().parking_room_m
    }

    /// A row of houses like this under the conditions.
    pub(super) fn houses(&self, drawn: HouseRowParams) -> HouseRowParams {
        if self.gardens {
            HouseRowParams { gap: 0.9, gap_m: [6.0, 45.0], set_back: 1.0, garden_m: [4.0, 14.0] }
        } else {
            drawn
        }
    }

    /// A cross-section like this under the conditions.
    pub(super) fn section(&self, drawn: CrossSection) -> CrossSection {
        CrossSection { kerb_height_m: self.kerb_height_m.unwrap_or(drawn.kerb_height_m), ..drawn }
    }
}

/// Refuses a value that is set and not within `range`; the text says so.
pub(crate) fn check_range(name: &str, value: Option<f32>, range: &RangeInclusive<f32>) -> Result<(), String> {
    let (least, most) = (range.start(), range.end());
    match value.filter(|value| !range.contains(value)) {
        Some(value) => Err(format!("{name} is {value}, which is not within {least} to {most}")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road_axis::RoadAxis;

    const DRAWN: RoadAxisShape = RoadAxisShape {
        gradient: 0.03,
        hills: Wave { amplitude_m: 1.0, length_m: 200.0, phase: 0.2 },
        ..RoadAxisShape::straight([0.0, 400.0])
    };

    fn gradients(conditions: &StreetConditions) -> Vec<f32> {
        let axis = RoadAxis::new(&conditions.road(DRAWN));
        (0..390).map(|along_m| axis.height_and_gradient(along_m as f32).1).collect()
    }

    #[test]
    fn a_set_gradient_is_even_and_hills_are_as_steep_as_said() {
        let even = gradients(&StreetConditions { gradient: Some(0.1), ..StreetConditions::default() });
        assert!(even.iter().all(|it| (it - 0.1).abs() < 1e-3), "{even:?}");
        let hills = gradients(&StreetConditions { hill_gradient: Some(0.1), ..StreetConditions::default() });
        let [least, most] = [f32::min, f32::max].map(|pick| hills.iter().copied().reduce(pick).unwrap());
        assert!((most - 0.1).abs() < 2e-3 && (least + 0.1).abs() < 2e-3, "{least} {most}");
        assert_eq!(StreetConditions::default().road(DRAWN), DRAWN);
    }

    #[test]
    fn what_cannot_be_is_named() {
        let refused = |text: &str| toml::from_str::<StreetConditions>(text).unwrap().check().unwrap_err();
        assert!(refused("gradient = 0.5").contains("gradient is 0.5, which is not within -0.2 to 0.2"));
        assert!(refused("kerb_height_m = -0.1").contains("kerb_height_m is -0.1"));
        assert!(refused("truck_ahead_height_m = nan").contains("truck_ahead_height_m is NaN"));
        assert!(refused("gradient = 0.1\nhill_gradient = 0.1").contains("either"));
        assert!(refused("haulage = true\nnorth_american = true").contains("only one of haulage"));
        assert!(StreetConditions::default().check().is_ok());
    }
}
