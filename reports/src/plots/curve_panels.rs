//! Curves with intervals over a parameter: panels below each other, with a series for each detector or data set.

use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, VPos};

use super::figure::{
    Axis, Chart, Figure, Frame, LEFT_MARGIN_PX, LEFT_PX, LEFT_ROOM_PX, Labels, Panel, TEXT_PX, USUAL_FRAME,
};
use super::marks::{BLACK, Mark, SeriesMark, text_style};
use super::series::{KEY_LINE_PX, Points, Position, Series, key_lines, key_name, series_marks};

const WIDTH_PX: u32 = 900;
const PANEL_PX: u32 = 300;
/// What a panel says that has no value.
pub(crate) const NOTHING_DRAWN: &str = "undefined throughout";
/// Room above and below the values, as a share of their spread.
const HEADROOM: f64 = 0.12;

/// A marked position, with its text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Note {
    /// A ring around the position, with the text above the value `top`.
    Ring { at: (f64, f64), top: f64, text: String },
    /// A small ring around the position, with the text aside.
    Front((f64, f64), String),
    /// A dotted line through the panel.
    Upright(f64, String),
    /// A cross, for values that lie off the panel.
    Cross((f64, f64)),
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CurvePanel {
    pub(crate) title: String,
    pub(crate) x_title: String,
    pub(crate) y_title: String,
    /// Labels of the positions on the x axis, if these are no numbers.
    pub(crate) x_words: Option<Vec<String>>,
    pub(crate) series: Vec<Series>,
    pub(crate) notes: Vec<Note>,
    /// A thin line through these positions.
    pub(crate) thread: Vec<(f64, f64)>,
    /// The ends of the y axis, unless they follow from the values.
    pub(crate) y_range: Option<[f64; 2]>,
}

impl CurvePanel {
    /// An empty panel with these titles of axes.
    pub(crate) fn over(x_title: impl Into<String>, y_title: impl Into<String>) -> Self {
        Self { x_title: x_title.into(), y_title: y_title.into(), ..Self::default() }
    }
}

/// The panels below each other, under a `title` and the key to their series.
pub(crate) fn curve_figure(panels: &[CurvePanel], title: &str) -> Figure {
    let series = panels.iter().flat_map(|it| &it.series).map(|it| (it.mark, it.name.as_str()));
    let mut key: Vec<(SeriesMark, &str)> = Vec::new();
    for entry in series {
        if !key.contains(&entry) {
            key.push(entry);
        }
    }
    // A single series needs no key.
    if key.len() == 1 {
        key.clear();
    }
    let mut heading = vec![Mark::title(title, (LEFT_MARGIN_PX.into(), 20.0))];
    heading.extend(key_lines(key.iter().copied(), 50.0));
    Figure {
        width_px: WIDTH_PX,
        heading_px: 40 + KEY_LINE_PX * key.len() as u32 + 6,
        heading,
        rows: panels.iter().map(|it| (PANEL_PX, vec![drawn(it)])).collect(),
    }
}

fn drawn(panel: &CurvePanel) -> Panel {
    let Some([x, y]) = ranges(panel) else {
        let nothing = format!("{}: {NOTHING_DRAWN}", panel.title);
        return Panel { marks: vec![key_name(&nothing, LEFT_PX, 40.0)], chart: None };
    };
    let mut marks = vec![Mark::line(panel.thread.iter().copied(), BLACK, 1)];
    marks.extend(series_marks(&panel.series, Points::Marked { apart: 0.004 * (x[1] - x[0]) }, y));
    marks.extend(panel.notes.iter().flat_map(|it| note_marks(it, x, y)));
    let x_axis = match &panel.x_words {
        None => Axis::linear(&panel.x_title, x, 12),
        Some(words) => {
            Axis::linear(&panel.x_title, x, words.len() + 1).labelled(Labels::Words(words.clone()))
        }
    };
    let frame = Frame { margins_px: [4, 20, 0, LEFT_MARGIN_PX], room_px: [44, LEFT_ROOM_PX], ..USUAL_FRAME };
    let caption = Some((panel.title.clone(), TEXT_PX + 1));
    Chart { caption, frame, ..Chart::new(x_axis, Axis::linear(&panel.y_title, y, 6), marks) }.into()
}

fn note_marks(note: &Note, [left, right]: [f64; 2], y: [f64; 2]) -> Vec<Mark> {
    let text = |position, aside_px, text: &str, (horizontal, vertical)| {
        Mark::text(position, aside_px, text, text_style(TEXT_PX - 1, horizontal, vertical))
    };
    match note {
        Note::Ring { at, top, text: said } => vec![
            Mark::circle(*at, 9, BLACK.stroke_width(2)),
            text((at.0, top.max(at.1)), [0, -12], said, (HPos::Center, VPos::Bottom)),
        ],
        Note::Front(position, said) => vec![
            Mark::circle(*position, 7, BLACK.stroke_width(1)),
            text(*position, [-7, -3], said, (HPos::Right, VPos::Bottom)),
        ],
        Note::Upright(x, said) => {
            // Words to the right of a line at the right end would leave the picture.
            let (aside_px, side) =
                if *x > left + 0.7 * (right - left) { (-5, HPos::Right) } else { (5, HPos::Left) };
            vec![
                Mark::line(y.map(|it| (*x, it)), BLACK, 1).dashed(Some([2, 4])),
                text((*x, y[1]), [aside_px, 10], said, (side, VPos::Center)),
            ]
        }
        Note::Cross((x, at_y)) => vec![Mark::cross((*x, at_y.clamp(y[0], y[1])))],
    }
}

/// Ends of the x and of the y axis around all that is drawn; `None` if nothing is.
fn ranges(panel: &CurvePanel) -> Option<[[f64; 2]; 2]> {
    let positions = || panel.series.iter().flat_map(|it| &it.positions).flatten();
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)])
    };
    let ys = |it: &Position| [it.y, it.within.map_or(it.y, |it| it[0]), it.within.map_or(it.y, |it| it[1])];
    let noted_x = panel.notes.iter().map(|it| match it {
        Note::Ring { at: (x, _), .. }
        | Note::Front((x, _), _)
        | Note::Upright(x, _)
        | Note::Cross((x, _)) => *x,
    });
    let x = spread(&mut positions().map(|it| it.x).chain(noted_x));
    let y = panel.y_range.unwrap_or_else(|| spread(&mut positions().flat_map(ys)));
    let padded = |[low, high]: [f64; 2], share: f64| {
        let room = if high > low { share * (high - low) } else { 0.5 * low.abs().max(1e-6) };
        [low - room, high + room]
    };
    let is_drawn = x.iter().chain(&y).all(|it| it.is_finite());
    is_drawn.then(|| [padded(x, 0.03), if panel.y_range.is_some() { y } else { padded(y, HEADROOM) }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    fn panel(positions: &[(f64, f64)]) -> CurvePanel {
        let position = |&(x, y): &(f64, f64)| Some(Position { x, y, within: Some([y - 0.1, y + 0.1]) });
        let positions = positions.iter().map(position).collect();
        CurvePanel {
            title: "objects".to_owned(),
            series: vec![Series { name: "hierarchical".to_owned(), mark: SeriesMark(0), positions }],
            ..CurvePanel::over("cell size (m)", "F-rate (%)")
        }
    }

    fn svg(panels: &[CurvePanel], title: &str) -> String {
        curve_figure(panels, title).svg(title)
    }

    #[test]
    fn axes_have_units_and_several_series_a_key() {
        let mut two = panel(&[(0.2, 3.0), (0.4, 4.0)]);
        let single = svg(&[two.clone()], "Street (simulated)");
        assert!(!single.contains("hierarchical"), "{single}");
        let pca = Series { name: "pca".to_owned(), mark: SeriesMark(4), ..two.series[0].clone() };
        two.series.push(pca);
        let both = svg(&[two], "Street (simulated)");
        check_holds(
            &both,
            &["cell size (m)", "F-rate (%)", "hierarchical", "pca", "Street (simulated)", "objects"],
        );
    }

    #[test]
    fn a_detector_has_the_same_colour_where_others_are_missing() {
        let mut both = panel(&[(0.2, 3.0), (0.4, 4.0)]);
        let pca = Series { name: "pca".to_owned(), mark: SeriesMark(1), ..both.series[0].clone() };
        both.series.push(pca.clone());
        let alone = CurvePanel { series: vec![pca], ..both.clone() };
        let svg = svg(&[alone, both], "");
        // Of each detector its line in the key, then on the panels: intervals, line and markers are elements of their own.
        let n_of = |class: &str| svg.matches(&format!("class=\"{class}\"")).count();
        assert!(n_of("k-d1") > n_of("k-d0") && n_of("k-d0") > 0, "{svg}");
        assert_eq!(svg.matches(">pca</text>").count(), 1);
    }

    #[test]
    fn intervals_have_room() {
        let [x, y] = ranges(&panel(&[(0.0, 1.0), (1.0, 2.0)])).unwrap();
        assert!(x[0] < 0.0 && x[1] > 1.0 && y[0] < 0.9 && y[1] > 2.1, "{x:?} {y:?}");
        let [x, y] = ranges(&panel(&[(1.0, 0.0)])).unwrap();
        assert!(x[0] < x[1] && y[0] < y[1], "{x:?} {y:?}");
    }

    #[test]
    fn nothing_is_said_to_be_nothing() {
        assert!(svg(&[panel(&[])], "Nothing").contains("undefined throughout"));
        assert!(svg(&[], "Nothing").contains("</svg>"));
    }
}
