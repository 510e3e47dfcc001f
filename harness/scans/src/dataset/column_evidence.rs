//! The number of columns that the points of a file have, by its numbers alone.
//!
//! Numbers of one column are alike: heights lie in a few metres, intensities are not negative, lasers have whole numbers.
//! Read with a wrong number of columns, each column is a mixture of several. So the right number is the one whose columns
//! tell most about their numbers: the mutual information of the column with sign, magnitude and wholeness of the number, in
//! bits. On scans it is 0.4 to 2 bits for the right number of columns and its multiples, and 0 for numbers without a common
//! divisor with it. The order of points does not matter.

/// Numbers of columns that are compared. No point has two columns, but data that are not understood may seem to.
const N_COLUMNS: std::ops::RangeInclusive<usize> = 2..=12;

/// Powers of two between which magnitudes are distinguished.
const EXPONENTS: std::ops::Range<u32> = 119..142;

/// Kinds of numbers: zero and magnitudes, each with two signs, whole and not; and one for NaN and infinities.
const N_KINDS: usize = 4 * (EXPONENTS.end - EXPONENTS.start + 1) as usize + 1;

/// Columns with less information about their numbers show nothing, in bits.
const MIN_BITS: f64 = 0.2;

/// The smallest number of columns with this share of the most bits is taken: points follow one another in patterns, too.
const ENOUGH: f64 = 0.8;

/// Another number of columns with more than this share of the bits is another way to read the file.
const ANOTHER_WAY: f64 = 0.7;

/// The likelihood ratio, as a deviance, from which on one number of columns is surely better than another. Chance alone
/// reaches 70 on scans of a few points, and patterns of neighbouring points 200.
const MIN_DEVIANCE: f64 = 400.0;

/// From this many numbers on, it is no chance if two ways to read a file are nearly as good.
const MANY: usize = 4096;

/// Numbers of a file that are sampled: this many stretches of this many numbers, evenly spread.
const N_STRETCHES: usize = 16;
const N_IN_STRETCH: usize = 1024;

/// The number of columns, as far as the numbers show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenColumns {
    /// This many.
    Seen(usize),
    /// One of these two.
    Either(usize, usize),
    /// There are too few numbers, or they are all alike.
    Unseen,
}

/// Numbers of files, counted by kind and column for each number of columns.
#[derive(Debug, Clone)]
pub struct ColumnEvidence {
    // The counts of each column, for each of `N_COLUMNS` in turn.
    counts: Vec<[u32; N_KINDS]>,
    n_numbers: usize,
}

impl ColumnEvidence {
    /// Evidence without any numbers.
    pub fn new() -> Self {
        Self { counts: vec![[0; N_KINDS]; N_COLUMNS.sum()], n_numbers: 0 }
    }

    /// Evidence of one file.
    pub fn of(bytes: &[u8]) -> Self {
        let mut evidence = Self::new();
        evidence.add(bytes);
        evidence
    }

    /// Adds numbers of a file, which are little-endian f32.
    pub fn add(&mut self, bytes: &[u8]) {
        let (numbers, _) = bytes.as_chunks::<4>();
        let n_wanted = N_STRETCHES * N_IN_STRETCH;
        let (n_stretches, n_in_stretch) =
            if numbers.len() <= n_wanted { (1, numbers.len()) } else { (N_STRETCHES, N_IN_STRETCH) };
        for stretch in 0..n_stretches {
            let begin = stretch * (numbers.len() - n_in_stretch) / (n_stretches - 1).max(1);
            for (index, number) in (begin..).zip(&numbers[begin..begin + n_in_stretch]) {
                let kind = kind_of(f32::from_le_bytes(*number));
                let mut first = 0;
                for n_columns in N_COLUMNS {
                    self.counts[first + index % n_columns][kind] += 1;
                    first += n_columns;
                }
            }
            self.n_numbers += n_in_stretch;
        }
    }

    /// The number of columns that the evidence shows.
    pub fn seen(&self) -> SeenColumns {
        let (mut first, mut bits) = (0, Vec::new());
        let whole: [u32; N_KINDS] = std::array::from_fn(|kind| {
            self.counts[..*N_COLUMNS.start()].iter().map(|counts| counts[kind]).sum()
        });
        for n_columns in N_COLUMNS {
            let columns = &self.counts[first..first + n_columns];
            let within: f64 = columns.iter().map(total_bits).sum();
            bits.push((n_columns, (total_bits(&whole) - within) / self.n_numbers.max(1) as f64));
            first += n_columns;
        }
        let most = bits.iter().map(|(_, bits)| *bits).fold(0.0, f64::max);
        let Some((chosen, its_bits)) = bits.iter().copied().find(|(_, bits)| *bits >= ENOUGH * most) else {
            return SeenColumns::Unseen;
        };
        let others = bits.iter().copied().filter(|(n, _)| *n > 2 && n % chosen != 0);
        let (other, other_bits) = others.fold((0, 0.0), |best, it| if it.1 > best.1 { it } else { best });
        let deviance = |bits: f64| 2.0 * std::f64::consts::LN_2 * self.n_numbers as f64 * bits;
        if its_bits < MIN_BITS || chosen < 3 {
            SeenColumns::Unseen
        } else if other_bits > ANOTHER_WAY * its_bits && self.n_numbers >= MANY {
            SeenColumns::Either(other.min(chosen), other.max(chosen))
        } else if deviance(its_bits - other_bits) < MIN_DEVIANCE {
            SeenColumns::Unseen
        } else {
            SeenColumns::Seen(chosen)
        }
    }
}

/// Index of the kind: sign, magnitude and wholeness of a number.
fn kind_of(number: f32) -> usize {
    if !number.is_finite() {
        return N_KINDS - 1;
    }
    let exponent = (number.to_bits() >> 23) & 0xff;
    let magnitude = if number == 0.0 {
        0
    } else {
        exponent.clamp(EXPONENTS.start, EXPONENTS.end - 1) - EXPONENTS.start + 1
    };
    4 * magnitude as usize + 2 * usize::from(number.is_sign_negative()) + usize::from(number.fract() == 0.0)
}

/// Entropy of the counted kinds, times their number, in bits; corrected for small counts (Miller, Madow).
fn total_bits(counts: &[u32; N_KINDS]) -> f64 {
    let n: f64 = counts.iter().map(|it| f64::from(*it)).sum();
    let seen = counts.iter().filter(|it| **it > 0);
    let n_seen = seen.clone().count();
    let bits: f64 = seen.map(|it| f64::from(*it) * (n / f64::from(*it)).log2()).sum();
    bits + n_seen.saturating_sub(1) as f64 / (2.0 * std::f64::consts::LN_2)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A point with its laser and its time: x, y, z, intensity, ring and seconds.
    pub type DrawnPoint = [f32; 6];

    /// A scan of 32 lasers on a road between walls, `n` points in the order in which they are measured.
    pub fn drawn_scan(n: usize) -> Vec<DrawnPoint> {
        let point = |index: usize| {
            let (ring, column) = (index % 32, index / 32);
            let azimuth_rad = column as f32 * 0.0123;
            let elevation_rad = (ring as f32 - 22.0) * 0.023;
            let (sin, cos) = azimuth_rad.sin_cos();
            let to_wall_m = 7.3 / sin.abs().max(0.1);
            let to_road_m = if elevation_rad < 0.0 { -1.73 / elevation_rad.tan() } else { f32::MAX };
            let range_m = to_wall_m.min(to_road_m);
            let intensity = ((index * 37) % 101) as f32 / 128.0;
            let height_m = range_m * elevation_rad.tan();
            [range_m * cos, range_m * sin, height_m, intensity, ring as f32, index as f32 * 1e-6]
        };
        (0..n).map(point).collect()
    }

    /// The points in another order.
    fn shuffled(mut points: Vec<DrawnPoint>) -> Vec<DrawnPoint> {
        let n = points.len();
        (0..n).for_each(|index| points.swap(index, index * 7919 % n));
        points
    }

    pub fn bytes_of(points: &[DrawnPoint], row: impl Fn(&DrawnPoint) -> Vec<f32>) -> Vec<u8> {
        points.iter().flat_map(row).flat_map(f32::to_le_bytes).collect()
    }

    #[track_caller]
    fn check(row: impl Fn(&DrawnPoint) -> Vec<f32>, expected: usize) {
        for n in [4000, 4096, 19_200] {
            let measured = drawn_scan(n);
            let mut by_ring = measured.clone();
            by_ring.sort_by(|a, b| a[4].total_cmp(&b[4]));
            for points in [measured.clone(), by_ring, shuffled(measured)] {
                let seen = ColumnEvidence::of(&bytes_of(&points, &row)).seen();
                assert_eq!(seen, SeenColumns::Seen(expected), "{n} points");
            }
        }
    }

    #[test]
    fn any_number_of_columns_is_seen_in_any_order_of_points() {
        check(|it| it[..3].to_vec(), 3);
        check(|it| it[..4].to_vec(), 4);
        check(|it| it[..5].to_vec(), 5);
        check(|it| it.to_vec(), 6);
        check(|it| [&it[..4], &[0.0; 3]].concat(), 7);
        // As PCL holds them: x, y, z and 1, then intensity and padding.
        check(|&[x, y, z, intensity, ..]| vec![x, y, z, 1.0, intensity, 0.0, 0.0, 0.0], 8);
    }

    #[test]
    fn intensities_may_be_bytes_or_all_alike() {
        for intensity in [0.0, 1.0] {
            check(|&[x, y, z, ..]| vec![x, y, z, intensity], 4);
            check(|&[x, y, z, _, ring, _]| vec![x, y, z, intensity, ring], 5);
        }
        check(|&[x, y, z, intensity, ..]| vec![x, y, z, (intensity * 255.0).round()], 4);
        check(|&[x, y, z, intensity, ring, _]| vec![x, y, z, (intensity * 255.0).round(), ring], 5);
        // A quarter without a return.
        check(|it| if it[4] < 8.0 { vec![0.0; 5] } else { it[..5].to_vec() }, 5);
    }

    #[test]
    fn few_numbers_and_like_numbers_show_nothing() {
        for n in [0, 1, 2, 10] {
            let bytes = bytes_of(&drawn_scan(n), |it| it[..4].to_vec());
            assert_eq!(ColumnEvidence::of(&bytes).seen(), SeenColumns::Unseen, "{n} points");
        }
        for number in [0.0_f32, 1.5, f32::NAN] {
            let bytes: Vec<u8> = std::iter::repeat_n(number.to_le_bytes(), 40_000).flatten().collect();
            assert_eq!(ColumnEvidence::of(&bytes).seen(), SeenColumns::Unseen, "{number}");
        }
    }

    #[test]
    fn several_files_show_what_one_is_too_small_for() {
        let mut evidence = ColumnEvidence::new();
        for scan in drawn_scan(1600).chunks(16) {
            let bytes = bytes_of(scan, |it| it[..5].to_vec());
            assert_eq!(ColumnEvidence::of(&bytes[..100]).seen(), SeenColumns::Unseen);
            evidence.add(&bytes);
        }
        assert_eq!(evidence.seen(), SeenColumns::Seen(5));
    }

    proptest! {
        #[test]
        fn random_numbers_show_nothing(numbers in prop::collection::vec(any::<f32>(), 0..3000)) {
            let bytes: Vec<u8> = numbers.iter().flat_map(|it| it.to_le_bytes()).collect();
            prop_assert_eq!(ColumnEvidence::of(&bytes).seen(), SeenColumns::Unseen);
        }
    }
}
