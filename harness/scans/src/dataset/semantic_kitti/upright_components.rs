//! Poles and signs, which labels do not separate from each other.

use std::collections::BTreeMap;

use detector::PointCloud;

/// Side of the cells that connect points, in metres on the ground plan.
///
/// Two points less than 0.3 m apart always belong together; two points without any between them and more than 0.85 m apart
/// (the diagonal of two cells) never do.
const CELL_SIZE_M: f32 = 0.3;

/// Groups `point_indices` of `cloud` into upright objects, each ascending, in the order of their first points.
///
/// Heights are ignored: the rings of a sensor meet a pole far apart from each other.
pub fn upright_components(cloud: &PointCloud, point_indices: &[u32]) -> Vec<Vec<u32>> {
    let mut points_by_cell: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
    for &point_idx in point_indices {
        let [x_m, y_m, _] = cloud.position_m(point_idx as usize);
        let cell = [x_m, y_m].map(|it| (it / CELL_SIZE_M).floor() as i64);
        points_by_cell.entry(cell).or_default().push(point_idx);
    }
    let mut components = Vec::new();
    while let Some((cell, points)) = points_by_cell.pop_first() {
        let (mut component, mut open) = (points, vec![cell]);
        while let Some([x, y]) = open.pop() {
            for neighbor in (x.saturating_sub(1)..=x.saturating_add(1))
                .flat_map(|x| [[x, y.saturating_sub(1)], [x, y], [x, y.saturating_add(1)]])
            {
                if let Some(points) = points_by_cell.remove(&neighbor) {
                    component.extend(points);
                    open.push(neighbor);
                }
            }
        }
        component.sort_unstable();
        components.push(component);
    }
    components.sort_unstable_by_key(|component| component[0]);
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(positions_m: &[[f32; 3]], expected: &[&[u32]]) {
        let cloud: PointCloud = positions_m.iter().copied().collect();
        let all: Vec<u32> = (0..positions_m.len() as u32).collect();
        assert_eq!(upright_components(&cloud, &all), expected);
    }

    #[test]
    fn what_stands_above_each_other_is_one() {
        check(&[[5.0, 1.0, -1.0], [5.05, 1.0, 2.0], [5.2, 1.1, 5.0]], &[&[0, 1, 2]]);
    }

    #[test]
    fn an_arm_belongs_to_its_pole() {
        check(&[[0.0, 0.0, 0.0], [0.0, 0.25, 4.0], [0.0, 0.5, 4.0], [0.0, 0.75, 4.0]], &[&[0, 1, 2, 3]]);
    }

    #[test]
    fn what_stands_a_metre_apart_is_two() {
        check(&[[7.0, 1.0, 0.0], [5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [7.1, 1.0, 2.0]], &[&[0, 3], &[1], &[2]]);
    }
}
