//! Panels small enough for three of them to stand side by side on a page, and one on a telephone.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::curve_panel::Series;
use super::series_marks::SeriesMark;
use super::style::{Area, Drawn, LINE_WIDTH_PX, QUIET_COLOR, axis_text};
use super::themed_svg::{KEY_SIZE_PX, KeyEntry, ThemedPanel};

pub(crate) const WIDTH_PX: u32 = 360;
pub(crate) const HEIGHT_PX: u32 = 250;
/// Height of all text in pixels as the library counts it, 1.24 times what browsers call its size.
pub(crate) const SMALL_TEXT_PX: i32 = 16;

/// One panel.
pub(crate) struct SmallPanel<'a, X> {
    pub(crate) title: &'a str,
    pub(crate) x_title: &'a str,
    pub(crate) y_title: &'a str,
    pub(crate) x: X,
    /// The ends of the y axis.
    pub(crate) y: [f64; 2],
    /// What stands at a place of the x axis.
    pub(crate) x_text: &'a dyn Fn(f64) -> String,
    pub(crate) n_x_labels: usize,
    /// In the order of the detectors of the run.
    pub(crate) series: &'a [Series],
    pub(crate) points: Points,
}

/// How the places of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Points {
    /// A marker each, with its interval, joined by lines; series a little apart.
    Marked,
    /// The line alone.
    Line,
}

/// Text of the usual height.
pub(crate) fn small_text(horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    let style: TextStyle<'static> = ("sans-serif", SMALL_TEXT_PX).into_font().color(&BLACK);
    style.pos(Pos::new(horizontal, vertical))
}

impl<X> SmallPanel<'_, X>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    /// The panel; `label` says what is seen.
    pub(crate) fn draw(self, label: String) -> ThemedPanel {
        let size_px = (WIDTH_PX, HEIGHT_PX);
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, size_px).into_drawing_area();
        self.draw_on(&root).expect("the panel has room, and memory takes all that is drawn");
        drop(root);
        ThemedPanel::of_library(&svg, size_px.into(), label)
    }

    fn draw_on(self, root: &Area<'_>) -> Drawn {
        let bold: TextStyle<'static> =
            ("sans-serif", SMALL_TEXT_PX, FontStyle::Bold).into_font().color(&BLACK);
        root.draw_text(self.title, &bold.pos(Pos::new(HPos::Left, VPos::Center)), (52, 10))?;
        let mut chart = ChartBuilder::on(root)
            .margin_top(24)
            .margin_right(12)
            .margin_left(2)
            .x_label_area_size(44)
            .y_label_area_size(50)
            .build_cartesian_2d(self.x, self.y[0]..self.y[1])?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(QUIET_COLOR)
            .axis_style(QUIET_COLOR)
            .x_labels(self.n_x_labels)
            .y_labels(6)
            .x_label_formatter(&|value| (self.x_text)(*value))
            .y_label_formatter(&|value| axis_text(*value))
            .x_desc(self.x_title)
            .y_desc(self.y_title)
            .label_style(small_text(HPos::Center, VPos::Center))
            .axis_desc_style(small_text(HPos::Center, VPos::Center))
            .draw()?;
        for (series_idx, series) in self.series.iter().enumerate() {
            let mark = SeriesMark(series_idx);
            let style = mark.color().stroke_width(LINE_WIDTH_PX);
            // A little apart, so that intervals do not hide each other.
            let aside = match self.points {
                Points::Marked => 0.09 * (series_idx as f64 - (self.series.len() as f64 - 1.0) / 2.0),
                Points::Line => 0.0,
            };
            for stretch in series.places.split(Option::is_none).filter(|it| !it.is_empty()) {
                let places: Vec<_> = stretch.iter().copied().flatten().collect();
                let line = places.iter().map(|it| (it.x + aside, it.y));
                match mark.dashes_px() {
                    None => chart.draw_series(LineSeries::new(line, style))?,
                    Some([dash_px, gap_px]) => {
                        chart.draw_series(DashedLineSeries::new(line, dash_px, gap_px, style))?
                    }
                };
                if self.points == Points::Marked {
                    let bars = places.iter().filter_map(|it| {
                        let ends = it.within?.map(|end| (it.x + aside, end.clamp(self.y[0], self.y[1])));
                        Some(PathElement::new(ends.to_vec(), mark.color().stroke_width(1)))
                    });
                    chart.draw_series(bars)?;
                    chart.draw_series(places.iter().map(|it| mark.marker((it.x + aside, it.y))))?;
                }
            }
        }
        Ok(())
    }
}

/// The key to series in this order.
pub(crate) fn key(names: &[&str]) -> Vec<KeyEntry> {
    let entry = |(series_idx, name): (usize, &&str)| {
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, KEY_SIZE_PX.into()).into_drawing_area();
        draw_swatch(&root, SeriesMark(series_idx)).expect("memory takes all that is drawn");
        drop(root);
        let name = (*name).to_owned();
        KeyEntry { swatch: ThemedPanel::of_library(&svg, KEY_SIZE_PX, name.clone()), name }
    };
    names.iter().enumerate().map(entry).collect()
}

fn draw_swatch(root: &Area<'_>, mark: SeriesMark) -> Drawn {
    let (middle_px, end_px) = ((KEY_SIZE_PX[1] / 2) as i32, KEY_SIZE_PX[0] as i32);
    let [dash_px, gap_px] = mark.dashes_px().unwrap_or([end_px, 1]);
    for from_px in (0..end_px).step_by((dash_px + gap_px) as usize) {
        let ends = vec![(from_px, middle_px), ((from_px + dash_px).min(end_px), middle_px)];
        root.draw(&PathElement::new(ends, mark.color().stroke_width(LINE_WIDTH_PX)))?;
    }
    root.draw(&mark.marker((end_px / 2, middle_px)))
}

/// Whole numbers from 0 on, with room on both sides, whose labels are words.
#[derive(Clone)]
pub(crate) struct Words {
    range: RangedCoordf64,
    n: usize,
}

impl Words {
    pub(crate) fn new(n: usize) -> Self {
        Self { range: (-0.5..n.max(1) as f64 - 0.5).into(), n }
    }
}

impl Ranged for Words {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        (0..self.n).map(|it| it as f64).collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.range()
    }
}
