//! The points of one scan.

/// Points of one scan as columns, in the sensor frame: x forward, y left, z up, in metres, origin at the sensor.
///
/// Columns rather than rows, because the grid reads x, y and z in one pass and nothing else.
///
/// Coordinates may be NaN or infinite (a sensor that marks missing returns); every detector treats such
/// points as absent. Readers of files leave them out and count them.
///
/// ```
/// use detector::PointCloud;
///
/// let mut cloud = PointCloud::with_capacity(2);
/// cloud.push([8.0, 3.0, -1.2], 0.4);
/// cloud.push([8.1, 3.0, -1.2], 0.5);
/// assert_eq!(cloud.x_m(), [8.0, 8.1]);
/// assert_eq!(cloud.position_m(1), [8.1, 3.0, -1.2]);
///
/// // Positions alone have intensity 0, and nothing else.
/// let mut drawn: PointCloud = [[8.0, 3.0, -1.2], [8.1, 3.0, -1.2]].into_iter().collect();
/// assert_eq!((drawn.intensity(), drawn.ring()), (&[0.0, 0.0][..], None));
///
/// // Rings and times are there for all points or for none.
/// drawn.set_ring(vec![7, 8]);
/// assert_eq!(drawn.ring(), Some(&[7, 8][..]));
/// drawn.push([8.2, 3.0, -1.2], 0.5);
/// assert_eq!(drawn.ring(), None);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointCloud {
    // Invariant: all columns that there are have the same length.
    x_m: Vec<f32>,
    y_m: Vec<f32>,
    z_m: Vec<f32>,
    intensity: Vec<f32>,
    ring: Option<Vec<u16>>,
    time_offset_s: Option<Vec<f32>>,
}

impl PointCloud {
    /// An empty cloud with room for `n_points`.
    pub fn with_capacity(n_points: usize) -> Self {
        let column = || Vec::with_capacity(n_points);
        let (ring, time_offset_s) = (None, None);
        Self { x_m: column(), y_m: column(), z_m: column(), intensity: column(), ring, time_offset_s }
    }

    /// Appends a point; `intensity` is the sensor's own, usually in 0 to 1. Its ring and time are unknown, so that the cloud
    /// has neither any longer.
    pub fn push(&mut self, position_m: [f32; 3], intensity: f32) {
        self.x_m.push(position_m[0]);
        self.y_m.push(position_m[1]);
        self.z_m.push(position_m[2]);
        self.intensity.push(intensity);
        (self.ring, self.time_offset_s) = (None, None);
    }

    /// Replaces all points by those with these x, y, z and intensities, whose memory it takes and gives its own in return.
    /// Their rings and times are unknown, so that the cloud has neither any longer.
    ///
    /// # Panics
    ///
    /// If the columns are not of one length.
    pub fn swap_columns(&mut self, columns: &mut [Vec<f32>; 4]) {
        let n_points = columns[0].len();
        assert!(columns.iter().all(|it| it.len() == n_points), "each point has all numbers");
        let own = [&mut self.x_m, &mut self.y_m, &mut self.z_m, &mut self.intensity];
        own.into_iter().zip(columns).for_each(|(own, given)| std::mem::swap(own, given));
        (self.ring, self.time_offset_s) = (None, None);
    }

    /// Sets the laser that saw each point.
    ///
    /// # Panics
    ///
    /// If the number of rings is not the number of points.
    pub fn set_ring(&mut self, ring: Vec<u16>) {
        assert_eq!(ring.len(), self.len(), "each point has a ring");
        self.ring = Some(ring);
    }

    /// Sets the time at which each point was measured: seconds after the time of the scan, negative before it.
    ///
    /// # Panics
    ///
    /// If the number of times is not the number of points.
    pub fn set_time_offset_s(&mut self, time_offset_s: Vec<f32>) {
        assert_eq!(time_offset_s.len(), self.len(), "each point has a time");
        self.time_offset_s = Some(time_offset_s);
    }

    /// Moves every point to the position that `position_m` returns, in metres; intensity, ring and time stay.
    pub fn move_points(&mut self, position_m: impl Fn([f32; 3]) -> [f32; 3]) {
        for point_idx in 0..self.len() {
            let moved_m = position_m(self.position_m(point_idx));
            [self.x_m[point_idx], self.y_m[point_idx], self.z_m[point_idx]] = moved_m;
        }
    }

    /// Forgets the points and keeps the memory.
    pub fn clear(&mut self) {
        for column in [&mut self.x_m, &mut self.y_m, &mut self.z_m, &mut self.intensity] {
            column.clear();
        }
        (self.ring, self.time_offset_s) = (None, None);
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.x_m.len()
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.x_m.is_empty()
    }

    /// Forward coordinates in metres.
    pub fn x_m(&self) -> &[f32] {
        &self.x_m
    }

    /// Leftward coordinates in metres.
    pub fn y_m(&self) -> &[f32] {
        &self.y_m
    }

    /// Upward coordinates in metres.
    pub fn z_m(&self) -> &[f32] {
        &self.z_m
    }

    /// Reflected intensities.
    pub fn intensity(&self) -> &[f32] {
        &self.intensity
    }

    /// Number of the laser that saw each point, where the data have it.
    pub fn ring(&self) -> Option<&[u16]> {
        self.ring.as_deref()
    }

    /// Seconds from the time of the scan to the measurement of each point, where the data have it; negative before that
    /// time.
    pub fn time_offset_s(&self) -> Option<&[f32]> {
        self.time_offset_s.as_deref()
    }

    /// Position of point `point_idx` in metres.
    pub fn position_m(&self, point_idx: usize) -> [f32; 3] {
        [self.x_m[point_idx], self.y_m[point_idx], self.z_m[point_idx]]
    }

    /// Positions of all points in metres, in order.
    pub fn positions_m(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        (0..self.len()).map(|point_idx| self.position_m(point_idx))
    }
}

impl FromIterator<[f32; 3]> for PointCloud {
    /// A cloud of these positions (metres) with intensity 0.
    fn from_iter<I: IntoIterator<Item = [f32; 3]>>(positions_m: I) -> Self {
        let mut cloud = Self::default();
        for position_m in positions_m {
            cloud.push(position_m, 0.0);
        }
        cloud
    }
}
