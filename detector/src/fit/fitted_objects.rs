//! Objects with their boxes and their points.

use std::ops::Range;

use crate::detection::{DetectedClass, Detection};
use crate::oriented_box::OrientedBox;

/// The objects of one scan after another, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct FittedObjects {
    /// The objects, in order.
    pub objects: Vec<FittedObject>,
    /// Their points.
    pub members: Members,
    hulls_m: Vec<[f32; 2]>,
    // What models look at, object by object.
    values: Vec<f32>,
}

/// An object: places in the buffers of [`FittedObjects`].
#[derive(Debug, Clone, PartialEq)]
pub struct FittedObject {
    /// Its points among the members.
    pub members: Range<usize>,
    /// The box around them.
    pub bounding_box: OrientedBox,
    /// How surely it is a vehicle, once that was asked.
    pub decision: Option<f32>,
    /// Whether it is one only if it is told a vehicle.
    pub is_doubtful: bool,
    hull: Range<usize>,
    values: Option<Range<usize>>,
}

impl FittedObject {
    /// Whether a model takes it for a vehicle.
    pub fn is_told_vehicle(&self) -> bool {
        self.decision.is_some_and(|it| it > 0.0)
    }

    /// What is reported of it, where `members` are its points and those of others.
    pub fn detection<'a>(&self, members: &'a Members, class: DetectedClass) -> Detection<'a> {
        Detection::new(members.point_indices(&self.members), self.bounding_box, class, self.decision)
    }
}

impl FittedObjects {
    /// Forgets the objects and keeps the memory.
    pub fn clear(&mut self) {
        self.objects.clear();
        self.members.clear();
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
        let (start, hull_start) = (self.members.len(), self.hulls_m.len());
        self.members.extend(points);
        self.hulls_m.extend_from_slice(hull_m);
        let (members, hull) = (start..self.members.len(), hull_start..self.hulls_m.len());
        let (decision, is_doubtful, values) = (None, false, None);
        self.objects.push(FittedObject { members, bounding_box, decision, is_doubtful, hull, values });
        self.objects.last_mut().expect("it was pushed")
    }

    /// Notes what a model looks at: the values that `describe` finds for the box and the positions of each object, if any.
    pub fn describe<const N: usize>(
        &mut self,
        mut describe: impl FnMut(&OrientedBox, &[[f32; 3]]) -> Option<[f32; N]>,
    ) {
        let Self { objects, members, values, .. } = self;
        values.clear();
        for object in objects {
            let start = values.len();
            values.extend(
                describe(&object.bounding_box, members.positions_m(&object.members)).iter().flatten(),
            );
            object.values = (values.len() > start).then_some(start..values.len());
        }
    }

    /// Decides about each object by the values that [`Self::describe`] noted.
    pub fn decide<const N: usize>(&mut self, decide: impl Fn(Option<&[f32; N]>) -> f32) {
        for object in &mut self.objects {
            let values = object.values.clone().map(|it| &self.values[it]);
            object.decision = Some(decide(values.and_then(|it| it.as_array())));
        }
    }

    /// The values of all described objects, in their order.
    pub fn values<const N: usize>(&self) -> &[[f32; N]] {
        self.values.as_chunks().0
    }

    /// Takes a decision for each of [`Self::values`].
    pub fn take_decisions(&mut self, decisions: &[f32]) {
        let described = self.objects.iter_mut().filter(|it| it.values.is_some());
        for (object, &decision) in described.zip(decisions) {
            object.decision = Some(decision);
        }
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
    // While a list is parted.
    behind: Vec<([f32; 3], u32)>,
}

impl Members {
    fn clear(&mut self) {
        self.positions_m.clear();
        self.point_indices.clear();
    }

    /// Number of points in all lists: where the next list begins.
    pub fn len(&self) -> usize {
        self.point_indices.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.point_indices.is_empty()
    }

    /// Adds a point at the end.
    pub fn push(&mut self, point_idx: u32, position_m: [f32; 3]) {
        self.positions_m.push(position_m);
        self.point_indices.push(point_idx);
    }

    /// Adds points at the end.
    pub fn extend(&mut self, points: impl Iterator<Item = (u32, [f32; 3])> + Clone) {
        self.positions_m.extend(points.clone().map(|(_, position_m)| position_m));
        self.point_indices.extend(points.map(|(point_idx, _)| point_idx));
    }

    /// Where the points of a list are, in the sensor frame.
    pub fn positions_m(&self, list: &Range<usize>) -> &[[f32; 3]] {
        &self.positions_m[list.clone()]
    }

    /// The indices of these points in the scan, ascending.
    pub fn point_indices(&self, list: &Range<usize>) -> &[u32] {
        &self.point_indices[list.clone()]
    }

    /// Makes two lists of one: of the points for which `is_first` holds, and of the others.
    pub fn part(&mut self, list: &Range<usize>, is_first: impl Fn([f32; 3]) -> bool) -> [Range<usize>; 2] {
        self.behind.clear();
        let mut middle = list.start;
        for idx in list.clone() {
            let (position_m, point_idx) = (self.positions_m[idx], self.point_indices[idx]);
            if is_first(position_m) {
                self.positions_m[middle] = position_m;
                self.point_indices[middle] = point_idx;
                middle += 1;
            } else {
                self.behind.push((position_m, point_idx));
            }
        }
        for (idx, &(position_m, point_idx)) in (middle..).zip(&self.behind) {
            self.positions_m[idx] = position_m;
            self.point_indices[idx] = point_idx;
        }
        [list.start..middle, middle..list.end]
    }

    /// A list of the points of two, at the end.
    pub fn joined(&mut self, [a, b]: [&Range<usize>; 2]) -> Range<usize> {
        let start = self.len();
        let (mut next_a, mut next_b) = (a.start, b.start);
        while next_a < a.end || next_b < b.end {
            let is_a =
                next_b == b.end || next_a < a.end && self.point_indices[next_a] < self.point_indices[next_b];
            let next = if is_a { &mut next_a } else { &mut next_b };
            self.push(self.point_indices[*next], self.positions_m[*next]);
            *next += 1;
        }
        start..self.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn parting_and_joining_keeps_points_and_their_order(is_first in prop::collection::vec(any::<bool>(), 0..50)) {
            let mut members = Members::default();
            members.push(7, [9.0; 3]);
            for (point_idx, &is_first) in (20..).zip(&is_first) {
                members.push(point_idx, [f32::from(u8::from(is_first)), point_idx as f32, 0.0]);
            }
            let list = 1..members.len();
            let [first, second] = members.part(&list, |[x, ..]| x == 1.0);
            for (list, expected) in [(&first, true), (&second, false)] {
                let indices = members.point_indices(list);
                prop_assert!(indices.windows(2).all(|pair| pair[0] < pair[1]));
                prop_assert!(indices.iter().all(|&it| is_first[it as usize - 20] == expected));
                let positions_m = members.positions_m(list);
                prop_assert!(indices.iter().zip(positions_m).all(|(&it, [_, y, _])| it as f32 == *y));
            }
            let both = members.joined([&second, &first]);
            prop_assert!(members.point_indices(&both).iter().copied().eq(20..20 + is_first.len() as u32));
            prop_assert!(members.positions_m(&both).iter().all(|[_, y, _]| *y >= 20.0));
            prop_assert_eq!(members.point_indices(&(0..1)), &[7]);
        }
    }
}
