//! What the colours of the viewer stand for.
//!
//! The hues can be told apart with every kind of colour vision; the greys stay behind them on a dark background.

use detector::stage_product::SurfaceClass;
use reports::palette::detector_hue;
pub use reports::palette::{BLUE, BLUISH_GREEN, ORANGE, REDDISH_PURPLE, Rgb, SKY_BLUE, VERMILION, YELLOW};

/// A grey between the two ends.
pub const GREY: Rgb = [150, 150, 150];

/// A right detection, or the annotation it found.
pub const MATCHED: Rgb = BLUISH_GREEN;
/// An annotation nobody found.
pub const MISSED: Rgb = YELLOW;
/// A detection of nothing.
pub const FALSE: Rgb = VERMILION;
/// What is neither right nor wrong.
pub const IGNORED: Rgb = GREY;
/// What a person, or the simulator, labelled.
pub const ANNOTATION: Rgb = SKY_BLUE;
/// Behind everything that is drawn in three dimensions.
pub const BACKGROUND: Rgb = [16, 17, 21];

/// Hues for things that have no meaning of their own, such as clusters; neighbours in the list differ most.
pub const CYCLE: [Rgb; 7] = [SKY_BLUE, ORANGE, BLUISH_GREEN, REDDISH_PURPLE, YELLOW, BLUE, VERMILION];

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
        SurfaceClass::Tall => [72, 104, 158],
        SurfaceClass::Short => [226, 226, 230],
    }
}
