//! Colours that follow the theme of the page, light or dark.
//!
//! Every drawn element has a class beside its colour. The style of a page, or of a standalone document, decides about the
//! class; a program that knows no styles takes the colour, which is legible on white.

use std::sync::LazyLock;

use super::palette::{BAND, BLACK, DARK_PAPER, DETECTOR_HUES, Hue, N_SHADES, QUIET, Rgb, WHITE, shade_hue};

/// The colours that follow a page: name of the class, colour in print, and colours on light and dark pages.
static THEMED: LazyLock<Vec<(String, Rgb, Hue)>> = LazyLock::new(|| {
    let of_pages = [
        ("ink", BLACK, Hue { on_light: [27, 31, 38], on_dark: [230, 232, 236] }),
        ("grid", QUIET, Hue { on_light: QUIET, on_dark: [58, 63, 72] }),
        ("band", BAND, Hue { on_light: BAND, on_dark: [38, 42, 50] }),
        ("paper", WHITE, Hue { on_light: WHITE, on_dark: DARK_PAPER }),
    ];
    let of_pages = of_pages.into_iter().map(|(name, print, hue)| (name.to_owned(), print, hue));
    let hues = DETECTOR_HUES.into_iter().enumerate().map(|(idx, it)| (format!("d{idx}"), it.on_light, it));
    // The fullest shade is the hue of the first detector, and has its class.
    let shades = (1..N_SHADES).map(|it| (format!("s{it}"), shade_hue(it).on_light, shade_hue(it)));
    of_pages.chain(hues).chain(shades).collect()
});

/// The colours of panels within `selector`, for light and dark, and the classes that take them.
pub fn theme_css(selector: &str) -> String {
    let variables = |on: fn(&Hue) -> Rgb| {
        let variables: Vec<String> =
            THEMED.iter().map(|(name, _, hue)| format!("--{name}:{};", hex(on(hue)))).collect();
        format!("{selector}{{{}}}", variables.concat())
    };
    let (light, dark) = (variables(|it| it.on_light), variables(|it| it.on_dark));
    let classes = THEMED.iter().map(|(it, ..)| it);
    let classes: Vec<String> =
        classes.map(|it| format!(".f-{it}{{fill:var(--{it})}}.k-{it}{{stroke:var(--{it})}}")).collect();
    format!("{light}@media screen and (prefers-color-scheme: dark){{{dark}}}{}", classes.concat())
}

/// The part of an element that has a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Paint {
    /// Its inside.
    Fill,
    /// Its line.
    Stroke,
}

/// The class of a part painted in `color`; `None` if that is the same on every page.
pub(crate) fn class_of(paint: Paint, color: Rgb) -> Option<String> {
    let letter = if paint == Paint::Fill { 'f' } else { 'k' };
    let (name, ..) = THEMED.iter().find(|(_, print, _)| *print == color)?;
    Some(format!("{letter}-{name}"))
}

/// Class and colour as attributes of an element.
pub(crate) fn painted(paint: Paint, color: Rgb) -> String {
    let attribute = if paint == Paint::Fill { "fill" } else { "stroke" };
    let class = class_of(paint, color).map_or_else(String::new, |it| format!("class=\"{it}\" "));
    format!("{class}{attribute}=\"{}\"", hex(color))
}

/// The colour as SVG has it.
pub(crate) fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_of_print_has_one_class() {
        for (idx, (name, print, _)) in THEMED.iter().enumerate() {
            assert!(THEMED[..idx].iter().all(|(_, other, _)| other != print), "{name}");
        }
        let fullest = class_of(Paint::Fill, shade_hue(N_SHADES).on_light);
        assert_eq!(fullest, class_of(Paint::Fill, DETECTOR_HUES[0].on_light));
    }
}
