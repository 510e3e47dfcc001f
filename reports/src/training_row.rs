//! `objects.csv` and `importance.csv`: what a trained model was judged by.

use serde::{Deserialize, Serialize};

use crate::csv_rows::CsvRow;
use crate::fixed_decimals::Fixed;

/// A held-out object with what the model sees of it and says about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JudgedObjectRow {
    data: String,
    sequence: String,
    kind: String,
    is_vehicle: bool,
    n_points: usize,
    range_m: Fixed<2>,
    decision: Fixed<5>,
    length_m: Fixed<4>,
    width_m: Fixed<4>,
    front_near_radius_m: Fixed<4>,
    front_far_radius_m: Fixed<4>,
    back_near_radius_m: Fixed<4>,
    back_far_radius_m: Fixed<4>,
    radius_difference_m: Fixed<4>,
    profile_difference: Fixed<4>,
}

impl CsvRow for JudgedObjectRow {
    const COLUMNS: &'static [&'static str] = &[
        "data",
        "sequence",
        "kind",
        "is_vehicle",
        "n_points",
        "range_m",
        "decision",
        "length_m",
        "width_m",
        "front_near_radius_m",
        "front_far_radius_m",
        "back_near_radius_m",
        "back_far_radius_m",
        "radius_difference_m",
        "profile_difference",
    ];
}

/// Where an object of [`JudgedObjectRow`] was seen, and what it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgedObjectPlace<'a> {
    /// Data set.
    pub data: &'a str,
    /// Drive.
    pub sequence: &'a str,
    /// What it is.
    pub kind: &'a str,
    /// Whether that is a vehicle.
    pub is_vehicle: bool,
    /// Number of its points.
    pub n_points: usize,
    /// Distance of the middle of its box from the sensor on the ground plan, in metres.
    pub range_m: f64,
}

impl JudgedObjectRow {
    /// The row of an object with its decision value and what that was made of, in the order of the columns.
    pub fn new(place: JudgedObjectPlace<'_>, decision: f32, features: &[f32; 8]) -> Self {
        let [
            length_m,
            width_m,
            front_near_radius_m,
            front_far_radius_m,
            back_near_radius_m,
            back_far_radius_m,
            radius_difference_m,
            profile_difference,
        ] = features.map(|it| Fixed(it.into()));
        Self {
            data: place.data.to_owned(),
            sequence: place.sequence.to_owned(),
            kind: place.kind.to_owned(),
            is_vehicle: place.is_vehicle,
            n_points: place.n_points,
            range_m: Fixed(place.range_m),
            decision: Fixed(decision.into()),
            length_m,
            width_m,
            front_near_radius_m,
            front_far_radius_m,
            back_near_radius_m,
            back_far_radius_m,
            radius_difference_m,
            profile_difference,
        }
    }
}

/// What one value is worth to a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImportanceRow {
    feature: String,
    roc_area_loss: Option<Fixed<5>>,
    n_objects: usize,
}

impl CsvRow for ImportanceRow {
    const COLUMNS: &'static [&'static str] = &["feature", "roc_area_loss", "n_objects"];
}

impl ImportanceRow {
    /// The row of a value without which, mixed up between `n_objects`, the area under the receiver operating characteristic
    /// is less by `roc_area_loss`.
    pub fn new(feature: &str, roc_area_loss: Option<f64>, n_objects: usize) -> Self {
        Self { feature: feature.to_owned(), roc_area_loss: roc_area_loss.map(Fixed), n_objects }
    }
}
