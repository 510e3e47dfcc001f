//! Patterns of keypoints: small labelled graphs of each and its nearest ones, and values of the whole.

use serde::{Deserialize, Serialize};

use super::hull_volume::tetrahedron_m3;
use super::neighborhoods::squared_distance;
use super::seen_extents::SeenExtents;
use super::shape_statistics::{N_SLICES, ShapeStatistics};

/// Number of keypoints of a graph: one, and the three nearest to it.
pub const N_VERTICES: usize = 4;
/// The label that stands where a graph lacks a keypoint.
const MISSING: u8 = 255;
/// The bin of a value that does not count.
const ANY: u8 = 255;

/// Tuning of [`Patterns`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatternParams {
    /// The kinds of patterns that are counted, each by itself.
    pub kinds: Vec<PatternKind>,
    /// Where bins of the height of the centre above the ground end, in metres, ascending; none: heights do not count.
    pub height_edges_m: Vec<f64>,
    /// Where bins of the spanned volume end, in cubic metres, ascending; none: volumes do not count.
    pub volume_edges_m3: Vec<f64>,
    /// Where bins of the extents of the whole end, in metres, ascending.
    pub extent_edges_m: Vec<f64>,
    /// Where bins of the shape statistics of the whole end, ascending: metres for lengths, plain numbers for shares, ratios
    /// and the tilt.
    pub shape_edges_m: Vec<f64>,
}

/// Kind of a pattern, of every keypoint or of the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PatternKind {
    /// Its graph: the labels of its four vertices without order, with the height of their mean and the volume that they
    /// span. The paper's.
    Graph,
    /// Its own label and height: a bag of words, without graphs.
    Keypoint,
    /// Extents of the seen part: a pattern for each of four pairs of extents, and none of keypoints. Not in the paper, whose
    /// shares hold no size.
    Extents,
    /// Shape statistics of the seen part: its height, the spread of its points, overall and in six level slices, the share
    /// of points in each slice, and the tilt. A pattern joins three or four of these values, in wide bins that overlap. Not
    /// in the paper.
    ShapeStatistics,
}

/// A pattern as a number: its kind, the bin of its height, the bin of its volume, its labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pattern(pub u64);

impl Pattern {
    fn new(kind: PatternKind, [height_bin, volume_bin]: [u8; 2], labels: [u8; N_VERTICES]) -> Self {
        let kind = match kind {
            PatternKind::Graph => 0,
            PatternKind::Keypoint => 2,
            PatternKind::Extents => 3,
            PatternKind::ShapeStatistics => 4,
        };
        let [a, b, c, d] = labels;
        Self(u64::from_be_bytes([0, kind, height_bin, volume_bin, a, b, c, d]))
    }

    /// The pattern of this number. `None` if there is no such kind.
    pub fn from_number(number: u64) -> Option<Self> {
        let [always_0, kind, ..] = number.to_be_bytes();
        (always_0 == 0 && usize::from(kind) < N_KINDS).then_some(Self(number))
    }

    /// The number of its kind.
    pub fn kind_number(self) -> usize {
        usize::from(self.0.to_be_bytes()[1])
    }

    /// A pattern with fewer distinctions: first without its volume, then without its height. `None` if it has neither.
    pub fn coarser(self) -> Option<Self> {
        let [_, _, height_bin, volume_bin, ..] = self.0.to_be_bytes();
        let mut bytes = self.0.to_be_bytes();
        if volume_bin != ANY {
            bytes[3] = ANY;
        } else if height_bin != ANY {
            bytes[2] = ANY;
        } else {
            return None;
        }
        Some(Self(u64::from_be_bytes(bytes)))
    }
}

/// Number of kinds of patterns; number 1 is not in use.
pub const N_KINDS: usize = 5;
/// Divisions of shape statistics into wide bins, and how many edges a wide bin spans.
const N_DIVISIONS: usize = 3;
/// Groups of values of the shape statistics.
const N_GROUPS: usize = 18;
/// Ratios to the height of the seen part take it to be at least this, in metres.
const LEAST_HEIGHT_OF_RATIOS_M: f64 = 0.01;

/// A keypoint with its label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabeledKeypoint {
    /// Position in metres, z above the ground.
    pub position_m: [f64; 3],
    /// Its label.
    pub label: u8,
}

/// Buffers for one cloud after another.
#[derive(Debug, Clone, Default)]
pub struct Patterns {
    graphs: Vec<[u32; N_VERTICES]>,
    patterns: Vec<Pattern>,
}

impl Patterns {
    /// The graphs and patterns of these keypoints.
    ///
    /// Of keypoints that are equally far the first is nearer. Where there are fewer than four, every graph has all of them,
    /// and its volume is 0.
    ///
    /// Paper: BG section 3.2.
    pub fn fill(
        &mut self,
        keypoints: &[LabeledKeypoint],
        extents: &SeenExtents,
        shape: &ShapeStatistics,
        params: &PatternParams,
    ) {
        self.graphs.clear();
        self.graphs.extend((0..keypoints.len()).map(|it| graph_of(it, keypoints)));
        self.patterns.clear();
        for graph in &self.graphs {
            let vertices = graph.map(|it| keypoints.get(it as usize));
            self.patterns.extend(params.kinds.iter().filter_map(|&kind| pattern_of(vertices, kind, params)));
        }
        if keypoints.is_empty() {
            return;
        }
        if params.kinds.contains(&PatternKind::Extents) {
            self.patterns.extend(patterns_of_extents(extents, &params.extent_edges_m));
        }
        if params.kinds.contains(&PatternKind::ShapeStatistics) {
            self.patterns.extend(patterns_of_shape(shape, &params.shape_edges_m));
        }
    }

    /// The keypoints of every graph: the one that it belongs to, and the nearest, from near to far; `u32::MAX` where one is
    /// missing.
    pub fn graphs(&self) -> &[[u32; N_VERTICES]] {
        &self.graphs
    }

    /// One pattern of every kind for each graph, and then those of the extents and of the shape statistics.
    pub fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }
}

fn graph_of(center_idx: usize, keypoints: &[LabeledKeypoint]) -> [u32; N_VERTICES] {
    let mut nearest = [(f64::INFINITY, u32::MAX); N_VERTICES - 1];
    let center_m = keypoints[center_idx].position_m;
    for (keypoint_idx, keypoint) in keypoints.iter().enumerate() {
        let squared_m = squared_distance(keypoint.position_m, center_m);
        if keypoint_idx == center_idx || squared_m >= nearest[N_VERTICES - 2].0 {
            continue;
        }
        let mut index = N_VERTICES - 2;
        while index > 0 && squared_m < nearest[index - 1].0 {
            nearest[index] = nearest[index - 1];
            index -= 1;
        }
        nearest[index] = (squared_m, keypoint_idx as u32);
    }
    [center_idx as u32, nearest[0].1, nearest[1].1, nearest[2].1]
}

/// `None` for kinds that are of the whole cloud.
fn pattern_of(
    vertices: [Option<&LabeledKeypoint>; N_VERTICES],
    kind: PatternKind,
    params: &PatternParams,
) -> Option<Pattern> {
    let mut labels = vertices.map(|it| it.map_or(MISSING, |keypoint| keypoint.label));
    let there = || vertices.iter().flatten();
    let mean_height_m = there().map(|it| it.position_m[2]).sum::<f64>() / there().count() as f64;
    let volume_m3 = match vertices {
        [Some(a), Some(b), Some(c), Some(d)] => tetrahedron_m3([a, b, c, d].map(|it| it.position_m)),
        _ => 0.0,
    };
    let volume_bin = bin_of(volume_m3, &params.volume_edges_m3);
    let bins = [bin_of(mean_height_m, &params.height_edges_m), volume_bin];
    match kind {
        PatternKind::Graph => labels.sort_unstable(),
        PatternKind::Keypoint => {
            let height_m = vertices[0].map_or(0.0, |it| it.position_m[2]);
            let bins = [bin_of(height_m, &params.height_edges_m), ANY];
            return Some(Pattern::new(kind, bins, [labels[0], MISSING, MISSING, MISSING]));
        }
        PatternKind::Extents | PatternKind::ShapeStatistics => return None,
    }
    Some(Pattern::new(kind, bins, labels))
}

/// The patterns of pairs of extents.
fn patterns_of_extents(extents: &SeenExtents, edges_m: &[f64]) -> [Pattern; 4] {
    let SeenExtents { bottom_m, top_m, length_m, width_m } = *extents;
    let pairs =
        [(0, [bottom_m, top_m]), (1, [top_m, length_m]), (2, [top_m, width_m]), (3, [length_m, width_m])];
    pairs.map(|(pair, both_m)| {
        let [first, second] = both_m.map(|it| bin_of(it, edges_m));
        Pattern::new(PatternKind::Extents, [ANY, ANY], [pair, first, second, MISSING])
    })
}

/// Shape statistics that make a pattern together; docs/decisions/object-clouds.md says how they were chosen. A rare pattern
/// first forgets its fourth value, then its third.
fn groups_of_shape(shape: &ShapeStatistics) -> [([f64; 3], Option<f64>); N_GROUPS] {
    let ShapeStatistics { extents, spread, mean_height_m, deviation_up_m, tilt, slices } = *shape;
    let (top_m, height_m, along_m) = (extents.top_m, shape.height_m(), spread.deviation_along_m);
    let shares = slices.map(|it| it.share);
    let lengths_m = slices.map(|it| it.spread.length_m);
    let deviations_m = slices.map(|it| it.spread.deviation_along_m);
    let [sorted_lengths_m, sorted_deviations_m] = [lengths_m, deviations_m].map(ascending);
    let of_height = |value_m: f64| value_m / height_m.max(LEAST_HEIGHT_OF_RATIOS_M);
    let three = |values| (values, None);
    [
        ([along_m, top_m, spread.deviation_across_m], Some(extents.bottom_m)),
        ([height_m, along_m, spread.deviation_across_m], Some(extents.length_m)),
        three([height_m, along_m, tilt]),
        three([top_m, extents.length_m, extents.width_m]),
        three([top_m, lengths_m[0], lengths_m[5]]),
        three([deviations_m[0], top_m, lengths_m[0]]),
        three([top_m, deviations_m[0], deviations_m[3]]),
        three([deviations_m[0], deviations_m[3], deviations_m[5]]),
        three([top_m, lengths_m[1], lengths_m[2]]),
        three([top_m, lengths_m[4], lengths_m[5]]),
        three([deviations_m[0], deviations_m[2], deviations_m[4]]),
        three([top_m, deviation_up_m, along_m]),
        three([of_height(deviation_up_m), of_height(mean_height_m), along_m]),
        three([sorted_lengths_m[0], sorted_lengths_m[2], sorted_lengths_m[5]]),
        three([top_m, sorted_lengths_m[0], sorted_lengths_m[5]]),
        three([top_m, sorted_deviations_m[1], sorted_deviations_m[4]]),
        three([shares[0], shares[5], top_m]),
        three([shares[2], shares[4], shares[5]]),
    ]
}

fn ascending(mut values: [f64; N_SLICES]) -> [f64; N_SLICES] {
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The bins of the values of each group, as wide as some edges, in every division.
fn patterns_of_shape(shape: &ShapeStatistics, edges_m: &[f64]) -> impl Iterator<Item = Pattern> {
    (0..).zip(groups_of_shape(shape)).flat_map(move |(group, (three, fourth))| {
        (0..N_DIVISIONS).map(move |division| {
            let [first, second, third] = three.map(|it| wide_bin_of(it, edges_m, division));
            let fourth = fourth.map_or(ANY, |it| wide_bin_of(it, edges_m, division));
            let index = group * N_DIVISIONS as u8 + division as u8;
            Pattern::new(PatternKind::ShapeStatistics, [third, fourth], [index, first, second, MISSING])
        })
    })
}

/// The bin of a division, as wide as some of `edges`.
fn wide_bin_of(value: f64, edges: &[f64], division: usize) -> u8 {
    ((edges.partition_point(|&edge| edge <= value) + division) / N_DIVISIONS) as u8
}

/// How many of `edges` are at most `value`; [`ANY`] without edges.
fn bin_of(value: f64, edges: &[f64]) -> u8 {
    if edges.is_empty() { ANY } else { edges.partition_point(|&edge| edge <= value) as u8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keypoint(x_m: f64, z_m: f64, label: u8) -> LabeledKeypoint {
        LabeledKeypoint { position_m: [x_m, 0.0, z_m], label }
    }

    fn params(kind: PatternKind) -> PatternParams {
        PatternParams {
            kinds: vec![kind],
            height_edges_m: vec![1.0, 2.0],
            volume_edges_m3: vec![0.1],
            extent_edges_m: vec![1.0, 2.0],
            shape_edges_m: vec![],
        }
    }

    #[track_caller]
    fn check(keypoints: &[LabeledKeypoint], kind: PatternKind, expected: &[[u8; 6]]) {
        let mut patterns = Patterns::default();
        patterns.fill(keypoints, &SeenExtents::default(), &ShapeStatistics::default(), &params(kind));
        let found: Vec<[u8; 6]> = patterns
            .patterns()
            .iter()
            .map(|it| {
                let [_, _, height, volume, labels @ ..] = it.0.to_be_bytes();
                let [a, b, c, d] = labels;
                [height, volume, a, b, c, d]
            })
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn the_labels_of_a_graph_have_no_order() {
        let row = [
            keypoint(0.0, 0.0, 7),
            keypoint(1.0, 0.0, 3),
            keypoint(2.0, 0.0, 5),
            keypoint(3.1, 0.0, 1),
            keypoint(9.0, 8.0, 0),
        ];
        let mut patterns = Patterns::default();
        patterns.fill(
            &row,
            &SeenExtents::default(),
            &ShapeStatistics::default(),
            &params(PatternKind::Graph),
        );
        assert_eq!(patterns.graphs()[0], [0, 1, 2, 3]);
        assert_eq!(patterns.graphs()[2], [2, 1, 3, 0]);
        check(&row[..4], PatternKind::Graph, &[[0, 0, 1, 3, 5, 7]; 4]);
        check(&row[..2], PatternKind::Graph, &[[0, 0, 3, 7, 255, 255]; 2]);
    }

    #[test]
    fn heights_and_volumes_are_binned() {
        let corner = |position_m| LabeledKeypoint { position_m, label: 0 };
        // A tetrahedron of a sixth of a cubic metre whose middle is 1.25 m high.
        let graph = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 2.0]].map(corner);
        check(&graph, PatternKind::Graph, &[[1, 1, 0, 0, 0, 0]; 4]);
        check(&graph[3..], PatternKind::Keypoint, &[[2, 255, 0, 255, 255, 255]]);
    }

    #[test]
    fn without_edges_heights_and_volumes_do_not_count() {
        let mut patterns = Patterns::default();
        let nothing = PatternParams {
            kinds: vec![PatternKind::Graph],
            height_edges_m: vec![],
            volume_edges_m3: vec![],
            extent_edges_m: vec![],
            shape_edges_m: vec![],
        };
        patterns.fill(
            &[keypoint(0.0, 5.0, 2)],
            &SeenExtents::default(),
            &ShapeStatistics::default(),
            &nothing,
        );
        assert_eq!(patterns.patterns(), [Pattern::new(PatternKind::Graph, [ANY, ANY], [2, 255, 255, 255])]);
        patterns.fill(&[], &SeenExtents::default(), &ShapeStatistics::default(), &nothing);
        assert_eq!(patterns.patterns(), []);
    }

    #[test]
    fn a_pattern_forgets_its_volume_and_then_its_height() {
        let fine = Pattern::new(PatternKind::Graph, [3, 2], [1, 2, 3, 4]);
        let coarser = fine.coarser().unwrap();
        assert_eq!(coarser, Pattern::new(PatternKind::Graph, [3, ANY], [1, 2, 3, 4]));
        assert_eq!(coarser.coarser(), Some(Pattern::new(PatternKind::Graph, [ANY, ANY], [1, 2, 3, 4])));
        assert_eq!(coarser.coarser().unwrap().coarser(), None);
    }

    #[test]
    fn extents_are_binned_two_at_a_time() {
        let extents = SeenExtents { bottom_m: 0.5, top_m: 1.5, length_m: 2.5, width_m: 1.0 };
        let mut patterns = Patterns::default();
        patterns.fill(
            &[keypoint(0.0, 0.0, 9)],
            &extents,
            &ShapeStatistics::default(),
            &params(PatternKind::Extents),
        );
        let labels: Vec<[u8; 3]> = patterns
            .patterns()
            .iter()
            .map(|it| {
                let [.., pair, first, second, _] = it.0.to_be_bytes();
                [pair, first, second]
            })
            .collect();
        assert_eq!(labels, [[0, 0, 1], [1, 1, 2], [2, 1, 1], [3, 2, 1]]);
        assert_eq!(patterns.patterns()[0].kind_number(), 3);
        patterns.fill(&[], &extents, &ShapeStatistics::default(), &params(PatternKind::Extents));
        assert!(patterns.patterns().is_empty());
    }

    #[test]
    fn shape_statistics_count_some_values_in_wide_bins_that_overlap() {
        let edges_m: Vec<f64> = (1..8).map(f64::from).collect();
        let params = PatternParams { shape_edges_m: edges_m, ..params(PatternKind::ShapeStatistics) };
        let extents = SeenExtents { bottom_m: 0.5, top_m: 6.5, length_m: 5.5, width_m: 3.5 };
        let mut shape = ShapeStatistics { extents, tilt: 4.5, ..ShapeStatistics::default() };
        shape.slices[0].spread.length_m = 3.5;
        shape.slices[2].share = 1.5;
        shape.slices[5].share = 2.5;
        let mut patterns = Patterns::default();
        patterns.fill(&[keypoint(0.0, 0.0, 9)], &extents, &shape, &params);
        assert_eq!(patterns.patterns().len(), 18 * 3);
        let numbers = |it: usize| patterns.patterns()[it].0.to_be_bytes();
        // The top, the length and the width exceed 6, 5 and 3 edges.
        assert_eq!(numbers(9), [0, 4, 1, 255, 9, 2, 1, 255]);
        assert_eq!(numbers(10), [0, 4, 1, 255, 10, 2, 2, 255]);
        assert_eq!(numbers(11), [0, 4, 1, 255, 11, 2, 2, 255]);
        // The bottom is the fourth of the first group; it exceeds none.
        assert_eq!(numbers(1), [0, 4, 0, 0, 1, 0, 2, 255]);
        // The tilt is the third of the third group.
        assert_eq!(numbers(6), [0, 4, 1, 255, 6, 2, 0, 255]);
        // The lowest slice is the longest, so of lengths in order it is the last.
        assert_eq!(numbers(3 * 4), [0, 4, 0, 255, 12, 2, 1, 255]);
        assert_eq!(numbers(3 * 13), [0, 4, 1, 255, 39, 0, 0, 255]);
        // Shares of the first and the last slice, and the top; of the third, the fifth and the last.
        assert_eq!(numbers(3 * 16), [0, 4, 2, 255, 48, 0, 0, 255]);
        assert_eq!(numbers(3 * 17 + 2), [0, 4, 1, 255, 53, 1, 0, 255]);
        patterns.fill(&[], &extents, &shape, &params);
        assert!(patterns.patterns().is_empty());
    }
}
