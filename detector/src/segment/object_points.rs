//! The foreground points, object by object.

use std::ops::Range;

use crate::point_cloud::PointCloud;
use crate::segment::dense_level::DenseLevel;
use crate::segment::dense_separation::NO_OBJECT;

/// Copies of the foreground points in the order of their objects, so that later stages read them from memory one after the
/// other.
///
/// Objects are numbered anew, in the order of their first points.
#[derive(Debug, Clone, Default)]
pub struct ObjectPoints {
    // By the object's old number: its points, its first point, and where its next point goes.
    n_points: Vec<u32>,
    first_idx: Vec<u32>,
    next_free: Vec<u32>,
    in_order: Vec<u32>,
    // Invariant: ascending, one longer than there are objects, the last is the length of the two below.
    starts: Vec<u32>,
    points: Vec<ObjectPoint>,
    point_indices: Vec<u32>,
}

/// A point of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectPoint {
    /// Its position in metres.
    pub position_m: [f32; 3],
    /// Its dense cell.
    pub dense_idx: u32,
}

impl ObjectPoints {
    /// Replaces the content by the points `point_indices` of `cloud`, which `dense` was filled with, in the order of their
    /// objects. `object_of_dense` is the object of every dense cell, a number below `n_objects`.
    pub fn fill(
        &mut self,
        cloud: &PointCloud,
        point_indices: &[u32],
        dense: &DenseLevel,
        object_of_dense: &[u32],
        n_objects: usize,
    ) {
        self.order_objects(dense, object_of_dense, n_objects);
        let nowhere = ObjectPoint { position_m: [0.0; 3], dense_idx: 0 };
        self.points.resize(point_indices.len(), nowhere);
        self.point_indices.resize(point_indices.len(), 0);
        let (x_m, y_m, z_m) = (cloud.x_m(), cloud.y_m(), cloud.z_m());
        let (points, sorted, next_free) =
            (&mut self.points[..], &mut self.point_indices[..], &mut self.next_free[..]);
        // A sensor that sweeps stays on an object for a while: its index is kept at hand.
        let mut object = 0;
        let mut index = next_free.first().copied().unwrap_or(0);
        for (&point_idx, &dense_idx) in point_indices.iter().zip(dense.dense_of_point()) {
            let next_object = object_of_dense[dense_idx as usize] as usize;
            if next_object != object {
                next_free[object] = index;
                object = next_object;
                index = next_free[object];
            }
            sorted[index as usize] = point_idx;
            let point_idx = point_idx as usize;
            let position_m = [x_m[point_idx], y_m[point_idx], z_m[point_idx]];
            points[index as usize] = ObjectPoint { position_m, dense_idx };
            index += 1;
        }
    }

    /// Finds where each object's points go, from the dense cells alone.
    fn order_objects(&mut self, dense: &DenseLevel, object_of_dense: &[u32], n_objects: usize) {
        self.n_points.clear();
        self.n_points.resize(n_objects, 0);
        self.first_idx.clear();
        self.first_idx.resize(n_objects, u32::MAX);
        for (dense_idx, (&object, &n_points)) in object_of_dense.iter().zip(dense.n_points()).enumerate() {
            if object != NO_OBJECT {
                self.n_points[object as usize] += n_points;
                let first_idx = &mut self.first_idx[object as usize];
                *first_idx = dense.first_idx(dense_idx).min(*first_idx);
            }
        }
        let (n_points, first_idx) = (&self.n_points, &self.first_idx);
        self.in_order.clear();
        self.in_order.extend((0..n_objects as u32).filter(|&object| n_points[object as usize] > 0));
        self.in_order.sort_unstable_by_key(|&object| first_idx[object as usize]);
        self.next_free.resize(n_objects, 0);
        self.starts.clear();
        let mut start = 0;
        for &object in &self.in_order {
            self.starts.push(start);
            self.next_free[object as usize] = start;
            start += n_points[object as usize];
        }
        self.starts.push(start);
    }

    /// Number of objects.
    pub fn n_objects(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The points of object `object_idx`, in scan order.
    pub fn points(&self, object_idx: usize) -> &[ObjectPoint] {
        &self.points[self.range(object_idx)]
    }

    /// The indices of these points in the scan, ascending.
    pub fn point_indices(&self, object_idx: usize) -> &[u32] {
        &self.point_indices[self.range(object_idx)]
    }

    fn range(&self, object_idx: usize) -> Range<usize> {
        self.starts[object_idx] as usize..self.starts[object_idx + 1] as usize
    }
}
