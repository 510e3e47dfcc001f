//! The colours of the viewer and their meanings.
//!
//! The hues can be distinguished with every kind of colour vision; the greys stay behind them on a dark background.

use detector::stage_product::LinkFate;
use detector::surface_class::SurfaceClass;
use reports::plots::palette::detector_hue;
pub use reports::plots::palette::{
    BLUE, BLUISH_GREEN, ORANGE, REDDISH_PURPLE, Rgb, SKY_BLUE, VERMILION, YELLOW,
};
use reports::verdicts::change::ChangeKind;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::partial_class::PartialClass;

/// A grey between the two ends.
pub const GREY: Rgb = [150, 150, 150];

/// A grey that stands out from the background.
const LIGHT_GREY: Rgb = [226, 226, 230];

/// A right detection, or the annotation it found.
pub const MATCHED: Rgb = BLUISH_GREEN;
/// An annotation that was not found.
pub const MISSED: Rgb = YELLOW;
/// A detection of nothing.
pub const FALSE: Rgb = VERMILION;
/// A box that is neither right nor wrong.
pub const IGNORED: Rgb = GREY;
/// A detection that all detectors have, where nothing is labelled.
pub const HAD_BY_ALL: Rgb = SKY_BLUE;
/// One that some other detectors have.
pub const HAD_BY_SOME: Rgb = YELLOW;
/// One that no other detector has.
pub const ALONE: Rgb = VERMILION;
/// An object that a person, or the simulator, labelled.
pub const ANNOTATION: Rgb = SKY_BLUE;
/// Circles around the sensor.
pub const RANGE_RINGS: Rgb = [70, 72, 80];
/// Background of the views.
pub const BACKGROUND: Rgb = [16, 17, 21];

/// Hues for things that have no meaning of their own, such as clusters; neighbours in the list differ most.
pub const CYCLE: [Rgb; 7] = [SKY_BLUE, ORANGE, BLUISH_GREEN, REDDISH_PURPLE, YELLOW, BLUE, VERMILION];

/// The colour of cluster `cluster`; clusters share a few colours in turn.
pub fn cluster_color(cluster: u32) -> Rgb {
    CYCLE[cluster as usize % CYCLE.len()]
}

/// The hue of the detector at `detector_idx` in the order of the run, as in plots and on pages.
pub fn detector_color(detector_idx: usize) -> Rgb {
    detector_hue(detector_idx).on_dark
}

/// The colour of points and cells of `class`: the foreground is bright, the ground is dim.
pub fn surface_color(class: SurfaceClass) -> Rgb {
    match class {
        SurfaceClass::Unseen => [52, 52, 58],
        SurfaceClass::Clutter => [112, 92, 72],
        SurfaceClass::Ground => [84, 84, 92],
        SurfaceClass::Tall | SurfaceClass::Wall => [72, 104, 158],
        SurfaceClass::Short => [226, 226, 230],
    }
}

/// The colour of links between cells.
pub fn link_color(fate: LinkFate) -> Rgb {
    match fate {
        LinkFate::Kept => SKY_BLUE,
        LinkFate::Cut => VERMILION,
        LinkFate::Unlinked => REDDISH_PURPLE,
    }
}

/// The colour of lines of the stage product `name`; unknown products are yellow.
pub fn line_color(name: &str) -> Rgb {
    match name {
        "segments" | "rectangles" | "concave_profiles" => ORANGE,
        "convex_profiles" => SKY_BLUE,
        "nearest_prototypes" => REDDISH_PURPLE,
        "corner_spheres" => GREY,
        "cuts" => VERMILION,
        _ => YELLOW,
    }
}

/// The colour of a class of partial clouds.
pub fn partial_class_color(class: PartialClass) -> Rgb {
    match class {
        PartialClass::Tree => BLUISH_GREEN,
        PartialClass::Car => ORANGE,
        PartialClass::Pole => SKY_BLUE,
        PartialClass::Pedestrian => REDDISH_PURPLE,
        PartialClass::Other => YELLOW,
    }
}

/// The colour of a change: losses warm, gains cold.
pub fn change_color(kind: ChangeKind) -> Rgb {
    match kind {
        ChangeKind::Lost => YELLOW,
        ChangeKind::NewFalse => VERMILION,
        ChangeKind::OtherClass => REDDISH_PURPLE,
        ChangeKind::Found => BLUISH_GREEN,
        ChangeKind::NoLongerFalse => SKY_BLUE,
        ChangeKind::Counting | ChangeKind::Otherwise | ChangeKind::NotShown => GREY,
    }
}

/// The colour of a class of objects, a hue for each group: the classes of a group differ in brightness. `None` is a class of
/// the user.
pub fn object_class_color(class: Option<AnnotationClass>) -> Rgb {
    use AnnotationClass as Class;
    let (hue, step) = match class {
        Some(Class::Car) => (ORANGE, 0),
        Some(Class::Van) => (ORANGE, 1),
        Some(Class::Truck) => (VERMILION, 0),
        Some(Class::Bus) => (VERMILION, 1),
        Some(Class::Pedestrian) => (REDDISH_PURPLE, 0),
        Some(Class::SittingPerson) => (REDDISH_PURPLE, 1),
        Some(Class::Cyclist) => (SKY_BLUE, 0),
        Some(Class::ParkedCycle) => (SKY_BLUE, 1),
        Some(Class::Tram) => (BLUE, 0),
        Some(Class::Trailer) => (BLUE, 1),
        Some(Class::ConstructionVehicle) => (BLUE, 2),
        Some(Class::Animal) => (REDDISH_PURPLE, 2),
        Some(Class::Tree) => (BLUISH_GREEN, 0),
        Some(Class::Hedge) => (BLUISH_GREEN, 1),
        Some(Class::Pole) => (LIGHT_GREY, 0),
        Some(Class::StreetFurniture) => (LIGHT_GREY, 1),
        Some(Class::Fence) => (GREY, 0),
        Some(Class::Misc | Class::Own(_)) | None => (YELLOW, 0),
    };
    // Towards white.
    hue.map(|it| it + ((u16::from(255 - it) * 3 * step) / 10) as u8)
}

/// The colour of points that have just been seen, and of those that were seen before.
pub const SEEN_NOW: Rgb = [240, 240, 245];
/// See [`SEEN_NOW`].
pub const SEEN_BEFORE: Rgb = [118, 122, 132];

/// The colour of a score, whose sign decides: from surely background over undecided to surely a vehicle.
pub fn score_color(score: f32) -> Rgb {
    // Beyond this a score is sure; the margin of the classifiers is at 1.
    const SURE: f32 = 1.0;
    let [from, to] = if score < 0.0 { [LIGHT_GREY, BLUE] } else { [LIGHT_GREY, ORANGE] };
    let share = (score.abs() / SURE).min(1.0).sqrt();
    [0, 1, 2].map(|channel| {
        let [low, high] = [from[channel], to[channel]].map(f32::from);
        (low + share * (high - low)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::plots::palette::DETECTOR_HUES;

    #[test]
    fn no_detector_has_the_colour_of_right_or_wrong_nor_that_of_another() {
        let colors: Vec<Rgb> = (0..DETECTOR_HUES.len()).map(detector_color).collect();
        for (idx, color) in colors.iter().enumerate() {
            assert!(![MATCHED, MISSED, FALSE, IGNORED].contains(color), "{idx}");
            assert!(!colors[..idx].contains(color), "{idx}");
        }
    }
}
