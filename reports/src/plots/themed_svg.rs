//! Panels that follow the colours of the page they are on, light or dark, and sheets of them that stand alone.
//!
//! Every colour of the drawing library becomes a class beside its attribute. A page's style decides about the class; a viewer
//! that knows no styles takes the attribute, which is legible on white. There are no ids, so that nothing can collide.

use std::fmt::Write as _;

use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::{Reader, Writer};

use super::style::{BLACK_HEX, QUIET, WHITE_HEX, hex};
use crate::plots::palette::{DETECTOR_HUES, Hue, Rgb};

/// A drawing without a background.
#[derive(Debug, Clone, PartialEq)]
pub struct ThemedPanel {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// What is seen, in a sentence, for those who do not see it.
    pub label: String,
    elements: String,
}

/// One entry of the key to a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyEntry {
    /// What it stands for.
    pub name: String,
    /// The sample of its line and marker, [`KEY_SIZE_PX`] large.
    pub swatch: ThemedPanel,
}

/// Width and height of a sample in a key.
pub const KEY_SIZE_PX: [u32; 2] = [36, 16];

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

impl ThemedPanel {
    /// Makes classes of the colours of `svg`, a document of the drawing library.
    pub(crate) fn of_library(svg: &str, size_px: [u32; 2], label: String) -> Self {
        Self::of_file(svg, size_px, label).expect("the library writes XML")
    }

    /// The same of a file, which somebody may have changed; `None` if it is no XML.
    pub(crate) fn of_file(svg: &str, size_px: [u32; 2], label: String) -> Option<Self> {
        let mut reader = Reader::from_str(svg);
        let mut writer = Writer::new(Vec::new());
        // Of one element, with references as they are; the library puts lines around it.
        let mut text = String::new();
        loop {
            let event = reader.read_event().ok()?;
            if matches!(event, Event::Start(_) | Event::Empty(_) | Event::End(_)) {
                let whole = std::mem::take(&mut text);
                write(&mut writer, Event::Text(BytesText::from_escaped(whole.trim())));
            }
            match event {
                Event::Eof => break,
                Event::Start(tag) if tag.name().as_ref() != b"svg" => {
                    write(&mut writer, Event::Start(with_classes(&tag)));
                }
                Event::End(tag) if tag.name().as_ref() != b"svg" => write(&mut writer, Event::End(tag)),
                Event::Empty(tag) => write(&mut writer, Event::Empty(with_classes(&tag))),
                Event::Text(part) => text.push_str(&String::from_utf8_lossy(&part)),
                Event::GeneralRef(part) => {
                    text.push('&');
                    text.push_str(&String::from_utf8_lossy(&part));
                    text.push(';');
                }
                _ => {}
            }
        }
        let elements = String::from_utf8(writer.into_inner()).ok()?;
        Some(Self { size_px, label, elements })
    }

    /// A panel of elements that have classes already.
    pub(crate) fn of_elements(elements: String, size_px: [u32; 2], label: String) -> Self {
        Self { size_px, label, elements }
    }

    /// For a page: as wide as there is room.
    pub fn inline(&self) -> String {
        let [width, height] = self.size_px;
        let label = escape(&self.label);
        format!(
            r#"<svg class="plot" role="img" viewBox="0 0 {width} {height}"><title>{label}</title>{}</svg>"#,
            self.elements
        )
    }

    /// For a page, beside words that say the same.
    pub fn inline_hidden(&self) -> String {
        let [width, height] = self.size_px;
        format!(
            r#"<svg class="swatch" aria-hidden="true" viewBox="0 0 {width} {height}" width="{width}" height="{height}">{}</svg>"#,
            self.elements
        )
    }
}

/// Panels side by side under a title and a key, as a document that stands alone.
pub fn sheet(panels: &[ThemedPanel], key: &[KeyEntry], title: &str) -> String {
    let mut x_px = MARGIN_PX;
    let places = panels.iter().map(|it| {
        let place = [x_px, 0];
        x_px += it.size_px[0] + MARGIN_PX;
        place
    });
    sheet_with(panels, &places.collect::<Vec<_>>(), key, title)
}

/// The same with one panel below the other, and without a key.
pub fn stack(panels: &[ThemedPanel], title: &str) -> String {
    let mut y_px = 0;
    let places = panels.iter().map(|it| {
        let place = [MARGIN_PX, y_px];
        y_px += it.size_px[1] + MARGIN_PX;
        place
    });
    sheet_with(panels, &places.collect::<Vec<_>>(), &[], title)
}

const MARGIN_PX: u32 = 16;

/// Panels with their upper left corners at `places_px` below title and key.
fn sheet_with(panels: &[ThemedPanel], places_px: &[[u32; 2]], key: &[KeyEntry], title: &str) -> String {
    const KEY_Y_PX: u32 = 40;
    let placed = || panels.iter().zip(places_px);
    let panels_width = placed().map(|(it, [x, _])| x + it.size_px[0]).max().unwrap_or(0);
    let key_width = |it: &KeyEntry| KEY_SIZE_PX[0] + 10 + 8 * it.name.chars().count() as u32 + 24;
    let keys_width: u32 = key.iter().map(key_width).sum();
    let title_width = 9 * title.chars().count() as u32;
    let width = (panels_width.max(keys_width).max(title_width) + MARGIN_PX).max(200);
    let top = if key.is_empty() { KEY_Y_PX } else { KEY_Y_PX + 28 };
    let height = top + placed().map(|(it, [_, y])| y + it.size_px[1]).max().unwrap_or(0) + MARGIN_PX;
    let (title, style) = (escape(title), theme_css("svg.sheet"));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"sheet\" role=\"img\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<title>{title}</title>\n<style>{style}</style>\n\
         <rect class=\"f-paper\" width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
         <text class=\"f-ink\" x=\"{MARGIN_PX}\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\" fill=\"{BLACK_HEX}\">\
         {title}</text>\n"
    );
    let mut x = MARGIN_PX;
    for entry in key {
        let [w, h] = KEY_SIZE_PX;
        let name = escape(&entry.name);
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<svg x=\"{x}\" y=\"{KEY_Y_PX}\" width=\"{w}\" height=\"{h}\">{}</svg><text class=\"f-ink\" x=\"{}\" y=\"{}\" \
             font-family=\"sans-serif\" font-size=\"13\" fill=\"{BLACK_HEX}\">{name}</text>",
            entry.swatch.elements,
            x + w + 6,
            KEY_Y_PX + 12
        );
        x += key_width(entry);
    }
    for (panel, [x, y]) in placed() {
        let [w, h] = panel.size_px;
        let y = top + y;
        let _ = writeln!(
            svg,
            "<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\"><title>{}</title>{}</svg>",
            escape(&panel.label),
            panel.elements
        );
    }
    svg.push_str("</svg>\n");
    svg
}

fn write(writer: &mut Writer<Vec<u8>>, event: Event<'_>) {
    writer.write_event(event).expect("memory takes all that is written");
}

/// The tag with a class for each colour that a theme may change.
fn with_classes(tag: &BytesStart<'_>) -> BytesStart<'static> {
    let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
    let mut themed = BytesStart::new(name);
    let mut classes = Vec::new();
    for attribute in tag.attributes().flatten() {
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let value = String::from_utf8_lossy(&attribute.value).into_owned();
        match (key.as_str(), class_of(&value)) {
            ("fill", Some(class)) => classes.push(format!("f-{class}")),
            ("stroke", Some(class)) => classes.push(format!("k-{class}")),
            _ => {}
        }
        // Full opacity goes without saying.
        if !(key == "opacity" && value == "1") {
            themed.push_attribute((key.as_bytes(), value.as_bytes()));
        }
    }
    if !classes.is_empty() {
        themed.push_attribute(("class", classes.join(" ").as_str()));
    }
    themed
}

/// The class of a colour, if a theme may change it.
fn class_of(color: &str) -> Option<String> {
    if color == BLACK_HEX {
        return Some("ink".to_owned());
    }
    if color == WHITE_HEX {
        return Some("paper".to_owned());
    }
    if color == hex(QUIET) {
        return Some("grid".to_owned());
    }
    let hue = DETECTOR_HUES.iter().position(|it| hex(it.on_light) == color)?;
    Some(format!("d{hue}"))
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;

    use super::*;
    use crate::plots::style::{QUIET_COLOR, color};

    fn panel(text: &str) -> ThemedPanel {
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, (100, 50)).into_drawing_area();
        let hue = color(DETECTOR_HUES[1].on_light);
        root.draw(&PathElement::new(vec![(0, 0), (9, 9)], hue.stroke_width(2))).unwrap();
        root.draw(&PathElement::new(vec![(0, 0), (9, 9)], QUIET_COLOR.stroke_width(1))).unwrap();
        root.draw_text(text, &("sans-serif", 12).into_font().color(&BLACK), (5, 5)).unwrap();
        drop(root);
        ThemedPanel::of_library(&svg, [100, 50], "a < b".to_owned())
    }

    #[test]
    fn colours_become_classes_and_text_stays_escaped() {
        let svg = panel("x < y & \"z\"").inline();
        for part in ["k-d1", "k-grid", "f-ink", "x &lt; y &amp;", "<title>a &lt; b</title>"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert_eq!((svg.matches("<svg").count(), svg.matches(" id=").count()), (1, 0), "{svg}");
    }

    #[test]
    fn a_sheet_stands_alone() {
        let key = [KeyEntry { name: "a & b".to_owned(), swatch: panel("") }];
        let svg = sheet(&[panel("one"), panel("other")], &key, "Both <simulated>");
        let mut reader = Reader::from_str(&svg);
        loop {
            if reader.read_event().unwrap() == Event::Eof {
                break;
            }
        }
        for part in ["prefers-color-scheme: dark", "a &amp; b", "Both &lt;simulated&gt;", "one", "other"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
    }
}
