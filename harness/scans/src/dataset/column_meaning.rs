//! The meaning of the columns of points, judged by their numbers.
//!
//! x, y and z come first; a file where one of them looks like something else is refused. A column of whole numbers, each of
//! which has an elevation of its own, is the laser. The first other column is the intensity, unless it only rises, as times
//! do, or has negative numbers.

use std::collections::BTreeMap;

use super::point_array::PointArray;
use super::point_columns::{PointColumn, PointColumns};

/// Number of points of a file that are sampled.
const N_SAMPLED: usize = 4096;

/// The columns of fewer points are not judged.
const MIN_POINTS: usize = 100;

/// A greater share of numbers is neither accident nor damage.
const NOTABLE: f64 = 0.01;

/// Share of the variance of elevations that lies between lasers, not within them. Intensities of whole numbers reach 0.2.
const MIN_BETWEEN_LASERS: f64 = 0.9;

/// No sensor has more lasers.
const MAX_LASERS: f64 = 512.0;

/// Points of some files with the same number of columns, column by column.
#[derive(Debug, Clone, Default)]
pub struct ColumnSample {
    columns: Vec<Vec<f64>>,
    n_files: usize,
}

impl ColumnSample {
    /// Adds points of `array`, which must have as many columns as the arrays before; a damaged array adds none.
    pub fn add(&mut self, array: &PointArray<'_>) {
        self.columns.resize(array.n_columns, Vec::new());
        self.n_files += 1;
        for (all, of_file) in self.columns.iter_mut().zip(array.sampled(N_SAMPLED).unwrap_or_default()) {
            all.extend(of_file);
        }
    }

    fn n_points(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Share of the numbers of column `index` for which `is_so` holds; 0 without numbers.
    fn share(&self, index: usize, is_so: impl Fn(f64) -> bool) -> f64 {
        let numbers = &self.columns[index];
        numbers.iter().filter(|it| is_so(**it)).count() as f64 / numbers.len().max(1) as f64
    }

    fn is_constant(&self, index: usize) -> bool {
        self.columns[index].windows(2).all(|pair| pair[0] == pair[1])
    }

    fn is_whole(&self, index: usize) -> bool {
        self.share(index, |it| it.fract() != 0.0) < NOTABLE && !self.is_constant(index)
    }

    /// Whether numbers never fall within a file, as times and numbers of points do not.
    fn rises(&self, index: usize) -> bool {
        let falls = self.columns[index].windows(2).filter(|pair| pair[1] < pair[0]).count();
        falls < self.n_files && !self.is_constant(index)
    }

    /// Whether the numbers of column `index` are those of lasers, each of which has an elevation of its own.
    fn is_laser(&self, index: usize) -> bool {
        if !self.is_whole(index) {
            return false;
        }
        let mut by_laser: BTreeMap<u64, Moments> = BTreeMap::new();
        let mut all = Moments::default();
        for (point_idx, number) in self.columns[index].iter().enumerate() {
            let [x_m, y_m, z_m] = [0, 1, 2].map(|axis| self.columns[axis][point_idx]);
            let elevation_rad = z_m.atan2(x_m.hypot(y_m));
            let is_seen = [x_m, y_m, z_m].iter().all(|it| it.is_finite()) && x_m.hypot(y_m) > 1.0;
            if !(0.0..MAX_LASERS).contains(number) {
                return false;
            }
            if is_seen {
                by_laser.entry(*number as u64).or_default().add(elevation_rad);
                all.add(elevation_rad);
            }
        }
        let within: f64 = by_laser.values().map(Moments::squares).sum();
        // A laser with a single point has no variance within it.
        all.n >= 10.0 * by_laser.len() as f64 && within <= (1.0 - MIN_BETWEEN_LASERS) * all.squares()
    }
}

/// Count, sum and sum of squares of numbers.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    n: f64,
    sum: f64,
    sum_of_squares: f64,
}

impl Moments {
    fn add(&mut self, number: f64) {
        self.n += 1.0;
        self.sum += number;
        self.sum_of_squares += number * number;
    }

    /// Sum of the squared distances from the mean.
    fn squares(&self) -> f64 {
        (self.sum_of_squares - self.sum * self.sum / self.n.max(1.0)).max(0.0)
    }
}

/// The meaning of the columns of `sample`; `usual` are those of the format, which are kept if nothing speaks against them.
/// Errors are the rest of a sentence about the file.
pub fn meaning_of(sample: &ColumnSample, usual: &PointColumns) -> Result<PointColumns, String> {
    let n_columns = sample.columns.len();
    if sample.n_points() < MIN_POINTS {
        return Ok(usual.resized(n_columns));
    }
    let are_whole = [0, 1, 2].map(|it| sample.is_whole(it));
    if let Some(axis) = are_whole.iter().position(|it| *it).filter(|_| are_whole.contains(&false)) {
        return Err(format!(
            "has whole numbers only in column {}, which cannot be {}",
            axis + 1,
            ["x", "y", "z"][axis]
        ));
    }
    let is_negative = |index: usize| sample.share(index, |it| it < 0.0) > NOTABLE;
    let kept = usual.position_of(PointColumn::Intensity).filter(|_| usual.n_columns() == n_columns);
    if kept.is_some_and(|it| !is_negative(it) && !sample.is_laser(it)) {
        return Ok(usual.clone());
    }
    let mut columns = vec![PointColumn::Other; n_columns - 3];
    let others = || 3..n_columns;
    let laser = others().find(|it| sample.is_laser(*it));
    let intensity = others().find(|it| Some(*it) != laser && !sample.rises(*it));
    match intensity.filter(|it| is_negative(*it)) {
        None => intensity.into_iter().for_each(|it| columns[it - 3] = PointColumn::Intensity),
        // Another value, such as a normal; or the column that belongs here is in front.
        Some(index) => {
            if let Some(axis) = (0..3).find(|it| !is_negative(*it)) {
                return Err(format!(
                    "has negative numbers in column {}, where the intensity is, and none in column {}",
                    index + 1,
                    axis + 1
                ));
            }
        }
    }
    if let Some(index) = laser {
        columns[index - 3] = PointColumn::Ring;
    }
    Ok(PointColumns::of_three_and(&columns))
}
