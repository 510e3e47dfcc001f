//! Objects with their boxes and their points.

use std::ops::Range;

use crate::detection::{DetectedClass, Detection};
use crate::oriented_box::OrientedBox;
use crate::road_user::{MayBe, RoadUserOdds};

/// The objects of one scan after another, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct FittedObjects {
    /// The objects, in order.
    pub objects: Vec<FittedObject>,
    /// Their points.
    pub members: Members,
    hulls_m: Vec<[f32; 2]>,
    // Values that models look at, object by object.
    values: Vec<f32>,
}

/// An object: indices in the buffers of [`FittedObjects`].
#[derive(Debug, Clone, PartialEq)]
pub struct FittedObject {
    /// Its points among the members.
    pub members: Range<usize>,
    /// The box around them.
    pub bounding_box: OrientedBox,
    /// The classes of road users that it may have by its size.
    pub may_be: MayBe,
    /// How surely it is a road user of each class, once a model has decided.
    pub odds: Option<RoadUserOdds>,
    /// Whether it is kept only if a model classifies it as a road user.
    pub has_low_iou: bool,
    hull: Range<usize>,
    values: Option<Range<usize>>,
}

impl FittedObject {
    /// Its points and its box as a detection without a class; `members` are its points and those of others.
    pub fn detection<'a>(&self, members: &'a Members) -> Detection<'a> {
        let points = members.point_indices(&self.members);
        Detection::new(points, self.bounding_box, DetectedClass::Object, None)
    }
}

impl FittedObjects {
    /// Forgets the objects and keeps the memory.
    pub fn clear(&mut self) {
        self.objects.clear();
        self.members.positions_m.clear();
        self.members.point_indices.clear();
        self.hulls_m.clear();
        self.values.clear();
    }

    /// Adds an object of these points, indices ascending, with its box and the hull that was fitted to.
    pub fn add(
        &mut self,
        points: impl Iterator<Item = (u32, [f32; 3])> + Clone,
        bounding_box: OrientedBox,
        hull_m: &[[f32; 2]],
    ) -> &mut FittedObject {
        let Members { positions_m, point_indices } = &mut self.members;
        let (start, hull_start) = (point_indices.len(), self.hulls_m.len());
        positions_m.extend(points.clone().map(|(_, position_m)| position_m));
        point_indices.extend(points.map(|(point_idx, _)| point_idx));
        self.hulls_m.extend_from_slice(hull_m);
        let (members, hull) = (start..point_indices.len(), hull_start..self.hulls_m.len());
        let (may_be, odds, has_low_iou, values) = (MayBe::ALL, None, false, None);
        self.objects.push(FittedObject { members, bounding_box, may_be, odds, has_low_iou, hull, values });
        self.objects.last_mut().expect("it was pushed")
    }

    /// Records the values of a model, which `describe` returns for each object and the positions of its
    /// points, if any.
    pub fn describe<const N: usize>(
        &mut self,
        mut describe: impl FnMut(&mut FittedObject, &[[f32; 3]]) -> Option<[f32; N]>,
    ) {
        let Self { objects, members, values, .. } = self;
        values.clear();
        for object in objects {
            let start = values.len();
            let positions_m = members.positions_m(&object.members);
            values.extend(describe(object, positions_m).iter().flatten());
            object.values = (values.len() > start).then_some(start..values.len());
        }
    }

    /// Decides about each object by the values that [`Self::describe`] recorded.
    pub fn decide<const N: usize>(&mut self, decide: impl Fn(MayBe, Option<&[f32; N]>) -> RoadUserOdds) {
        for object in &mut self.objects {
            let values = object.values.clone().map(|it| &self.values[it]);
            object.odds = Some(decide(object.may_be, values.and_then(|it| it.as_array())));
        }
    }

    /// The values of all described objects, in their order.
    pub fn values<const N: usize>(&self) -> &[[f32; N]] {
        self.values.as_chunks().0
    }

    /// The described objects, in the order of [`Self::values`].
    pub fn described_mut(&mut self) -> impl Iterator<Item = &mut FittedObject> {
        self.objects.iter_mut().filter(|it| it.values.is_some())
    }

    /// The convex hull of an object on the ground plan, in metres, counter-clockwise.
    pub fn hull_m(&self, object: &FittedObject) -> &[[f32; 2]] {
        &self.hulls_m[object.hull.clone()]
    }
}

/// Lists of points, one behind the other. In each the indices ascend.
#[derive(Debug, Clone, Default)]
pub struct Members {
    // Invariant: the two have the same length.
    positions_m: Vec<[f32; 3]>,
    point_indices: Vec<u32>,
}

impl Members {
    /// Positions of the points of all lists.
    pub fn all_positions_m(&self) -> &[[f32; 3]] {
        &self.positions_m
    }

    /// Positions of the points of a list, in the sensor frame.
    pub fn positions_m(&self, list: &Range<usize>) -> &[[f32; 3]] {
        &self.positions_m[list.clone()]
    }

    /// The indices of these points in the scan, ascending.
    pub fn point_indices(&self, list: &Range<usize>) -> &[u32] {
        &self.point_indices[list.clone()]
    }
}
