//! Whether the points of an object are scattered, on lines or on surfaces, judged by the neighbourhoods of points.

use detector::describe::box_frame_points::BoxFramePoints;

use crate::symmetric_eigenvalues::{LANES, SymmetricMatrices, symmetric_eigenvalues};

/// Points within this distance of a point are its neighbours.
pub const RADIUS_M: f32 = 0.25;
/// Most points of an object whose neighbourhoods are used: evenly over the object in the order of the scan.
pub const MOST_SAMPLES: usize = 128;
/// Bins of each histogram, of the same width over 0 to 1.
pub const N_BINS: usize = 4;
/// A neighbourhood of fewer points, the point itself included, always lies in a plane, and so has no shape.
const LEAST_NEIGHBORS: f32 = 4.0;
/// Below this spread, in square metres, all neighbours lie at one position: a tenth of a millimetre.
const LEAST_SPREAD_M2: f32 = 1e-8;
/// Neighbours that are tested side by side. Registers hold ten sums of four each.
const SIDE_BY_SIDE: usize = 4;

/// Histograms over the neighbourhoods of an object: for each bin from 0 to 1, its share of all neighbourhoods used.
///
/// A histogram sums up to less than 1 if some points have too few neighbours for a shape: less by the share of those points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeHistograms {
    /// λ₃ / λ₁.
    pub scatterness: [f32; N_BINS],
    /// (λ₁ − λ₂) / λ₁.
    pub linearness: [f32; N_BINS],
    /// (λ₂ − λ₃) / λ₁.
    pub surfacedness: [f32; N_BINS],
}

/// Buffers for the neighbourhoods of one object after another.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NeighborhoodShapes {
    // The strip of each point, and for each strip where its points begin in `sorted_m`.
    strip_of_point: Vec<u32>,
    starts: Vec<u32>,
    // Coordinates strip by strip, filled up so that whole blocks can be read behind the last.
    sorted_m: [Vec<f32>; 3],
    covariances: Vec<[f32; 6]>,
}

impl NeighborhoodShapes {
    /// The histograms of an object of `length_m` with these points.
    ///
    /// For up to [`MOST_SAMPLES`] points, the covariance of all points within [`RADIUS_M`] has the eigenvalues
    /// λ₁ ≥ λ₂ ≥ λ₃. Scatterness λ₃, linearness λ₁ − λ₂ and surfacedness λ₂ − λ₃ are divided by λ₁, so that they lie in
    /// 0 to 1, sum up to 1, and do not depend on how far the neighbours of this point happen to reach. The object may be
    /// moved and turned about the vertical without changing anything but for rounding.
    ///
    /// Radius, division and number of bins were chosen on simulated training drives, where these classify vehicles best.
    /// A smaller radius holds points of one ring alone, a larger one a whole bonnet with its surroundings.
    ///
    /// Paper: VM sections 1 and 6, \[5\], which takes the three as Lalonde et al. 2006 (\[6\]) and does not divide.
    pub fn describe(&mut self, points: &BoxFramePoints, length_m: f32) -> ShapeHistograms {
        let n_points = points.along_m().len();
        self.sort_into_strips(points, length_m);
        self.covariances.clear();
        let n_samples = n_points.min(MOST_SAMPLES);
        for sample_idx in 0..n_samples {
            let point_idx = sample_idx * n_points / n_samples;
            let center_m = [points.along_m(), points.across_m(), points.up_m()].map(|it| it[point_idx]);
            self.covariances
                .extend(self.covariance_around(center_m, self.strip_of_point[point_idx] as usize));
        }
        histograms(&self.covariances, n_samples)
    }

    /// Puts the points into strips across the object, each as wide as the radius.
    fn sort_into_strips(&mut self, points: &BoxFramePoints, length_m: f32) {
        let Self { strip_of_point, starts, sorted_m, .. } = self;
        let last_strip = (length_m / RADIUS_M) as u32;
        let strip = |along_m: f32| (((along_m + 0.5 * length_m) / RADIUS_M) as u32).min(last_strip);
        strip_of_point.clear();
        strip_of_point.extend(points.along_m().iter().map(|&it| strip(it)));
        // One entry is spent on counting, one on the end of the last strip.
        starts.clear();
        starts.resize(last_strip as usize + 3, 0);
        for &strip in &*strip_of_point {
            starts[strip as usize + 2] += 1;
        }
        for idx in 2..starts.len() {
            starts[idx] += starts[idx - 1];
        }
        for column in &mut *sorted_m {
            column.clear();
            column.resize(strip_of_point.len() + SIDE_BY_SIDE, f32::INFINITY);
        }
        let columns = points.along_m().iter().zip(points.across_m()).zip(points.up_m());
        for (&strip, ((&along_m, &across_m), &up_m)) in strip_of_point.iter().zip(columns) {
            let index = &mut starts[strip as usize + 1];
            for (column, coordinate_m) in sorted_m.iter_mut().zip([along_m, across_m, up_m]) {
                column[*index as usize] = coordinate_m;
            }
            *index += 1;
        }
    }

    /// The covariance of the points around `center_m`, which lies in `strip`; `None` of too few.
    fn covariance_around(&self, center_m: [f32; 3], strip: usize) -> Option<[f32; 6]> {
        let from = self.starts[strip.saturating_sub(1)] as usize;
        let to = self.starts[(strip + 2).min(self.starts.len() - 2)] as usize;
        let [along, across, up] = self.sorted_m.each_ref().map(|column| {
            // A block may hold points beyond `to`. They are farther away than the radius, or infinitely far.
            let n_blocks = (to - from).div_ceil(SIDE_BY_SIDE);
            &column[from..from + n_blocks * SIDE_BY_SIDE]
        });
        let mut sums = [[0.0_f32; SIDE_BY_SIDE]; 10];
        let blocks = along.as_chunks().0.iter().zip(across.as_chunks().0).zip(up.as_chunks().0);
        for ((along, across), up) in blocks {
            add_neighbors(&mut sums, [along, across, up], center_m);
        }
        let [n, x, y, z, xx, yy, zz, xy, xz, yz] = sums.map(|lanes| lanes.iter().sum::<f32>());
        if n < LEAST_NEIGHBORS {
            return None;
        }
        let [x, y, z] = [x, y, z].map(|it| it / n);
        Some([xx / n - x * x, yy / n - y * y, zz / n - z * z, xy / n - x * y, xz / n - x * z, yz / n - y * z])
    }
}

/// Adds the points of a block that lie within the radius of `center_m`: their number, and the first and second moments about
/// it.
#[inline]
fn add_neighbors(
    sums: &mut [[f32; SIDE_BY_SIDE]; 10],
    [along, across, up]: [&[f32; SIDE_BY_SIDE]; 3],
    [center_along, center_across, center_up]: [f32; 3],
) {
    let offset =
        |lane: usize| [along[lane] - center_along, across[lane] - center_across, up[lane] - center_up];
    let is_near: [bool; SIDE_BY_SIDE] = std::array::from_fn(|lane| {
        let [x, y, z] = offset(lane);
        x * x + y * y + z * z <= RADIUS_M * RADIUS_M
    });
    // The sensor sweeps along an object, so that blocks without a neighbour come in long runs.
    if is_near == [false; SIDE_BY_SIDE] {
        return;
    }
    for (lane, is_near) in is_near.into_iter().enumerate() {
        let [x, y, z] = offset(lane);
        let kept = |it: f32| if is_near { it } else { 0.0 };
        let (x, y, z) = (kept(x), kept(y), kept(z));
        let moments = [kept(1.0), x, y, z, x * x, y * y, z * z, x * y, x * z, y * z];
        for (sum, moment) in sums.iter_mut().zip(moments) {
            sum[lane] += moment;
        }
    }
}

fn histograms(covariances: &[[f32; 6]], n_samples: usize) -> ShapeHistograms {
    let mut counts = [[0_u32; N_BINS]; 3];
    for chunk in covariances.chunks(LANES) {
        let matrices: SymmetricMatrices = std::array::from_fn(|value| {
            std::array::from_fn(|lane| chunk.get(lane).map_or(0.0, |covariance| covariance[value]))
        });
        let eigenvalues = symmetric_eigenvalues(&matrices);
        for lane in 0..chunk.len() {
            let [first, second, third] = eigenvalues.map(|it| it[lane]);
            // Rounding may leave a little less than nothing.
            let (second, third) = (second.max(0.0), third.max(0.0));
            if first < LEAST_SPREAD_M2 {
                continue;
            }
            let shares = [third / first, (first - second) / first, (second - third) / first];
            for (bins, share) in counts.iter_mut().zip(shares) {
                bins[((share * N_BINS as f32) as usize).min(N_BINS - 1)] += 1;
            }
        }
    }
    let [scatterness, linearness, surfacedness] =
        counts.map(|bins| bins.map(|count| count as f32 / n_samples.max(1) as f32));
    ShapeHistograms { scatterness, linearness, surfacedness }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::OrientedBox;
    use proptest::prelude::*;

    /// A box of any size around the origin: only its length and turn matter here.
    fn around_origin(yaw_rad: f32, length_m: f32) -> OrientedBox {
        OrientedBox { center_m: [0.0; 3], length_width_height_m: [length_m, 1.0, 1.0], yaw_rad }
    }

    fn shapes_in(positions_m: &[[f32; 3]], bounding_box: &OrientedBox) -> ShapeHistograms {
        let mut points = BoxFramePoints::default();
        points.fill(bounding_box, positions_m.iter().copied());
        NeighborhoodShapes::default().describe(&points, bounding_box.length_width_height_m[0])
    }

    fn shapes(positions_m: &[[f32; 3]]) -> ShapeHistograms {
        shapes_in(positions_m, &around_origin(0.0, 8.0))
    }

    /// Steps of a fifth of the radius, from −4 to 4 radii.
    fn steps() -> impl Iterator<Item = f32> + Clone {
        (-20_i8..=20).map(|step| f32::from(step) * RADIUS_M / 5.0)
    }

    const NOTHING: [f32; N_BINS] = [0.0; N_BINS];
    const ALL_LOW: [f32; N_BINS] = [1.0, 0.0, 0.0, 0.0];
    const ALL_HIGH: [f32; N_BINS] = [0.0, 0.0, 0.0, 1.0];

    #[test]
    fn a_line_is_linear_and_nothing_else() {
        let line: Vec<_> = steps().map(|along| [0.6 * along, 0.8 * along, 0.3]).collect();
        let expected = ShapeHistograms { scatterness: ALL_LOW, linearness: ALL_HIGH, surfacedness: ALL_LOW };
        assert_eq!(shapes(&line), expected);
    }

    #[test]
    fn a_plane_is_a_surface_but_at_its_edges() {
        let wall: Vec<_> = steps().flat_map(|x| steps().map(move |z| [x, 0.5 * x, z])).collect();
        let it = shapes(&wall);
        assert_eq!(it.scatterness, ALL_LOW);
        // At an edge half of the disc is missing: along it the spread is r²/4, across r²/4 − (4r/3π)² = 0.07 r².
        assert!(it.surfacedness[3] > 0.6 && it.surfacedness[0] == 0.0, "{it:?}");
        assert!(it.linearness[0] > 0.6 && it.linearness[3] == 0.0, "{it:?}");
    }

    #[test]
    fn a_ball_is_scattered() {
        // 0.8 radii across, so that all of it is around each of its points.
        let lattice = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
        let inside = |it: &[f32; 3]| it.iter().map(|m| m * m).sum::<f32>() <= 16.0 * RADIUS_M * RADIUS_M;
        let ball: Vec<_> = lattice.filter(inside).map(|it| it.map(|m| 0.1 * m)).collect();
        let expected = ShapeHistograms { scatterness: ALL_HIGH, linearness: ALL_LOW, surfacedness: ALL_LOW };
        assert_eq!(shapes(&ball), expected);
    }

    #[test]
    fn lonely_points_have_no_shape() {
        let nothing = ShapeHistograms { scatterness: NOTHING, linearness: NOTHING, surfacedness: NOTHING };
        assert_eq!(shapes(&[]), nothing);
        assert_eq!(shapes(&[[1.0, 0.0, 0.0]]), nothing);
        assert_eq!(shapes(&[[1.0, 0.0, 0.0]; 100]), nothing, "all at one place");
        let far_apart: Vec<_> = (-3_i8..=3).map(|it| [f32::from(it), 0.0, 0.0]).collect();
        assert_eq!(shapes(&far_apart), nothing);
        // Half of the points on a line, half alone.
        let line = (0_u8..10).map(|it| [0.02 * f32::from(it), 0.0, 0.0]);
        let alone = (0_u8..10).map(|it| [3.0, 2.0 * f32::from(it), 0.0]);
        let half: Vec<_> = line.chain(alone).collect();
        assert_eq!(shapes(&half).linearness, [0.0, 0.0, 0.0, 0.5]);
    }

    #[test]
    fn neighbors_are_found_across_strips_and_beyond_the_box() {
        // Four points around the border of two strips, and the same where the box says that there is nothing.
        for along_m in [0.0, 0.5, 9.0, -9.0] {
            let corner =
                [[-0.1, 0.0], [0.1, 0.0], [-0.1, 0.1], [0.1, 0.1]].map(|[x, z]| [along_m + x, 0.0, z]);
            assert_eq!(shapes(&corner).scatterness, ALL_LOW, "{along_m}");
        }
    }

    #[test]
    fn buffers_of_one_object_do_not_show_in_the_next() {
        let wall: Vec<_> = steps().flat_map(|x| steps().map(move |z| [x, 0.0, z])).collect();
        let line: Vec<_> = steps().map(|along| [along, 0.0, 0.0]).collect();
        let mut reused = NeighborhoodShapes::default();
        let mut points = BoxFramePoints::default();
        for (object, length_m) in [(&wall, 4.0), (&line, 4.1), (&Vec::new(), 0.0), (&wall, 4.0)] {
            let it = around_origin(0.0, length_m);
            points.fill(&it, object.iter().copied());
            assert_eq!(reused.describe(&points, length_m), shapes_in(object, &it));
        }
    }

    fn cloud() -> impl Strategy<Value = Vec<[f32; 3]>> {
        let point = (-2.0_f32..2.0, -1.0_f32..1.0, -0.7_f32..0.7).prop_map(|(x, y, z)| [x, y, z]);
        prop::collection::vec(point, 1..150)
    }

    proptest! {
        #[test]
        fn every_share_is_that_of_all_points_searched(positions_m in cloud()) {
            let found = shapes_in(&positions_m, &around_origin(0.4, 4.0));
            let n_samples = positions_m.len().min(MOST_SAMPLES);
            let has_shape = |sample_idx: &usize| {
                let center = positions_m[sample_idx * positions_m.len() / n_samples];
                let squared = |it: &[f32; 3]| (0..3).map(|axis| (it[axis] - center[axis]).powi(2)).sum::<f32>();
                positions_m.iter().filter(|it| squared(it) <= RADIUS_M * RADIUS_M).count() >= 4
            };
            let expected = (0..n_samples).filter(has_shape).count() as f32 / n_samples as f32;
            for bins in [found.scatterness, found.linearness, found.surfacedness] {
                prop_assert!((bins.iter().sum::<f32>() - expected).abs() < 1e-4, "{found:?} against {expected}");
            }
        }

        #[test]
        fn histograms_do_not_depend_on_position_and_turn(
            positions_m in cloud(), yaw_rad in -3.1_f32..3.1, x in -40.0_f32..40.0, y in -40.0_f32..40.0,
        ) {
            let (sin, cos) = yaw_rad.sin_cos();
            let moved: Vec<_> = positions_m
                .iter()
                .map(|it| [x + cos * it[0] - sin * it[1], y + sin * it[0] + cos * it[1], it[2] - 1.0])
                .collect();
            let here = shapes_in(&positions_m, &around_origin(0.0, 4.0));
            let there_box = OrientedBox { center_m: [x, y, -1.0], ..around_origin(yaw_rad, 4.0) };
            let there = shapes_in(&moved, &there_box);
            let pairs = [
                (here.scatterness, there.scatterness),
                (here.linearness, there.linearness),
                (here.surfacedness, there.surfacedness),
            ];
            // A share that lies on the border of two bins, or a neighbour at exactly the radius, may change sides.
            let most = 1.01 / positions_m.len().min(MOST_SAMPLES) as f32;
            for (here, there) in pairs {
                for (a, b) in here.into_iter().zip(there) {
                    prop_assert!((a - b).abs() <= most, "{here:?} against {there:?}");
                }
            }
        }
    }
}
