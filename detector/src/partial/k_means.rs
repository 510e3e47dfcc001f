//! Groups of vectors that lie together.

use rayon::prelude::*;

use crate::seeded_draws::SeededDraws;

/// Rounds after which the grouping ends in any case.
const MOST_ROUNDS: usize = 100;
/// Fewest vectors that are worth a thread.
const LEAST_SHARE: usize = 256;

/// The means of at most `n_groups` groups of `vectors`, by the method of Lloyd from a start drawn as in k-means++; fewer if
/// there are fewer different vectors. None without vectors.
///
/// Equal vectors in equal order and an equal seed give the same means to the bit, with any number of threads.
///
/// Paper: BG section 3.2.
pub fn k_means<const D: usize>(vectors: &[[f64; D]], n_groups: usize, seed: u64) -> Vec<[f64; D]> {
    let mut centers = drawn_start(vectors, n_groups, seed);
    let mut group_of: Vec<usize> = vec![0; vectors.len()];
    for _ in 0..MOST_ROUNDS {
        let regroup = |(vector, group): (&[f64; D], &mut usize)| {
            let nearest = nearest_center(vector, &centers);
            std::mem::replace(group, nearest) != nearest
        };
        let pairs = vectors.par_iter().zip(&mut group_of).with_min_len(LEAST_SHARE);
        let is_changed = pairs.map(regroup).reduce(|| false, |one, other| one | other);
        let moved = means(vectors, &group_of, &centers);
        if moved == centers && !is_changed {
            break;
        }
        centers = moved;
    }
    centers
}

/// The index of the nearest of `centers`, the first of equally near ones; 0 without centres.
#[inline(always)]
pub fn nearest_center<const D: usize>(vector: &[f64; D], centers: &[[f64; D]]) -> usize {
    let mut best = (0, f64::INFINITY);
    for (center_idx, center) in centers.iter().enumerate() {
        let distance = squared(vector, center);
        if distance < best.1 {
            best = (center_idx, distance);
        }
    }
    best.0
}

#[inline(always)]
fn squared<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for value in 0..D {
        let off = a[value] - b[value];
        sum += off * off;
    }
    sum
}

/// The first vector drawn from all, each next one with a chance that grows with the square of its distance to those drawn
/// before.
fn drawn_start<const D: usize>(vectors: &[[f64; D]], n_groups: usize, seed: u64) -> Vec<[f64; D]> {
    let mut draws = SeededDraws::new(seed);
    let mut centers: Vec<[f64; D]> = Vec::with_capacity(n_groups);
    let mut squares = vec![1.0; vectors.len()];
    while centers.len() < n_groups {
        let whole: f64 = squares.iter().sum();
        if whole <= 0.0 {
            break;
        }
        let mut left = draws.share() * whole;
        let is_drawn = |square: &f64| {
            left -= square;
            left < 0.0
        };
        // Rounding may leave nothing drawn: then it is the last one that can be.
        let drawn = squares.iter().position(is_drawn).or_else(|| squares.iter().rposition(|&it| it > 0.0));
        let Some(drawn) = drawn else { break };
        let center = vectors[drawn];
        for (square, vector) in squares.iter_mut().zip(vectors) {
            let distance = squared(vector, &center);
            *square = if centers.is_empty() { distance } else { distance.min(*square) };
        }
        centers.push(center);
    }
    centers
}

/// The mean of every group; that of a group without vectors stays where it is.
fn means<const D: usize>(vectors: &[[f64; D]], group_of: &[usize], centers: &[[f64; D]]) -> Vec<[f64; D]> {
    let mut sums = vec![([0.0; D], 0.0); centers.len()];
    for (vector, &group) in vectors.iter().zip(group_of) {
        let (sum, n) = &mut sums[group];
        for value in 0..D {
            sum[value] += vector[value];
        }
        *n += 1.0;
    }
    let mean = |((sum, n), center): (&([f64; D], f64), &[f64; D])| {
        if *n > 0.0 { sum.map(|it| it / n) } else { *center }
    };
    sums.iter().zip(centers).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_lie_apart_are_found_whatever_the_seed() {
        let vectors = [[0.0, 0.0], [0.0, 1.0], [9.0, 0.0], [9.0, 1.0], [0.0, 20.0], [1.0, 20.0]];
        for seed in 0..20 {
            let mut centers = k_means(&vectors, 3, seed);
            centers.sort_by(|a, b| a[0].total_cmp(&b[0]));
            assert_eq!(centers, [[0.0, 0.5], [0.5, 20.0], [9.0, 0.5]]);
            assert_eq!(k_means(&vectors, 3, seed), k_means(&vectors, 3, seed));
        }
    }

    #[test]
    fn there_are_no_more_groups_than_different_vectors() {
        assert_eq!(k_means(&[[1.0]; 7], 3, 1), [[1.0]]);
        assert_eq!(k_means::<1>(&[], 3, 1), [[0.0; 1]; 0]);
        let mut two = k_means(&[[1.0], [2.0], [2.0]], 5, 1);
        two.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(two, [[1.0], [2.0]]);
    }

    #[test]
    fn the_first_of_equally_near_centers_counts() {
        assert_eq!(nearest_center(&[1.0], &[[3.0], [0.0], [2.0]]), 1);
    }
}
