//! Blobs of several objects, cut where their dense cells are empty.

use serde::Deserialize;

use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::segment::dense_level::DenseLevel;
use crate::segment::dense_reach::DenseReach;
use crate::segment::disjoint_sets::DisjointSets;
use crate::segment::expected_density::ExpectedDensity;

/// Tuning of [`DenseSeparation::separate`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenseSeparationParams {
    /// Whether blobs are cut at all; otherwise each stays one object, as a grid without dense cells leaves it.
    pub enabled: bool,
    /// A dense cell with less than this share of the points it could be expected to hold is near-empty.
    pub low_density_share: f32,
    /// Points in a dense cell of an upright object, over those that all points together put into one at its range.
    pub object_density_ratio: f32,
    /// Where all points together put this many into a dense cell, a single empty dense cell separates.
    pub single_gap_points: f32,
    /// Fewest dense cells on either side of a border that have to touch the other side; all, where there are no more.
    pub min_contacts: u32,
}

/// Decides for every dense cell which object it belongs to.
///
/// *Parts* are the groups of occupied dense cells of a coarse cell that touch: one, unless a line of near-empty dense cells
/// runs through it (Fig. 4 c). Parts of linked coarse cells stay together if occupied dense cells of the one touch those of
/// the other, on either side as many as the parameters say; near-empty dense cells along their border, straight (Fig. 4 a)
/// or stepped (Fig. 4 b), keep them apart.
///
/// The weight of the range decides which dense cells are near-empty, and how many empty dense cells in a row are a gap. A
/// dense cell is expected to hold what the others of its coarse cell hold on average, but not more than upright objects hold
/// at that range ([`ExpectedDensity`]).
///
/// Paper: HG section 3.2, third step, Fig. 4, and section 4.
#[derive(Debug, Clone)]
pub struct DenseSeparation {
    params: DenseSeparationParams,
    reach: DenseReach,
    expected: ExpectedDensity,
    // The part, and after all links the object, of every dense cell.
    object_of_dense: Vec<u32>,
    first_part_of_block: Vec<u32>,
    // Occupied dense cells of each part, as bits.
    cells_of_part: Vec<u64>,
    parts: DisjointSets,
    cut_links: Vec<[u32; 2]>,
}

/// Marks dense cells without points.
pub const NO_OBJECT: u32 = u32::MAX;

impl DenseSeparation {
    /// Nothing separated yet, in grids of the geometry `grid`.
    pub fn new(params: DenseSeparationParams, grid: &GridParams, weighting: &DensityWeighting) -> Self {
        Self {
            expected: ExpectedDensity::new(
                params.object_density_ratio,
                params.single_gap_points,
                grid,
                weighting,
            ),
            params,
            reach: DenseReach::new(grid.xi),
            object_of_dense: Vec::new(),
            first_part_of_block: Vec::new(),
            cells_of_part: Vec::new(),
            parts: DisjointSets::default(),
            cut_links: Vec::new(),
        }
    }

    /// Replaces the content by the objects of the blobs that `links` makes of the blocks of `dense`.
    pub fn separate(&mut self, grid: &HierarchicalGrid, dense: &DenseLevel, links: &[[u32; 2]]) {
        self.cut_links.clear();
        if self.params.enabled {
            self.cut_blobs(grid, dense, links);
        } else {
            self.keep_blobs(dense, links);
        }
        for part in self.object_of_dense.iter_mut().filter(|part| **part != NO_OBJECT) {
            *part = self.parts.representative(*part);
        }
    }

    /// The object of every dense cell: the smallest number of its parts, or [`NO_OBJECT`] for empty cells.
    pub fn object_of_dense(&self) -> &[u32] {
        &self.object_of_dense
    }

    /// Number of parts; objects are numbered below it.
    pub fn n_parts(&self) -> usize {
        self.cells_of_part.len()
    }

    /// The links that were cut, ascending.
    pub fn cut_links(&self) -> &[[u32; 2]] {
        &self.cut_links
    }

    fn cut_blobs(&mut self, grid: &HierarchicalGrid, dense: &DenseLevel, links: &[[u32; 2]]) {
        self.find_parts(grid, dense);
        self.parts.reset(self.cells_of_part.len());
        for &blocks in links {
            let cells = blocks.map(|block_idx| dense.cell_of_block()[block_idx as usize]);
            if !self.join_touching(grid, blocks, cells) {
                self.cut_links.push(blocks);
            }
        }
    }

    /// Makes each block one part, and joins all that are linked.
    fn keep_blobs(&mut self, dense: &DenseLevel, links: &[[u32; 2]]) {
        self.object_of_dense.clear();
        self.cells_of_part.clear();
        for block_idx in 0..dense.n_blocks() as u32 {
            let mut cells = 0;
            for (bit, &n_in_cell) in dense.n_points_of_block(block_idx).iter().enumerate() {
                let is_empty = n_in_cell == 0;
                cells |= u64::from(!is_empty) << bit;
                self.object_of_dense.push(if is_empty { NO_OBJECT } else { block_idx });
            }
            self.cells_of_part.push(cells);
        }
        self.parts.reset(self.cells_of_part.len());
        for &[from, to] in links {
            self.parts.join(from, to);
        }
    }

    fn find_parts(&mut self, grid: &HierarchicalGrid, dense: &DenseLevel) {
        self.object_of_dense.clear();
        self.object_of_dense.resize(dense.n_points().len(), NO_OBJECT);
        self.first_part_of_block.clear();
        self.cells_of_part.clear();
        for (block_idx, &cell_idx) in dense.cell_of_block().iter().enumerate() {
            let n_points = dense.n_points_of_block(block_idx as u32);
            let first_part = self.cells_of_part.len();
            self.first_part_of_block.push(first_part as u32);
            let expected = self.expected.of_cell(grid, cell_idx);
            let least = expected.least_points(self.params.low_density_share, n_points.iter().copied());
            let occupied = occupied(n_points, least);
            self.reach.push_groups(occupied, expected.max_steps, &mut self.cells_of_part);
            let parts = &self.cells_of_part[first_part..];
            for (bit, &n_in_cell) in n_points.iter().enumerate() {
                // Near-empty cells are in no part, and their points go to the nearest one.
                if n_in_cell > 0 {
                    let dense_idx = block_idx * n_points.len() + bit;
                    let part = first_part + self.reach.nearest(parts, bit as u32);
                    self.object_of_dense[dense_idx] = part as u32;
                }
            }
        }
        self.first_part_of_block.push(self.cells_of_part.len() as u32);
    }

    fn parts_of_block(&self, block_idx: u32) -> std::ops::Range<u32> {
        let block_idx = block_idx as usize;
        self.first_part_of_block[block_idx]..self.first_part_of_block[block_idx + 1]
    }

    /// Joins the parts of two neighbouring blocks that touch; `false` if none do.
    fn join_touching(&mut self, grid: &HierarchicalGrid, blocks: [u32; 2], cells: [u32; 2]) -> bool {
        let [from, to] = cells.map(|cell_idx| grid.column_and_row(cell_idx));
        let steps = [to[0] as i32 - from[0] as i32, to[1] as i32 - from[1] as i32];
        let max_steps = self.expected.of_cell(grid, cells[0]).max_steps;
        let mut any = false;
        for part in self.parts_of_block(blocks[0]) {
            for neighbor in self.parts_of_block(blocks[1]) {
                let cells = [part, neighbor].map(|idx| self.cells_of_part[idx as usize]);
                let least = cells.map(u64::count_ones).into_iter().fold(self.params.min_contacts, u32::min);
                if self.reach.n_contacts(cells, steps, max_steps) >= least {
                    self.parts.join(part, neighbor);
                    any = true;
                }
            }
        }
        any
    }
}

/// The dense cells of a block that hold at least `least` points, as bits.
fn occupied(n_points: &[u32], least: f32) -> u64 {
    let is_occupied = n_points.iter().enumerate().filter(|&(_, &n)| n as f32 >= least);
    is_occupied.fold(0, |bits, (bit, _)| bits | 1 << bit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::density_curve::DensityCurve;
    use crate::grid::density_weighting::DensityWeightingParams;
    use crate::point_cloud::PointCloud;
    use crate::segment::connected_components::{ConnectedComponentsParams, connected_components};

    const PARAMS: DenseSeparationParams = DenseSeparationParams {
        enabled: true,
        low_density_share: 0.1,
        object_density_ratio: 3.0,
        single_gap_points: 2.0,
        min_contacts: 1,
    };

    /// The weighting of the paper's sensor.
    fn weighting(enabled: bool) -> DensityWeighting {
        let curve = DensityCurve::shipped("hdl-64e-s2").unwrap();
        DensityWeighting::new(&DensityWeightingParams { enabled, curve })
    }

    /// Separates a drawing of dense cells, three to a coarse cell, whose first corner is `forward_m` in front of the
    /// sensor: `#` holds 20 points, `1` a single one. Returns the drawing with a letter for each object.
    fn separated(
        drawing: &str,
        forward_m: f32,
        params: &DenseSeparationParams,
        weighting: &DensityWeighting,
    ) -> String {
        let geometry = GridParams { cell_size_m: 0.6, xi: 3, extent_m: 60.0 };
        let mut grid = HierarchicalGrid::new(geometry.clone());
        let mut cloud = PointCloud::default();
        let mut position_of_point = Vec::new();
        for (row, line) in drawing.lines().enumerate() {
            for (column, mark) in line.chars().enumerate() {
                let n_points = match mark {
                    '#' => 20,
                    '1' => 1,
                    _ => 0,
                };
                for _ in 0..n_points {
                    let at_m = |step: usize| (step as f32 + 0.5) * 0.2;
                    cloud.push([forward_m + at_m(column), at_m(row), 0.0], 0.0);
                    position_of_point.push((row, column));
                }
            }
        }
        grid.fill(&cloud);
        let point_indices: Vec<u32> = (0..cloud.len() as u32).collect();
        let mut dense = DenseLevel::default();
        dense.fill(&grid, grid.occupied(), &point_indices);
        let mut links = Vec::new();
        connected_components(
            &grid,
            &dense,
            &ConnectedComponentsParams { max_height_difference_m: 1.0 },
            &mut links,
        );
        let mut separation = DenseSeparation::new(params.clone(), &geometry, weighting);
        separation.separate(&grid, &dense, &links);
        let mut lines: Vec<Vec<char>> = drawing.lines().map(|line| vec!['.'; line.len()]).collect();
        let mut seen = Vec::new();
        for (&dense_idx, (row, column)) in dense.dense_of_point().iter().zip(position_of_point) {
            let object = separation.object_of_dense()[dense_idx as usize];
            let letter = seen.iter().position(|&it| it == object).unwrap_or_else(|| {
                seen.push(object);
                seen.len() - 1
            });
            lines[row][column] = (b'a' + letter as u8) as char;
        }
        lines.iter().map(|line| line.iter().collect::<String>()).collect::<Vec<_>>().join("\n")
    }

    #[track_caller]
    fn check_at(forward_m: f32, drawing: &str, expected: &str) {
        let found = separated(drawing, forward_m, &PARAMS, &weighting(true));
        assert_eq!(found, expected, "\n{drawing}\nbecame\n{found}");
    }

    #[track_caller]
    fn check(drawing: &str, expected: &str) {
        check_at(6.0, drawing, expected);
    }

    // The coarse cells lie at columns 0-2, 3-5, 6-8 and likewise for rows.

    #[test]
    fn a_straight_empty_border_between_two_cells_separates() {
        // Fig. 4 a.
        check("##.###\n##.###\n##.###", "aa.bbb\naa.bbb\naa.bbb");
    }

    #[test]
    fn a_stepped_empty_border_between_two_cells_separates() {
        // Fig. 4 b.
        check("###.##\n##..##\n#..###", "aaa.bb\naa..bb\na..bbb");
    }

    #[test]
    fn an_empty_line_through_one_cell_separates() {
        // Fig. 4 c.
        check("#.#\n#.#\n#.#", "a.b\na.b\na.b");
        check("####.####\n####.####\n####.####", "aaaa.bbbb\naaaa.bbbb\naaaa.bbbb");
    }

    #[test]
    fn cells_that_touch_at_a_corner_stay_together() {
        check("##.\n##.\n..#", "aa.\naa.\n..a");
        check("##....\n##....\n..#...\n...##.", "aa....\naa....\n..a...\n...aa.");
    }

    #[test]
    fn a_bridge_of_one_cell_joins_unless_more_contacts_are_asked_for() {
        let drawing = "######\n##.###\n##.###";
        check(drawing, "aaaaaa\naa.aaa\naa.aaa");
        let two = DenseSeparationParams { min_contacts: 2, ..PARAMS };
        assert_eq!(separated(drawing, 6.0, &two, &weighting(true)), "aaabbb\naa.bbb\naa.bbb");
        // No more of it could touch.
        assert_eq!(
            separated("..####\n...###\n...###", 6.0, &two, &weighting(true)),
            "..aaaa\n...aaa\n...aaa"
        );
    }

    #[test]
    fn near_empty_cells_separate_like_empty_ones_and_join_the_nearer_side() {
        check("##1###\n##1###\n##1###", "aaabbb\naaabbb\naaabbb");
    }

    #[test]
    fn the_farther_away_the_wider_a_gap_has_to_be() {
        check_at(18.0, "##.###\n##.###\n##.###", "aa.aaa\naa.aaa\naa.aaa");
        check_at(18.0, "#.#\n#.#\n#.#", "a.a\na.a\na.a");
        check_at(18.0, "##..##\n##..##\n##..##", "aa..bb\naa..bb\naa..bb");
        check_at(30.0, "##..##\n##..##\n##..##", "aa..aa\naa..aa\naa..aa");
    }

    #[test]
    fn switched_off_it_leaves_the_blobs_whole() {
        let off = DenseSeparationParams { enabled: false, ..PARAMS };
        for (drawing, expected) in [
            ("##.###\n##.###\n##.###", "aa.aaa\naa.aaa\naa.aaa"),
            ("#.#\n#.#\n#1#", "a.a\na.a\naaa"),
            // A whole coarse cell lies between the two.
            ("###...###\n###...###\n###...###", "aaa...bbb\naaa...bbb\naaa...bbb"),
        ] {
            assert_eq!(separated(drawing, 6.0, &off, &weighting(true)), expected, "\n{drawing}");
        }
    }

    #[test]
    fn without_weights_a_single_empty_cell_is_a_gap_at_every_range() {
        let drawing = "##.###\n##.###\n##.###";
        assert_eq!(separated(drawing, 30.0, &PARAMS, &weighting(false)), "aa.bbb\naa.bbb\naa.bbb");
    }
}
