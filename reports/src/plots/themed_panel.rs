//! Panels for a page, and standalone sheets of them.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::palette::{BLACK, WHITE};
use super::theme::{Paint, hex, painted, theme_css};

/// A drawing without a background, whose colours follow the page.
#[derive(Debug, Clone, PartialEq)]
pub struct ThemedPanel {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Description of the drawing in a sentence, for those who do not see it.
    pub label: String,
    /// SVG.
    pub(crate) elements: String,
}

/// One entry of the key to a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyEntry {
    /// Meaning of the swatch.
    pub name: String,
    /// Sample of the line and marker, of size [`KEY_SIZE_PX`].
    pub swatch: ThemedPanel,
}

/// Width and height of a sample in a key.
pub const KEY_SIZE_PX: [u32; 2] = [36, 16];

impl ThemedPanel {
    /// SVG for a page, as wide as there is room.
    pub fn inline(&self) -> String {
        let [width, height] = self.size_px;
        let label = escape(&self.label);
        format!(
            r#"<svg class="plot" role="img" viewBox="0 0 {width} {height}"><title>{label}</title>{}</svg>"#,
            self.elements
        )
    }

    /// SVG for a page, hidden from screen readers because words beside it say the same.
    pub fn inline_hidden(&self) -> String {
        let [width, height] = self.size_px;
        format!(
            r#"<svg class="swatch" aria-hidden="true" viewBox="0 0 {width} {height}" width="{width}" height="{height}">{}</svg>"#,
            self.elements
        )
    }

    /// A standalone document, which a page may also embed as it is.
    pub(crate) fn document(&self) -> String {
        format!("{}{}\n</svg>\n", beginning(self.size_px, &self.label), self.elements)
    }
}

/// The beginning of a document: its title, its colours on light and on dark pages, and its background.
fn beginning([width, height]: [u32; 2], title: &str) -> String {
    let (title, style, paper) = (escape(title), theme_css("svg.sheet"), painted(Paint::Fill, WHITE));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"sheet\" role=\"img\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<title>{title}</title>\n<style>{style}</style>\n\
         <rect {paper} width=\"{width}\" height=\"{height}\"/>\n"
    )
}

/// Arrangement of panels on a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// Side by side.
    Row,
    /// One below the other.
    Column,
}

const MARGIN_PX: u32 = 16;

/// Panels under a title and a key, as a standalone document.
pub fn sheet(panels: &[ThemedPanel], arrangement: Arrangement, key: &[KeyEntry], title: &str) -> String {
    const KEY_Y_PX: u32 = 40;
    let mut corner_px = [MARGIN_PX, 0];
    let placed: Vec<(&ThemedPanel, [u32; 2])> = panels
        .iter()
        .map(|it| {
            let here_px = corner_px;
            let axis = usize::from(arrangement == Arrangement::Column);
            corner_px[axis] += it.size_px[axis] + MARGIN_PX;
            (it, here_px)
        })
        .collect();
    let panels_width = placed.iter().map(|(it, [x, _])| x + it.size_px[0]).max().unwrap_or(0);
    let key_width = |it: &KeyEntry| KEY_SIZE_PX[0] + 10 + 8 * it.name.chars().count() as u32 + 24;
    let keys_width: u32 = key.iter().map(key_width).sum();
    let title_width = 9 * title.chars().count() as u32;
    let width = (panels_width.max(keys_width).max(title_width) + MARGIN_PX).max(200);
    let top = if key.is_empty() { KEY_Y_PX } else { KEY_Y_PX + 28 };
    let height = top + placed.iter().map(|(it, [_, y])| y + it.size_px[1]).max().unwrap_or(0) + MARGIN_PX;
    let ink = hex(BLACK);
    let mut svg = beginning([width, height], title);
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<text class=\"f-ink\" x=\"{MARGIN_PX}\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\" fill=\"{ink}\">\
         {}</text>",
        escape(title)
    );
    let mut x = MARGIN_PX;
    for entry in key {
        let [w, h] = KEY_SIZE_PX;
        let name = escape(&entry.name);
        let _ = writeln!(
            svg,
            "<svg x=\"{x}\" y=\"{KEY_Y_PX}\" width=\"{w}\" height=\"{h}\">{}</svg><text class=\"f-ink\" x=\"{}\" y=\"{}\" \
             font-family=\"sans-serif\" font-size=\"13\" fill=\"{ink}\">{name}</text>",
            entry.swatch.elements,
            x + w + 6,
            KEY_Y_PX + 12
        );
        x += key_width(entry);
    }
    for (panel, [x, y]) in placed {
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

#[cfg(test)]
mod tests {
    use quick_xml::Reader;
    use quick_xml::events::Event;

    use super::*;
    use crate::files::texts::check_holds;

    #[test]
    fn a_sheet_stands_alone() {
        let panel = |text: &str| ThemedPanel {
            size_px: [100, 50],
            label: "a < b".to_owned(),
            elements: format!("<text>{text}</text>"),
        };
        let key = [KeyEntry { name: "a & b".to_owned(), swatch: panel("") }];
        let panels = [panel("one"), panel("other")];
        let svg = sheet(&panels, Arrangement::Row, &key, "Both <simulated>");
        let mut reader = Reader::from_str(&svg);
        while reader.read_event().unwrap() != Event::Eof {}
        check_holds(
            &svg,
            &["prefers-color-scheme: dark", "a &amp; b", "Both &lt;simulated&gt;", "one", "other"],
        );
        check_holds(&svg, &["<title>a &lt; b</title>"]);
    }
}
