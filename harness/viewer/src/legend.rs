//! The class ids of a recording and their meanings.

use detector::stage_product::LinkFate;
use detector::surface_class::SurfaceClass;
use re_sdk_types::datatypes::{ClassDescription, Rgba32};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::reason::Agreement;

use super::palette::{self, Rgb};

/// Id of the class of a labelled object whose outcome is not drawn.
pub const ANNOTATION_ID: u16 = 8;
/// Id of the first fate of a link; the others follow.
const FIRST_LINK_ID: u16 = 28;
/// Clusters take this id and the next ones, in turn.
const FIRST_CLUSTER_ID: u16 = 32;
/// Id of the first class of objects; the others of ours follow, and one for those of users.
const FIRST_OBJECT_CLASS_ID: u16 = 64;

/// Outcome of a box, as one layer of the drawing.
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
    /// Detections that cannot be judged.
    Unknowable,
    /// Detections that all detectors have, where nothing is labelled.
    HadByAll,
    /// Those that some others have.
    HadBySome,
    /// Those that no other has.
    Alone,
}

impl OutcomeLayer {
    /// All layers, in the order of the legend.
    pub const ALL: [Self; 10] = [
        Self::Matched,
        Self::Found,
        Self::Missed,
        Self::False,
        Self::IgnoredAnnotation,
        Self::IgnoredDetection,
        Self::Unknowable,
        Self::HadByAll,
        Self::HadBySome,
        Self::Alone,
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
            Self::HadByAll => "had_by_all",
            Self::HadBySome => "had_by_some",
            Self::Alone => "alone",
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
            Self::HadByAll => (Agreement::All.name(), palette::HAD_BY_ALL),
            Self::HadBySome => (Agreement::Some.name(), palette::HAD_BY_SOME),
            Self::Alone => (Agreement::Alone.name(), palette::ALONE),
        }
    }
}

/// The class id of a surface class.
pub fn surface_id(class: SurfaceClass) -> u16 {
    class as u16
}

/// The class id of the fate of a link.
pub fn link_id(fate: LinkFate) -> u16 {
    FIRST_LINK_ID + fate as u16
}

/// The class id of cluster `cluster`; clusters share a few colours in turn.
pub fn cluster_id(cluster: u32) -> u16 {
    FIRST_CLUSTER_ID + (cluster as usize % palette::CYCLE.len()) as u16
}

/// The class id of a class that a detector gives, by its name; classes of users share one.
pub fn object_class_id(name: &str) -> u16 {
    let place = AnnotationClass::ALL.iter().position(|it| it.name() == name);
    FIRST_OBJECT_CLASS_ID + place.unwrap_or(AnnotationClass::ALL.len()) as u16
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
    let links = LinkFate::ALL.map(|it| described(link_id(it), it.name(), palette::link_color(it)));
    let annotation = described(ANNOTATION_ID, "annotation", palette::ANNOTATION);
    let objects = AnnotationClass::ALL
        .map(|it| described(object_class_id(it.name()), it.name(), palette::object_class_color(Some(it))));
    let own = described(object_class_id(""), "class of the user", palette::object_class_color(None));
    let fixed = surfaces.into_iter().chain([annotation]).chain(outcomes).chain(links).chain(clusters);
    fixed.chain(objects).chain([own]).collect()
}

/// A named dot of a drawn legend.
pub struct LegendDot {
    /// Its name.
    pub name: String,
    /// Its colour.
    pub color: Rgb,
    /// Its position, in the units of [`VISIBLE_X`] and [`VISIBLE_Y`].
    pub position: [f32; 2],
}

/// Left and right end of a drawn legend.
pub const VISIBLE_X: [f64; 2] = [-1.5, 9.3];
/// Top and bottom of a drawn legend of three rows.
pub const VISIBLE_Y: [f64; 2] = [-2.8, 3.2];
/// Where the name of the scan is written.
pub const TITLE_POSITION: [f32; 2] = [3.9, -2.7];
/// From dot to dot: the names below them are wider than high.
const STEP: [f32; 2] = [2.6, 1.1];

/// Dots of outcomes, or of agreement where nothing is labelled, above those of surfaces: views in three dimensions have no legend of their own.
pub fn outcome_dots(is_labelled: bool) -> Vec<LegendDot> {
    let surface = |it: SurfaceClass| (it.name(), palette::surface_color(it));
    let boxes = if is_labelled {
        [
            ("matched", palette::MATCHED),
            ("missed", palette::MISSED),
            ("false", palette::FALSE),
            ("ignored", palette::IGNORED),
        ]
    } else {
        [
            ("all have it", palette::HAD_BY_ALL),
            ("some others", palette::HAD_BY_SOME),
            ("no other", palette::ALONE),
            ("ignored", palette::IGNORED),
        ]
    };
    let surfaces = [SurfaceClass::Short, SurfaceClass::Tall, SurfaceClass::Clutter, SurfaceClass::Ground];
    in_rows([boxes, surfaces.map(surface)])
}

/// Detectors in a row, below the outcomes and surfaces.
const DETECTORS_IN_A_ROW: usize = 3;

/// The dot of the detector at `detector_idx`, in the colour of its lines.
pub fn detector_dot(name: &str, detector_idx: usize) -> LegendDot {
    let (row, place) = (detector_idx / DETECTORS_IN_A_ROW, detector_idx % DETECTORS_IN_A_ROW);
    let position = [0.3 + 3.6 * place as f32, STEP[1] * (row + 2) as f32];
    LegendDot { name: name.to_owned(), color: palette::detector_color(detector_idx), position }
}

/// Top and bottom of the legend of outcomes, below which there are so many detectors.
pub fn visible_y(n_detectors: usize) -> [f64; 2] {
    let n_further_rows = n_detectors.div_ceil(DETECTORS_IN_A_ROW).saturating_sub(1);
    [VISIBLE_Y[0], VISIBLE_Y[1] + f64::from(STEP[1]) * n_further_rows as f64]
}

/// Dots of lines that stages draw, and of scores.
pub fn stage_dots() -> Vec<LegendDot> {
    let line = |name| palette::line_color(name);
    let link = |name, fate| (name, palette::link_color(fate));
    in_rows([
        [
            link("link kept", LinkFate::Kept),
            link("cut", LinkFate::Cut),
            link("heights differ", LinkFate::Unlinked),
            ("wall", line("segments")),
        ],
        [
            ("hull", line("hulls")),
            ("rectangle, concave", line("rectangles")),
            ("convex", line("convex_profiles")),
            ("prototype", line("nearest_prototypes")),
        ],
        [
            ("background", palette::score_color(-1.0)),
            ("undecided", palette::score_color(0.0)),
            ("vehicle", palette::score_color(1.0)),
            ("sphere", line("corner_spheres")),
        ],
    ])
}

fn in_rows<const N: usize>(rows: [[(&'static str, Rgb); 4]; N]) -> Vec<LegendDot> {
    let mut dots = Vec::new();
    for (row, y) in rows.into_iter().zip(0_u8..) {
        for ((name, color), x) in row.into_iter().zip(0_u8..) {
            let position = [STEP[0] * f32::from(x), STEP[1] * f32::from(y)];
            dots.push(LegendDot { name: name.to_owned(), color, position });
        }
    }
    dots
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
