//! Blobs taken apart where their dense cells are near-empty (HG section 3.2, Fig. 4).

use std::collections::{BTreeMap, BTreeSet};

use detector::PointCloud;
use detector::portable_math::single;

use super::Params;
use super::cells::{Cell, dense_cell};
use super::density::points_per_cell;
use super::foreground::Foreground;

pub struct Separated {
    /// In the order of their first point.
    pub clusters: Vec<Cluster>,
    pub n_cuts: usize,
}

/// The points of one object.
#[derive(Default)]
pub struct Cluster {
    /// Ascending.
    pub points: Vec<u32>,
    /// The same points by dense cell.
    pub points_of_dense: BTreeMap<Cell, Vec<u32>>,
}

/// A group of dense cells of one coarse cell.
struct Part {
    coarse: Cell,
    occupied: Vec<Cell>,
    points_of_dense: BTreeMap<Cell, Vec<u32>>,
    /// Parts of one object share it.
    object: usize,
}

pub fn separate(
    cloud: &PointCloud,
    foreground: &Foreground,
    links: &[[Cell; 2]],
    params: &Params,
) -> Separated {
    let mut parts = Vec::new();
    for (&coarse, points) in foreground {
        let mut points_of_dense: BTreeMap<Cell, Vec<u32>> = BTreeMap::new();
        for &point_idx in points {
            let dense = dense_cell(coarse, cloud.position_m(point_idx as usize), &params.front_end.grid);
            points_of_dense.entry(dense).or_default().push(point_idx);
        }
        push_parts(coarse, points_of_dense, params, &mut parts);
    }
    for (object, part) in parts.iter_mut().enumerate() {
        part.object = object;
    }
    let mut n_cuts = 0;
    for &[coarse, neighbor] in links {
        // Without separation each coarse cell is one part, and all links hold.
        let steps = if params.of_papers.separation.enabled { max_steps(coarse, params) } else { u32::MAX };
        let touching = touching_parts(&parts, [coarse, neighbor], steps);
        if touching.is_empty() {
            n_cuts += 1;
        }
        for [a, b] in touching {
            let (kept, given_up) = (parts[a].object, parts[b].object);
            for part in parts.iter_mut().filter(|part| part.object == given_up) {
                part.object = kept;
            }
        }
    }
    Separated { clusters: clusters(parts), n_cuts }
}

/// Groups the dense cells of a coarse cell that are not near-empty; a near-empty one joins the nearest group.
fn push_parts(
    coarse: Cell,
    points_of_dense: BTreeMap<Cell, Vec<u32>>,
    params: &Params,
    parts: &mut Vec<Part>,
) {
    let n_points: usize = points_of_dense.values().map(Vec::len).sum();
    let mean = n_points as f32 / points_of_dense.len() as f32;
    let on_objects = params.of_papers.separation.object_density_ratio * points_per_dense_cell(coarse, params);
    let least = (params.of_papers.separation.low_density_share * mean.min(on_objects)).max(1.0);
    let occupied = points_of_dense.iter().filter(|(_, points)| points.len() as f32 >= least);
    let mut left: BTreeSet<Cell> = occupied.map(|(&dense, _)| dense).collect();
    let first_part = parts.len();
    while let Some(seed) = left.pop_first() {
        let mut occupied = vec![seed];
        let mut n_followed = 0;
        while n_followed < occupied.len() {
            let from = occupied[n_followed];
            let max_steps =
                if params.of_papers.separation.enabled { max_steps(coarse, params) } else { u32::MAX };
            occupied.extend(left.extract_if(.., |it| from.steps_to(*it) <= max_steps));
            n_followed += 1;
        }
        parts.push(Part { coarse, occupied, points_of_dense: BTreeMap::new(), object: 0 });
    }
    for (dense, points) in points_of_dense {
        let distance = |part: &&mut Part| part.occupied.iter().map(|it| it.steps_to(dense)).min();
        let nearest =
            parts[first_part..].iter_mut().min_by_key(distance).expect("the fullest is not near-empty");
        nearest.points_of_dense.insert(dense, points);
    }
}

/// Pairs of parts of two coarse cells without a gap between them.
fn touching_parts(parts: &[Part], coarse: [Cell; 2], max_steps: u32) -> Vec<[usize; 2]> {
    let [of_first, of_second] = coarse.map(|coarse| {
        let first = parts.partition_point(|part| part.coarse < coarse);
        first..parts.partition_point(|part| part.coarse <= coarse)
    });
    let pairs = of_first.flat_map(|a| of_second.clone().map(move |b| [a, b]));
    let touch = |&[a, b]: &[usize; 2]| {
        parts[a]
            .occupied
            .iter()
            .any(|it| parts[b].occupied.iter().any(|other| it.steps_to(*other) <= max_steps))
    };
    pairs.filter(touch).collect()
}

/// Up to how many steps between dense cells there is no gap.
fn max_steps(coarse: Cell, params: &Params) -> u32 {
    let share = params.of_papers.separation.single_gap_points / points_per_dense_cell(coarse, params);
    single::cbrt(share).ceil().max(1.0) as u32
}

fn points_per_dense_cell(coarse: Cell, params: &Params) -> f32 {
    points_per_cell(
        coarse,
        params.front_end.grid.cell_size_m / params.front_end.grid.xi as f32,
        &params.front_end,
    )
}

fn clusters(parts: Vec<Part>) -> Vec<Cluster> {
    let mut of_object: BTreeMap<usize, Cluster> = BTreeMap::new();
    for part in parts {
        of_object.entry(part.object).or_default().points_of_dense.extend(part.points_of_dense);
    }
    let mut clusters: Vec<Cluster> = of_object.into_values().collect();
    for cluster in &mut clusters {
        cluster.points = cluster.points_of_dense.values().flatten().copied().collect();
        cluster.points.sort_unstable();
    }
    clusters.sort_by_key(|cluster| cluster.points[0]);
    clusters
}
