//! Colours that can be distinguished with every kind of colour vision: Okabe and Ito's palette.

/// Red, green and blue, 0 to 255.
pub type Rgb = [u8; 3];

/// Text, axes and annotations.
pub const BLACK: Rgb = [0, 0, 0];
/// Background of standalone documents.
pub const WHITE: Rgb = [255, 255, 255];
/// Background of dark pages.
pub const DARK_PAPER: Rgb = [20, 22, 27];
/// Grid lines and frames, which are no data.
pub const QUIET: Rgb = [215, 215, 215];
/// Band behind grid lines.
pub const BAND: Rgb = [232, 234, 237];
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
    /// The bright colour.
    pub on_dark: Rgb,
    /// The deep colour.
    pub on_light: Rgb,
}

/// Hues for detectors, none of which means right or wrong in the viewer. A thirteenth detector has the hue of the first.
pub const DETECTOR_HUES: [Hue; 12] = [
    Hue { on_dark: SKY_BLUE, on_light: BLUE },
    Hue { on_dark: ORANGE, on_light: VERMILION },
    Hue { on_dark: REDDISH_PURPLE, on_light: [156, 74, 120] },
    Hue { on_dark: [214, 214, 222], on_light: [70, 72, 84] },
    Hue { on_dark: [120, 90, 255], on_light: [58, 32, 190] },
    Hue { on_dark: [75, 205, 186], on_light: [66, 154, 141] },
    Hue { on_dark: [182, 128, 84], on_light: [128, 67, 16] },
    Hue { on_dark: [161, 69, 153], on_light: [226, 29, 210] },
    Hue { on_dark: [171, 226, 129], on_light: [92, 142, 54] },
    Hue { on_dark: [49, 93, 212], on_light: [4, 42, 143] },
    Hue { on_dark: [166, 81, 71], on_light: [88, 21, 14] },
    Hue { on_dark: [160, 112, 226], on_light: [109, 14, 241] },
];

/// The hue of the detector at `detector_idx` in the order of the run: the same in the viewer, in plots and on pages.
pub fn detector_hue(detector_idx: usize) -> Hue {
    DETECTOR_HUES[detector_idx % DETECTOR_HUES.len()]
}

/// Number of the shades of a share.
pub const N_SHADES: u32 = 7;

/// Shade `shade`, 1 to [`N_SHADES`]: the last is the fullest, the others are between it and the background.
pub fn shade_hue(shade: u32) -> Hue {
    let between = |background: Rgb, fullest: Rgb| {
        std::array::from_fn(|channel| {
            let [from, to] = [background, fullest].map(|it| i64::from(it[channel]));
            (from + (to - from) * i64::from(shade) / i64::from(N_SHADES)) as u8
        })
    };
    Hue { on_dark: between(DARK_PAPER, SKY_BLUE), on_light: between(WHITE, BLUE) }
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

    /// `color` as a person without one kind of cones sees it, as linear light.
    ///
    /// Viénot, Brettel and Mollon 1999: Digital video colourmaps for checking the legibility of displays by dichromats.
    fn seen_without(matrix: [[f64; 3]; 3], color: Rgb) -> [f64; 3] {
        let linear = color.map(|it| (f64::from(it) / 255.0).powf(2.2));
        matrix.map(|row| (0..3).map(|channel| row[channel] * linear[channel]).sum::<f64>().max(0.0))
    }

    #[test]
    fn hues_of_detectors_differ_for_every_kind_of_colour_vision() {
        const NORMAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        const PROTANOPE: [[f64; 3]; 3] =
            [[0.112_38, 0.887_62, 0.0], [0.112_38, 0.887_62, 0.0], [0.004_01, -0.004_01, 1.0]];
        const DEUTERANOPE: [[f64; 3]; 3] =
            [[0.292_75, 0.707_25, 0.0], [0.292_75, 0.707_25, 0.0], [-0.022_34, 0.022_34, 1.0]];
        for matrix in [NORMAL, PROTANOPE, DEUTERANOPE] {
            for of_background in [|hue: &Hue| hue.on_dark, |hue: &Hue| hue.on_light] {
                // As bright as screens show it.
                let seen = DETECTOR_HUES
                    .map(|it| seen_without(matrix, of_background(&it)).map(|it| it.powf(1.0 / 2.2)));
                for (idx, a) in seen.iter().enumerate() {
                    for b in &seen[..idx] {
                        let difference = (0..3).map(|it| (a[it] - b[it]).powi(2)).sum::<f64>().sqrt();
                        assert!(difference > 0.15, "{a:?} and {b:?}: {difference}");
                    }
                }
            }
        }
    }

    #[test]
    fn hues_stand_out_from_their_backgrounds() {
        for hue in DETECTOR_HUES {
            assert!(contrast(hue.on_light, WHITE) >= 3.0, "{hue:?}");
            assert!(contrast(hue.on_dark, DARK_PAPER) >= 3.0, "{hue:?}");
        }
    }
}
