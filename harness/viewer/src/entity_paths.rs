//! Where things are in a recording.

use detector::DetectedClass;
use detector::stage_product::Shape;
use reports::vocabulary::task::Task;
use rerun::{ComponentIdentifier, EntityPath, EntityPathPart};
use serde::{Deserialize, Serialize};

use super::legend::OutcomeLayer;

/// The timeline: the number of the scan within the run.
pub const SCAN_TIMELINE: &str = "scan";

/// Everything in three dimensions, in a frame that rests: that of the first scan of the drive.
pub const WORLD: &str = "world";
/// Everything that moves with the sensor, in its frame.
pub const SENSOR: &str = "world/sensor";
/// Position of the sensor and the direction of forward.
pub const FORWARD: &str = "world/sensor/forward";
/// Circles around the sensor.
pub const RANGE_RINGS: &str = "world/sensor/range_rings";
/// The latest positions of the sensor.
pub const DRIVE: &str = "world/drive";
/// Everything that does not depend on a detector.
pub const SCAN: &str = "world/sensor/scan";
/// The points of the scan, and columns of colours per detector.
pub const POINTS: &str = "world/sensor/scan/points";
/// The labelled objects.
pub const ANNOTATIONS: &str = "world/sensor/scan/annotations";
/// Positions that are pointed at.
pub const MARKS: &str = "world/sensor/scan/marks";
/// Legend of outcomes and surfaces.
pub const LEGEND_OUTCOMES: &str = "legend/outcomes";
/// Legend of stage products.
pub const LEGEND_STAGES: &str = "legend/stages";
/// Name of the scan that is shown.
pub const LEGEND_SCAN: &str = "legend/scan";
/// F-rates so far, one line per task and detector.
pub const F_RATE: &str = "series/f_rate";
/// Numbers of detections where nothing is labelled, one line per task and detector.
pub const DETECTIONS: &str = "series/detections";
/// Latencies in milliseconds, one line per detector.
pub const LATENCY: &str = "series/latency_ms";
/// Stage times in milliseconds, one line per detector and stage.
pub const STAGE_TIMES: &str = "series/stage_ms";

/// Found, missed and false objects of single scans, three lines per task and detector.
pub const COUNTS: &str = "series/counts";
/// Numbers that only some recordings have, one line each.
pub const FURTHER: &str = "series/further";
/// Missed and false objects, and why, a line of text for each.
pub const MISTAKES: &str = "mistakes";
/// The same of the scan that is shown, as a text with links to their boxes.
pub const MISTAKES_OF_SCAN: &str = "mistakes_of_scan";

const DETECTORS: &str = "world/sensor/detectors";

/// A drive as detectors know it, in a frame that rests.
pub const STREAM: &str = "stream";
/// The points of the newest scan, where they were seen.
pub const STREAM_SCAN: &str = "stream/scan";
/// What moves with the car.
pub const STREAM_SENSOR: &str = "stream/sensor";
/// The car itself.
pub const STREAM_CAR: &str = "stream/sensor/car";
/// Circles around the car.
pub const STREAM_RINGS: &str = "stream/sensor/range_rings";
/// How old what each detector knows is.
pub const STREAM_AGE: &str = "stream_series/age_ms";
/// The share of objects that are where each detector has them.
pub const STREAM_FOUND: &str = "stream_series/found";

/// What a detector knows in [`STREAM`].
pub fn known(detector: &str) -> EntityPath {
    below("stream/sensor/known", &[detector])
}

/// The line of a detector among these series.
pub fn stream_series(series: &str, detector: &str) -> EntityPath {
    below(series, &[detector])
}

/// The kinds of stage products that have an entity of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    /// Links between cells.
    Links,
    /// Columns over the ground by object.
    ObjectCells,
}

impl ProductKind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Cells,
        Self::Segments,
        Self::Contours,
        Self::Boxes,
        Self::Spheres,
        Self::Links,
        Self::ObjectCells,
    ];

    /// The kind of a shape; `None` if it labels points: those are columns of [`POINTS`].
    pub fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::LabeledPoints(_) | Shape::Clusters(_) => None,
            Shape::Cells { .. } => Some(Self::Cells),
            Shape::Segments(_) => Some(Self::Segments),
            Shape::Contours(_) => Some(Self::Contours),
            Shape::Boxes(_) => Some(Self::Boxes),
            Shape::Spheres(_) => Some(Self::Spheres),
            Shape::Links(_) => Some(Self::Links),
            Shape::ObjectCells { .. } => Some(Self::ObjectCells),
        }
    }

    fn path_part(self) -> &'static str {
        match self {
            Self::Cells => "cells",
            Self::Segments => "segments",
            Self::Contours => "contours",
            Self::Boxes => "boxes",
            Self::Spheres => "spheres",
            Self::Links => "links",
            Self::ObjectCells => "object_cells",
        }
    }
}

/// The colour of the lines of one detector, in [`LEGEND_OUTCOMES`].
pub fn legend_of_detector(name: &str) -> EntityPath {
    below(LEGEND_OUTCOMES, &["detectors", name])
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
pub fn stage_product(detector: &str, kind: ProductKind, stage: &str, product: &str) -> EntityPath {
    below(DETECTORS, &[detector, kind.path_part(), stage, product])
}

/// The part of a stage product that has this name, such as the cells of one class.
pub fn product_part(product: &EntityPath, name: &str) -> EntityPath {
    product.join(&EntityPath::new(vec![EntityPathPart::new(name)]))
}

/// How sure a detector is of each detection that it is a vehicle.
pub fn scores(detector: &str) -> EntityPath {
    below(DETECTORS, &[detector, "scores"])
}

/// The scores of detections of one class.
pub fn scores_of_class(detector: &str, class: DetectedClass) -> EntityPath {
    below(DETECTORS, &[detector, "scores", class.name()])
}

/// The outcomes of one detector for one task.
pub fn outcomes(detector: &str, task: Task) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name()])
}

/// One layer of outcomes.
pub fn outcome_layer(detector: &str, task: Task, layer: OutcomeLayer) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name(), layer.path_part()])
}

/// Mistakes of one detector that are pointed at.
pub fn marks(detector: &str) -> EntityPath {
    below(DETECTORS, &[detector, "marks"])
}

/// Dots above detections, by the class that their detector gives.
pub fn given_classes(detector: &str, task: Task) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name(), "classes"])
}

/// Arrows at detections whose detector gives their velocity.
pub fn velocities(detector: &str, task: Task) -> EntityPath {
    below(DETECTORS, &[detector, "outcomes", task.name(), "velocities"])
}

/// The F-rates of all detectors for one task.
pub fn f_rates(task: Task) -> EntityPath {
    below(F_RATE, &[task.name()])
}

/// The F-rate of one detector for one task.
pub fn f_rate(task: Task, detector: &str) -> EntityPath {
    below(F_RATE, &[task.name(), detector])
}

/// The numbers of detections of all detectors for one task.
pub fn numbers_of_detections(task: Task) -> EntityPath {
    below(DETECTIONS, &[task.name()])
}

/// The number of detections of one detector for one task.
pub fn number_of_detections(task: Task, detector: &str) -> EntityPath {
    below(DETECTIONS, &[task.name(), detector])
}

/// Found, missed and false objects of one detector for one task.
pub fn counts(detector: &str, task: Task) -> EntityPath {
    below(COUNTS, &[detector, task.name()])
}

/// One of these numbers, called `name`.
pub fn count(detector: &str, task: Task, name: &str) -> EntityPath {
    below(COUNTS, &[detector, task.name(), name])
}

/// Objects that one detector missed or found falsely in one task.
pub fn mistakes(detector: &str, task: Task) -> EntityPath {
    below(MISTAKES, &[detector, task.name()])
}

/// Those of the scan that is shown, as links to their boxes.
pub fn mistakes_of_scan(detector: &str, task: Task) -> EntityPath {
    below(MISTAKES_OF_SCAN, &[detector, task.name()])
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

/// The column of [`POINTS`] that holds the colours of a stage product which labels points.
pub fn point_colors(detector: &str, stage: &str, product: &str) -> ComponentIdentifier {
    let column = format!("{detector}:{stage}:{product}:colors");
    ComponentIdentifier::try_new(column).expect("a name with a colon is not empty")
}

/// A part of the recording of a growing object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GrowthPart {
    /// Everything in three dimensions.
    Scene,
    /// The points that have been seen.
    Points,
    /// The keypoints by their labels.
    Keypoints,
    /// The graphs of the keypoints.
    Graphs,
    /// Its predicted class, in words.
    Decision,
    /// The scanner that sees it.
    Scanner,
    /// The chance of each class.
    Chances,
    /// The distance to each class.
    Errors,
    /// How often patterns occur.
    Bag,
}

/// A part of the recording of a growing object, which is given by its data set, the end that it is seen from, and its name.
pub fn growth(of: &[String; 3], part: GrowthPart) -> EntityPath {
    let parts: &[&str] = match part {
        GrowthPart::Scene => &["scene"],
        GrowthPart::Points => &["scene", "points"],
        GrowthPart::Keypoints => &["scene", "keypoints"],
        GrowthPart::Graphs => &["scene", "graphs"],
        GrowthPart::Decision => &["scene", "decision"],
        GrowthPart::Scanner => &["scene", "scanner"],
        GrowthPart::Chances => &["chances"],
        GrowthPart::Errors => &["errors"],
        GrowthPart::Bag => &["bag"],
    };
    let of = of.each_ref().map(String::as_str);
    below("partial", &[&of, parts].concat())
}

fn below(parent: &str, parts: &[&str]) -> EntityPath {
    let parts: Vec<EntityPathPart> = parts.iter().copied().map(EntityPathPart::new).collect();
    EntityPath::from(parent).join(&EntityPath::new(parts))
}
