//! The points of a file that have a position: one rule for the readers of all formats.
//!
//! A point with a coordinate that is NaN or infinite was not measured. It is left out, and its index in the file is kept, so
//! that values of the file for each point still find their points. A finite coordinate beyond the range of any sensor is
//! damage. An intensity that is not finite becomes 0. Numbers of lasers and times are taken if every point with a position
//! has one.

use std::path::Path;

use detector::PointCloud;

use super::DatasetError;
use crate::annotation::{Annotation, LabeledScan, ScanId};

/// A coordinate farther from the origin than this, in metres, is damage.
pub const MAX_COORDINATE_M: f64 = 10_000.0;

/// No point of a scan is measured more seconds before or after its time.
pub const MAX_TIME_OFFSET_S: f64 = 10.0;

/// Points of a file, taken in its order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PositionedPoints {
    // Invariant: `left_out` ascends and is below `n_in_file`.
    cloud: PointCloud,
    left_out: Vec<u32>,
}

impl PositionedPoints {
    /// No points, with room for `capacity`.
    pub fn with_capacity(capacity: usize) -> Self {
        Self { cloud: PointCloud::with_capacity(capacity), left_out: Vec::new() }
    }

    /// Takes the next point of the file, in metres. Errors are the rest of a sentence about the file.
    ///
    /// # Errors
    ///
    /// If a coordinate is a number beyond [`MAX_COORDINATE_M`].
    pub fn push(&mut self, position_m: [f64; 3], intensity: f32) -> Result<(), String> {
        // False for NaN.
        if position_m.iter().all(|it| it.abs() <= MAX_COORDINATE_M) {
            let intensity = if intensity.is_finite() { intensity } else { 0.0 };
            self.cloud.push(position_m.map(|it| it as f32), intensity);
            return Ok(());
        }
        let point_idx = self.n_in_file();
        if !position_m.iter().all(|it| it.is_finite()) {
            let index = u32::try_from(point_idx).map_err(|_| "has too many points")?;
            self.left_out.push(index);
            return Ok(());
        }
        let too_far = ["x", "y", "z"].into_iter().zip(position_m).find(|(_, it)| it.abs() > MAX_COORDINATE_M);
        let (axis, value_m) = too_far.unwrap_or(("x", position_m[0]));
        let value = if value_m.abs() < 1e9 { format!("{value_m:.3}") } else { format!("{value_m:e}") };
        Err(format!(
            "has point {point_idx} at {axis} = {value} m, beyond {MAX_COORDINATE_M} m from the origin"
        ))
    }

    /// The points in another frame, with intensities in another unit.
    #[must_use]
    pub fn converted(self, point: impl Fn([f32; 3], f32) -> ([f32; 3], f32)) -> Self {
        let mut cloud = PointCloud::with_capacity(self.cloud.len());
        for (position_m, intensity) in self.cloud.positions_m().zip(self.cloud.intensity()) {
            let (position_m, intensity) = point(position_m, *intensity);
            cloud.push(position_m, intensity);
        }
        if let Some(ring) = self.cloud.ring() {
            cloud.set_ring(ring.to_vec());
        }
        if let Some(time_offset_s) = self.cloud.time_offset_s() {
            cloud.set_time_offset_s(time_offset_s.to_vec());
        }
        Self { cloud, left_out: self.left_out }
    }

    /// Number of points that were taken, with and without a position.
    pub fn n_in_file(&self) -> usize {
        self.cloud.len() + self.left_out.len()
    }

    /// The points that have a position.
    pub fn cloud(&self) -> &PointCloud {
        &self.cloud
    }

    /// The values of the points with a position, of values for all points of the file.
    pub fn values_of_kept<T: Copy>(&self, of_all: &[T]) -> Vec<T> {
        values_of_kept(of_all, &self.left_out)
    }

    /// Takes numbers of lasers for all points of the file. If a point with a position has no valid number, none is taken.
    pub fn take_rings(&mut self, of_all: &[f64]) {
        let ring_of = |it: f64| (it.fract() == 0.0 && (0.0..=65535.0).contains(&it)).then_some(it as u16);
        let rings: Option<Vec<u16>> = self.values_of_kept(of_all).into_iter().map(ring_of).collect();
        if let Some(rings) = rings.filter(|it| it.len() == self.cloud.len()) {
            self.cloud.set_ring(rings);
        }
    }

    /// Takes times for all points of the file, in seconds after that of the scan. If a point with a position has no time
    /// within [`MAX_TIME_OFFSET_S`], none is taken.
    pub fn take_time_offsets_s(&mut self, of_all: &[f64]) {
        let offset_of = |it: f64| (it.abs() <= MAX_TIME_OFFSET_S).then_some(it as f32);
        let offsets_s: Option<Vec<f32>> = self.values_of_kept(of_all).into_iter().map(offset_of).collect();
        if let Some(offsets_s) = offsets_s.filter(|it| it.len() == self.cloud.len()) {
            self.cloud.set_time_offset_s(offsets_s);
        }
    }

    /// The cloud, and the indices in the file of the points that are not in it, ascending.
    pub fn into_parts(self) -> (PointCloud, Vec<u32>) {
        (self.cloud, self.left_out)
    }

    /// The scan with these points, with everything labelled.
    pub fn labeled_everywhere(self, id: ScanId, annotations: Vec<Annotation>) -> LabeledScan {
        let (cloud, points_left_out) = self.into_parts();
        LabeledScan { points_left_out, ..LabeledScan::everywhere(id, cloud, annotations) }
    }

    /// The points of a file that states their number, which may be 0. `path` is named in errors.
    ///
    /// # Errors
    ///
    /// If there are points, but none has a position.
    pub fn none_or_some(self, path: &Path) -> Result<Self, DatasetError> {
        if self.left_out.is_empty() { Ok(self) } else { self.not_empty(path) }
    }

    /// The points, which must be some; `path` is named in errors.
    pub fn not_empty(self, path: &Path) -> Result<Self, DatasetError> {
        if !self.cloud.is_empty() {
            return Ok(self);
        }
        Err(match self.left_out.len() {
            0 => DatasetError::damaged(path, "has no points"),
            n => DatasetError::damaged(path, format!("has {n} points, but none with a position")),
        })
    }
}

/// The values of the points that are not at the indices `left_out`, which ascend, of values for all points of a file.
pub fn values_of_kept<T: Copy>(of_all: &[T], left_out: &[u32]) -> Vec<T> {
    let mut left_out = left_out.iter().copied().peekable();
    let kept = (0_u32..).zip(of_all).filter(|(index, _)| left_out.next_if_eq(index).is_none());
    kept.map(|(_, value)| *value).collect()
}

/// For each point of a file, its value of `of_kept`, which has one for each point with a position; `None` at the indices
/// `left_out`.
pub fn values_of_file<T: Copy>(of_kept: &[T], left_out: &[u32]) -> Vec<Option<T>> {
    let mut left_out = left_out.iter().copied().peekable();
    let mut of_kept = of_kept.iter();
    let next = |index: u32| match left_out.next_if_eq(&index) {
        Some(_) => Some(None),
        None => of_kept.next().map(|value| Some(*value)),
    };
    (0..).map_while(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(x_m: &[f64]) -> Result<PositionedPoints, String> {
        let mut points = PositionedPoints::default();
        x_m.iter().try_for_each(|x_m| points.push([1.0, *x_m, 2.0], 0.5))?;
        Ok(points)
    }

    #[test]
    fn points_without_a_position_are_left_out_by_their_indices() {
        let points = points(&[f64::NAN, 1.0, f64::NEG_INFINITY, f64::INFINITY, 2.0]).unwrap();
        assert_eq!((points.n_in_file(), points.cloud().y_m()), (5, &[1.0, 2.0][..]));
        assert_eq!(points.values_of_kept(b"abcde"), b"be");
        let (cloud, left_out) = points.into_parts();
        assert_eq!((cloud.len(), &left_out[..]), (2, &[0, 2, 3][..]));
        assert_eq!(values_of_file(b"be", &left_out), [None, Some(b'b'), None, None, Some(b'e')]);
    }

    #[test]
    fn a_number_that_no_sensor_measures_is_damage_with_its_index_and_value() {
        assert_eq!(points(&[10_000.0, -10_000.0]).unwrap().cloud().len(), 2);
        for (value, shown) in [(10_000.1, "10000.100"), (-1e300, "-1e300")] {
            let problem = points(&[f64::NAN, 0.0, value]).expect_err("too far");
            assert!(problem.starts_with(&format!("has point 2 at y = {shown}")), "{problem}");
            assert!(problem.ends_with("beyond 10000 m from the origin"), "{problem}");
        }
        // A point that was not measured is left out, whatever its other coordinates are.
        let mut points = PositionedPoints::default();
        points.push([f64::NAN, 1e9, 0.0], 0.0).unwrap();
        assert_eq!(points.n_in_file(), 1);
    }

    #[test]
    fn an_intensity_that_is_no_number_becomes_0() {
        let mut points = PositionedPoints::default();
        for intensity in [f32::NAN, f32::INFINITY, 0.25] {
            points.push([0.0; 3], intensity).unwrap();
        }
        assert_eq!(points.cloud().intensity(), [0.0, 0.0, 0.25]);
    }

    #[test]
    fn rings_and_times_are_those_of_the_points_with_a_position_and_of_all_of_them() {
        let with = |rings: &[f64], times_s: &[f64]| {
            let mut points = points(&[1.0, f64::NAN, 2.0]).unwrap();
            points.take_rings(rings);
            points.take_time_offsets_s(times_s);
            let (cloud, _) = points.into_parts();
            (cloud.ring().map(<[u16]>::to_vec), cloud.time_offset_s().map(<[f32]>::to_vec))
        };
        assert_eq!(
            with(&[3.0, f64::NAN, 65535.0], &[-0.5, 1e9, 0.25]),
            (Some(vec![3, 65535]), Some(vec![-0.5, 0.25]))
        );
        for (ring, time_s) in [(1.5, f64::NAN), (-1.0, 11.0), (65536.0, f64::INFINITY), (f64::NAN, -1e300)] {
            assert_eq!(with(&[3.0, 3.0, ring], &[0.0, 0.0, time_s]), (None, None));
        }
        assert_eq!(with(&[3.0], &[]), (None, None));
    }

    #[test]
    fn none_and_none_with_a_position_are_distinguished() {
        let message = |x_m: &[f64]| {
            points(x_m).unwrap().not_empty(Path::new("a.bin")).expect_err("nothing to look at").to_string()
        };
        assert_eq!(message(&[]), "\"a.bin\" has no points");
        assert_eq!(message(&[f64::NAN; 3]), "\"a.bin\" has 3 points, but none with a position");
        let announced = |x_m: &[f64]| points(x_m).unwrap().none_or_some(Path::new("a.pcd"));
        assert_eq!(announced(&[]).unwrap().n_in_file(), 0);
        assert_eq!(announced(&[f64::NAN, 1.0]).unwrap().n_in_file(), 2);
        assert!(announced(&[f64::NAN; 3]).is_err());
    }

    proptest! {
        #[test]
        fn every_point_is_kept_or_left_out(
            has_position in prop::collection::vec(any::<bool>(), 0..100),
        ) {
            let x_m: Vec<f64> =
                (0..).zip(&has_position).map(|(it, has)| if *has { f64::from(it) } else { f64::NAN }).collect();
            let points = points(&x_m).unwrap();
            prop_assert_eq!(points.n_in_file(), x_m.len());
            let kept: Vec<f64> = points.values_of_kept(&x_m);
            prop_assert!(kept.iter().map(|it| *it as f32).eq(points.cloud().y_m().iter().copied()));
            let (_, left_out) = points.into_parts();
            let of_file = values_of_file(&kept, &left_out);
            prop_assert_eq!(of_file.len(), x_m.len());
            for (found, expected) in of_file.iter().zip(&x_m) {
                prop_assert_eq!(found.is_none(), expected.is_nan());
                prop_assert!(found.is_none_or(|it| it == *expected));
            }
        }
    }
}
