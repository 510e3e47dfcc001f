//! Colours that follow the page they are on, light or dark.
//!
//! Whatever is drawn for a page has a class beside the colour of each of its elements. A page's style decides about the
//! class; a viewer that knows no styles takes the colour, which is legible on white.

use super::palette::{BLACK, DETECTOR_HUES, Hue, QUIET, Rgb, WHITE};

/// Ink, grid lines and paper on light and on dark backgrounds.
const LIGHT: [&str; 3] = ["#1b1f26", "#d7d7d7", "#ffffff"];
const DARK: [&str; 3] = ["#e6e8ec", "#3a3f48", "#14161b"];

/// The colours of panels within `selector`, for light and dark, and the classes that take them.
pub fn theme_css(selector: &str) -> String {
    let variables = |[ink, grid, paper]: [&str; 3], hue: fn(&Hue) -> Rgb| {
        let hues = DETECTOR_HUES.iter().enumerate();
        let hues: Vec<String> = hues.map(|(idx, it)| format!("--d{idx}:{};", hex(hue(it)))).collect();
        let hues = hues.concat();
        format!("{selector}{{--ink:{ink};--grid:{grid};--paper:{paper};{hues}}}")
    };
    let (light, dark) = (variables(LIGHT, |it| it.on_light), variables(DARK, |it| it.on_dark));
    let classes = ["ink", "grid", "paper"].into_iter().map(str::to_owned);
    let classes = classes.chain((0..DETECTOR_HUES.len()).map(|idx| format!("d{idx}")));
    let classes: Vec<String> =
        classes.map(|it| format!(".f-{it}{{fill:var(--{it})}}.k-{it}{{stroke:var(--{it})}}")).collect();
    format!("{light}@media screen and (prefers-color-scheme: dark){{{dark}}}{}", classes.concat())
}

/// What of an element has a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Paint {
    /// Its inside.
    Fill,
    /// Its line.
    Stroke,
}

/// The class of what is painted; `None` if its colour is the same on every page.
pub(crate) fn class_of(paint: Paint, color: Rgb) -> Option<String> {
    let letter = if paint == Paint::Fill { 'f' } else { 'k' };
    match color {
        BLACK => Some(format!("{letter}-ink")),
        WHITE => Some(format!("{letter}-paper")),
        QUIET => Some(format!("{letter}-grid")),
        _ => {
            let hue = DETECTOR_HUES.iter().position(|it| it.on_light == color)?;
            Some(format!("{letter}-d{hue}"))
        }
    }
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
