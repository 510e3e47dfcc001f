//! Velocities of annotated objects, from their positions in the samples before and after.

/// No velocity is computed over more seconds than this, or over twice this across three samples.
const LONGEST_S: f64 = 1.5;

/// An object in one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Number of the object.
    pub track: u32,
    /// The time of the sample, in microseconds.
    pub time_us: u64,
    /// Whether the tables have a sample of it before.
    pub has_before: bool,
    /// Whether they have one after.
    pub has_after: bool,
    /// Its centre on the ground plan, in metres.
    pub center_m: [f64; 2],
    /// The token of the sample.
    pub sample: String,
    /// Its index among the annotations of the sample.
    pub index: usize,
}

/// Passes the known velocities in metres per second to `take`, with sample and index: from the sighting before to the one
/// after, or from or to this one if only one of them exists. As `box_velocity` of nuscenes-devkit.
pub fn add_velocities(mut sightings: Vec<Sighting>, mut take: impl FnMut(&str, usize, [f64; 2])) {
    sightings.sort_by_key(|it| (it.track, it.time_us));
    for of_track in sightings.chunk_by(|a, b| a.track == b.track) {
        for (index, it) in of_track.iter().enumerate() {
            let before = index.checked_sub(1).map(|before| &of_track[before]).filter(|_| it.has_before);
            let after = of_track.get(index + 1).filter(|_| it.has_after);
            let longest_s = if before.is_some() && after.is_some() { 2.0 * LONGEST_S } else { LONGEST_S };
            let (first, last) = (before.unwrap_or(it), after.unwrap_or(it));
            let seconds = 1e-6 * last.time_us as f64 - 1e-6 * first.time_us as f64;
            if seconds > 0.0 && seconds <= longest_s {
                let along = |axis: usize| (last.center_m[axis] - first.center_m[axis]) / seconds;
                take(&it.sample, it.index, [along(0), along(1)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocities of an object at these times and positions, where the tables state that it goes on.
    fn velocities(sightings: &[(u64, f64)]) -> Vec<Option<f64>> {
        let last = sightings.len() - 1;
        let sighting = |(index, (time_us, x_m)): (usize, &(u64, f64))| Sighting {
            track: 3,
            time_us: *time_us,
            has_before: index > 0,
            has_after: index < last,
            center_m: [*x_m, 0.0],
            sample: index.to_string(),
            index: 0,
        };
        let mut found = vec![None; sightings.len()];
        add_velocities(sightings.iter().enumerate().map(sighting).rev().collect(), |sample, _, velocity| {
            found[sample.parse::<usize>().unwrap()] = Some(velocity[0]);
        });
        found
    }

    #[test]
    fn a_velocity_is_from_before_to_after() {
        let found = velocities(&[(0, 0.0), (500_000, 1.0), (1_000_000, 4.0)]);
        assert_eq!(found, [Some(2.0), Some(4.0), Some(6.0)]);
    }

    #[test]
    fn what_is_seen_once_or_after_a_gap_has_none() {
        assert_eq!(velocities(&[(0, 0.0)]), [None]);
        assert_eq!(velocities(&[(0, 0.0), (2_000_000, 1.0)]), [None, None]);
        // Three seconds from the one before to the one after are not too long.
        assert_eq!(velocities(&[(0, 0.0), (2_000_000, 1.0), (3_000_000, 3.0)])[1], Some(1.0));
    }
}
