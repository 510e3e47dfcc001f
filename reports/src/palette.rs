//! Colours that can be told apart with every kind of colour vision: Okabe and Ito's palette.

/// Red, green and blue, 0 to 255.
pub type Rgb = [u8; 3];

/// Orange.
pub const ORANGE: Rgb = [230, 159, 0];
/// Sky blue.
pub const SKY_BLUE: Rgb = [86, 180, 233];
/// Bluish green.
pub const BLUISH_GREEN: Rgb = [0, 158, 115];
/// Yellow.
pub const YELLOW: Rgb = [240, 228, 66];
/// Blue.
pub const BLUE: Rgb = [0, 114, 178];
/// Vermilion.
pub const VERMILION: Rgb = [213, 94, 0];
/// Reddish purple.
pub const REDDISH_PURPLE: Rgb = [204, 121, 167];

/// A hue that keeps its distance from light and from dark backgrounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hue {
    /// Bright.
    pub on_dark: Rgb,
    /// Deep.
    pub on_light: Rgb,
}

/// Hues for detectors; the first three are not those of right and wrong in the viewer.
pub const DETECTOR_HUES: [Hue; 4] = [
    Hue { on_dark: SKY_BLUE, on_light: BLUE },
    Hue { on_dark: ORANGE, on_light: VERMILION },
    Hue { on_dark: REDDISH_PURPLE, on_light: [156, 74, 120] },
    Hue { on_dark: BLUISH_GREEN, on_light: [0, 115, 90] },
];

/// The hue of the detector at `detector_idx` in the order of the run: the same in the viewer, in plots and on pages.
pub fn detector_hue(detector_idx: usize) -> Hue {
    DETECTOR_HUES[detector_idx % DETECTOR_HUES.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// WCAG 2: contrast of two colours, 1 to 21.
    fn contrast(a: Rgb, b: Rgb) -> f64 {
        let luminance = |color: Rgb| {
            let linear = color.map(|it| (f64::from(it) / 255.0).powf(2.2));
            0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn hues_stand_out_from_their_backgrounds() {
        for hue in DETECTOR_HUES {
            assert!(contrast(hue.on_light, [255, 255, 255]) >= 3.0, "{hue:?}");
            assert!(contrast(hue.on_dark, [20, 22, 27]) >= 3.0, "{hue:?}");
        }
    }
}
