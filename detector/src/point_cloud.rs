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
/// // Positions alone have intensity 0.
/// let drawn: PointCloud = [[8.0, 3.0, -1.2], [8.1, 3.0, -1.2]].into_iter().collect();
/// assert_eq!(drawn.intensity(), [0.0, 0.0]);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointCloud {
    // Invariant: the four columns have the same length.
    x_m: Vec<f32>,
    y_m: Vec<f32>,
    z_m: Vec<f32>,
    intensity: Vec<f32>,
}

impl PointCloud {
    /// An empty cloud with room for `n_points`.
    pub fn with_capacity(n_points: usize) -> Self {
        let column = || Vec::with_capacity(n_points);
        Self { x_m: column(), y_m: column(), z_m: column(), intensity: column() }
    }

    /// Appends a point; `intensity` is the sensor's own, usually in 0 to 1.
    pub fn push(&mut self, position_m: [f32; 3], intensity: f32) {
        self.x_m.push(position_m[0]);
        self.y_m.push(position_m[1]);
        self.z_m.push(position_m[2]);
        self.intensity.push(intensity);
    }

    /// Forgets the points and keeps the memory.
    pub fn clear(&mut self) {
        for column in [&mut self.x_m, &mut self.y_m, &mut self.z_m, &mut self.intensity] {
            column.clear();
        }
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
