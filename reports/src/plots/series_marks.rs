//! Lines and markers of up to five series, told apart by form as well as by colour.

use std::iter::{Once, once};

use plotters::element::{Drawable, PointCollection};
use plotters::prelude::*;
use plotters_backend::{BackendCoord, DrawingBackend, DrawingErrorKind};

use super::style::{LINE_WIDTH_PX, color};
use crate::plots::palette::detector_hue;

/// How the series of this number is drawn; a sixth looks like the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SeriesMark(pub(crate) usize);

/// A filled circle, hollow triangle, hollow square, cross or plus at a place of any coordinate system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Marker<C> {
    place: C,
    mark: SeriesMark,
}

impl SeriesMark {
    pub(crate) fn color(self) -> RGBColor {
        color(detector_hue(self.0).on_light)
    }

    /// Length of the dashes and of the gaps between them in pixels; `None` for a full line.
    pub(crate) fn dashes_px(self) -> Option<[i32; 2]> {
        [None, Some([9, 5]), Some([2, 4]), Some([14, 4]), Some([5, 2])][self.0 % 5]
    }

    pub(crate) fn marker<C>(self, place: C) -> Marker<C> {
        Marker { place, mark: self }
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Marker<C> {
    type Point = &'a C;
    type IntoIter = Once<&'a C>;

    fn point_iter(self) -> Self::IntoIter {
        once(&self.place)
    }
}

impl<C, Backend: DrawingBackend> Drawable<Backend> for Marker<C> {
    fn draw<Places: Iterator<Item = BackendCoord>>(
        &self,
        mut places: Places,
        backend: &mut Backend,
        _: (u32, u32),
    ) -> Result<(), DrawingErrorKind<Backend::ErrorType>> {
        let Some((x, y)) = places.next() else { return Ok(()) };
        let style = self.mark.color().stroke_width(LINE_WIDTH_PX);
        let at = |[right, down]: [i32; 2]| (x + right, y + down);
        match self.mark.0 % 5 {
            0 => backend.draw_circle((x, y), 4, &self.mark.color(), true),
            1 => backend.draw_path([[0, -6], [5, 4], [-5, 4], [0, -6]].map(at), &style),
            2 => backend.draw_path([[-4, -4], [4, -4], [4, 4], [-4, 4], [-4, -4]].map(at), &style),
            4 => {
                backend.draw_path([[-5, 0], [5, 0]].map(at), &style)?;
                backend.draw_path([[0, -5], [0, 5]].map(at), &style)
            }
            _ => {
                backend.draw_path([[-4, -4], [4, 4]].map(at), &style)?;
                backend.draw_path([[-4, 4], [4, -4]].map(at), &style)
            }
        }
    }
}
