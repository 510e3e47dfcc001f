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

#[derive(Debug)]
struct Track {
    // x, y in metres; velocity along both in metres per second.
    state: Vector4<f64>,
    covariance: Matrix4<f64>,
    at_us: TimeUs,
}

impl Tracker {
    /// Takes the centres of all detections at `at_us`, and gives the velocity of each, in metres per second: none at all for
    /// something that is seen for the first time.
    pub fn step(&mut self, at_us: TimeUs, centers_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.tracks.retain(|it| at_us - it.at_us <= LONGEST_UNSEEN_US);
        let expected: Vec<Track> = self.tracks.iter().map(|it| it.expected(at_us)).collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (track_idx, track) in expected.iter().enumerate() {
            for (center_idx, center_m) in centers_m.iter().enumerate() {
                let distance = track.squared_distance(*center_m);
                if distance <= GATE {
                    pairs.push((distance, track_idx, center_idx));
                }
            }
        }
        // The nearest first; equally near ones in the order of the tracks.
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut track_of: Vec<Option<usize>> = vec![None; centers_m.len()];
        let mut is_seen = vec![false; expected.len()];
        for (_, track_idx, center_idx) in pairs {
            if !is_seen[track_idx] && track_of[center_idx].is_none() {
                (is_seen[track_idx], track_of[center_idx]) = (true, Some(track_idx));
            }
        }
        let velocities = centers_m.iter().zip(&track_of).map(|(center_m, track_idx)| {
            let Some(track_idx) = *track_idx else {
                self.tracks.push(Track::new(at_us, *center_m));
                return [0.0; 2];
            };
            self.tracks[track_idx] = expected[track_idx].corrected(*center_m);
            let state = &self.tracks[track_idx].state;
            [state[2], state[3]]
        });
        velocities.collect()
    }
}

impl Track {
    fn new(at_us: TimeUs, [x_m, y_m]: [f64; 2]) -> Self {
        let [place, speed] = [MEASURED_M, NEW_M_PER_S].map(|it| it * it);
        let covariance = Matrix4::from_diagonal(&Vector4::new(place, place, speed, speed));
        Self { state: Vector4::new(x_m, y_m, 0.0, 0.0), covariance, at_us }
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
        Self { state: transition * self.state, covariance, at_us }
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
            state: self.state + gain * off_m,
            covariance: (Matrix4::identity() - gain * seen) * self.covariance,
            at_us: self.at_us,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_car_and_a_tree_have_their_speeds_after_a_second() {
        let mut tracker = Tracker::default();
        let mut velocities = Vec::new();
        for step in 0..11_i64 {
            let along_m = step as f64;
            velocities = tracker.step(step * 100_000, &[[along_m, 3.0], [20.0, -2.0]]);
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
        tracker.step(0, &[[0.0, 0.0]]);
        assert_eq!(tracker.step(100_000, &[[30.0, 0.0]]), [[0.0; 2]]);
        assert_eq!(tracker.tracks.len(), 2);
        assert_eq!(tracker.step(1_150_000, &[]), [[0.0; 2]; 0]);
        assert_eq!(tracker.tracks.len(), 0);
    }
}
