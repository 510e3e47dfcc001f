//! Colours that follow the page they are on, light or dark.
//!
//! Whatever is drawn for a page has a class beside the colour of each of its elements. A page's style decides about the class; a
//! viewer that knows no styles takes the colour, which is legible on white.

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

/// What `color` is on a page, as classes name it; `None` if it is the same on every page.
pub(crate) fn role_of(color: Rgb) -> Option<String> {
    match color {
        BLACK => Some("ink".to_owned()),
        WHITE => Some("paper".to_owned()),
        QUIET => Some("grid".to_owned()),
        _ => DETECTOR_HUES.iter().position(|it| it.on_light == color).map(|hue| format!("d{hue}")),
    }
}

/// The colour as SVG has it.
pub(crate) fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}
