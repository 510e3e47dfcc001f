//! What the drawing library draws, as elements of SVG.

use std::fmt::Write as _;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
    FontTransform,
};
use quick_xml::escape::escape;

use super::theme::{hex, role_of};

/// Which colours elements have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// Those of print.
    Print,
    /// Those of print, each with the class that follows the theme of a page. There are no line breaks and no ids, so that pages stay
    /// small and nothing collides.
    Themed,
}

/// Elements in the order in which they are drawn.
pub(crate) struct SvgBackend<'a> {
    pub(crate) elements: &'a mut String,
    pub(crate) size_px: (u32, u32),
    pub(crate) colours: Colours,
}

/// What of an element has its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Paint {
    Fill,
    Stroke,
}

type Written = Result<(), DrawingErrorKind<std::fmt::Error>>;

impl Paint {
    fn of(is_filled: bool) -> Self {
        if is_filled { Self::Fill } else { Self::Stroke }
    }

    /// The colours of the inside and of the line.
    fn fill_and_stroke(self, color: BackendColor) -> [String; 2] {
        let (color, none) = (hex(color.rgb.into()), "none".to_owned());
        if self == Self::Fill { [color, none] } else { [none, color] }
    }
}

impl SvgBackend<'_> {
    fn element(
        &mut self,
        name: &str,
        (paint, color): (Paint, BackendColor),
        attributes: &[(&str, String)],
        content: Option<&str>,
    ) -> Written {
        if color.alpha == 0.0 {
            return Ok(());
        }
        self.write_element(name, (paint, color), attributes, content).map_err(DrawingErrorKind::DrawingError)
    }

    fn write_element(
        &mut self,
        name: &str,
        (paint, color): (Paint, BackendColor),
        attributes: &[(&str, String)],
        content: Option<&str>,
    ) -> std::fmt::Result {
        let is_themed = self.colours == Colours::Themed;
        let line_end = if is_themed { "" } else { "\n" };
        write!(self.elements, "<{name}")?;
        // Full opacity goes without saying.
        for (key, value) in attributes.iter().filter(|(key, _)| !(is_themed && *key == "opacity")) {
            write!(self.elements, " {key}=\"{value}\"")?;
        }
        if let Some(role) = role_of(color.rgb.into()).filter(|_| is_themed) {
            let letter = if paint == Paint::Fill { 'f' } else { 'k' };
            write!(self.elements, " class=\"{letter}-{role}\"")?;
        }
        match content {
            None => write!(self.elements, "/>{line_end}"),
            Some(text) => {
                write!(self.elements, ">{line_end}{}{line_end}</{name}>{line_end}", escape(text))
            }
        }
    }
}

fn opacity(color: BackendColor) -> (&'static str, String) {
    ("opacity", color.alpha.to_string())
}

/// Places as paths and polygons have them.
fn points(path: impl IntoIterator<Item = BackendCoord>) -> (&'static str, String) {
    let points: Vec<String> = path.into_iter().map(|(x, y)| format!("{x},{y} ")).collect();
    ("points", points.concat())
}

impl DrawingBackend for SvgBackend<'_> {
    type ErrorType = std::fmt::Error;

    fn get_size(&self) -> (u32, u32) {
        self.size_px
    }

    fn ensure_prepared(&mut self) -> Written {
        Ok(())
    }

    fn present(&mut self) -> Written {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Written {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Written {
        let ends = [("x1", from.0), ("y1", from.1), ("x2", to.0), ("y2", to.1)];
        let mut attributes = vec![
            opacity(style.color()),
            ("stroke", hex(style.color().rgb.into())),
            ("stroke-width", style.stroke_width().to_string()),
        ];
        attributes.extend(ends.map(|(key, px)| (key, px.to_string())));
        self.element("line", (Paint::Stroke, style.color()), &attributes, None)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        is_filled: bool,
    ) -> Written {
        let (paint, color) = (Paint::of(is_filled), style.color());
        let [fill, stroke] = paint.fill_and_stroke(color);
        let sides = [("x", left), ("y", top), ("width", right - left), ("height", bottom - top)];
        let mut attributes = sides.map(|(key, px)| (key, px.to_string())).to_vec();
        attributes.extend([opacity(color), ("fill", fill), ("stroke", stroke)]);
        self.element("rect", (paint, color), &attributes, None)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Written {
        let [fill, stroke] = Paint::Stroke.fill_and_stroke(style.color());
        let width = ("stroke-width", style.stroke_width().to_string());
        let attributes = [("fill", fill), opacity(style.color()), ("stroke", stroke), width, points(path)];
        self.element("polyline", (Paint::Stroke, style.color()), &attributes, None)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Written {
        let fill = ("fill", hex(style.color().rgb.into()));
        self.element(
            "polygon",
            (Paint::Fill, style.color()),
            &[opacity(style.color()), fill, points(path)],
            None,
        )
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius_px: u32,
        style: &S,
        is_filled: bool,
    ) -> Written {
        let (paint, color) = (Paint::of(is_filled), style.color());
        let [fill, stroke] = paint.fill_and_stroke(color);
        let attributes = [
            ("cx", x.to_string()),
            ("cy", y.to_string()),
            ("r", radius_px.to_string()),
            opacity(color),
            ("fill", fill),
            ("stroke", stroke),
            ("stroke-width", style.stroke_width().to_string()),
        ];
        self.element("circle", (paint, color), &attributes, None)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Written {
        let anchor = match style.anchor().h_pos {
            HPos::Left => "start",
            HPos::Right => "end",
            HPos::Center => "middle",
        };
        let down = match style.anchor().v_pos {
            VPos::Top => "0.76em",
            VPos::Center => "0.5ex",
            VPos::Bottom => "-0.5ex",
        };
        let mut attributes = vec![
            ("x", x.to_string()),
            ("y", y.to_string()),
            ("dy", down.to_owned()),
            ("text-anchor", anchor.to_owned()),
            ("font-family", style.family().as_str().to_owned()),
            // The library counts the height of lines, browsers that of letters.
            ("font-size", (style.size() / 1.24).to_string()),
            opacity(style.color()),
            ("fill", hex(style.color().rgb.into())),
        ];
        if matches!(style.style(), FontStyle::Bold) {
            attributes.push(("font-weight", "bold".to_owned()));
        }
        if matches!(style.transform(), FontTransform::Rotate270) {
            attributes.push(("transform", format!("rotate(270, {x}, {y})")));
        }
        self.element("text", (Paint::Fill, style.color()), &attributes, Some(text))
    }
}
