//! Where things are in a recording.

use detector::StageProduct;
use rerun::{ComponentIdentifier, EntityPath, EntityPathPart};

use super::legend::OutcomeLayer;
use crate::task::Task;

/// The timeline: the number of the scan within the run.
pub const SCAN_TIMELINE: &str = "scan";

/// Everything in three dimensions, in the sensor frame.
pub const WORLD: &str = "world";
/// Where the sensor is and which way is forward.
pub const SENSOR: &str = "world/sensor";
/// What does not depend on a detector.
pub const SCAN: &str = "world/scan";
/// The points of the scan, and one column of class ids per detector.
pub const POINTS: &str = "world/scan/points";
/// The labelled objects.
pub const ANNOTATIONS: &str = "world/scan/annotations";
/// What the colours mean, and which scan is shown.
pub const LEGEND: &str = "legend";
/// The colours.
pub const LEGEND_COLORS: &str = "legend/colors";
/// Which scan is shown.
pub const LEGEND_SCAN: &str = "legend/scan";
/// F-rates so far, one line per task and detector.
pub const F_RATE: &str = "series/f_rate";
/// Latencies in milliseconds, one line per detector.
pub const LATENCY: &str = "series/latency_ms";
/// Stage times in milliseconds, one line per detector and stage.
pub const STAGE_TIMES: &str = "series/stage_ms";

/// Numbers that only some recordings have, one line each.
pub const FURTHER: &str = "series/further";

const DETECTORS: &str = "world/detectors";

/// The kinds of stage products that have an entity of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProductKind {
    /// Columns over the ground.
    Cells,
    /// Straight lines.
    Segments,
    /// Closed outlines.
    Contours,
    /// Boxes.
    Boxes,
    /// Spheres.
    Spheres,
}

impl ProductKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Cells, Self::Segments, Self::Contours, Self::Boxes, Self::Spheres];

    fn path_part(self) -> &'static str {
        match self {
            Self::Cells => "cells",
            Self::Segments => "segments",
            Self::Contours => "contours",
            Self::Boxes => "boxes",
            Self::Spheres => "spheres",
        }
    }
}

/// Everything of one detector.
pub fn detector(name: &str) -> EntityPath {
    below(DETECTORS, &[name])
}

/// The products of one kind that the stages of a detector left behind.
pub fn products(detector: &str, kind: ProductKind) -> EntityPath {
    below(DETECTORS, &[detector, kind.path_part()])
}

/// One stage product that is no column of [`POINTS`].
pub fn stage_product(detector: &str, kind: ProductKind, product: &StageProduct) -> EntityPath {
    below(DETECTORS, &[detector, kind.path_part(), product.stage, product.name])
}

/// The outcomes of one detector for one task.
pub fn outcomes(detector: &str, task: Task) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name()])
}

/// One layer of outcomes.
pub fn outcome_layer(detector: &str, task: Task, layer: OutcomeLayer) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name(), layer.path_part()])
}

/// The F-rates of all detectors for one task.
pub fn f_rates(task: Task) -> EntityPath {
    below(F_RATE, &[task.name()])
}

/// The F-rate of one detector for one task.
pub fn f_rate(task: Task, detector: &str) -> EntityPath {
    below(F_RATE, &[task.name(), detector])
}

/// A series that only some recordings have.
pub fn further(name: &str) -> EntityPath {
    below(FURTHER, &[name])
}

/// The latency of one detector.
pub fn latency(detector: &str) -> EntityPath {
    below(LATENCY, &[detector])
}

/// The stage times of one detector.
pub fn stage_times(detector: &str) -> EntityPath {
    below(STAGE_TIMES, &[detector])
}

/// The column of [`POINTS`] that holds what the last stage of a detector takes the points for.
pub fn surface_column(detector: &str) -> ComponentIdentifier {
    column(&format!("{detector}:surfaces"))
}

/// The column of [`POINTS`] that holds the last clusters of a detector.
pub fn cluster_column(detector: &str) -> ComponentIdentifier {
    column(&format!("{detector}:clusters"))
}

/// The column of [`POINTS`] that holds labels of an earlier stage.
pub fn earlier_column(detector: &str, product: &StageProduct) -> ComponentIdentifier {
    column(&format!("{detector}:{}:{}", product.stage, product.name))
}

fn column(name: &str) -> ComponentIdentifier {
    ComponentIdentifier::try_new(name).expect("a name with a colon is not empty")
}

fn below(parent: &str, parts: &[&str]) -> EntityPath {
    let parts: Vec<EntityPathPart> = parts.iter().copied().map(EntityPathPart::new).collect();
    EntityPath::from(parent).join(&EntityPath::new(parts))
}
