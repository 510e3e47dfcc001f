//! The objects on which over- and under-segmentation are measured: connected points of equal labels.

use std::collections::HashMap;

use detector::PointCloud;

use super::label_numbers::{class_number, is_in_no_cluster};

/// Points nearer to each other than this are connected, in metres.
const REACH_M: f32 = 1.0;
/// Fewest points of an object.
const LEAST_POINTS: usize = 10;
/// Most points of an object.
const MOST_POINTS: usize = 300_000;

/// Side of the cells, in metres. All points of a cell are connected: its diagonal in space is less than [`REACH_M`].
const CELL_SIZE_M: f32 = 0.57;
/// A point may be in reach up to so many cells away.
const CELLS_IN_REACH: i32 = 2;

/// Object of every point of `cloud`, numbered from 1 in the order of first points; 0 for none.
///
/// Two points belong to one object if they have the same label, class and instance, and a chain of such points less than 1 m
/// apart connects them. Ground and unlabelled points belong to none. Groups of fewer than 10 points or more than 300,000 are
/// no objects.
///
/// Source: `generateEuclideanClusteringLabels` of `continuous_clustering`, with the values that the makers of TRAVEL gave.
pub fn same_label_clusters(cloud: &PointCloud, labels: &[u32]) -> Vec<u32> {
    let cells = LabelCells::of(cloud, labels);
    let mut root_of_cell: Vec<usize> = (0..cells.points.len()).collect();
    for (idx, (label, position)) in cells.keys.iter().enumerate() {
        for offset in offsets_ahead() {
            let other = [0, 1, 2].map(|axis| position[axis] + offset[axis]);
            let Some(&other) = cells.idx_of.get(&(*label, other)) else { continue };
            let [a, b] = [root(&mut root_of_cell, idx), root(&mut root_of_cell, other)];
            if a != b && are_in_reach(cloud, &cells.points[idx], &cells.points[other]) {
                root_of_cell[a.max(b)] = a.min(b);
            }
        }
    }
    let mut points_of_root: HashMap<usize, usize> = HashMap::new();
    let roots: Vec<usize> = (0..root_of_cell.len()).map(|it| root(&mut root_of_cell, it)).collect();
    for (points, root) in cells.points.iter().zip(&roots) {
        *points_of_root.entry(*root).or_default() += points.len();
    }
    let mut objects = vec![0; labels.len()];
    let (mut number_of_root, mut n_objects) = (HashMap::new(), 0);
    // Roots are the first cells of their objects, and cells are in the order of their first points.
    for (points, root) in cells.points.iter().zip(&roots) {
        if !(LEAST_POINTS..=MOST_POINTS).contains(&points_of_root[root]) {
            continue;
        }
        let number = *number_of_root.entry(*root).or_insert_with(|| {
            n_objects += 1;
            n_objects
        });
        for it in points {
            objects[*it as usize] = number;
        }
    }
    objects
}

/// A label, and a cell's position.
type CellKey = (u32, [i32; 3]);

/// Points that may belong to objects, by label and cell.
struct LabelCells {
    // In the order of first points.
    keys: Vec<CellKey>,
    points: Vec<Vec<u32>>,
    // Only looked up.
    idx_of: HashMap<CellKey, usize>,
}

impl LabelCells {
    fn of(cloud: &PointCloud, labels: &[u32]) -> Self {
        let mut cells = Self { keys: Vec::new(), points: Vec::new(), idx_of: HashMap::new() };
        for ((position_m, &label), point_idx) in cloud.positions_m().zip(labels).zip(0..) {
            if is_in_no_cluster(class_number(label)) {
                continue;
            }
            let key = (label, position_m.map(|it| (it / CELL_SIZE_M).floor() as i32));
            let idx = *cells.idx_of.entry(key).or_insert(cells.keys.len());
            if idx == cells.keys.len() {
                cells.keys.push(key);
                cells.points.push(Vec::new());
            }
            cells.points[idx].push(point_idx);
        }
        cells
    }
}

/// Offsets to the cells in reach, one of every two opposite ones.
fn offsets_ahead() -> impl Iterator<Item = [i32; 3]> {
    let steps = || -CELLS_IN_REACH..=CELLS_IN_REACH;
    let all = steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    all.filter(|it| *it > [0, 0, 0])
}

/// The first cell of the object of cell `idx`, as far as cells are joined yet.
fn root(root_of_cell: &mut [usize], mut idx: usize) -> usize {
    while root_of_cell[idx] != idx {
        root_of_cell[idx] = root_of_cell[root_of_cell[idx]];
        idx = root_of_cell[idx];
    }
    idx
}

fn are_in_reach(cloud: &PointCloud, some: &[u32], others: &[u32]) -> bool {
    some.iter().any(|&a| {
        let a = cloud.position_m(a as usize);
        others.iter().any(|&b| squared_distance_m2(a, cloud.position_m(b as usize)) < REACH_M * REACH_M)
    })
}

/// Squared distance in square metres; in single precision and in this order, as in the maker's program.
fn squared_distance_m2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis]));
    x + y + z
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Rows of points 0.5 m apart along x, each from a position: how many, and their label.
    fn clusters(rows: &[([f32; 3], usize, u32)]) -> Vec<u32> {
        let points = rows
            .iter()
            .flat_map(|&([x, y, z], n, label)| (0..n).map(move |it| ([x + 0.5 * it as f32, y, z], label)));
        let (positions_m, labels): (Vec<[f32; 3]>, Vec<u32>) = points.unzip();
        same_label_clusters(&positions_m.into_iter().collect(), &labels)
    }

    /// Compares the objects of the rows with `expected`, one for each row.
    #[track_caller]
    fn check(rows: &[([f32; 3], usize, u32)], expected: &[u32]) {
        let expected =
            rows.iter().zip(expected).flat_map(|(row, object)| std::iter::repeat_n(*object, row.1));
        assert_eq!(clusters(rows), expected.collect::<Vec<_>>(), "{rows:?}");
    }

    const BUILDING: u32 = 50;

    #[test]
    fn less_than_a_metre_apart_is_one_object_and_a_metre_is_two() {
        check(&[([0.0; 3], 10, BUILDING), ([0.0, 0.99, 0.0], 10, BUILDING)], &[1, 1]);
        check(&[([0.0; 3], 10, BUILDING), ([0.0, 1.0, 0.0], 10, BUILDING)], &[1, 2]);
        check(&[([0.0; 3], 10, BUILDING), ([0.0, 0.0, -1.0], 10, BUILDING)], &[1, 2]);
    }

    #[test]
    fn another_class_or_instance_is_another_object() {
        check(&[([0.0; 3], 10, 10 + (1 << 16)), ([0.0, 0.5, 0.0], 10, 10 + (2 << 16))], &[1, 2]);
        check(&[([0.0; 3], 10, 10 + (1 << 16)), ([0.0, 0.5, 0.0], 10, 252 + (1 << 16))], &[1, 2]);
    }

    #[test]
    fn nine_points_ground_and_unlabelled_points_are_no_object() {
        check(&[([0.0; 3], 9, BUILDING), ([0.0, 5.0, 0.0], 10, BUILDING)], &[0, 1]);
        check(&[([0.0; 3], 50, 40), ([0.0, 0.5, 0.0], 50, 0), ([0.0, 0.6, 0.0], 50, 1)], &[0, 0, 1]);
    }

    /// The objects by comparing all pairs of points.
    fn slow_clusters(cloud: &PointCloud, labels: &[u32]) -> Vec<u32> {
        let n = labels.len();
        let mut objects = vec![0; n];
        let mut n_objects = 0;
        let mut is_seen = vec![false; n];
        for start in 0..n {
            if is_seen[start] || is_in_no_cluster(class_number(labels[start])) {
                continue;
            }
            let (mut members, mut next) = (vec![start], 0);
            is_seen[start] = true;
            while let Some(&a) = members.get(next) {
                next += 1;
                for b in 0..n {
                    let squared_m2 = squared_distance_m2(cloud.position_m(a), cloud.position_m(b));
                    if !is_seen[b] && labels[a] == labels[b] && squared_m2 < 1.0 {
                        is_seen[b] = true;
                        members.push(b);
                    }
                }
            }
            if members.len() >= LEAST_POINTS {
                n_objects += 1;
                for it in members {
                    objects[it] = n_objects;
                }
            }
        }
        objects
    }

    proptest! {
        #[test]
        fn cells_find_what_a_look_at_all_pairs_finds(
            points in prop::collection::vec(
                (prop::array::uniform3(-4.0_f32..4.0), prop::sample::select(vec![0_u32, 1, 10, 50, 70])), 0..200,
            ),
        ) {
            let (positions_m, labels): (Vec<[f32; 3]>, Vec<u32>) = points.into_iter().unzip();
            let cloud: PointCloud = positions_m.into_iter().collect();
            prop_assert_eq!(same_label_clusters(&cloud, &labels), slow_clusters(&cloud, &labels));
        }
    }
}
