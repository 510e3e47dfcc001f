//! Curves with intervals over a parameter, one series for each detector or data set, and the key to them.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::series_marks::SeriesMark;
use super::style::{
    Area, Drawn, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, QUIET_COLOR, RIGHT_ROOM_PX, TEXT_PX, axis_text,
    text,
};

pub(crate) const WIDTH_PX: u32 = 900;
pub(crate) const PANEL_PX: u32 = 300;
const KEY_LINE_PX: i32 = 22;
/// Room above and below the values, as a share of their spread.
const HEADROOM: f64 = 0.08;

/// A place on a panel, with the interval of its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) within: Option<[f64; 2]>,
}

/// Places that belong together; where one is missing the line is broken.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) places: Vec<Option<Place>>,
}

/// Something that is pointed at.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Note {
    pub(crate) place: (f64, f64),
    pub(crate) text: String,
    /// Whether the place gets a ring; otherwise a line stands upright there through the whole panel.
    pub(crate) shape: NoteShape,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoteShape {
    /// A ring around the place.
    Ring,
    /// A small ring around the place, with the text aside.
    Front,
    /// A dotted line through the panel.
    Upright,
    /// A cross, for values that lie off the panel.
    Cross,
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) x_title: String,
    pub(crate) y_title: String,
    /// What stands at the places of the x axis if these are no numbers.
    pub(crate) x_words: Option<Vec<String>>,
    pub(crate) series: Vec<Series>,
    pub(crate) notes: Vec<Note>,
    /// A thin line through these places.
    pub(crate) thread: Vec<(f64, f64)>,
    /// The ends of the y axis, unless they follow from the values.
    pub(crate) y_range: Option<[f64; 2]>,
}

/// The panels below each other as an SVG document, under a `title` and the key to the series of the first.
pub(crate) fn panels_svg(panels: &[Panel], title: &str) -> String {
    let names: Vec<&str> =
        panels.first().iter().flat_map(|it| &it.series).map(|it| it.name.as_str()).collect();
    // A single series needs no key.
    let names = if names.len() > 1 { &names[..] } else { &[] };
    let heading_px = 40 + KEY_LINE_PX as u32 * names.len() as u32 + 6;
    let mut svg = String::new();
    let size_px = (WIDTH_PX, heading_px + PANEL_PX * panels.len() as u32);
    let root = SVGBackend::with_string(&mut svg, size_px).into_drawing_area();
    draw(&root, panels, names, heading_px, title)
        .expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn draw(root: &Area<'_>, panels: &[Panel], names: &[&str], heading_px: u32, title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, below) = root.split_vertically(heading_px);
    heading.draw_text(title, &text(20, HPos::Left), (LEFT_MARGIN_PX as i32, 20))?;
    for (series, name) in names.iter().enumerate() {
        draw_key_line(&heading, series, name)?;
    }
    if !panels.is_empty() {
        for (area, panel) in below.split_evenly((panels.len(), 1)).iter().zip(panels) {
            draw_panel(area, panel)?;
        }
    }
    root.present()
}

fn draw_key_line(area: &Area<'_>, series: usize, name: &str) -> Drawn {
    let (mark, y_px) = (SeriesMark(series), 50 + KEY_LINE_PX * series as i32);
    let left_px = (LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32;
    let end_px = left_px + 54;
    let [dash_px, gap_px] = mark.dashes_px().unwrap_or([54, 1]);
    for from_px in (left_px..end_px).step_by((dash_px + gap_px) as usize) {
        let ends = vec![(from_px, y_px), ((from_px + dash_px).min(end_px), y_px)];
        area.draw(&PathElement::new(ends, mark.color().stroke_width(LINE_WIDTH_PX)))?;
    }
    area.draw(&mark.marker((i32::midpoint(left_px, end_px), y_px)))?;
    area.draw_text(name, &text(TEXT_PX, HPos::Left), (end_px + 12, y_px))
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Drawn {
    let Some([x, y]) = ranges(panel) else {
        let nothing = format!("{}: undefined throughout", panel.title);
        return area.draw_text(
            &nothing,
            &text(TEXT_PX, HPos::Left),
            ((LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32, 40),
        );
    };
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(4)
        .caption(&panel.title, text(TEXT_PX + 1, HPos::Left))
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(44)
        .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
    let word_at = |value: &f64| match &panel.x_words {
        None => axis_text(*value),
        Some(words) if value.fract() == 0.0 && *value >= 0.0 => {
            words.get(*value as usize).cloned().unwrap_or_default()
        }
        Some(_) => String::new(),
    };
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(panel.x_words.as_ref().map_or(12, |words| words.len() + 1))
        .y_labels(6)
        .x_label_formatter(&word_at)
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc(&panel.x_title)
        .y_desc(&panel.y_title)
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    chart.draw_series([PathElement::new(panel.thread.clone(), BLACK.stroke_width(1))])?;
    draw_series(&mut chart, panel, [x, y])?;
    draw_notes(&mut chart, &panel.notes, y)
}

fn draw_series(chart: &mut Chart<'_, '_>, panel: &Panel, [x, y]: [[f64; 2]; 2]) -> Drawn {
    // A little apart, so that intervals do not hide each other.
    let apart = 0.004 * (x[1] - x[0]);
    for (series_idx, series) in panel.series.iter().enumerate() {
        let aside = apart * (series_idx as f64 - (panel.series.len() as f64 - 1.0) / 2.0);
        let mark = SeriesMark(series_idx);
        let style = mark.color().stroke_width(LINE_WIDTH_PX);
        let is_shown = |it: &Place| (y[0]..=y[1]).contains(&it.y);
        for stretch in
            series.places.split(|it| !it.as_ref().is_some_and(is_shown)).filter(|it| !it.is_empty())
        {
            let places: Vec<Place> = stretch.iter().copied().flatten().collect();
            let line = places.iter().map(|it| (it.x + aside, it.y));
            match mark.dashes_px() {
                None => chart.draw_series(LineSeries::new(line, style))?,
                Some([dash_px, gap_px]) => {
                    chart.draw_series(DashedLineSeries::new(line, dash_px, gap_px, style))?
                }
            };
            let bars = places.iter().filter_map(|it| {
                let [low, high] = it.within?;
                let ends = [low, high].map(|end| (it.x + aside, end.clamp(y[0], y[1])));
                Some(PathElement::new(ends.to_vec(), mark.color().stroke_width(1)))
            });
            chart.draw_series(bars)?;
            chart.draw_series(places.iter().map(|it| mark.marker((it.x + aside, it.y))))?;
        }
    }
    Ok(())
}

fn draw_notes(chart: &mut Chart<'_, '_>, notes: &[Note], y: [f64; 2]) -> Drawn {
    let label = text(TEXT_PX - 1, HPos::Center).pos(Pos::new(HPos::Center, VPos::Bottom));
    for note in notes {
        let (at_x, at_y) = note.place;
        match note.shape {
            NoteShape::Ring => {
                chart.draw_series([Circle::new(note.place, 9, BLACK.stroke_width(2))])?;
                let place = EmptyElement::at(note.place);
                chart.draw_series([place + Text::new(note.text.clone(), (0, -12), label.clone())])?;
            }
            NoteShape::Front => {
                chart.draw_series([Circle::new(note.place, 7, BLACK.stroke_width(1))])?;
                let aside = text(TEXT_PX - 1, HPos::Right).pos(Pos::new(HPos::Right, VPos::Bottom));
                let place = EmptyElement::at(note.place);
                chart.draw_series([place + Text::new(note.text.clone(), (-7, -3), aside)])?;
            }
            NoteShape::Upright => {
                let line = DashedLineSeries::new([(at_x, y[0]), (at_x, y[1])], 2, 4, BLACK.stroke_width(1));
                chart.draw_series(line)?;
                let beside = text(TEXT_PX - 1, HPos::Left);
                let place = EmptyElement::at((at_x, y[1]));
                chart.draw_series([place + Text::new(note.text.clone(), (5, 10), beside)])?;
            }
            NoteShape::Cross => {
                let at_y = at_y.clamp(y[0], y[1]);
                chart.draw_series([plotters::element::Cross::new((at_x, at_y), 5, BLACK.stroke_width(2))])?;
            }
        }
    }
    Ok(())
}

/// From left to right and from below to above all that is drawn; `None` if there is nothing.
fn ranges(panel: &Panel) -> Option<[[f64; 2]; 2]> {
    let places = || panel.series.iter().flat_map(|it| &it.places).flatten();
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)])
    };
    let ys = |it: &Place| [it.y, it.within.map_or(it.y, |it| it[0]), it.within.map_or(it.y, |it| it[1])];
    let noted_x = panel.notes.iter().map(|it| it.place.0);
    let x = spread(&mut places().map(|it| it.x).chain(noted_x));
    let y = panel.y_range.unwrap_or_else(|| spread(&mut places().flat_map(ys)));
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

    fn panel(places: &[(f64, f64)]) -> Panel {
        let place = |&(x, y): &(f64, f64)| Some(Place { x, y, within: Some([y - 0.1, y + 0.1]) });
        Panel {
            title: "objects".to_owned(),
            x_title: "cell size (m)".to_owned(),
            y_title: "F-rate (%)".to_owned(),
            x_words: None,
            series: vec![Series {
                name: "hierarchical".to_owned(),
                places: places.iter().map(place).collect(),
            }],
            notes: Vec::new(),
            thread: Vec::new(),
            y_range: None,
        }
    }

    #[test]
    fn axes_have_units_and_several_series_a_key() {
        let mut two = panel(&[(0.2, 3.0), (0.4, 4.0)]);
        let single = panels_svg(&[two.clone()], "Street (simulated)");
        assert!(!single.contains("hierarchical"), "{single}");
        two.series.push(Series { name: "pca".to_owned(), places: two.series[0].places.clone() });
        let svg = panels_svg(&[two.clone()], "Street (simulated)");
        for part in ["cell size (m)", "F-rate (%)", "hierarchical", "pca", "Street (simulated)", "objects"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert_eq!(svg, panels_svg(&[two], "Street (simulated)"));
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
        assert!(panels_svg(&[panel(&[])], "Nothing").contains("undefined throughout"));
        assert!(panels_svg(&[], "Nothing").contains("</svg>"));
    }
}
