//! What the class ids of a recording mean.

use detector::stage_product::SurfaceClass;
use rerun::datatypes::{ClassDescription, Rgba32};

use super::palette::{self, Rgb};

/// Id of the class of a labelled object whose outcome is not drawn.
pub const ANNOTATION_ID: u16 = 8;
/// Clusters take this id and the next ones, in turn.
const FIRST_CLUSTER_ID: u16 = 32;

/// What became of a box, as one layer of the drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutcomeLayer {
    /// Detections that are right.
    Matched,
    /// Annotations that were found.
    Found,
    /// Annotations that were not found.
    Missed,
    /// Detections of nothing.
    False,
    /// Annotations that do not count.
    IgnoredAnnotation,
    /// Detections that do not count.
    IgnoredDetection,
    /// Detections of which it cannot be known.
    Unknowable,
}

impl OutcomeLayer {
    /// All layers, in the order of the legend.
    pub const ALL: [Self; 7] = [
        Self::Matched,
        Self::Found,
        Self::Missed,
        Self::False,
        Self::IgnoredAnnotation,
        Self::IgnoredDetection,
        Self::Unknowable,
    ];

    /// The last part of its entity path.
    pub fn path_part(self) -> &'static str {
        match self {
            Self::Matched => "matched",
            Self::Found => "found",
            Self::Missed => "missed",
            Self::False => "false",
            Self::IgnoredAnnotation => "ignored_annotations",
            Self::IgnoredDetection => "ignored_detections",
            Self::Unknowable => "unknowable",
        }
    }

    /// Its id in the annotation context.
    pub fn class_id(self) -> u16 {
        16 + self as u16
    }

    fn meaning(self) -> (&'static str, Rgb) {
        match self {
            Self::Matched => ("matched: detection", palette::MATCHED),
            Self::Found => ("matched: annotation", palette::MATCHED),
            Self::Missed => ("missed annotation", palette::MISSED),
            Self::False => ("false detection", palette::FALSE),
            Self::IgnoredAnnotation => ("ignored annotation", palette::IGNORED),
            Self::IgnoredDetection => ("ignored detection", palette::IGNORED),
            Self::Unknowable => ("detection that cannot be judged", palette::IGNORED),
        }
    }
}

/// The class id of a surface class.
pub fn surface_id(class: SurfaceClass) -> u16 {
    class as u16
}

/// The class id of cluster `cluster`; clusters share a few colours in turn.
pub fn cluster_id(cluster: u32) -> u16 {
    FIRST_CLUSTER_ID + (cluster as usize % palette::CYCLE.len()) as u16
}

/// Names and colours of all class ids.
pub fn class_descriptions() -> Vec<ClassDescription> {
    let surfaces =
        SurfaceClass::ALL.map(|it| described(surface_id(it), it.name(), palette::surface_color(it)));
    let outcomes = OutcomeLayer::ALL.map(|it| {
        let (name, color) = it.meaning();
        described(it.class_id(), name, color)
    });
    let clusters =
        (FIRST_CLUSTER_ID..).zip(palette::CYCLE).map(|(id, color)| described(id, "cluster", color));
    let annotation = described(ANNOTATION_ID, "annotation", palette::ANNOTATION);
    surfaces.into_iter().chain([annotation]).chain(outcomes).chain(clusters).collect()
}

/// A named dot of the drawn legend.
pub struct LegendDot {
    /// What it says.
    pub name: &'static str,
    /// In which colour.
    pub color: Rgb,
    /// Where, in the units of [`VISIBLE_X`] and [`VISIBLE_Y`].
    pub position: [f32; 2],
}

/// Left and right end of the drawn legend.
pub const VISIBLE_X: [f64; 2] = [-0.6, 3.6];
/// Top and bottom of the drawn legend.
pub const VISIBLE_Y: [f64; 2] = [-0.9, 2.0];
/// Where the name of the scan is written.
pub const TITLE_POSITION: [f32; 2] = [1.5, -0.75];

/// The drawn legend, outcomes above surfaces: views in three dimensions have no legend of their own.
pub fn dots() -> Vec<LegendDot> {
    let outcomes = [
        ("matched", palette::MATCHED),
        ("missed", palette::MISSED),
        ("false", palette::FALSE),
        ("ignored", palette::IGNORED),
    ];
    let surfaces = [SurfaceClass::Short, SurfaceClass::Tall, SurfaceClass::Clutter, SurfaceClass::Ground];
    let row = |y: f32| (0..4).map(move |column| [column as f32, y]);
    let dot = |((name, color), position)| LegendDot { name, color, position };
    let surfaces = surfaces.map(|it| (it.name(), palette::surface_color(it)));
    outcomes.into_iter().zip(row(0.0)).chain(surfaces.into_iter().zip(row(1.0))).map(dot).collect()
}

/// `color` as Rerun takes it, opaque.
pub fn rgba([r, g, b]: Rgb) -> Rgba32 {
    Rgba32::from_rgb(r, g, b)
}

fn described(id: u16, name: &str, color: Rgb) -> ClassDescription {
    ClassDescription::from((id, name, rgba(color)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_meanings_share_an_id() {
        let mut ids: Vec<u16> = class_descriptions().iter().map(|it| it.info.id).collect();
        let n_meanings = ids.len();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), n_meanings);
    }
}
