//! Points at one position, which drivers write for beams without a return.

use detector::PointCloud;

/// Number of points of a scan that are sampled.
const N_SAMPLED: usize = 4096;

/// Scans with fewer points are passed over.
const MIN_POINTS: usize = 100;

/// If a greater share of the points is at one position, it was not measured there.
const MAX_SHARE: f64 = 0.02;

/// Points of a scan that share one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamePosition {
    /// Their share of all points.
    pub share: f64,
    /// The position, in metres.
    pub position_m: [f32; 3],
}

impl SamePosition {
    /// The position that a notable share of the points of one of `clouds` has; of several the one with the greatest share.
    /// `None` if there is none.
    pub fn of<'a>(clouds: impl IntoIterator<Item = &'a PointCloud>) -> Option<Self> {
        let of_clouds = clouds.into_iter().filter(|it| it.len() >= MIN_POINTS).filter_map(Self::of_cloud);
        let notable = of_clouds.filter(|it| it.share > MAX_SHARE);
        notable.reduce(|most, it| if it.share > most.share { it } else { most })
    }

    fn of_cloud(cloud: &PointCloud) -> Option<Self> {
        let n = cloud.len().min(N_SAMPLED);
        let mut sampled: Vec<[u32; 3]> =
            (0..n).map(|it| cloud.position_m(it * cloud.len() / n).map(|it| (it + 0.0).to_bits())).collect();
        sampled.sort_unstable();
        let most = sampled.chunk_by(|a, b| a == b).max_by_key(|it| it.len())?;
        Some(Self { share: most.len() as f64 / n as f64, position_m: most[0].map(f32::from_bits) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: usize, n_there: usize, there_m: [f32; 3]) -> PointCloud {
        (0..n).map(|it| if it % n < n_there { there_m } else { [it as f32, 1.0, -1.5] }).collect()
    }

    #[test]
    fn a_share_at_one_position_is_found_wherever_it_is() {
        let found = |n, n_there, there_m| SamePosition::of(&[cloud(n, n_there, there_m)]);
        for there_m in [[0.0; 3], [-0.0, 0.0, 0.0], [1.5, 0.0, 1.8]] {
            let expected = SamePosition { share: 0.25, position_m: there_m.map(|it| it + 0.0) };
            assert_eq!(found(4000, 1000, there_m), Some(expected));
        }
        assert_eq!(found(4000, 40, [0.0; 3]), None);
        assert_eq!(found(99, 50, [0.0; 3]), None);
        assert_eq!(SamePosition::of(&[PointCloud::default()]), None);
        let share = found(200_000, 100_000, [0.0; 3]).unwrap().share;
        assert!((share - 0.5).abs() < 0.01, "{share}");
        let both = [cloud(4000, 1000, [0.0; 3]), cloud(4000, 3000, [0.0; 3])];
        assert_eq!(SamePosition::of(&both).unwrap().share, 0.75);
    }
}
