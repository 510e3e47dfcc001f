//! A small tracker, to show what forecasting gives: nearest neighbour, and a Kalman filter of constant velocity.

use nalgebra::{Matrix2, Matrix2x4, Matrix4, Vector2, Vector4};

use super::moving::TimeUs;

/// Standard deviation of a measured centre, in metres.
const MEASURED_M: f64 = 0.3;
/// Standard deviation of the velocity of something new, in metres per second.
const NEW_M_PER_S: f64 = 8.0;
/// Standard deviation of accelerations, in metres per second squared.
const ACCELERATION_M_PER_S2: f64 = 3.0;
/// A detection is farther away from where a track is expected in one of a hundred cases: the square of the distance in standard
/// deviations, of two degrees of freedom.
const GATE: f64 = 9.21;
/// A track without a detection for so long is given up.
const LONGEST_UNSEEN_US: TimeUs = 1_000_000;

/// Follows centres on the ground plan in a frame that rests.
#[derive(Debug, Default)]
pub struct Tracker {
    tracks: Vec<Track>,
}

/// A detection as the tracker sees it.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Its centre.
    pub center_m: [f64; 2],
    /// The number that its detector gives the object, if it follows it.
    pub track: Option<u32>,
}

#[derive(Debug)]
struct Track {
    // The number that the detector gives.
    number: Option<u32>,
    // x, y in metres; velocity along both in metres per second.
    state: Vector4<f64>,
    covariance: Matrix4<f64>,
    at_us: TimeUs,
}

impl Tracker {
    /// Takes all detections at `at_us`, and gives the velocity of each, in metres per second: none at all for something that
    /// is seen for the first time. What has a number is followed by it, and all else by its place.
    pub fn step(&mut self, at_us: TimeUs, all_seen: &[Seen]) -> Vec<[f64; 2]> {
        self.tracks.retain(|it| at_us - it.at_us <= LONGEST_UNSEEN_US);
        let expected: Vec<Track> = self.tracks.iter().map(|it| it.expected(at_us)).collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (track_idx, track) in expected.iter().enumerate() {
            for (seen_idx, seen) in all_seen.iter().enumerate() {
                let distance = track.squared_distance(seen.center_m);
                if seen.track == track.number && (seen.track.is_some() || distance <= GATE) {
                    pairs.push((distance, track_idx, seen_idx));
                }
            }
        }
        // The nearest first; equally near ones in the order of the tracks.
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut track_of: Vec<Option<usize>> = vec![None; all_seen.len()];
        let mut is_seen = vec![false; expected.len()];
        for (_, track_idx, seen_idx) in pairs {
            if !is_seen[track_idx] && track_of[seen_idx].is_none() {
                (is_seen[track_idx], track_of[seen_idx]) = (true, Some(track_idx));
            }
        }
        let velocities = all_seen.iter().zip(&track_of).map(|(seen, track_idx)| {
            let Some(track_idx) = *track_idx else {
                self.tracks.push(Track::new(at_us, seen));
                return [0.0; 2];
            };
            self.tracks[track_idx] = expected[track_idx].corrected(seen.center_m);
            let state = &self.tracks[track_idx].state;
            [state[2], state[3]]
        });
        velocities.collect()
    }
}

impl Track {
    fn new(at_us: TimeUs, &Seen { center_m: [x_m, y_m], track: number }: &Seen) -> Self {
        let [place, speed] = [MEASURED_M, NEW_M_PER_S].map(|it| it * it);
        let covariance = Matrix4::from_diagonal(&Vector4::new(place, place, speed, speed));
        Self { number, state: Vector4::new(x_m, y_m, 0.0, 0.0), covariance, at_us }
    }

    fn expected(&self, at_us: TimeUs) -> Self {
        let dt_s = (at_us - self.at_us) as f64 / 1e6;
        let mut transition = Matrix4::identity();
        (transition[(0, 2)], transition[(1, 3)]) = (dt_s, dt_s);
        let gain = nalgebra::Matrix4x2::new(
            dt_s * dt_s / 2.0,
            0.0, //
            0.0,
            dt_s * dt_s / 2.0, //
            dt_s,
            0.0, //
            0.0,
            dt_s,
        );
        let noise = gain * gain.transpose() * ACCELERATION_M_PER_S2.powi(2);
        let covariance = transition * self.covariance * transition.transpose() + noise;
        Self { number: self.number, state: transition * self.state, covariance, at_us }
    }

    fn innovation(&self, [x_m, y_m]: [f64; 2]) -> (Vector2<f64>, Matrix2<f64>) {
        let off_m = Vector2::new(x_m - self.state[0], y_m - self.state[1]);
        let spread = self.covariance.fixed_view::<2, 2>(0, 0) + Matrix2::identity() * MEASURED_M.powi(2);
        (off_m, spread)
    }

    fn squared_distance(&self, center_m: [f64; 2]) -> f64 {
        let (off_m, spread) = self.innovation(center_m);
        spread.try_inverse().map_or(f64::INFINITY, |it| off_m.dot(&(it * off_m)))
    }

    fn corrected(&self, center_m: [f64; 2]) -> Self {
        let (off_m, spread) = self.innovation(center_m);
        let seen = Matrix2x4::identity();
        let gain = self.covariance * seen.transpose() * spread.try_inverse().unwrap_or_else(Matrix2::zeros);
        Self {
            number: self.number,
            state: self.state + gain * off_m,
            covariance: (Matrix4::identity() - gain * seen) * self.covariance,
            at_us: self.at_us,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Something without a number.
    fn at(x_m: f64, y_m: f64) -> Seen {
        Seen { center_m: [x_m, y_m], track: None }
    }

    #[test]
    fn what_has_a_number_is_followed_by_it() {
        let mut tracker = Tracker::default();
        let numbered = |x_m: f64, track: u32| Seen { track: Some(track), ..at(x_m, 0.0) };
        tracker.step(0, &[numbered(0.0, 4), numbered(5.0, 9)]);
        // By their places the two would have stood still.
        let velocities = tracker.step(100_000, &[numbered(0.0, 9), numbered(5.0, 4), at(0.1, 0.0)]);
        assert!(velocities[0][0] < -20.0 && velocities[1][0] > 20.0, "{velocities:?}");
        assert_eq!(velocities[2], [0.0; 2]);
    }

    #[test]
    fn a_car_and_a_tree_have_their_speeds_after_a_second() {
        let mut tracker = Tracker::default();
        let mut velocities = Vec::new();
        for step in 0..11_i64 {
            let along_m = step as f64;
            velocities = tracker.step(step * 100_000, &[at(along_m, 3.0), at(20.0, -2.0)]);
            if step == 0 {
                assert_eq!(velocities, [[0.0; 2]; 2]);
            }
        }
        let [car, tree] = velocities[..] else { panic!("{velocities:?}") };
        assert!((car[0] - 10.0).abs() < 0.3 && car[1].abs() < 0.01, "{car:?}");
        assert!(tree[0].hypot(tree[1]) < 0.01, "{tree:?}");
    }

    #[test]
    fn what_is_far_from_all_tracks_is_new_and_what_was_unseen_for_long_is_forgotten() {
        let mut tracker = Tracker::default();
        tracker.step(0, &[at(0.0, 0.0)]);
        assert_eq!(tracker.step(100_000, &[at(30.0, 0.0)]), [[0.0; 2]]);
        assert_eq!(tracker.tracks.len(), 2);
        assert_eq!(tracker.step(1_150_000, &[]), [[0.0; 2]; 0]);
        assert_eq!(tracker.tracks.len(), 0);
    }
}
