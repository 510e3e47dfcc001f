//! The entry of a sweep in a manifest: parameters and their values.

use serde::{Deserialize, Serialize};

/// What was swept, and how often it was timed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweepEntry {
    /// The swept parameters by their full names; the first is the axis of plots.
    pub swept: Vec<SweptParameter>,
    /// Full names of the parameters that go with a swept one.
    pub tied: Vec<String>,
    /// Of each combination of values, that of each swept parameter, and then of each tied one.
    pub points: Vec<Vec<String>>,
    /// The value of the first swept parameter where it is not swept.
    pub configured: Option<String>,
    /// Scans of each data set that were timed.
    pub n_timed_scans_per_data_set: u32,
    /// Timed detections of each of these at each point.
    pub n_timed_detections_per_scan_and_point: u32,
}

/// A swept parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweptParameter {
    /// Its full name.
    pub name: String,
    /// Its values.
    pub values: Vec<String>,
}

/// Name of a detector with these `values` of `parameters`, such as `hierarchical@cell_size_m=0.6+xi=3`: with the last part of
/// the name of a parameter where no other ends alike.
pub fn entrant_name(detector: &str, parameters: &[String], values: &[String]) -> String {
    let end = |name: &'_ str| name.rsplit('.').next().unwrap_or(name).to_owned();
    let short = |name: &String| {
        let is_alone = parameters.iter().filter(|it| end(it) == end(name)).count() == 1;
        if is_alone { end(name) } else { name.clone() }
    };
    let set: Vec<String> =
        parameters.iter().zip(values).map(|(name, value)| format!("{}={value}", short(name))).collect();
    format!("{detector}@{}", set.join("+"))
}

impl SweepEntry {
    /// Name of `detector` at a point in the rows of the sweep.
    pub fn entrant(&self, detector: &str, point_idx: usize) -> String {
        entrant_name(detector, &self.parameters(), &self.points[point_idx])
    }

    /// Full names of the parameters that differ from point to point, in the order of the values of [`Self::points`].
    pub fn parameters(&self) -> Vec<String> {
        self.swept.iter().map(|it| it.name.clone()).chain(self.tied.iter().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entrant_is_named_as_shortly_as_it_can_be() {
        let texts = |names: &[&str]| names.iter().map(|it| (*it).to_owned()).collect::<Vec<_>>();
        let name =
            |parameters: &[&str], values: &[&str]| entrant_name("pca", &texts(parameters), &texts(values));
        assert_eq!(name(&["pca.grid.cell_size_m", "xi"], &["0.6", "3"]), "pca@cell_size_m=0.6+xi=3");
        assert_eq!(
            name(&["a.cell_size_m", "b.cell_size_m"], &["0.6", "0.8"]),
            "pca@a.cell_size_m=0.6+b.cell_size_m=0.8"
        );
    }
}
