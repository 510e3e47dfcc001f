//! Strays: points far beyond the end of an object that belong to something else.

/// Strays are this far from the rest, in metres.
const LEAST_GAP_M: f32 = 0.8;
/// At one end there are at most this many in a hundred points.
const MOST_OF_100: usize = 4;
/// Slices in which points are counted along an axis.
const N_SLICES: usize = 64;

/// The range of `values_m` without strays at either end, if some end has any. `range_m` is that of all of them.
pub fn without_strays(range_m: [f32; 2], values_m: impl Iterator<Item = f32> + Clone) -> Option<[f32; 2]> {
    let [low_m, high_m] = range_m;
    if high_m - low_m <= LEAST_GAP_M {
        return None;
    }
    let slices_per_m = N_SLICES as f32 / (high_m - low_m);
    let slice_of = |it_m: f32| (((it_m - low_m) * slices_per_m) as usize).min(N_SLICES - 1);
    let mut n_in_slice = [0_usize; N_SLICES];
    let mut n = 0;
    for it_m in values_m.clone() {
        n_in_slice[slice_of(it_m)] += 1;
        n += 1;
    }
    let least_slices = (LEAST_GAP_M * slices_per_m).ceil() as usize;
    let most = n * MOST_OF_100 / 100;
    let first = first_of_rest(n_in_slice.iter().copied(), least_slices, most);
    let last = N_SLICES - 1 - first_of_rest(n_in_slice.iter().rev().copied(), least_slices, most);
    if (first, last) == (0, N_SLICES - 1) || first > last {
        return None;
    }
    let kept = values_m.filter(|it| (first..=last).contains(&slice_of(*it)));
    let widened = |[low, high]: [f32; 2], it: f32| [low.min(it), high.max(it)];
    Some(kept.fold([f32::INFINITY, f32::NEG_INFINITY], widened))
}

/// The first slice behind the widest of the gaps of at least `least_slices` that have at most `most` points before them; 0
/// if there is none.
fn first_of_rest(n_in_slice: impl Iterator<Item = usize>, least_slices: usize, most: usize) -> usize {
    let (mut first, mut n_before, mut n_empty) = (0, 0, 0);
    for (slice, n) in n_in_slice.enumerate() {
        if n > 0 {
            if n_empty >= least_slices && n_before <= most {
                first = slice;
            }
            n_before += n;
            n_empty = 0;
        } else {
            n_empty += 1;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The range of values every 5 cm from 0 to 1.5 m, and of others.
    fn range_with(others_m: &[f32]) -> Option<[f32; 2]> {
        let body = (0..30_u8).map(|it| 0.05 * f32::from(it));
        // Four times, so that there are 120.
        let all: Vec<f32> = std::iter::repeat_n(body, 4).flatten().chain(others_m.iter().copied()).collect();
        let [low_m, high_m] = all
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], it| [low.min(*it), high.max(*it)]);
        without_strays([low_m, high_m], all.iter().copied())
    }

    #[test]
    fn a_few_points_far_from_the_end_are_strays() {
        assert_eq!(range_with(&[3.7, 3.8, 3.7, 3.9]), Some([0.0, 1.45]));
        assert_eq!(range_with(&[-2.0, 3.7]), Some([0.0, 1.45]));
        // One behind the other.
        assert_eq!(range_with(&[3.0, 5.0]), Some([0.0, 1.45]));
    }

    #[test]
    fn near_points_and_many_points_are_none() {
        assert_eq!(range_with(&[]), None);
        assert_eq!(range_with(&[2.0, 2.1]), None);
        assert_eq!(range_with(&[3.7; 6]), None);
    }
}
