//! Connected components of points, found by searching a kd-tree around every point.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// Buffers of [`kd_tree_components`] for one scan after another.
///
/// The tree itself is not among them: it is immutable, and its library builds a new one for every scan.
#[derive(Debug, Clone, Default)]
pub struct KdTreeScratch {
    // The finite points with their numbers, as the tree wants them.
    entries: Vec<(u32, [f32; 3])>,
    // Points of the growing component, in the order in which they were reached.
    reached: Vec<u32>,
    // Points whose surroundings are known.
    is_searched: Vec<bool>,
}

/// Label of points that no component has reached yet.
const NO_LABEL: u32 = u32::MAX;

/// The tree adds up its distances to branches step by step; a search this much wider, in squared distance, makes sure
/// that rounding there cannot hide a point that is near enough by the exact test.
const SEARCH_MARGIN: f32 = 1.000_01;

/// Writes to `labels`, for every point, the smallest index of a point of its component.
///
/// Two points are neighbours if their squared distance is strictly below the squared tolerance, both computed in f32, x
/// before y before z. Chains of neighbours connect the points of a component, which may be a single point. A point that is
/// not finite has no neighbours, and a tolerance that is not positive connects nothing.
///
/// Components grow as in PCL's Euclidean cluster extraction: every point is looked up in the tree once, except that
/// points at the very same position share one look-up. The cost follows the number of pairs of neighbours.
///
/// Paper: HG section 5, "connected component analysis".
///
/// ```
/// use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
///
/// let positions_m = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.6, 0.0, 0.0]];
/// let (mut scratch, mut labels) = (KdTreeScratch::default(), Vec::new());
/// kd_tree_components(&positions_m, 0.5, &mut scratch, &mut labels);
/// assert_eq!(labels, [0, 1, 0, 0]);
/// ```
pub fn kd_tree_components(
    positions_m: &[[f32; 3]],
    tolerance_m: f32,
    scratch: &mut KdTreeScratch,
    labels: &mut Vec<u32>,
) {
    labels.clear();
    if tolerance_m.is_nan() || tolerance_m <= 0.0 {
        labels.extend(0..positions_m.len() as u32);
        return;
    }
    labels.resize(positions_m.len(), NO_LABEL);
    scratch.is_searched.clear();
    scratch.is_searched.resize(positions_m.len(), false);
    scratch.entries.clear();
    let finite = (0..).zip(positions_m).filter(|(_, position_m)| is_finite(position_m));
    scratch.entries.extend(finite.map(|(point_idx, &position_m)| (point_idx, position_m)));
    let tree = ImmutableKdTree::new_from_entries(&scratch.entries)
        .expect("points bring their own numbers, so that these cannot overflow");
    let neighborhoods = Neighborhoods { tree, positions_m, squared_tolerance_m2: tolerance_m * tolerance_m };
    for (seed_idx, seed_m) in (0..).zip(positions_m) {
        if labels[seed_idx as usize] != NO_LABEL {
            continue;
        }
        labels[seed_idx as usize] = seed_idx;
        if is_finite(seed_m) {
            neighborhoods.grow(seed_idx, scratch, labels);
        }
    }
}

struct Neighborhoods<'a> {
    tree: ImmutableKdTree<f32, 3>,
    positions_m: &'a [[f32; 3]],
    squared_tolerance_m2: f32,
}

impl Neighborhoods<'_> {
    /// Labels all points that chains of neighbours connect with `seed_idx`.
    fn grow(&self, seed_idx: u32, scratch: &mut KdTreeScratch, labels: &mut [u32]) {
        let KdTreeScratch { reached, is_searched, .. } = scratch;
        reached.clear();
        reached.push(seed_idx);
        let mut n_searched = 0;
        while let Some(&point_idx) = reached.get(n_searched) {
            n_searched += 1;
            if is_searched[point_idx as usize] {
                continue;
            }
            let position_m = &self.positions_m[point_idx as usize];
            let radius_m2 = self.squared_tolerance_m2 * SEARCH_MARGIN;
            let search = self.tree.query(position_m).within::<SquaredEuclidean<f32>>(radius_m2).unsorted();
            search.visit(|found| {
                let found_idx = found.item as usize;
                let found_m = &self.positions_m[found_idx];
                if found.distance == 0.0 && is_same_position(position_m, found_m) {
                    is_searched[found_idx] = true;
                }
                if labels[found_idx] == NO_LABEL
                    && squared_distance_m2(position_m, found_m) < self.squared_tolerance_m2
                {
                    labels[found_idx] = seed_idx;
                    reached.push(found.item);
                }
            });
        }
    }
}

fn is_finite(position_m: &[f32; 3]) -> bool {
    position_m.iter().all(|coordinate_m| coordinate_m.is_finite())
}

/// Compares coordinates: squared distances of very near points round to 0.
#[expect(clippy::float_cmp, reason = "only points with the very same neighbours may share a search")]
fn is_same_position(a: &[f32; 3], b: &[f32; 3]) -> bool {
    a == b
}

fn squared_distance_m2(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    let [dx, dy, dz] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dx * dx + dy * dy + dz * dz
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use test_data::test_data;

    fn labels_of(positions_m: &[[f32; 3]], tolerance_m: f32) -> Vec<u32> {
        let mut labels = Vec::new();
        kd_tree_components(positions_m, tolerance_m, &mut KdTreeScratch::default(), &mut labels);
        labels
    }

    /// Labels found by comparing every point with every other, until nothing changes.
    fn labels_by_brute_force(positions_m: &[[f32; 3]], tolerance_m: f32) -> Vec<u32> {
        let n = positions_m.len();
        let mut labels: Vec<u32> = (0..n as u32).collect();
        loop {
            let before = labels.clone();
            for (a, b) in (0..n).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let [dx, dy, dz] = [0, 1, 2].map(|axis| positions_m[a][axis] - positions_m[b][axis]);
                if dx * dx + dy * dy + dz * dz < tolerance_m * tolerance_m {
                    let smaller = labels[a].min(labels[b]);
                    (labels[a], labels[b]) = (smaller, smaller);
                }
            }
            if labels == before {
                return labels;
            }
        }
    }

    #[track_caller]
    fn check(positions_m: &[[f32; 3]], tolerance_m: f32, expected: &[u32]) {
        assert_eq!(labels_of(positions_m, tolerance_m), expected);
    }

    #[test]
    fn no_points_have_no_labels() {
        check(&[], 0.5, &[]);
    }

    #[test]
    fn one_point_is_its_own_component() {
        check(&[[1.0, 2.0, 3.0]], 0.5, &[0]);
    }

    #[test]
    fn points_exactly_the_tolerance_apart_are_not_neighbors() {
        check(&[[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.3, 0.4]], 0.5, &[0, 1, 2]);
    }

    #[test]
    fn points_a_rounding_step_nearer_than_the_tolerance_are_neighbors() {
        check(&[[0.0; 3], [0.5_f32.next_down(), 0.0, 0.0]], 0.5, &[0, 0]);
    }

    #[test]
    fn a_chain_is_one_component_named_after_its_smallest_index() {
        check(&[[9.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.0; 3], [0.4, 0.0, 0.0]], 0.5, &[0, 1, 1, 1]);
    }

    #[test]
    fn points_that_are_not_finite_have_no_neighbors() {
        let nan = [f32::NAN, 0.0, 0.0];
        let infinite = [0.0, f32::INFINITY, 0.0];
        check(&[nan, [0.0; 3], infinite, [0.1, 0.0, 0.0], nan, infinite], 0.5, &[0, 1, 2, 1, 4, 5]);
    }

    #[test]
    fn points_that_are_all_not_finite_stay_alone() {
        check(&[[f32::NAN; 3], [f32::NEG_INFINITY; 3]], 0.5, &[0, 1]);
    }

    #[test]
    fn points_at_the_far_end_of_the_number_range_stay_alone() {
        check(&[[f32::MAX; 3], [0.0; 3], [f32::MIN; 3], [0.1, 0.0, 0.0]], 0.5, &[0, 1, 2, 1]);
    }

    #[test]
    fn a_tolerance_that_is_not_positive_connects_nothing() {
        for tolerance_m in [0.0, -0.5, f32::NAN] {
            check(&[[0.0; 3], [0.0; 3], [0.1, 0.0, 0.0]], tolerance_m, &[0, 1, 2]);
        }
    }

    #[test]
    fn very_many_points_at_one_position_are_one_component() {
        let mut positions_m = vec![[3.0, -1.0, 0.5]; 60_000];
        positions_m[59_999] = [3.4, -1.0, 0.5];
        check(&positions_m, 0.5, &vec![0; 60_000]);
    }

    #[test]
    fn a_second_scan_forgets_the_first() {
        let mut scratch = KdTreeScratch::default();
        let mut labels = Vec::new();
        kd_tree_components(&[[0.0; 3]; 9], 0.5, &mut scratch, &mut labels);
        kd_tree_components(&[[0.0; 3], [7.0; 3], [0.1; 3]], 0.5, &mut scratch, &mut labels);
        assert_eq!(labels, [0, 1, 0]);
    }

    /// Coordinates on a lattice, so that duplicates and ties are frequent, some of them not finite.
    fn lattice_coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![
            40 => (-6_i32..6).prop_map(|step| step as f32 * 0.25),
            1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)],
        ]
    }

    proptest! {
        #[test]
        fn scattered_points_fall_apart_as_by_brute_force(
            positions_m in prop::collection::vec(prop::array::uniform3(-3.0_f32..3.0), 0..150),
            tolerance_m in 0.1_f32..1.5,
        ) {
            prop_assert_eq!(labels_of(&positions_m, tolerance_m), labels_by_brute_force(&positions_m, tolerance_m));
        }

        #[test]
        fn points_on_a_lattice_fall_apart_as_by_brute_force(
            positions_m in prop::collection::vec(prop::array::uniform3(lattice_coordinate()), 0..150),
            n_steps in 1_u32..4,
        ) {
            let tolerance_m = n_steps as f32 * 0.25;
            prop_assert_eq!(labels_of(&positions_m, tolerance_m), labels_by_brute_force(&positions_m, tolerance_m));
        }
    }

    /// Little-endian words of a file of PCL's run.
    fn words_of(name: &str) -> Vec<u32> {
        let bytes = std::fs::read(test_data("oracle").join(name)).unwrap();
        bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect()
    }

    /// Compares with the components that PCL found, component by component named after the smallest index.
    #[track_caller]
    fn check_against_pcl(scan: &str) {
        let words = words_of(&format!("{scan}_fg.bin"));
        let points = words.chunks_exact(4);
        let positions_m: Vec<_> = points.map(|it| [it[0], it[1], it[2]].map(f32::from_bits)).collect();
        for (tolerance, tolerance_m) in [("0.3", 0.3), ("0.5", 0.5), ("0.7", 0.7)] {
            let expected = words_of(&format!("{scan}_labels_tol{tolerance}.u32"));
            assert!(labels_of(&positions_m, tolerance_m) == expected, "{scan} at {tolerance} m");
        }
    }

    #[test]
    #[ignore = "needs oracle/obj_000001_fg.bin in SCANBENCH_TEST_DATA"]
    fn the_foreground_of_kitti_object_000001_falls_apart_as_in_pcl() {
        check_against_pcl("obj_000001");
    }

    #[test]
    #[ignore = "needs oracle/sk00_000000_fg.bin in SCANBENCH_TEST_DATA"]
    fn the_foreground_of_semantic_kitti_00_000000_falls_apart_as_in_pcl() {
        check_against_pcl("sk00_000000");
    }
}
