//! Objects that are cut, or joined, where the vehicle model likes that better.

use super::cut_places::{CutPlaces, Plane};
use super::joinable::may_be_one;
use super::regrouping_params::RegroupingParams;
use crate::classify::object_classifier::{NO_VEHICLE, ObjectClassifier};
use crate::classify::size_gate::{SizeGateParams, size_gate};
use crate::describe::surroundings::Surroundings;
use crate::detection::DetectedClass;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::oriented_box::OrientedBox;

/// Cuts objects in which several vehicles stand, or one and something else, and joins vehicles that came apart.
///
/// A row of parked cars is one cluster where the gaps between them are hidden from the sensor, however the dense cells are
/// weighed. Where both parts are taken for vehicles more surely than the whole, it is cut, and so are the parts again. In
/// the same way two objects side by side, not both of them vehicles, become one if that is taken for one more surely than
/// either.
///
/// Not in the papers, which have no step from the classifier back to the clusters.
#[derive(Debug, Clone)]
pub struct Regrouping {
    params: RegroupingParams,
    to_cut: Vec<FittedObject>,
    places: CutPlaces,
    // With room for all points of an object, so that writing needs no branch.
    parts_m: [Vec<[f32; 3]>; 2],
}

/// What looks at an object as it might be.
pub struct Judge<'a, M, S> {
    /// Fits its box.
    pub box_fit: &'a mut ConvexHullBox,
    /// Tells how surely it is a vehicle.
    pub model: &'a mut M,
    /// Tells what stands around a box.
    pub surroundings: S,
    /// What has not the size of a vehicle is none, without asking the model.
    pub sizes: &'a SizeGateParams,
}

impl<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings> Judge<'_, M, S> {
    /// How surely these points, one at least, are a vehicle; [`NO_VEHICLE`] if their size says no.
    fn decision(&mut self, positions_m: &[[f32; 3]]) -> f32 {
        let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
        let bounding_box = self.box_of_vehicle(outline_m, z_range_m(positions_m), positions_m.len());
        bounding_box.map_or(NO_VEHICLE, |it| self.decision_in(&it, positions_m))
    }

    /// The box of `n_points` points, one at least, with this outline. `None` if a vehicle has not its size.
    fn box_of_vehicle(
        &mut self,
        outline_m: impl Iterator<Item = [f32; 2]>,
        z_range_m: [f32; 2],
        n_points: usize,
    ) -> Option<OrientedBox> {
        if !self.has_height(z_range_m) {
            return None;
        }
        let bounding_box = self.box_over(outline_m, z_range_m);
        let class = size_gate(n_points, &bounding_box, self.sizes);
        (class == DetectedClass::Vehicle).then_some(bounding_box)
    }

    /// Box and decision of an object of these points, one at least.
    fn judge(&mut self, positions_m: &[[f32; 3]]) -> (OrientedBox, f32) {
        let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
        let bounding_box = self.box_over(outline_m, z_range_m(positions_m));
        (bounding_box, self.decision_in(&bounding_box, positions_m))
    }

    /// Whether it could be a vehicle by its height.
    fn has_height(&self, [low_m, high_m]: [f32; 2]) -> bool {
        (self.sizes.min_height_m..=self.sizes.max_height_m).contains(&(high_m - low_m))
    }

    fn box_over(&mut self, outline_m: impl Iterator<Item = [f32; 2]>, z_range_m: [f32; 2]) -> OrientedBox {
        self.box_fit.fit(outline_m, z_range_m).expect("it has points")
    }

    fn decision_in(&mut self, bounding_box: &OrientedBox, positions_m: &[[f32; 3]]) -> f32 {
        let surroundings = (self.surroundings)(bounding_box);
        self.model.decision(bounding_box, &surroundings, positions_m.iter().copied())
    }
}

/// From the lowest to the highest of some points.
fn z_range_m(positions_m: &[[f32; 3]]) -> [f32; 2] {
    let (mut low_m, mut high_m) = (f32::INFINITY, f32::NEG_INFINITY);
    for &[_, _, z_m] in positions_m {
        low_m = if z_m < low_m { z_m } else { low_m };
        high_m = if z_m > high_m { z_m } else { high_m };
    }
    [low_m, high_m]
}

impl Regrouping {
    /// Nothing regrouped yet.
    pub fn new(params: RegroupingParams) -> Self {
        Self { params, to_cut: Vec::new(), places: CutPlaces::default(), parts_m: [Vec::new(), Vec::new()] }
    }

    /// Whether anything is cut or joined at all.
    pub fn is_enabled(&self) -> bool {
        self.params.enabled
    }

    /// Cuts and joins `fitted`, whose objects have their decisions. Parts stand where the whole stood, a joined object where
    /// the first of its parts stood.
    pub fn regroup<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        fitted: &mut FittedObjects,
        mut judge: Judge<'_, M, S>,
    ) {
        if self.params.enabled {
            self.cut(fitted, &mut judge);
            self.join(fitted, &mut judge);
        }
    }

    fn cut<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        fitted: &mut FittedObjects,
        judge: &mut Judge<'_, M, S>,
    ) {
        self.to_cut.clear();
        self.to_cut.extend(fitted.objects.drain(..).rev());
        while let Some(object) = self.to_cut.pop() {
            let Some(plane) = self.best_cut(fitted, &object, judge) else {
                fitted.objects.push(object);
                continue;
            };
            let parts = fitted.members.part(&object.members, |position_m| plane.is_before(position_m));
            for members in parts.into_iter().rev() {
                let (bounding_box, decision) = judge.judge(fitted.members.positions_m(&members));
                let mut part = fitted.object(members, bounding_box, judge.box_fit.hull_m());
                part.decision = Some(decision);
                self.to_cut.push(part);
            }
        }
    }

    /// The cut whose parts are liked best, if they are liked better than the whole.
    fn best_cut<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        fitted: &FittedObjects,
        object: &FittedObject,
        judge: &mut Judge<'_, M, S>,
    ) -> Option<Plane> {
        let positions_m = fitted.members.positions_m(&object.members);
        let mut places = std::mem::take(&mut self.places);
        let mut best = (object.decision.unwrap_or(0.0).max(0.0), None);
        for &plane in places.find(positions_m, &object.bounding_box, &self.params) {
            if let Some(value) = self.value(positions_m, plane, judge)
                && value > best.0
            {
                best = (value, Some(plane));
            }
        }
        self.places = places;
        best.1
    }

    /// How much the model likes the parts on both sides of a plane. `None` if one of them has too few points.
    fn value<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        positions_m: &[[f32; 3]],
        plane: Plane,
        judge: &mut Judge<'_, M, S>,
    ) -> Option<f32> {
        let [before_m, behind_m] = &mut self.parts_m;
        for part_m in [&mut *before_m, &mut *behind_m] {
            part_m.resize(part_m.len().max(positions_m.len()), [0.0; 3]);
        }
        let (mut n_before, mut n_behind) = (0, 0);
        for &position_m in positions_m {
            // Written to both, added to one: which one cannot be foreseen.
            let is_before = usize::from(plane.is_before(position_m));
            before_m[n_before] = position_m;
            behind_m[n_behind] = position_m;
            n_before += is_before;
            n_behind += 1 - is_before;
        }
        if n_before.min(n_behind) < self.params.min_points.max(1) {
            return None;
        }
        let [a, b] = [&before_m[..n_before], &behind_m[..n_behind]].map(|part_m| judge.decision(part_m));
        Some(a.min(b).max(a.max(b) - self.params.lone_part_margin))
    }

    fn join<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        fitted: &mut FittedObjects,
        judge: &mut Judge<'_, M, S>,
    ) {
        let mut first = 0;
        while first < fitted.objects.len() {
            let mut second = first + 1;
            while second < fitted.objects.len() {
                if let Some(joined) = self.joined(fitted, [first, second], judge) {
                    fitted.objects[first] = joined;
                    fitted.objects.remove(second);
                    second = first + 1;
                } else {
                    second += 1;
                }
            }
            first += 1;
        }
    }

    /// What two objects are together, if the model likes that better than either.
    fn joined<M: ObjectClassifier, S: Fn(&OrientedBox) -> Surroundings>(
        &mut self,
        fitted: &mut FittedObjects,
        pair: [usize; 2],
        judge: &mut Judge<'_, M, S>,
    ) -> Option<FittedObject> {
        let [a, b] = pair.map(|it| &fitted.objects[it]);
        let [a_range_m, b_range_m] = [a, b].map(|it| ends_m(&it.bounding_box));
        let both_m = [a_range_m[0].min(b_range_m[0]), a_range_m[1].max(b_range_m[1])];
        if !self.may_be_joined(fitted, a, b) || !judge.has_height(both_m) {
            return None;
        }
        let [a_decision, b_decision] = [a, b].map(|it| it.decision.unwrap_or(0.0));
        let parts_m = [a, b].map(|it| fitted.members.positions_m(&it.members));
        // What sticks out of both sticks out of one of them.
        let outline_m = [a, b].into_iter().flat_map(|it| fitted.hull_m(it)).copied();
        let [a_z_m, b_z_m] = parts_m.map(z_range_m);
        let z_range_m = [a_z_m[0].min(b_z_m[0]), a_z_m[1].max(b_z_m[1])];
        let n_points = parts_m[0].len() + parts_m[1].len();
        let bounding_box = judge.box_of_vehicle(outline_m, z_range_m, n_points)?;
        let [positions_m, _] = &mut self.parts_m;
        positions_m.clear();
        for part_m in parts_m {
            positions_m.extend_from_slice(part_m);
        }
        let decision = judge.decision_in(&bounding_box, positions_m);
        if decision <= a_decision.max(b_decision).max(0.0) {
            return None;
        }
        let members = fitted.members.joined([&a.members.clone(), &b.members.clone()]);
        let mut joined = fitted.object(members, bounding_box, judge.box_fit.hull_m());
        joined.decision = Some(decision);
        Some(joined)
    }

    fn may_be_joined(&self, fitted: &FittedObjects, a: &FittedObject, b: &FittedObject) -> bool {
        let are_vehicles = [a, b].iter().all(|it| it.decision.is_some_and(|decision| decision > 0.0));
        !are_vehicles && may_be_one([a, b].map(|it| (&it.bounding_box, fitted.hull_m(it))), &self.params)
    }
}

/// The lower and the upper end of a box.
fn ends_m(bounding_box: &OrientedBox) -> [f32; 2] {
    [-0.5, 0.5].map(|it| bounding_box.center_m[2] + it * bounding_box.length_width_height_m[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    /// Likes what is about 4 m long, and the more so the nearer to that.
    struct FourMetres;

    impl ObjectClassifier for FourMetres {
        fn decision(
            &mut self,
            bounding_box: &OrientedBox,
            _: &Surroundings,
            positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
        ) -> f32 {
            assert!(positions_m.len() > 0);
            1.0 - (bounding_box.length_width_height_m[0] - 4.0).abs()
        }
    }

    /// Two sides of a thing of this length and 1.8 m width, from `start_m` on along x.
    fn sides(start_m: f32, length_m: f32) -> Vec<[f32; 3]> {
        let n_along = (length_m / 0.05) as u8;
        let along =
            (0..=n_along).map(|it| [start_m + length_m * f32::from(it) / f32::from(n_along), 5.0, -1.0]);
        along.chain((0..=36_u8).map(|it| [start_m, 5.0 + 0.05 * f32::from(it), -1.0])).collect()
    }

    /// The lengths and numbers of points of what becomes of objects of these points, each a list.
    fn regrouped(objects: &[Vec<[f32; 3]>], change: impl Fn(&mut RegroupingParams)) -> Vec<(i32, usize)> {
        let HierarchicalParams { regrouping: mut params, vehicle_size: mut sizes, .. } =
            HierarchicalParams::shipped();
        // Drawings are flat.
        sizes.min_height_m = 0.0;
        change(&mut params);
        let (mut fitted, mut box_fit, mut model) =
            (FittedObjects::default(), ConvexHullBox::default(), FourMetres);
        let mut judge = Judge {
            box_fit: &mut box_fit,
            model: &mut model,
            surroundings: |_: &OrientedBox| Surroundings::default(),
            sizes: &sizes,
        };
        let mut next_point = 0;
        for positions_m in objects {
            let start = fitted.members.len();
            for &position_m in positions_m {
                fitted.members.push(next_point, position_m);
                next_point += 1;
            }
            let (bounding_box, decision) = judge.judge(positions_m);
            let mut object = fitted.object(start..fitted.members.len(), bounding_box, judge.box_fit.hull_m());
            object.decision = Some(decision);
            fitted.objects.push(object);
        }
        Regrouping::new(params).regroup(&mut fitted, judge);
        let mut seen: Vec<u32> = Vec::new();
        let found = fitted.objects.iter().map(|it| {
            let point_indices = fitted.members.point_indices(&it.members);
            assert!(point_indices.windows(2).all(|pair| pair[0] < pair[1]));
            seen.extend(point_indices);
            (it.bounding_box.length_width_height_m[0].round() as i32, point_indices.len())
        });
        let found = found.collect();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..next_point), "a point is lost, or in two objects");
        found
    }

    #[test]
    fn a_row_of_cars_is_cut_between_them_and_a_car_is_not() {
        let car = sides(10.0, 4.0);
        let row = [car.clone(), sides(14.6, 4.0), sides(19.2, 4.0)].concat();
        // Only one part of the first cut is liked.
        let lone_part = |it: &mut RegroupingParams| it.lone_part_margin = 0.5;
        assert_eq!(regrouped(std::slice::from_ref(&row), lone_part), [(4, 118), (4, 118), (4, 118)]);
        let pair = [car.clone(), sides(14.6, 4.0)].concat();
        assert_eq!(regrouped(&[pair], |_| ()), [(4, 118), (4, 118)]);
        assert_eq!(regrouped(&[car], |_| ()), [(4, 118)]);
        assert_eq!(regrouped(&[row], |it| it.enabled = false), [(13, 354)]);
    }

    #[test]
    fn a_car_is_cut_off_what_is_none_if_it_alone_is_liked_well_enough() {
        let with_hedge = [sides(10.0, 4.0), sides(14.6, 7.5)].concat();
        let n_points = with_hedge.len();
        let margin = |margin: f32| move |it: &mut RegroupingParams| it.lone_part_margin = margin;
        assert_eq!(regrouped(std::slice::from_ref(&with_hedge), margin(0.5))[0], (4, 118));
        assert_eq!(regrouped(&[with_hedge], margin(1.0)), [(12, n_points)]);
    }

    #[test]
    fn halves_of_a_car_are_joined_and_cars_are_not() {
        let (front, rear) = (sides(10.0, 1.9), sides(12.1, 1.9));
        let n_points = front.len() + rear.len();
        assert_eq!(regrouped(&[rear.clone(), front.clone()], |_| ()), [(4, n_points)]);
        assert_eq!(regrouped(&[rear.clone(), front.clone()], |it| it.max_gap_m = 0.1).len(), 2);
        assert_eq!(regrouped(&[rear, front], |it| it.max_joined_length_m = 1.5).len(), 2);
        assert_eq!(regrouped(&[sides(10.0, 3.5), sides(13.7, 3.5)], |_| ()).len(), 2);
    }
}
