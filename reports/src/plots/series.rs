//! Series of values with their intervals, and the key to them.

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::{Figure, LEFT_PX, TEXT_PX};
use super::marks::{Mark, SeriesMark, text_style};
use super::themed_panel::{KEY_SIZE_PX, KeyEntry};

/// A position on a chart, with the interval of its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Position {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) within: Option<[f64; 2]>,
}

/// Positions of one line, which is broken where one is missing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    pub(crate) name: String,
    /// Its mark: for a detector its index in the order of the run, whatever else is on the panel.
    pub(crate) mark: SeriesMark,
    pub(crate) positions: Vec<Option<Position>>,
}

/// The detectors of a study, in the order of its results: each has the same mark on every panel.
pub(crate) struct DetectorMarks<'a>(Vec<&'a str>);

impl<'a> DetectorMarks<'a> {
    /// The detectors among `names`, which may repeat.
    pub(crate) fn of(names: impl Iterator<Item = &'a str>) -> Self {
        let mut detectors = Vec::new();
        for name in names {
            if !detectors.contains(&name) {
                detectors.push(name);
            }
        }
        Self(detectors)
    }

    /// The mark of the `turn`th series of a detector on a panel, from 0.
    pub(crate) fn mark(&self, detector: &str, turn: usize) -> SeriesMark {
        let detector_idx = self.0.iter().position(|it| *it == detector).unwrap_or(self.0.len());
        SeriesMark(detector_idx + turn * self.0.len())
    }
}

/// How the positions of series are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Points {
    /// Markers with intervals, joined by lines; series are so far `apart` that intervals do not hide each other.
    Marked { apart: f64 },
    /// The line alone.
    Line,
}

/// The marks of `series`; positions beyond the ends `y` of the axis are gaps.
pub(crate) fn series_marks(series: &[Series], points: Points, y: [f64; 2]) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (series_idx, of_series) in series.iter().enumerate() {
        let mark = of_series.mark;
        let aside = match points {
            Points::Marked { apart } => apart * (series_idx as f64 - (series.len() as f64 - 1.0) / 2.0),
            Points::Line => 0.0,
        };
        let is_shown = |it: &Position| (y[0]..=y[1]).contains(&it.y);
        for stretch in of_series.positions.split(|it| !it.as_ref().is_some_and(is_shown)) {
            let positions: Vec<Position> = stretch.iter().copied().flatten().collect();
            if positions.is_empty() {
                continue;
            }
            marks.push(mark.line(positions.iter().map(|it| (it.x + aside, it.y))));
            if points != Points::Line {
                let bars = positions.iter().filter_map(|it| {
                    let ends = it.within?.map(|end| (it.x + aside, end.clamp(y[0], y[1])));
                    Some(Mark::line(ends, mark.color(), 1))
                });
                marks.extend(bars);
                marks.extend(positions.iter().map(|it| mark.marker((it.x + aside, it.y))));
            }
        }
    }
    marks
}

/// Height of a line of a key, in pixels.
pub(crate) const KEY_LINE_PX: u32 = 22;

/// The key to series with these marks and names, one below the other from `top_px` on.
pub(crate) fn key_lines<'a>(
    series: impl IntoIterator<Item = (SeriesMark, &'a str)>,
    top_px: f64,
) -> Vec<Mark> {
    const SAMPLE_PX: f64 = 54.0;
    let line = |(line, (mark, name)): (usize, (SeriesMark, &str))| {
        let y_px = top_px + f64::from(KEY_LINE_PX) * line as f64;
        let mut marks = sample(mark, [LEFT_PX, LEFT_PX + SAMPLE_PX], y_px).to_vec();
        marks.push(key_name(name, LEFT_PX + SAMPLE_PX + 12.0, y_px));
        marks
    };
    series.into_iter().enumerate().flat_map(line).collect()
}

/// A name beside a sample.
pub(crate) fn key_name(name: &str, x_px: f64, y_px: f64) -> Mark {
    Mark::text((x_px, y_px), [0, 0], name, text_style(TEXT_PX, HPos::Left, VPos::Center))
}

/// The key to series in this order, for a page.
pub(crate) fn key(names: &[&str]) -> Vec<KeyEntry> {
    let [width_px, height_px] = KEY_SIZE_PX.map(f64::from);
    let entry = |(series, name): (usize, &&str)| {
        let marks = sample(SeriesMark(series), [0.0, width_px], height_px / 2.0).to_vec();
        let swatch = Figure::of_marks(KEY_SIZE_PX, marks).panel((*name).to_owned());
        KeyEntry { name: (*name).to_owned(), swatch }
    };
    names.iter().enumerate().map(entry).collect()
}

/// The key to those of the series that `have_curve`.
pub(crate) fn key_of(names: &[&str], have_curve: impl Fn(&str) -> bool) -> Vec<KeyEntry> {
    key(names).into_iter().filter(|it| have_curve(&it.name)).collect()
}

/// A sample of a series: its line with its marker.
fn sample(mark: SeriesMark, [left_px, right_px]: [f64; 2], y_px: f64) -> [Mark; 2] {
    let middle_px = f64::midpoint(left_px, right_px);
    [mark.line([left_px, right_px].map(|x_px| (x_px, y_px))), mark.marker((middle_px, y_px))]
}
