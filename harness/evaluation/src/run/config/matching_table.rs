//! How detections are judged, as a table of the configuration.

use std::collections::BTreeMap;

use detector::params::ParamsError;
use detector::params::bounds::{Bounds, check_bounds};
use reports::vocabulary::criterion::CriterionKind;
use serde::Deserialize;
use serde::de::Error as _;

use crate::matching::assign::MatchingParams;
use crate::matching::class_criteria::ClassCriteria;
use crate::matching::class_rule::ClassRule;
use crate::matching::criterion::Criterion;
use crate::matching::criterion_preset::CriterionPreset;
use crate::matching::eligibility::EligibilityParams;
use crate::run::config::slice_table::OwnSlices;

/// Default parameters of the matching, for every detector.
pub(super) const MATCHING_TOML: &str = r#"
criterion = "points"
min_iou = 0.5
max_centre_distance_m = 2.0
min_points = 20
max_range_m = 80.0
tall_above_ground_m = 3.1
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MatchingTable {
    criterion: CriterionKind,
    min_iou: f64,
    max_centre_distance_m: f64,
    min_points: usize,
    max_range_m: f64,
    tall_above_ground_m: f64,
    /// A benchmark whose criteria of classes are used.
    preset: Option<CriterionPreset>,
    /// The slice that alone is judged.
    only: Option<String>,
    /// Criteria of single classes.
    #[serde(default)]
    class: BTreeMap<String, ClassRule>,
}

/// Bounds of reasonable values.
pub(super) const MATCHING_BOUNDS: &[Bounds] = &[
    Bounds::new("min_iou", 0.01, 1.0),
    Bounds::new("max_centre_distance_m", 0.01, 100.0),
    Bounds::new("max_range_m", 1.0, 1000.0),
    Bounds::new("tall_above_ground_m", 0.1, 1000.0),
];

/// Keys of the table that have no shipped value.
pub(super) const WITHOUT_DEFAULT: [&str; 3] = ["class", "preset", "only"];

/// Reads the parameters of a complete TOML document; `slices` are the user's.
pub(super) fn matching_from(
    text: &str,
    slices: &OwnSlices,
) -> Result<(MatchingParams, ClassCriteria), ParamsError> {
    let table: MatchingTable = toml::from_str(text)?;
    check_bounds(&toml::from_str(text)?, MATCHING_BOUNDS)?;
    let criterion = match table.criterion {
        CriterionKind::Points => Criterion::Points { min_iou: table.min_iou },
        CriterionKind::BevIou => Criterion::BevIou { min_iou: table.min_iou },
        CriterionKind::Iou3d => Criterion::Iou3d { min_iou: table.min_iou },
        CriterionKind::Centre => Criterion::Centre { max_distance_m: table.max_centre_distance_m },
    };
    let eligibility = EligibilityParams {
        min_points: table.min_points,
        max_range_m: table.max_range_m,
        tall_above_ground_m: table.tall_above_ground_m,
        only: table.only.map(|it| slices.bounds_of(&it)).transpose().map_err(toml::de::Error::custom)?,
    };
    let class_criteria = ClassCriteria::new(table.class, table.preset).map_err(toml::de::Error::custom)?;
    Ok((MatchingParams { criterion, eligibility }, class_criteria))
}
