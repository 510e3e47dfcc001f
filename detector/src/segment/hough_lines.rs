//! Straight segments in a grid of cells, by the progressive probabilistic Hough transform.

use serde::Deserialize;

use crate::portable_math;
use crate::seeded_draws::SeededDraws;

/// Tuning of [`HoughLines::find`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoughParams {
    /// Directions a line may have, spread evenly over half a turn.
    pub n_directions: u32,
    /// Least votes for a line whose cells are followed.
    pub min_votes: u16,
    /// Least length of a segment, in cells.
    pub min_length_cells: u32,
    /// Longest gap within a segment, in cells.
    pub max_gap_cells: u32,
    /// Seed of the order of the votes.
    pub seed: u64,
}

/// A straight run of cells, from end to end, as columns and rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment {
    /// The cell at which it starts.
    pub start: [i32; 2],
    /// The cell at which it ends.
    pub end: [i32; 2],
}

/// Finds segments in one set of cells after another.
///
/// Cells vote in random order, each for all lines through it. Once a line has enough votes, the cells along it are
/// followed to both sides, the segment is taken out of the set together with the votes of its cells, and the rest goes
/// on voting: most cells of a long wall never vote. The order is the same for the same cells.
///
/// Paper: HG section 3.1, reference 12 (Matas, Galambos, Kittler 2000).
#[derive(Debug, Clone)]
pub struct HoughLines {
    params: HoughParams,
    n_columns: u32,
    // Cosine and sine of every direction's normal, in 1/65536.
    normals: Vec<[i32; 2]>,
    // By direction and distance from the origin.
    votes: Vec<u16>,
    n_distances: usize,
    // For every cell.
    states: Vec<CellState>,
    waiting: Vec<u32>,
    segments: Vec<Segment>,
}

/// State of a cell in the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CellState {
    /// It is not in the set, or its segment was taken out.
    Absent,
    /// It has not voted yet.
    Waiting,
    /// It has voted.
    Voted,
}

/// One half of a line, from a cell outward.
#[derive(Debug, Clone, Copy)]
struct Ray {
    // In 1/65536 cells; a whole cell along the axis the line is closer to.
    step: [i32; 2],
    // One cell along the other axis.
    across: [i32; 2],
}

/// The part of a ray that was followed.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// Steps to the last cell.
    n_steps: u32,
    /// Steps with a cell on the ray or beside it; those with a cell on it count twice.
    fit: u32,
}

impl Ray {
    fn at(self, position: [i32; 2], n_steps: u32) -> [i32; 2] {
        let along =
            |axis: usize| (i64::from(n_steps) * i64::from(self.step[axis]) + FIXED_ONE as i64 / 2) >> 16;
        [0, 1].map(|axis| position[axis] + along(axis) as i32)
    }
}

const FIXED_ONE: f64 = 65536.0;

impl HoughLines {
    /// A search over square grids of `n_columns` × `n_columns` cells.
    pub fn new(params: HoughParams, n_columns: u32) -> Self {
        let normal = |direction: u32| {
            let angle_rad = std::f64::consts::PI * f64::from(direction) / f64::from(params.n_directions);
            let (sine, cosine) = portable_math::sin_cos(angle_rad);
            [cosine, sine].map(|it| (it * FIXED_ONE).round() as i32)
        };
        let normals: Vec<[i32; 2]> = (0..params.n_directions).map(normal).collect();
        // From −n_columns, where the normal points to smaller columns, to the far corner.
        let n_distances = 3 * n_columns as usize;
        Self {
            n_columns,
            votes: vec![0; normals.len() * n_distances],
            normals,
            n_distances,
            states: vec![CellState::Absent; (n_columns * n_columns) as usize],
            waiting: Vec::new(),
            segments: Vec::new(),
            params,
        }
    }

    /// Finds the segments in the set `cells`, each given once.
    pub fn find(&mut self, cells: &[u32]) -> &[Segment] {
        self.segments.clear();
        self.votes.fill(0);
        self.waiting.clear();
        self.waiting.extend_from_slice(cells);
        for &cell_idx in cells {
            self.states[cell_idx as usize] = CellState::Waiting;
        }
        let mut random = SeededDraws::new(self.params.seed);
        while !self.waiting.is_empty() {
            let drawn = random.below(self.waiting.len());
            let cell_idx = self.waiting.swap_remove(drawn);
            if self.states[cell_idx as usize] != CellState::Waiting {
                continue;
            }
            self.states[cell_idx as usize] = CellState::Voted;
            let n_votes = self.vote(cell_idx);
            if n_votes >= self.params.min_votes {
                self.take_out_segment(cell_idx, n_votes);
            }
        }
        for &cell_idx in cells {
            self.states[cell_idx as usize] = CellState::Absent;
        }
        &self.segments
    }

    fn position(&self, cell_idx: u32) -> [i32; 2] {
        [cell_idx % self.n_columns, cell_idx / self.n_columns].map(|it| it as i32)
    }

    /// Index of the counter of a cell's votes for a direction.
    fn bin(&self, direction: usize, [column, row]: [i32; 2]) -> usize {
        let [cosine, sine] = self.normals[direction];
        let distance = (column * cosine + row * sine + FIXED_ONE as i32 / 2) >> 16;
        direction * self.n_distances + (distance + self.n_columns as i32) as usize
    }

    /// Votes for all lines through a cell; returns the votes of the line that has the most.
    fn vote(&mut self, cell_idx: u32) -> u16 {
        let position = self.position(cell_idx);
        let mut most = 0;
        for direction in 0..self.normals.len() {
            let bin = self.bin(direction, position);
            self.votes[bin] += 1;
            most = most.max(self.votes[bin]);
        }
        most
    }

    /// Takes the longest segment through a cell out of the set and keeps it if it is long enough.
    ///
    /// A few votes fit lines of several directions; of the lines with the most votes, the one that fits the most cells best
    /// is followed.
    fn take_out_segment(&mut self, cell_idx: u32, n_votes: u16) {
        let position = self.position(cell_idx);
        let mut best = (0, 0);
        for direction in 0..self.normals.len() {
            // One less, because the votes of a line that falls between two directions are shared by both.
            if self.votes[self.bin(direction, position)] + 1 >= n_votes {
                let fit: u32 = self.rays(direction).map(|ray| self.follow(position, ray).fit).iter().sum();
                if fit > best.1 {
                    best = (direction, fit);
                }
            }
        }
        let rays = self.rays(best.0);
        let [start, end] = rays.map(|ray| {
            let run = self.follow(position, ray);
            for n_steps in 1..=run.n_steps {
                for beside in self.cells_beside(position, ray, n_steps).into_iter().flatten() {
                    self.take_out(beside);
                }
            }
            ray.at(position, run.n_steps)
        });
        self.take_out(cell_idx);
        let length = (end[0] - start[0]).abs().max((end[1] - start[1]).abs()) + 1;
        if length >= self.params.min_length_cells as i32 {
            self.segments.push(Segment { start, end });
        }
    }

    /// The line of a direction, to both sides: it runs at a right angle to its normal.
    fn rays(&self, direction: usize) -> [Ray; 2] {
        let [cosine, sine] = self.normals[direction];
        let longer = cosine.abs().max(sine.abs());
        let step = [-sine, cosine].map(|it| (i64::from(it) * FIXED_ONE as i64 / i64::from(longer)) as i32);
        let across = if sine.abs() >= cosine.abs() { [0, 1] } else { [1, 0] };
        [-1, 1].map(|sense| Ray { step: step.map(|it| sense * it), across })
    }

    /// How far there are cells of the set along a ray from `position`, or beside it, without too long a gap.
    fn follow(&self, position: [i32; 2], ray: Ray) -> Run {
        let mut run = Run { n_steps: 0, fit: 0 };
        for n_steps in 1.. {
            let is_waiting =
                |it: Option<u32>| it.is_some_and(|it| self.states[it as usize] != CellState::Absent);
            let [on, beside @ ..] = self.cells_beside(position, ray, n_steps).map(is_waiting);
            if on || beside.contains(&true) {
                run = Run { n_steps, fit: run.fit + 1 + u32::from(on) };
            } else if n_steps - run.n_steps > self.params.max_gap_cells {
                break;
            }
        }
        run
    }

    /// The cell after so many steps along a ray and its neighbours across, those inside the grid.
    fn cells_beside(&self, position: [i32; 2], ray: Ray, n_steps: u32) -> [Option<u32>; 3] {
        let at = ray.at(position, n_steps);
        [0, -1, 1].map(|side| {
            let [column, row] = [at[0] + side * ray.across[0], at[1] + side * ray.across[1]];
            let inside = [column, row].iter().all(|it| (0..self.n_columns as i32).contains(it));
            inside.then(|| (row * self.n_columns as i32 + column) as u32)
        })
    }

    /// Takes a cell and its votes out of the set, if it is in it.
    fn take_out(&mut self, cell_idx: u32) {
        let state = std::mem::replace(&mut self.states[cell_idx as usize], CellState::Absent);
        if state == CellState::Voted {
            let position = self.position(cell_idx);
            for direction in 0..self.normals.len() {
                let bin = self.bin(direction, position);
                self.votes[bin] -= 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const N_COLUMNS: u32 = 60;

    fn search() -> HoughLines {
        let params =
            HoughParams { n_directions: 90, min_votes: 6, min_length_cells: 8, max_gap_cells: 2, seed: 1 };
        HoughLines::new(params, N_COLUMNS)
    }

    fn cells(positions: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
        let mut cells: Vec<u32> = positions.map(|(column, row)| row * N_COLUMNS + column).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The ends of a segment, the one with the smaller column first.
    fn ends(segment: Segment) -> [[i32; 2]; 2] {
        let mut ends = [segment.start, segment.end];
        ends.sort_unstable();
        ends
    }

    #[test]
    fn a_straight_run_is_one_segment_from_end_to_end() {
        let found = search().find(&cells((10..40).map(|column| (column, 20)))).to_vec();
        assert_eq!(found.iter().map(|&it| ends(it)).collect::<Vec<_>>(), [[[10, 20], [39, 20]]]);
    }

    #[test]
    fn two_walls_at_a_corner_are_two_segments() {
        let positions = (10..40).map(|column| (column, 20)).chain((21..45).map(|row| (10, row)));
        let found = search().find(&cells(positions)).to_vec();
        assert_eq!(found.len(), 2, "{found:?}");
    }

    #[test]
    fn a_short_gap_is_bridged_and_a_long_one_is_not() {
        let with_gap = |n: u32| cells((10..25).chain(25 + n..40).map(|column| (column, 20)));
        assert_eq!(search().find(&with_gap(2)).len(), 1);
        assert_eq!(search().find(&with_gap(3)).len(), 2);
    }

    #[test]
    fn what_is_too_short_or_scattered_is_no_segment() {
        assert_eq!(search().find(&cells((10..17).map(|column| (column, 20)))), []);
        // A knight's move apart, so that the longest straight runs have wide gaps.
        let scattered =
            (0..12).flat_map(|row| (0..12).map(move |column| (4 * column + row % 3, 4 * row + 3)));
        assert_eq!(search().find(&cells(scattered)), []);
    }

    #[test]
    fn the_search_before_leaves_no_trace() {
        let first = cells((5..50).map(|column| (column, 7)));
        let second = cells((5..50).map(|column| (column, column)));
        let mut used = search();
        used.find(&first);
        assert_eq!(used.find(&second), search().find(&second));
    }

    proptest! {
        #[test]
        fn a_run_in_any_direction_is_found_nearly_whole(
            angle_rad in 0.0_f64..std::f64::consts::PI, length in 16_u32..28,
        ) {
            let at = |step: f64| {
                let along = |share: f64| (30.0 + (step - f64::from(length) / 2.0) * share).round() as u32;
                (along(angle_rad.cos()), along(angle_rad.sin()))
            };
            let run = cells((0..=4 * length).map(|quarter| at(f64::from(quarter) / 4.0)));
            let found = search().find(&run).to_vec();
            let longest = found.iter().map(|it| {
                let [dx, dy] = [0, 1].map(|axis| f64::from(it.end[axis] - it.start[axis]));
                dx.hypot(dy)
            });
            let longest = longest.fold(0.0, f64::max);
            prop_assert!(longest >= 0.7 * f64::from(length) - 1.0, "{longest} of {length}: {found:?}");
        }

        #[test]
        fn any_set_of_cells_ends_within_the_grid(set in prop::collection::vec(0..N_COLUMNS * N_COLUMNS, 0..400)) {
            let mut set = set;
            set.sort_unstable();
            set.dedup();
            let mut search = search();
            for segment in search.find(&set) {
                for end in [segment.start, segment.end] {
                    prop_assert!(end.iter().all(|it| (-1..=N_COLUMNS as i32).contains(it)), "{segment:?}");
                }
            }
            // Every vote was given back or belongs to a cell that stayed.
            let n_voted = search.votes.iter().map(|&it| u32::from(it)).sum::<u32>();
            prop_assert_eq!(n_voted % 90, 0);
        }
    }
}
