//! An object whose seen part grows.

use detector::PointCloud;

use super::ObjectCloud;

/// An object with the moments at which more of it was visible.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowingCloud {
    /// All points that were seen in the end, in the order in which they were seen.
    pub whole: ObjectCloud,
    /// Length, width and height of the object in metres, seen and unseen parts, where they are known.
    pub extents_m: Option<[f32; 3]>,
    /// The moments at which it can be judged, ascending; the last shows everything. Never empty.
    pub moments: Vec<Moment>,
}

/// A moment at which an object can be judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Number of points of [`GrowingCloud::whole`] seen by then: the first ones.
    pub n_points: usize,
    /// Seconds since the start of the observation; 0 if times are unknown.
    pub time_s: f64,
    /// Distance on the ground plan between the sensor and the middle of the object, in metres, where it is known.
    pub distance_m: Option<f32>,
}

impl GrowingCloud {
    /// An object that was seen at a single moment.
    pub fn seen_at_once(whole: ObjectCloud, extents_m: Option<[f32; 3]>, distance_m: Option<f32>) -> Self {
        let moment = Moment { n_points: whole.cloud.len(), time_s: 0.0, distance_m };
        Self { whole, extents_m, moments: vec![moment] }
    }

    /// The points that were seen by `moment`.
    pub fn seen_at(&self, moment: &Moment) -> PointCloud {
        let cloud = &self.whole.cloud;
        let mut seen = PointCloud::with_capacity(moment.n_points);
        for (position_m, intensity) in cloud.positions_m().zip(cloud.intensity()).take(moment.n_points) {
            seen.push(position_m, *intensity);
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::partial_class::PartialClass;

    #[test]
    fn what_is_seen_first_comes_first() {
        let cloud: PointCloud = (0..5).map(|it| [0.0, 0.0, it as f32]).collect();
        let whole = ObjectCloud { id: "pole".to_owned(), class: PartialClass::Pole, cloud };
        let growing = GrowingCloud::seen_at_once(whole, None, Some(7.0));
        let [last] = growing.moments[..] else { panic!("{growing:?}") };
        assert_eq!(growing.seen_at(&last), growing.whole.cloud);
        let early = Moment { n_points: 2, time_s: 0.0, distance_m: None };
        assert_eq!(growing.seen_at(&early).z_m(), [0.0, 1.0]);
    }
}
