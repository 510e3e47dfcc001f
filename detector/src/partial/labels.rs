//! The kinds of keypoints.

use serde::{Deserialize, Serialize};

use super::k_means::{k_means, nearest_center};
use super::patch_descriptor::Descriptor;

/// Tuning of [`Labeler`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelParams {
    /// Number of labels: the k of k-means.
    pub n_labels: usize,
    /// Whether values are divided by their deviation first.
    pub scaling: ValueScaling,
    /// Seed of the first means.
    pub seed: u64,
    /// Most descriptors that the means are made of; of more, as many are taken that are evenly spread over the objects.
    pub max_descriptors: usize,
}

/// How the values of descriptors are made comparable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ValueScaling {
    /// Divided by their deviation. Subtracting their mean would change no distance.
    Standardized,
}

/// The largest number of labels: a pattern keeps a byte for each, and one for a missing keypoint.
pub const MOST_LABELS: usize = 250;

/// Means of descriptors; a keypoint has the label of the nearest.
#[derive(Debug, Clone, PartialEq)]
pub struct Labeler {
    /// The divisor of each value.
    pub units: Descriptor,
    /// The means, in these units.
    pub centers: Vec<Descriptor>,
}

impl Labeler {
    /// Learns the labels of these descriptors.
    ///
    /// Paper: BG section 3.2.
    pub fn learned(descriptors: &[Descriptor], params: &LabelParams) -> Self {
        let n_taken = descriptors.len().min(params.max_descriptors);
        let taken: Vec<Descriptor> =
            (0..n_taken).map(|it| descriptors[it * descriptors.len() / n_taken]).collect();
        let units = deviations(&taken);
        let scaled: Vec<Descriptor> = taken.iter().map(|it| in_units(it, &units)).collect();
        Self { units, centers: k_means(&scaled, params.n_labels, params.seed) }
    }

    /// The label of a descriptor.
    pub fn label_of(&self, descriptor: &Descriptor) -> u8 {
        nearest_center(&in_units(descriptor, &self.units), &self.centers) as u8
    }
}

fn in_units(descriptor: &Descriptor, units: &Descriptor) -> Descriptor {
    std::array::from_fn(|value| descriptor[value] / units[value])
}

/// Standard deviations; 1 for values that are the same everywhere.
fn deviations(descriptors: &[Descriptor]) -> Descriptor {
    let n = descriptors.len().max(1) as f64;
    std::array::from_fn(|value| {
        let mean = descriptors.iter().map(|it| it[value]).sum::<f64>() / n;
        let squares = descriptors.iter().map(|it| (it[value] - mean) * (it[value] - mean));
        let deviation = (squares.sum::<f64>() / n).sqrt();
        if deviation > 1e-12 { deviation } else { 1.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial::patch_descriptor::N_DESCRIPTOR_VALUES;

    fn descriptor(cosine: f64, volume: f64) -> Descriptor {
        let mut values = [0.0; N_DESCRIPTOR_VALUES];
        (values[8], values[11]) = (cosine, volume);
        values
    }

    fn params(max_descriptors: usize) -> LabelParams {
        LabelParams { n_labels: 2, scaling: ValueScaling::Standardized, seed: 1, max_descriptors }
    }

    #[test]
    fn values_count_in_units_of_their_deviation() {
        let descriptors =
            [descriptor(0.0, 0.0), descriptor(1.0, 0.0), descriptor(0.0, 30.0), descriptor(1.0, 31.0)];
        let labeler = Labeler::learned(&descriptors, &params(9));
        assert!((labeler.units[8] - 0.5).abs() < 1e-12 && (labeler.units[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_more_descriptors_are_looked_at_than_allowed() {
        let mut descriptors = vec![descriptor(0.0, 0.0); 4];
        descriptors[3] = descriptor(9.0, 0.0);
        let n_centers =
            |of: &[Descriptor], max_descriptors| Labeler::learned(of, &params(max_descriptors)).centers.len();
        assert_eq!([2, 4].map(|it| n_centers(&descriptors, it)), [1, 2]);
        assert_eq!(n_centers(&[], 2), 0);
    }
}
