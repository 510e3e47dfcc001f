//! Labels, graphs, patterns, and how often each occurs.

use std::collections::BTreeMap;

use detector::partial::bag::{CountScaling, RarePatterns};
use detector::partial::labels::Labeler;
use detector::partial::partial_model::PartialModel;
use detector::partial::patterns::{Pattern, PatternKind};

use super::points::vector;
use super::surfaces::axes;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    pub position_m: [f64; 3],
    pub label: u8,
}

pub fn label(labeler: &Labeler, descriptor: &[f64; 12]) -> u8 {
    let distance = |center: &[f64; 12]| -> f64 {
        (0..12).map(|it| (descriptor[it] / labeler.units[it] - center[it]).powi(2)).sum()
    };
    let distances: Vec<f64> = labeler.centers.iter().map(distance).collect();
    (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b])).expect("there are labels")
        as u8
}

/// Every vertex with its three nearest.
pub fn graphs(vertices: &[Vertex]) -> Vec<Vec<usize>> {
    let of_center = |center: usize| {
        let squared = |it: &usize| {
            (vector(vertices[*it].position_m) - vector(vertices[center].position_m)).norm_squared()
        };
        let mut others: Vec<usize> = (0..vertices.len()).filter(|&it| it != center).collect();
        others.sort_by(|a, b| squared(a).total_cmp(&squared(b)));
        [center].into_iter().chain(others.into_iter().take(3)).collect()
    };
    (0..vertices.len()).map(of_center).collect()
}

pub fn strips_m(vertices: &[Vertex], graphs: &[Vec<usize>]) -> Vec<Vec<[f32; 3]>> {
    let position = |it: usize| vertices[it].position_m.map(|value| value as f32);
    let strip = |graph: &Vec<usize>| {
        let mut strip = vec![position(graph[0])];
        for &it in &graph[1..] {
            strip.extend([position(it), position(graph[0])]);
        }
        strip
    };
    graphs.iter().map(strip).collect()
}

/// The numbers of all patterns of the vocabulary that occur.
pub fn bag(
    vertices: &[Vertex],
    graphs: &[Vec<usize>],
    points_m: &[[f64; 3]],
    all_points_m: &[[f64; 3]],
    model: &PartialModel,
) -> BTreeMap<Pattern, f64> {
    let params = &model.params;
    let mut bag = BTreeMap::new();
    if params.patterns.kinds.contains(&PatternKind::Extents) {
        count_extents(points_m, model, &mut bag);
    }
    if params.patterns.kinds.contains(&PatternKind::ShapeStatistics) {
        count_shape_statistics(all_points_m, model, &mut bag);
    }
    let of_graphs = |it: &&PatternKind| !matches!(it, PatternKind::Extents | PatternKind::ShapeStatistics);
    for &kind in params.patterns.kinds.iter().filter(of_graphs) {
        for graph in graphs {
            let mut pattern = Some(pattern(vertices, graph, kind, model));
            while let Some(it) = pattern.filter(|it| model.vocabulary.patterns().binary_search(it).is_err()) {
                pattern = match params.bag.rare {
                    RarePatterns::Dropped => None,
                    RarePatterns::Merged => it.coarser(),
                };
            }
            if let Some(it) = pattern {
                *bag.entry(it).or_insert(0.0) += 1.0;
            }
        }
    }
    for (pattern, count) in &mut bag {
        let n = match pattern.kind_number() {
            3 => 4.0,
            4 => 54.0,
            _ => graphs.len() as f64,
        };
        *count = match params.bag.counts {
            CountScaling::Share => *count / n,
            CountScaling::RootShare => (*count / n).sqrt(),
        };
    }
    bag
}

/// Bottom, top, length and width.
fn extents_m(points_m: &[[f64; 3]]) -> [f64; 4] {
    let flat: Vec<[f64; 3]> = points_m.iter().map(|&[x, y, _]| [x, y, 0.0]).collect();
    let [along, across, _] = axes(&flat);
    let up = nalgebra::Vector3::z();
    let span = |axis: nalgebra::Vector3<f64>| {
        let values = || points_m.iter().map(|&it| vector(it).dot(&axis));
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let [bottom_m, top_m] = span(up);
    let [length_m, width_m] = [along, across].map(span).map(|[low, high]| high - low);
    [bottom_m, top_m, length_m, width_m]
}

/// Standard deviations of all points along their main axis on the ground plan and across it.
fn deviations_m(points_m: &[[f64; 3]]) -> [f64; 2] {
    let flat: Vec<[f64; 3]> = points_m.iter().map(|&[x, y, _]| [x, y, 0.0]).collect();
    let n = flat.len() as f64;
    let mean = flat.iter().map(|&it| vector(it)).sum::<nalgebra::Vector3<f64>>() / n;
    let [along, across, _] = axes(&flat);
    [along, across]
        .map(|axis| (flat.iter().map(|&it| (vector(it) - mean).dot(&axis).powi(2)).sum::<f64>() / n).sqrt())
}

/// What goes aside for each metre upward, by least squares.
fn tilt(points_m: &[[f64; 3]]) -> f64 {
    let mean = points_m.iter().map(|&it| vector(it)).sum::<nalgebra::Vector3<f64>>() / points_m.len() as f64;
    let products = points_m.iter().map(|&it| (vector(it) - mean) * (it[2] - mean.z));
    let sum: nalgebra::Vector3<f64> = products.sum();
    sum.xy().norm() / (sum.z + 1e-6)
}

/// Shape statistics that are looked at together.
fn groups_of_shape_statistics(points_m: &[[f64; 3]]) -> [Vec<f64>; 18] {
    let [bottom_m, top_m, length_m, width_m] = extents_m(points_m);
    let height_m = top_m - bottom_m;
    let n = points_m.len() as f64;
    let slice_of = |z: f64| ((z - bottom_m) * (6.0 / height_m.max(1e-3))).floor().min(5.0);
    let slices = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|number| -> Vec<[f64; 3]> {
        points_m.iter().filter(|it| slice_of(it[2]) == number).copied().collect()
    });
    let shares = slices.each_ref().map(|it| it.len() as f64 / n);
    let of_slices = slices.map(|slice| match slice.len() {
        0..3 => [0.0; 2],
        _ => [extents_m(&slice)[2], deviations_m(&slice)[0]],
    });
    let [lengths, alongs] = [0, 1].map(|value| of_slices.map(|it| it[value]));
    let sorted = |values: [f64; 6]| {
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        values
    };
    let (sorted_lengths, sorted_alongs) = (sorted(lengths), sorted(alongs));
    let mean_z = points_m.iter().map(|it| it[2]).sum::<f64>() / n;
    let up_m = (points_m.iter().map(|it| (it[2] - mean_z).powi(2)).sum::<f64>() / n).sqrt();
    let whole_m = height_m.max(0.01);
    let [along_m, across_m] = deviations_m(points_m);
    [
        vec![along_m, top_m, across_m, bottom_m],
        vec![height_m, along_m, across_m, length_m],
        vec![height_m, along_m, tilt(points_m)],
        vec![top_m, length_m, width_m],
        vec![top_m, lengths[0], lengths[5]],
        vec![alongs[0], top_m, lengths[0]],
        vec![top_m, alongs[0], alongs[3]],
        vec![alongs[0], alongs[3], alongs[5]],
        vec![top_m, lengths[1], lengths[2]],
        vec![top_m, lengths[4], lengths[5]],
        vec![alongs[0], alongs[2], alongs[4]],
        vec![top_m, up_m, along_m],
        vec![up_m / whole_m, (mean_z - bottom_m) / whole_m, along_m],
        vec![sorted_lengths[0], sorted_lengths[2], sorted_lengths[5]],
        vec![top_m, sorted_lengths[0], sorted_lengths[5]],
        vec![top_m, sorted_alongs[1], sorted_alongs[4]],
        vec![shares[0], shares[5], top_m],
        vec![shares[2], shares[4], shares[5]],
    ]
}

/// Groups of shape statistics, in bins that span three edges, which begin at each of three edges in turn.
fn count_shape_statistics(points_m: &[[f64; 3]], model: &PartialModel, bag: &mut BTreeMap<Pattern, f64>) {
    let edges = &model.params.patterns.shape_edges_m;
    let groups = groups_of_shape_statistics(points_m);
    for (index, division) in (0..54_u64).map(|it| (it, it as usize % 3)) {
        let bins = groups[index as usize / 3].iter().map(|&value| {
            let n_below = edges.iter().filter(|&&edge| edge <= value).count();
            ((n_below + division) / 3) as u64
        });
        let mut bins: Vec<u64> = bins.collect();
        bins.resize(4, 255);
        let of = |third, fourth| {
            let numbers = [4, third, fourth, index, bins[0], bins[1], 255];
            Pattern(numbers.into_iter().fold(0, |whole, it| whole << 8 | it))
        };
        let found = [of(bins[2], bins[3]), of(bins[2], 255), of(255, 255)];
        let n_tried = if model.params.bag.rare == RarePatterns::Merged { 3 } else { 1 };
        let is_known = |it: &&Pattern| model.vocabulary.patterns().binary_search(it).is_ok();
        if let Some(&pattern) = found[..n_tried].iter().find(is_known) {
            bag.insert(pattern, 1.0);
        }
    }
}

/// Each two of bottom, top, length and width that say something together.
fn count_extents(points_m: &[[f64; 3]], model: &PartialModel, bag: &mut BTreeMap<Pattern, f64>) {
    let [bottom_m, top_m, length_m, width_m] = extents_m(points_m);
    let edges = &model.params.patterns.extent_edges_m;
    let bin = |value: f64| edges.iter().filter(|&&edge| edge <= value).count() as u64;
    for (pair, [a, b]) in
        (0..).zip([[bottom_m, top_m], [top_m, length_m], [top_m, width_m], [length_m, width_m]])
    {
        let numbers = [3, 255, 255, pair, bin(a), bin(b), 255];
        let pattern = Pattern(numbers.into_iter().fold(0, |whole, it| whole << 8 | it));
        if model.vocabulary.patterns().binary_search(&pattern).is_ok() {
            bag.insert(pattern, 1.0);
        }
    }
}

fn pattern(vertices: &[Vertex], graph: &[usize], kind: PatternKind, model: &PartialModel) -> Pattern {
    let params = &model.params.patterns;
    let counted = if kind == PatternKind::Keypoint { &graph[..1] } else { graph };
    let height_m = counted.iter().map(|&it| vertices[it].position_m[2]).sum::<f64>() / counted.len() as f64;
    let volume_m3 = match *counted {
        [a, b, c, d] => {
            let [b, c, d] =
                [b, c, d].map(|it| vector(vertices[it].position_m) - vector(vertices[a].position_m));
            b.dot(&c.cross(&d)).abs() / 6.0
        }
        _ => 0.0,
    };
    let bin = |value: f64, edges: &[f64]| match edges {
        [] => 255,
        _ => edges.iter().filter(|&&edge| edge <= value).count() as u64,
    };
    let volume_bin =
        if kind == PatternKind::Keypoint { 255 } else { bin(volume_m3, &params.volume_edges_m3) };
    let mut labels: Vec<u64> = counted.iter().map(|&it| u64::from(vertices[it].label)).collect();
    labels.resize(4, 255);
    let kind = match kind {
        PatternKind::Graph => {
            labels.sort_unstable();
            0
        }
        PatternKind::Keypoint | PatternKind::Extents | PatternKind::ShapeStatistics => 2,
    };
    let numbers =
        [kind, bin(height_m, &params.height_edges_m), volume_bin, labels[0], labels[1], labels[2], labels[3]];
    Pattern(numbers.into_iter().fold(0, |whole, it| whole << 8 | it))
}

/// The least L1 distance to a mean bag of every class.
pub fn distances(bag: &BTreeMap<Pattern, f64>, model: &PartialModel) -> Vec<f64> {
    let to_center = |center: &[f32]| -> f64 {
        let columns = model.vocabulary.patterns().iter().zip(center);
        columns.map(|(pattern, &mean)| (bag.get(pattern).unwrap_or(&0.0) - f64::from(mean)).abs()).sum()
    };
    let of_class = |class_idx: usize| {
        let centers = model.decision.centers.iter().filter(|it| it.class_idx == class_idx);
        centers.map(|it| to_center(&it.bag)).fold(f64::INFINITY, f64::min)
    };
    (0..model.classes.len()).map(of_class).collect()
}
