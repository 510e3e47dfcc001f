//! Marks on panels: lines, rectangles, circles, markers of series and text, at positions of data or of pixels.

use std::slice::Iter;

use plotters::element::{DashedPathElement, Drawable, PointCollection};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{BackendCoord, DrawingBackend, DrawingErrorKind};

use super::palette::{self, Rgb, detector_hue};

/// Width of the lines of the data, in pixels.
pub(crate) const LINE_WIDTH_PX: u32 = 2;
/// Text and notes about data.
pub(crate) const BLACK: RGBColor = color(palette::BLACK);
/// Grid lines and frames.
pub(crate) const QUIET: RGBColor = color(palette::QUIET);

/// A mark on a panel.
#[derive(Clone)]
pub(crate) struct Mark {
    /// Positions across and upright, in units of the axes of a chart; in pixels, from the upper left corner.
    positions: Vec<(f64, f64)>,
    shape: Shape,
}

#[derive(Clone)]
enum Shape {
    /// A line through all positions, with the lengths of dashes and of gaps in pixels.
    Line(ShapeStyle, Option<[i32; 2]>),
    /// A filled rectangle between two corners.
    Rectangle(RGBColor),
    /// A circle with its radius in pixels.
    Circle(u32, ShapeStyle),
    /// Paths, in pixels from the position.
    Paths(&'static [&'static [[i32; 2]]], ShapeStyle),
    /// Text with its distance in pixels from the position.
    Text(String, [i32; 2], TextStyle<'static>),
}

impl Mark {
    pub(crate) fn line(
        positions: impl IntoIterator<Item = (f64, f64)>,
        color: RGBColor,
        width_px: u32,
    ) -> Self {
        let shape = Shape::Line(color.stroke_width(width_px), None);
        Self { positions: positions.into_iter().collect(), shape }
    }

    /// This line with dashes and gaps of these lengths in pixels.
    pub(crate) fn dashed(self, dashes_px: Option<[i32; 2]>) -> Self {
        match self.shape {
            Shape::Line(style, _) => Self { shape: Shape::Line(style, dashes_px), ..self },
            _ => self,
        }
    }

    pub(crate) fn rectangle(corners: [(f64, f64); 2], color: RGBColor) -> Self {
        Self { positions: corners.to_vec(), shape: Shape::Rectangle(color) }
    }

    /// The outline of an upright rectangle.
    pub(crate) fn outline([from, to]: [(f64, f64); 2], color: RGBColor) -> Self {
        Self::line([from, (to.0, from.1), to, (from.0, to.1), from], color, LINE_WIDTH_PX)
    }

    pub(crate) fn circle(position: (f64, f64), radius_px: u32, style: ShapeStyle) -> Self {
        Self { positions: vec![position], shape: Shape::Circle(radius_px, style) }
    }

    /// A cross, larger than the markers of series.
    pub(crate) fn cross(position: (f64, f64)) -> Self {
        const PATHS: &[&[[i32; 2]]] = &[&[[-5, -5], [5, 5]], &[[-5, 5], [5, -5]]];
        Self { positions: vec![position], shape: Shape::Paths(PATHS, BLACK.stroke_width(2)) }
    }

    /// A hollow diamond.
    pub(crate) fn diamond(position: (f64, f64), color: RGBColor) -> Self {
        const PATHS: &[&[[i32; 2]]] = &[&[[0, -6], [5, 0], [0, 6], [-5, 0], [0, -6]]];
        Self { positions: vec![position], shape: Shape::Paths(PATHS, color.stroke_width(1)) }
    }

    /// Text, `aside_px` to the right of and below `position`.
    pub(crate) fn text(
        position: (f64, f64),
        aside_px: [i32; 2],
        text: impl Into<String>,
        style: TextStyle<'static>,
    ) -> Self {
        Self { positions: vec![position], shape: Shape::Text(text.into(), aside_px, style) }
    }

    /// The title of a figure, in pixels.
    pub(crate) fn title(text: &str, position: (f64, f64)) -> Self {
        Self::text(position, [0, 0], text, text_style(20, HPos::Left, VPos::Center))
    }
}

pub(crate) const fn color([red, green, blue]: Rgb) -> RGBColor {
    RGBColor(red, green, blue)
}

/// Text whose lines are `height_px` high, placed by its sides `horizontal` and `vertical`.
pub(crate) fn text_style(height_px: i32, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    let style: TextStyle<'static> = ("sans-serif", height_px).into_font().color(&BLACK);
    style.pos(Pos::new(horizontal, vertical))
}

/// Bold text, placed by its left end at half height.
pub(crate) fn bold_style(height_px: i32) -> TextStyle<'static> {
    let style: TextStyle<'static> = ("sans-serif", height_px, FontStyle::Bold).into_font().color(&BLACK);
    style.pos(Pos::new(HPos::Left, VPos::Center))
}

/// Form and colour of the series of this number; no two of sixty series have both in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SeriesMark(pub(crate) usize);

impl SeriesMark {
    pub(crate) fn color(self) -> RGBColor {
        color(detector_hue(self.0).on_light)
    }

    /// Length of the dashes and of the gaps between them in pixels; `None` for a full line.
    pub(crate) fn dashes_px(self) -> Option<[i32; 2]> {
        [None, Some([9, 5]), Some([2, 4]), Some([14, 4]), Some([5, 2])][self.0 % 5]
    }

    pub(crate) fn line(self, positions: impl IntoIterator<Item = (f64, f64)>) -> Mark {
        Mark::line(positions, self.color(), LINE_WIDTH_PX).dashed(self.dashes_px())
    }

    /// A filled circle, hollow triangle, hollow square, cross or plus.
    pub(crate) fn marker(self, position: (f64, f64)) -> Mark {
        const PATHS: [&[&[[i32; 2]]]; 4] = [
            &[&[[0, -6], [5, 4], [-5, 4], [0, -6]]],
            &[&[[-4, -4], [4, -4], [4, 4], [-4, 4], [-4, -4]]],
            &[&[[-4, -4], [4, 4]], &[[-4, 4], [4, -4]]],
            &[&[[-5, 0], [5, 0]], &[[0, -5], [0, 5]]],
        ];
        match self.0 % 5 {
            0 => Mark::circle(position, 4, self.color().filled()),
            form => {
                let style = self.color().stroke_width(LINE_WIDTH_PX);
                Mark { positions: vec![position], shape: Shape::Paths(PATHS[form - 1], style) }
            }
        }
    }
}

impl<'a> PointCollection<'a, (f64, f64)> for &'a Mark {
    type Point = &'a (f64, f64);
    type IntoIter = Iter<'a, (f64, f64)>;

    fn point_iter(self) -> Self::IntoIter {
        self.positions.iter()
    }
}

impl<Backend: DrawingBackend> Drawable<Backend> for Mark {
    fn draw<Positions: Iterator<Item = BackendCoord>>(
        &self,
        mut positions: Positions,
        backend: &mut Backend,
        size_px: (u32, u32),
    ) -> Result<(), DrawingErrorKind<Backend::ErrorType>> {
        if let Shape::Line(style, dashes_px) = &self.shape {
            let Some([dash_px, gap_px]) = *dashes_px else { return backend.draw_path(positions, style) };
            let nowhere = std::iter::empty::<BackendCoord>();
            return DashedPathElement::new(nowhere, dash_px, gap_px, *style)
                .draw(positions, backend, size_px);
        }
        let Some((x, y)) = positions.next() else { return Ok(()) };
        match &self.shape {
            Shape::Line(..) => Ok(()),
            Shape::Rectangle(color) => {
                let (to_x, to_y) = positions.next().unwrap_or((x, y));
                let corners = [(x.min(to_x), y.min(to_y)), (x.max(to_x), y.max(to_y))];
                backend.draw_rect(corners[0], corners[1], color, true)
            }
            Shape::Circle(radius_px, style) => backend.draw_circle((x, y), *radius_px, style, style.filled),
            Shape::Paths(paths, style) => paths.iter().try_for_each(|path| {
                backend.draw_path(path.iter().map(|[right, down]| (x + right, y + down)), style)
            }),
            Shape::Text(text, [right, down], style) => backend.draw_text(text, style, (x + right, y + down)),
        }
    }
}
