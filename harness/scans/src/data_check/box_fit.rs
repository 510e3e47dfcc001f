//! How well points lie along the sides of labelled boxes that face the sensor, and which change of all boxes makes it
//! better.

use detector::OrientedBox;

use super::label_correction::{Correction, DrawnBy};
use super::paired_fits::PairedFits;
use super::seen_vehicles::{SeenVehicle, SeenVehicles};

/// A point at least this far from the side that it belongs to counts nothing, in metres.
const NEAR_SIDE_M: f32 = 0.45;
/// Points may lie this far outside of boxes, in metres.
const OUTSIDE_M: f32 = 0.3;
/// Noise brings points of sides this far out of boxes, in metres.
const NOISE_M: f32 = 0.1;
/// Steps of a shift along both axes, coarse first: size in metres, and number to either side.
const SHIFT_STEPS: [(f32, i32); 3] = [(0.3, 6), (0.1, 3), (0.05, 2)];
/// A shift has two parameters and fits better by chance: its fit counts only times this factor.
const WORTH_OF_SHIFT: f64 = 0.94;
/// The factor where the median car has no length of cars, so that the size of boxes is suspected first.
const WORTH_OF_SHIFT_IF_ODD: f64 = 0.7;
/// Lengths of cars, in metres.
const CAR_LENGTHS_M: std::ops::Range<f32> = 3.0..5.6;

/// A change of all boxes that lets points lie better along their sides.
#[derive(Debug, Clone, PartialEq)]
pub struct BetterFit {
    /// The change.
    pub correction: Correction,
    /// How well points lie without it and with it, object by object.
    pub fits: PairedFits,
}

/// The mean over `vehicles`, changed by `correction` if there is one, of how well points lie along sides, from 0 to 1; 0
/// without vehicles.
pub fn mean_fit(vehicles: &[SeenVehicle], correction: Option<Correction>) -> f64 {
    let fits = vehicles.iter().map(|it| fit_of(it, correction));
    fits.sum::<f64>() / vehicles.len().max(1) as f64
}

/// How well points lie along the sides of `vehicle`, changed by `correction` if there is one, from 0 to 1.
pub fn fit_of(vehicle: &SeenVehicle, correction: Option<Correction>) -> f64 {
    let labelled = &vehicle.bounding_box;
    fit(&correction.map_or(*labelled, |it| it.of(labelled)), &vehicle.sides_m)
}

/// How many of `points_m` lie in `bounding_box` or right outside of it, where noise brings points of its sides, seen from
/// above.
pub fn n_inside(bounding_box: &OrientedBox, points_m: &[[f32; 2]]) -> usize {
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    let is_inside = |[x_m, y_m]: &&[f32; 2]| {
        let [along_m, across_m, _] = bounding_box.in_box_frame([*x_m, *y_m, 0.0]);
        along_m.abs() <= 0.5 * length_m + NOISE_M && across_m.abs() <= 0.5 * width_m + NOISE_M
    };
    points_m.iter().filter(is_inside).count()
}

/// Mean over `points_m` of how near each is to the sides of `bounding_box` that face the sensor: 1 on one, 0 elsewhere.
fn fit(bounding_box: &OrientedBox, points_m: &[[f32; 2]]) -> f64 {
    let (sin, cos) = bounding_box.yaw_rad.sin_cos();
    let [center_x_m, center_y_m, _] = bounding_box.center_m;
    let in_frame = |x: f32, y: f32| [cos * x + sin * y, cos * y - sin * x];
    let sensor_m = in_frame(-center_x_m, -center_y_m);
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    let half_m = [0.5 * length_m, 0.5 * width_m];
    let of_point = |[x, y]: [f32; 2]| {
        let at_m = in_frame(x - center_x_m, y - center_y_m);
        let (mut outside_m, mut from_side_m) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        for axis in 0..2 {
            outside_m = outside_m.max(at_m[axis].abs() - half_m[axis]);
            if sensor_m[axis].abs() > half_m[axis] {
                from_side_m = from_side_m.max(at_m[axis] * sensor_m[axis].signum() - half_m[axis]);
            }
        }
        if outside_m > OUTSIDE_M || from_side_m.abs() >= NEAR_SIDE_M {
            return 0.0;
        }
        let share = from_side_m / NEAR_SIDE_M;
        (1.0 - share * share).powi(2)
    };
    points_m.iter().map(|it| f64::from(of_point(*it))).sum::<f64>() / points_m.len().max(1) as f64
}

/// The change that is believed first, of those that boxes `drawn_by` people or a detector may need and that leave them near
/// their vehicles; `None` if all boxes fit best as they are.
pub fn better_fit(vehicles: &SeenVehicles, drawn_by: DrawnBy) -> Option<BetterFit> {
    let seen = &vehicles.seen;
    let unchanged = mean_fit(seen, None);
    let with_fit = |it: Correction| (it, mean_fit(seen, Some(it)));
    let worth_of_shift = if has_odd_cars(seen) { WORTH_OF_SHIFT_IF_ODD } else { WORTH_OF_SHIFT };
    let tried = changes().filter(|it| drawn_by.may_need(*it)).map(with_fit).map(|it| (it, it.1));
    let shifts = [Correction::Shift, Correction::OwnShift].map(|it| best_shift(seen, it));
    let shifts = shifts.into_iter().filter(|it| drawn_by.may_need(it.0));
    let tried = tried.chain(shifts.map(|it| (it, worth_of_shift * it.1)));
    let ((correction, fit), _) = tried.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (fit > unchanged).then(|| BetterFit { correction, fits: paired_fits(vehicles, correction) })
}

/// How well points lie without and with `correction`, object by object.
fn paired_fits(vehicles: &SeenVehicles, correction: Correction) -> PairedFits {
    let fits = |it: &SeenVehicle| [fit_of(it, None), fit_of(it, Some(correction))];
    PairedFits::of(vehicles.seen.iter().map(|it| (vehicles.object(it), fits(it))))
}

/// Points in boxes without and with `correction`, object by object.
pub fn paired_interiors(vehicles: &SeenVehicles, correction: Correction) -> PairedFits {
    let inside = |it: &SeenVehicle| {
        [it.bounding_box, correction.of(&it.bounding_box)].map(|of| n_inside(&of, &it.sides_m) as f64)
    };
    PairedFits::of(vehicles.seen.iter().map(|it| (vehicles.object(it), inside(it))))
}

/// All changes that are tried besides shifts.
fn changes() -> impl Iterator<Item = Correction> {
    let steps = |n: i32, step: f32| (-n..=n).filter(|it| *it != 0).map(move |it| it as f32 * step);
    [Correction::SwapSides, Correction::NegateYaw, Correction::YawFromLeft, Correction::YawFromDegrees]
        .into_iter()
        .chain(steps(22, 2_f32.to_radians()).map(Correction::Yaw))
        .chain(steps(24, 0.5_f32.to_radians()).map(Correction::Turn))
        .chain((8..=44).map(|it| Correction::Scale(it as f32 * 0.05)))
}

/// The best shift of one kind, found in steps that become smaller, with its fit.
fn best_shift(vehicles: &[SeenVehicle], kind: fn([f32; 2]) -> Correction) -> (Correction, f64) {
    let mut best = ([0.0; 2], mean_fit(vehicles, None));
    for (step_m, n) in SHIFT_STEPS {
        let around = best.0;
        for index in 0..(2 * n + 1).pow(2) {
            let steps = [index / (2 * n + 1) - n, index % (2 * n + 1) - n];
            let by_m = [0, 1].map(|axis| around[axis] + steps[axis] as f32 * step_m);
            let fit = mean_fit(vehicles, Some(kind(by_m)));
            if fit > best.1 {
                best = (by_m, fit);
            }
        }
    }
    (kind(best.0), best.1)
}

/// Whether the length of the median car is outside of [`CAR_LENGTHS_M`].
fn has_odd_cars(vehicles: &[SeenVehicle]) -> bool {
    let longer = |it: &SeenVehicle| {
        let [length_m, width_m, _] = it.bounding_box.length_width_height_m;
        length_m.max(width_m)
    };
    let mut lengths_m: Vec<f32> = vehicles.iter().map(longer).collect();
    lengths_m.sort_unstable_by(f32::total_cmp);
    lengths_m.get(lengths_m.len() / 2).is_some_and(|it| !CAR_LENGTHS_M.contains(it))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::{Annotation, LabeledScan, ScanId};
    use detector::PointCloud;
    use reports::vocabulary::class::AnnotationClass;

    const CAR: [f32; 3] = [4.0, 1.8, 1.5];

    /// Cars around the sensor, with points along the sides that it sees, and the ground.
    fn cars(n: usize) -> SeenVehicles {
        let mut vehicles = SeenVehicles::default();
        for index in 0..n {
            let angle = index as f32 * 0.9;
            let (center_x_m, center_y_m) = (12.0 * angle.cos(), 12.0 * angle.sin());
            let bounding_box = OrientedBox {
                center_m: [center_x_m, center_y_m, -0.95],
                length_width_height_m: CAR,
                yaw_rad: 2.3 * angle,
            };
            let mut cloud = PointCloud::default();
            let mut add = |along_m: f32, across_m: f32, z_m: f32| {
                let (sin, cos) = bounding_box.yaw_rad.sin_cos();
                let (x_m, y_m) = (cos * along_m - sin * across_m, sin * along_m + cos * across_m);
                cloud.push([center_x_m + x_m, center_y_m + y_m, z_m], 0.0);
            };
            let [sensor_along_m, sensor_across_m, _] = bounding_box.in_box_frame([0.0; 3]);
            for step in 0..80 {
                let share = step as f32 / 79.0 - 0.5;
                add(share * 4.0, 0.9 * sensor_across_m.signum(), -1.0);
                add(2.0 * sensor_along_m.signum(), share * 1.8, -1.0);
                for across_m in [-1.0, 0.0, 1.0] {
                    add(share * 7.0, across_m, -1.7);
                }
            }
            let car = Annotation { bounding_box: Some(bounding_box), ..Annotation::of(AnnotationClass::Car) };
            let id = ScanId { sequence: "drawn".to_owned(), index: index as u32 };
            vehicles.add(&LabeledScan::everywhere(id, cloud, vec![car]), |it| *it);
        }
        vehicles
    }

    #[test]
    fn points_on_the_seen_sides_fit_and_no_change_is_better() {
        let vehicles = cars(12);
        let seen = &vehicles.seen;
        assert_eq!((seen.len(), vehicles.one_of_each().len()), (12, 12));
        // A side that the sensor sees along its plane only counts less.
        assert!(mean_fit(seen, None) > 0.8, "{}", mean_fit(seen, None));
        let better = better_fit(&vehicles, DrawnBy::People);
        assert!(better.as_ref().is_none_or(|it| it.fits.gain() < 1.1), "{better:?}");
        assert_eq!(mean_fit(&[], None), 0.0);
    }

    #[test]
    fn a_change_of_all_boxes_is_found_back() {
        for (damage, mended) in [
            (Correction::SwapSides, Correction::SwapSides),
            (Correction::Shift([0.6, 0.0]), Correction::Shift([-0.6, 0.0])),
            (Correction::OwnShift([0.6, -0.3]), Correction::OwnShift([-0.6, 0.3])),
            (Correction::NegateYaw, Correction::NegateYaw),
        ] {
            let mut vehicles = cars(12);
            for it in &mut vehicles.seen {
                it.bounding_box = damage.of(&it.bounding_box);
            }
            let found = better_fit(&vehicles, DrawnBy::People).unwrap();
            assert!(found.fits.gain() > 1.3 && found.fits.is_surely_over(1.1), "{found:?}");
            assert!(found.fits.share_larger() > 0.7, "{found:?}");
            let text = |it: Correction| it.to_string();
            let of_kind = |it: Correction| std::mem::discriminant(&it);
            assert_eq!(of_kind(found.correction), of_kind(mended), "{damage:?}: {}", text(found.correction));
            if let (
                Correction::Shift(found_m) | Correction::OwnShift(found_m),
                Correction::Shift(m) | Correction::OwnShift(m),
            ) = (found.correction, mended)
            {
                assert!((found_m[0] - m[0]).abs() < 0.15 && (found_m[1] - m[1]).abs() < 0.15, "{found:?}");
            }
        }
    }
}
