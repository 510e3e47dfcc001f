//! The parameters of all stages.

use serde::{Deserialize, Serialize};

use super::bag::BagParams;
use super::decision::DecisionParams;
use super::keypoints::KeypointParams;
use super::labels::{LabelParams, MOST_LABELS};
use super::local_surface::SurfaceParams;
use super::patch_descriptor::DescriptorParams;
use super::patterns::PatternParams;
use super::thinned_points::ThinningParams;
use crate::params::ParamsError;
use crate::params::bounds::check_range;

/// Parameters of the bag of graphs, a table for each stage. The files explain the values.
///
/// ```
/// use detector::partial::partial_params::PartialParams;
///
/// let (ours, of_paper) = (PartialParams::shipped(), PartialParams::of_paper());
/// assert_ne!(ours.decision.rule, of_paper.decision.rule);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialParams {
    /// Evening out of points.
    pub thinning: ThinningParams,
    /// Local surfaces.
    pub surface: SurfaceParams,
    /// Keypoints.
    pub keypoints: KeypointParams,
    /// Their descriptors.
    pub descriptor: DescriptorParams,
    /// Their labels.
    pub labels: LabelParams,
    /// Their graphs.
    pub patterns: PatternParams,
    /// Bags of patterns.
    pub bag: BagParams,
    /// The decision.
    pub decision: DecisionParams,
}

/// The text of `params/partial.toml`.
pub const PARTIAL_TOML: &str = include_str!("../params/partial.toml");
/// The text of `params/partial_paper.toml`: what the paper states, and nothing else.
pub const PARTIAL_PAPER_TOML: &str = include_str!("../params/partial_paper.toml");

impl PartialParams {
    /// The parameters that come with the program.
    pub fn shipped() -> Self {
        Self::from_toml(PARTIAL_TOML).expect("the embedded file is tested")
    }

    /// The parameters of the paper.
    pub fn of_paper() -> Self {
        Self::from_toml(PARTIAL_PAPER_TOML).expect("the embedded file is tested")
    }

    /// Parameters from a complete TOML document.
    ///
    /// # Errors
    ///
    /// [`ParamsError`] if a parameter is missing, unknown or out of range.
    pub fn from_toml(text: &str) -> Result<Self, ParamsError> {
        let params: Self = toml::from_str(text)?;
        params.validate()?;
        Ok(params)
    }

    /// Checks that a detector can work with all values.
    ///
    /// # Errors
    ///
    /// [`ParamsError`] that names the first parameter that makes no sense.
    pub fn validate(&self) -> Result<(), ParamsError> {
        self.validate_points()?;
        self.validate_patterns()?;
        self.validate_decision()
    }

    fn validate_points(&self) -> Result<(), ParamsError> {
        let Self { thinning, surface, keypoints, descriptor, .. } = self;
        let cube_m = if thinning.cube_m == 0.0 { 1.0 } else { thinning.cube_m };
        for (name, value, range, allowed) in [
            ("thinning.cube_m", cube_m, [0.01, 10.0], "0.01 to 10 m, or 0"),
            ("thinning.max_points", thinning.max_points as f64, [1.0, 1e7], "1 to 10^7"),
            ("surface.radius_m", surface.radius_m, [0.05, 100.0], "0.05 to 100 m"),
            ("surface.max_neighbors", surface.max_neighbors as f64, [6.0, 1e6], "6 to 10^6"),
            ("surface.damping", surface.damping, [0.0, 1e6], "0 to 10^6"),
            ("keypoints.min_sphere", keypoints.min_sphere, [0.0, 1e3], "0 to 1000"),
            ("keypoints.max_sphere", keypoints.max_sphere, [keypoints.min_sphere, 1e3], "min_sphere to 1000"),
            ("descriptor.max_points", descriptor.max_points as f64, [4.0, 1e6], "4 to 10^6"),
            ("descriptor.small_scale", descriptor.small_scale, [0.01, 10.0], "0.01 to 10"),
            (
                "descriptor.large_scale",
                descriptor.large_scale,
                [descriptor.small_scale, 10.0],
                "small_scale to 10",
            ),
        ] {
            check_range(name, value, range, allowed)?;
        }
        Ok(())
    }

    fn validate_patterns(&self) -> Result<(), ParamsError> {
        let Self { labels, patterns, bag, .. } = self;
        check_range("labels.n_labels", labels.n_labels as f64, [1.0, MOST_LABELS as f64], "1 to 250")?;
        check_range("labels.max_descriptors", labels.max_descriptors as f64, [1.0, 1e8], "1 to 10^8")?;
        check_range("bag.min_share", bag.min_share, [0.0, 1.0], "0 to 1")?;
        let n_kinds = patterns.kinds.iter().collect::<std::collections::BTreeSet<_>>().len();
        let is_sound = n_kinds == patterns.kinds.len();
        check_range(
            "patterns.kinds",
            if is_sound { n_kinds as f64 } else { f64::NAN },
            [1.0, 4.0],
            "1 to 4 different kinds",
        )?;
        for (name, edges) in [
            ("patterns.height_edges_m", &patterns.height_edges_m),
            ("patterns.volume_edges_m3", &patterns.volume_edges_m3),
            ("patterns.extent_edges_m", &patterns.extent_edges_m),
            ("patterns.shape_edges_m", &patterns.shape_edges_m),
        ] {
            let allowed = "up to 100 ascending numbers";
            check_range(name, edges.len() as f64, [0.0, 100.0], allowed)?;
            let misplaced = edges.windows(2).find(|it| it[0] >= it[1]).map(|it| it[1]);
            let misplaced = misplaced.or_else(|| edges.iter().copied().find(|it| !it.is_finite()));
            if let Some(value) = misplaced {
                return Err(ParamsError::OutOfRange { name, value, allowed: allowed.to_owned() });
            }
        }
        Ok(())
    }

    fn validate_decision(&self) -> Result<(), ParamsError> {
        let DecisionParams { min_keypoints, evidence_edges, near_share, n_folds, weights, .. } =
            &self.decision;
        for (name, value, range, allowed) in [
            ("decision.min_keypoints", *min_keypoints as f64, [1.0, 1e6], "1 to 10^6"),
            ("decision.near_share", *near_share, [0.0, 1.0], "0 to 1"),
            ("decision.n_folds", *n_folds as f64, [2.0, 100.0], "2 to 100"),
            ("decision.weights.penalty", weights.penalty, [0.0, 1e6], "0 to 10^6"),
            ("decision.weights.n_steps", weights.n_steps as f64, [0.0, 1e6], "0 to 10^6"),
            ("decision.weights.step_size", weights.step_size, [0.0, 1e6], "0 to 10^6"),
            (
                "decision.evidence_edges",
                evidence_edges.len() as f64,
                [0.0, 100.0],
                "up to 100 ascending numbers",
            ),
        ] {
            check_range(name, value, range, allowed)?;
        }
        match evidence_edges.windows(2).find(|it| it[0] >= it[1]) {
            None => Ok(()),
            Some(pair) => {
                let (name, value) = ("decision.evidence_edges", pair[1] as f64);
                Err(ParamsError::OutOfRange {
                    name,
                    value,
                    allowed: "up to 100 ascending numbers".to_owned(),
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_decides_by_the_nearest_mean_of_graphs() {
        use crate::partial::decision::{Centers, DecisionRule};
        use crate::partial::patterns::PatternKind;
        let PartialParams { patterns, decision, .. } = PartialParams::of_paper();
        assert_eq!(patterns.kinds, [PatternKind::Graph]);
        assert_eq!((decision.rule, decision.centers), (DecisionRule::Nearest, Centers::OfClass));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        assert!(PARTIAL_TOML.contains(from));
        let error = PartialParams::from_toml(&PARTIAL_TOML.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn misspelled_missing_and_senseless_parameters_are_refused() {
        check_refused("radius_m", "radios_m", "unknown field `radios_m`");
        check_refused("damping", "# damping", "missing field `damping`");
        check_refused("min_sphere = ", "min_sphere = 2000.0 # ", "keypoints.min_sphere = 2000 is not within");
        check_refused("cube_m = ", "cube_m = 0.001 # ", "thinning.cube_m = 0.001 is not within");
        check_refused("radius_m = ", "radius_m = nan # ", "surface.radius_m = NaN is not within");
        check_refused("height_edges_m = [", "height_edges_m = [99.0, ", "patterns.height_edges_m = ");
        check_refused("kinds = [", "kinds = [\"keypoint\", \"keypoint\", ", "patterns.kinds = NaN");
        check_refused("evidence_edges = [", "evidence_edges = [999, ", "decision.evidence_edges = ");
    }
}
