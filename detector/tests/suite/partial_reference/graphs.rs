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
    let place = |it: usize| vertices[it].position_m.map(|value| value as f32);
    let strip = |graph: &Vec<usize>| {
        let mut strip = vec![place(graph[0])];
        for &it in &graph[1..] {
            strip.extend([place(it), place(graph[0])]);
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
    model: &PartialModel,
) -> BTreeMap<Pattern, f64> {
    let params = &model.params;
    let mut bag = BTreeMap::new();
    if params.patterns.kinds.contains(&PatternKind::Extents) {
        count_extents(points_m, model, &mut bag);
    }
    if params.patterns.kinds.contains(&PatternKind::Size) {
        count_size(points_m, model, &mut bag);
    }
    for &kind in
        params.patterns.kinds.iter().filter(|it| !matches!(it, PatternKind::Extents | PatternKind::Size))
    {
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
            4 => 3.0,
            _ => graphs.len() as f64,
        };
        *count = match params.bag.counts {
            CountScaling::Raw => *count,
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

/// All four in bins that span three edges, which begin at each of three edges in turn.
fn count_size(points_m: &[[f64; 3]], model: &PartialModel, bag: &mut BTreeMap<Pattern, f64>) {
    let edges = &model.params.patterns.extent_edges_m;
    for division in 0..3 {
        // The edges at which a bin of this division begins.
        let begins = edges.iter().enumerate().filter(|(it, _)| (it + 1 + division) % 3 == 0).map(|it| *it.1);
        let begins: Vec<f64> = begins.collect();
        let [bottom, top, length, width] =
            extents_m(points_m).map(|it| begins.iter().filter(|&&begin| begin <= it).count() as u64);
        let of = |width, bottom| {
            let numbers = [4, width, bottom, division as u64, top, length, 255];
            Pattern(numbers.into_iter().fold(0, |whole, it| whole << 8 | it))
        };
        // All four; what is rare without the bottom, and without the width, too.
        let found = [of(width, bottom), of(width, 255), of(255, 255)];
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
        PatternKind::CenteredGraph => {
            labels[1..].sort_unstable();
            1
        }
        PatternKind::Keypoint | PatternKind::Extents | PatternKind::Size => 2,
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
