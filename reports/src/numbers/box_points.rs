//! Where the points of matched vehicles lie in the frames of their boxes.

use std::collections::BTreeMap;

use crate::vocabulary::class::AnnotationClass;

/// Side of the cells that points are counted in, in metres.
pub const CELL_M: f64 = 0.15;

/// Direction across the length of boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// From above: to the left.
    Left,
    /// From the side: upwards.
    Up,
}

/// The points of all vehicles of one class, in the frame of one kind of box: x along its length to the front, y across, from
/// the centre.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPoints {
    /// The class.
    pub class: AnnotationClass,
    /// The kind of box.
    pub frame: &'static str,
    /// Number of vehicles.
    pub n_vehicles: usize,
    /// Direction of y.
    pub across: Across,
    /// Mean length of the boxes, and mean width or height, in metres.
    pub length_width_m: [f64; 2],
    /// For each cell that holds a point, the share of the points of a vehicle, on average over the vehicles. Cell `[0, 0]`
    /// begins at the centre.
    pub shares: BTreeMap<[i32; 2], f64>,
}

/// A vehicle's points in the frame of a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramedPoints<'a> {
    /// Length and width of the box, in metres.
    pub length_width_m: [f32; 2],
    /// The points along the length and across, in metres.
    pub positions_m: &'a [[f32; 2]],
}

impl BoxPoints {
    /// The points of `vehicles`. Every vehicle counts alike, however many points it has.
    pub fn of<'a>(
        class: AnnotationClass,
        frame: &'static str,
        vehicles: impl Iterator<Item = FramedPoints<'a>>,
    ) -> Self {
        let (mut n_vehicles, mut sums_m, mut shares) = (0, [0.0; 2], BTreeMap::new());
        for vehicle in vehicles {
            n_vehicles += 1;
            sums_m = std::array::from_fn(|axis| sums_m[axis] + f64::from(vehicle.length_width_m[axis]));
            for position_m in vehicle.positions_m {
                let cell = position_m.map(|it| (f64::from(it) / CELL_M).floor() as i32);
                *shares.entry(cell).or_default() += 1.0 / vehicle.positions_m.len() as f64;
            }
        }
        let of_all = 1.0 / f64::from(n_vehicles.max(1));
        for share in shares.values_mut() {
            *share *= of_all;
        }
        Self {
            class,
            frame,
            n_vehicles: n_vehicles as usize,
            across: Across::Left,
            length_width_m: sums_m.map(|it| it * of_all),
            shares,
        }
    }

    /// These points with `across` as the direction of y.
    pub fn seen_across(self, across: Across) -> Self {
        Self { across, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vehicle_counts_alike() {
        let many = [[0.05, 0.05]; 30];
        let few = [[0.05, 0.05], [-0.05, 0.25]];
        let framed = |positions_m, length_m| FramedPoints { length_width_m: [length_m, 1.8], positions_m };
        let vehicles = [framed(&many[..], 4.0), framed(&few[..], 5.0)];
        let points = BoxPoints::of(AnnotationClass::Car, "hull box", vehicles.into_iter());
        assert_eq!((points.n_vehicles, points.length_width_m[0]), (2, 4.5));
        let shares: Vec<_> = points.shares.iter().map(|(cell, it)| (*cell, (it * 100.0).round())).collect();
        assert_eq!(shares, [([-1, 1], 25.0), ([0, 0], 75.0)]);
        let nothing = BoxPoints::of(AnnotationClass::Car, "hull box", std::iter::empty());
        assert_eq!((nothing.n_vehicles, nothing.length_width_m), (0, [0.0; 2]));
    }
}
