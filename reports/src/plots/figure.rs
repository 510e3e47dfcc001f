//! A figure: a title and a key above panels in rows. This is the only module that draws panels.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::marks::{BLACK, Mark, QUIET, text_style};
use super::svg_backend::SvgBackend;
use super::themed_panel::ThemedPanel;
use crate::files::fixed_decimals::fixed_decimals;

/// Room left of the titles of the vertical axes, in pixels.
pub(crate) const LEFT_MARGIN_PX: u32 = 14;
/// Room left of the vertical axes, in pixels; the same in all panels, so that these are flush.
pub(crate) const LEFT_ROOM_PX: u32 = 80;
/// Left end of the axes, in pixels.
pub(crate) const LEFT_PX: f64 = (LEFT_MARGIN_PX + LEFT_ROOM_PX) as f64;
/// Height of the text on axes and beside data, in pixels.
pub(crate) const TEXT_PX: i32 = 15;

/// A drawing.
#[derive(Clone)]
pub struct Figure {
    pub(crate) width_px: u32,
    /// Height of the heading above the panels, in pixels.
    pub(crate) heading_px: u32,
    /// Title and key, at positions in pixels.
    pub(crate) heading: Vec<Mark>,
    /// Rows from above, each with its height in pixels and its panels from the left. All panels are equally wide.
    pub(crate) rows: Vec<(u32, Vec<Panel>)>,
}

/// A part of a figure.
#[derive(Clone, Default)]
pub(crate) struct Panel {
    /// Marks at positions in pixels.
    pub(crate) marks: Vec<Mark>,
    pub(crate) chart: Option<Chart>,
}

/// Two axes, and the marks between them.
#[derive(Clone)]
pub(crate) struct Chart {
    /// Text above the chart, with its height in pixels.
    pub(crate) caption: Option<(String, i32)>,
    pub(crate) frame: Frame,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Behind the grid.
    pub(crate) band: Option<Mark>,
    pub(crate) marks: Vec<Mark>,
}

/// How axes are drawn, and the room around them.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    /// Margins above, to the right, below and to the left, in pixels.
    pub(crate) margins_px: [u32; 4],
    /// Room for labels and titles, below and to the left, in pixels.
    pub(crate) room_px: [u32; 2],
    /// Height of labels and of titles, in pixels.
    pub(crate) text_px: [i32; 2],
    pub(crate) axis_color: RGBColor,
    pub(crate) grid: Grid,
}

/// The lines at the ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grid {
    Both,
    /// Lines at the ticks of the vertical axis.
    Level,
    None,
}

/// One axis.
#[derive(Clone)]
pub(crate) struct Axis {
    /// Title with the unit; may be empty.
    pub(crate) title: String,
    pub(crate) scale: Scale,
    /// The greatest number of ticks.
    pub(crate) n_ticks: usize,
    pub(crate) labels: Labels,
}

/// Scale of an axis, from one end to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scale {
    Linear([f64; 2]),
    /// Logarithmic: equal ratios are equal distances.
    Logarithmic([f64; 2]),
}

/// Labels at ticks.
#[derive(Clone)]
pub(crate) enum Labels {
    Numbers,
    /// These words at the whole numbers from 0 on.
    Words(Vec<String>),
    /// Ratios at whole values, which are doublings.
    Ratios,
    /// Ticks without labels.
    Blank,
    /// Neither ticks nor a line.
    NoAxis,
}

/// A chart as wide as a page.
pub(crate) const USUAL_FRAME: Frame = Frame {
    margins_px: [8, 20, 0, LEFT_MARGIN_PX],
    room_px: [46, LEFT_ROOM_PX],
    text_px: [TEXT_PX, TEXT_PX],
    axis_color: BLACK,
    grid: Grid::Both,
};

type Area<'a> = DrawingArea<SvgBackend<'a>, Shift>;
/// Drawing fails only if a panel has no room at all.
type Drawn = Result<(), DrawingAreaErrorKind<std::fmt::Error>>;

impl Figure {
    /// Marks in pixels, without panels.
    pub(crate) fn of_marks([width_px, height_px]: [u32; 2], marks: Vec<Mark>) -> Self {
        Self { width_px, heading_px: height_px, heading: marks, rows: Vec::new() }
    }

    /// A standalone document; `label` describes it.
    pub fn svg(&self, label: &str) -> String {
        self.panel(label.to_owned()).document()
    }

    /// A panel for a page; `label` describes it.
    pub fn panel(&self, label: String) -> ThemedPanel {
        ThemedPanel { size_px: self.size_px(), label, elements: self.elements() }
    }

    fn size_px(&self) -> [u32; 2] {
        [self.width_px, self.heading_px + self.rows.iter().map(|(height_px, _)| height_px).sum::<u32>()]
    }

    fn elements(&self) -> String {
        let mut elements = String::new();
        let backend = SvgBackend { elements: &mut elements, size_px: self.size_px().into() };
        self.draw(&backend.into_drawing_area())
            .expect("the panels have room, and memory takes all that is drawn");
        elements
    }

    fn draw(&self, root: &Area<'_>) -> Drawn {
        let part = |left: u32, top: u32, size_px: (u32, u32)| {
            root.clone().shrink((left as i32, top as i32), (size_px.0 as i32, size_px.1 as i32))
        };
        draw_in_pixels(&part(0, 0, (self.width_px, self.heading_px)), &self.heading)?;
        let n_columns = self.rows.iter().map(|(_, panels)| panels.len()).max().unwrap_or(0).max(1) as u32;
        let panel_px = self.width_px / n_columns;
        let mut top = self.heading_px;
        for (height_px, panels) in &self.rows {
            for (panel, column) in panels.iter().zip(0..) {
                let area = part(column * panel_px, top, (panel_px, *height_px));
                draw_in_pixels(&area, &panel.marks)?;
                panel.chart.iter().try_for_each(|it| draw_chart(&area, it))?;
            }
            top += height_px;
        }
        Ok(())
    }
}

fn draw_in_pixels(area: &Area<'_>, marks: &[Mark]) -> Drawn {
    let (width_px, height_px) = area.dim_in_pixel();
    let axis = |px: u32| Scale::Linear([0.0, px.into()]);
    let pixels = Cartesian2d::<Scale, Scale>::new(axis(width_px), axis(height_px), area.get_pixel_range());
    let area = area.apply_coord_spec(pixels);
    marks.iter().try_for_each(|it| area.draw(it))
}

fn draw_chart(area: &Area<'_>, chart: &Chart) -> Drawn {
    let Frame { margins_px, room_px, text_px, axis_color, grid } = chart.frame;
    let mut builder = ChartBuilder::on(area);
    if let Some((caption, height_px)) = &chart.caption {
        builder.caption(caption, text_style(*height_px, HPos::Left, VPos::Center));
    }
    let mut axes = builder
        .margin_top(margins_px[0])
        .margin_right(margins_px[1])
        .margin_bottom(margins_px[2])
        .margin_left(margins_px[3])
        .x_label_area_size(room_px[0])
        .y_label_area_size(room_px[1])
        .build_cartesian_2d(chart.x.scale, chart.y.scale)?;
    chart.band.iter().try_for_each(|it| axes.plotting_area().draw(it))?;
    let [x_label, y_label] = [&chart.x, &chart.y].map(|axis| |value: &f64| axis.label(*value));
    let mut mesh = axes.configure_mesh();
    match grid {
        Grid::Both => &mut mesh,
        Grid::Level => mesh.disable_x_mesh(),
        Grid::None => mesh.disable_mesh(),
    };
    if matches!(chart.x.labels, Labels::NoAxis) {
        mesh.disable_x_axis();
    }
    if !chart.x.title.is_empty() {
        mesh.x_desc(&chart.x.title);
    }
    let [label_style, title_style] = text_px.map(|it| text_style(it, HPos::Center, VPos::Center));
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(QUIET)
        .axis_style(axis_color)
        .x_labels(chart.x.n_ticks)
        .y_labels(chart.y.n_ticks)
        .x_label_formatter(&x_label)
        .y_label_formatter(&y_label)
        .y_desc(&chart.y.title)
        .label_style(label_style)
        .axis_desc_style(title_style)
        .draw()?;
    chart.marks.iter().try_for_each(|it| axes.plotting_area().draw(it))
}

impl From<Chart> for Panel {
    fn from(chart: Chart) -> Self {
        Self { marks: Vec::new(), chart: Some(chart) }
    }
}

impl Chart {
    /// A chart as wide as a page.
    pub(crate) fn new(x: Axis, y: Axis, marks: Vec<Mark>) -> Self {
        Self { caption: None, frame: USUAL_FRAME, x, y, band: None, marks }
    }
}

impl Axis {
    /// An axis of numbers.
    pub(crate) fn linear(title: impl Into<String>, ends: [f64; 2], n_ticks: usize) -> Self {
        Self { title: title.into(), scale: Scale::Linear(ends), n_ticks, labels: Labels::Numbers }
    }

    /// This axis with other labels.
    pub(crate) fn labelled(self, labels: Labels) -> Self {
        Self { labels, ..self }
    }

    fn label(&self, value: f64) -> String {
        let whole = ((value - value.round()).abs() < 1e-6).then_some(value.round());
        match &self.labels {
            Labels::Numbers => axis_text(value),
            Labels::Words(words) => {
                let word = whole.filter(|it| *it >= 0.0).and_then(|it| words.get(it as usize));
                word.cloned().unwrap_or_default()
            }
            Labels::Ratios if value.fract() == 0.0 => value.exp2().to_string(),
            Labels::Ratios | Labels::Blank | Labels::NoAxis => String::new(),
        }
    }
}

/// A number on an axis: as short as it can be written.
fn axis_text(value: f64) -> String {
    let text = fixed_decimals(value, 5);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        match *self {
            Self::Linear([from, to]) => RangedCoordf64::from(from..to).map(value, limit),
            Self::Logarithmic([from, to]) => logarithmic(from..to).map(value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match *self {
            Self::Linear([from, to]) => RangedCoordf64::from(from..to).key_points(hint),
            Self::Logarithmic([from, to]) => logarithmic(from..to).key_points(hint),
        }
    }

    fn range(&self) -> Range<f64> {
        let (Self::Linear([from, to]) | Self::Logarithmic([from, to])) = *self;
        from..to
    }
}

fn logarithmic(ends: Range<f64>) -> LogCoord<f64> {
    ends.log_scale().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::plots::marks::SeriesMark;

    #[test]
    fn numbers_on_axes_are_short() {
        assert_eq!(
            [0.0, 5.0, -0.25, 0.1 + 0.2, 100.0, 120_000.0].map(axis_text),
            ["0", "5", "-0.25", "0.3", "100", "120000"]
        );
    }

    #[test]
    fn words_stand_at_whole_numbers_and_ratios_at_whole_doublings() {
        let labels = |labels, values: [f64; 5]| {
            let axis = Axis { labels, ..Axis::linear("", [0.0, 1.0], 2) };
            values.map(|it| axis.label(it))
        };
        assert_eq!(labels(Labels::Ratios, [-2.0, -0.5, 0.0, 1.0, 1.5]), ["0.25", "", "1", "2", ""]);
        let words = Labels::Words(vec!["a".to_owned(), "b".to_owned()]);
        assert_eq!(labels(words, [-1.0, 0.0, 0.5, 1.0 + 1e-9, 2.0]), ["", "a", "", "b", ""]);
    }

    #[test]
    fn colours_become_classes_and_text_stays_escaped() {
        let hue = SeriesMark(1);
        let text = Mark::text((5.0, 5.0), [0, 0], "x < y & \"z\"", text_style(12, HPos::Left, VPos::Center));
        let line = [(0.0, 0.0), (9.0, 9.0)];
        let marks = vec![hue.line(line), Mark::line(line, QUIET, 1), text];
        let figure = Figure::of_marks([100, 50], marks);
        let page = figure.panel("a < b".to_owned()).inline();
        check_holds(&page, &["k-d1", "k-grid", "f-ink", "x &lt; y &amp;", "<title>a &lt; b</title>"]);
        assert_eq!((page.matches("<svg").count(), page.matches(" id=").count()), (1, 0), "{page}");
        let alone = figure.svg("a < b");
        check_holds(
            &alone,
            &["f-paper", "fill=\"#FFFFFF\"", "prefers-color-scheme: dark", "stroke=\"#D55E00\""],
        );
    }
}
