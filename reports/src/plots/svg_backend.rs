//! Backend of the drawing library that writes elements of SVG.

use std::fmt::{Display, Write as _};

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
    FontTransform,
};
use quick_xml::escape::escape;

use super::theme::{Paint, class_of, hex};

/// Elements in the order in which they are drawn, in the colours of print, each with the class that follows the theme of a
/// page. There are no line breaks and no ids, so that pages stay small and nothing collides.
pub(crate) struct SvgBackend<'a> {
    pub(crate) elements: &'a mut String,
    pub(crate) size_px: (u32, u32),
}

type Written = Result<(), DrawingErrorKind<std::fmt::Error>>;
type Attributes<'a> = [(&'static str, &'a dyn Display)];

impl SvgBackend<'_> {
    /// Writes an element that is painted in `color`, unless that is fully transparent.
    fn element(
        &mut self,
        name: &str,
        paint: Paint,
        color: BackendColor,
        attributes: &Attributes<'_>,
        content: Option<&str>,
    ) -> Written {
        if color.alpha == 0.0 {
            return Ok(());
        }
        let mut tag = format!("<{name}");
        // Full opacity is the default.
        let is_said = |key: &str| key != "opacity" || color.alpha < 1.0;
        for (key, value) in attributes.iter().filter(|(key, _)| is_said(key)) {
            write!(tag, " {key}=\"{value}\"").map_err(DrawingErrorKind::DrawingError)?;
        }
        if let Some(class) = class_of(paint, color.rgb.into()) {
            tag.extend([" class=\"", &class, "\""]);
        }
        let rest = match content {
            None => "/>".to_owned(),
            Some(text) => format!(">{}</{name}>", escape(text)),
        };
        self.elements.extend([tag, rest]);
        Ok(())
    }
}

/// The painted part of an area, and the colours of its inside and of its line.
fn paint(color: BackendColor, is_filled: bool) -> (Paint, [String; 2]) {
    let (color, none) = (hex(color.rgb.into()), "none".to_owned());
    if is_filled { (Paint::Fill, [color, none]) } else { (Paint::Stroke, [none, color]) }
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
        let (color, width) = (style.color(), style.stroke_width());
        let (stroke, opacity) = (hex(color.rgb.into()), color.alpha);
        let style: &Attributes<'_> = &[("opacity", &opacity), ("stroke", &stroke), ("stroke-width", &width)];
        let ends: &Attributes<'_> = &[("x1", &from.0), ("y1", &from.1), ("x2", &to.0), ("y2", &to.1)];
        self.element("line", Paint::Stroke, color, &[style, ends].concat(), None)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        is_filled: bool,
    ) -> Written {
        let (painted, [fill, stroke]) = paint(style.color(), is_filled);
        let (width, height, opacity) = (right - left, bottom - top, style.color().alpha);
        let position: &Attributes<'_> = &[("x", &left), ("y", &top), ("width", &width), ("height", &height)];
        let style_of: &Attributes<'_> = &[("opacity", &opacity), ("fill", &fill), ("stroke", &stroke)];
        self.element("rect", painted, style.color(), &[position, style_of].concat(), None)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Written {
        let (color, width) = (style.color(), style.stroke_width());
        let (stroke, opacity) = (hex(color.rgb.into()), color.alpha);
        let points: Vec<String> = path.into_iter().map(|(x, y)| format!("{x},{y} ")).collect();
        let points = points.concat();
        let attributes: &Attributes<'_> = &[
            ("fill", &"none"),
            ("opacity", &opacity),
            ("stroke", &stroke),
            ("stroke-width", &width),
            ("points", &points),
        ];
        self.element("polyline", Paint::Stroke, color, attributes, None)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius_px: u32,
        style: &S,
        is_filled: bool,
    ) -> Written {
        let (painted, [fill, stroke]) = paint(style.color(), is_filled);
        let (opacity, width) = (style.color().alpha, style.stroke_width());
        let position: &Attributes<'_> = &[("cx", &x), ("cy", &y), ("r", &radius_px), ("opacity", &opacity)];
        let style_of: &Attributes<'_> = &[("fill", &fill), ("stroke", &stroke), ("stroke-width", &width)];
        self.element("circle", painted, style.color(), &[position, style_of].concat(), None)
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
        let (font, color) = (style.family(), style.color());
        // The library counts the height of lines, browsers that of letters.
        let (family, size_px) = (font.as_str(), style.size() / 1.24);
        let (fill, turned) = (hex(color.rgb.into()), format!("rotate(270, {x}, {y})"));
        let position: &Attributes<'_> = &[("x", &x), ("y", &y), ("dy", &down), ("text-anchor", &anchor)];
        let letters: &Attributes<'_> = &[("font-family", &family), ("font-size", &size_px)];
        let mut attributes = [position, letters, &[("opacity", &color.alpha), ("fill", &fill)]].concat();
        if matches!(style.style(), FontStyle::Bold) {
            attributes.push(("font-weight", &"bold"));
        }
        if matches!(style.transform(), FontTransform::Rotate270) {
            attributes.push(("transform", &turned));
        }
        self.element("text", Paint::Fill, color, &attributes, Some(text))
    }
}
