//! Detectors below each other, each with its rate, its interval, and the rate that a paper states.

use std::ops::RangeInclusive;

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::Figure;
use super::marks::{LINE_WIDTH_PX, Mark, QUIET, SeriesMark, bold_style, text_style};
use super::small_panel::SMALL_TEXT_PX;
use super::themed_panel::{Arrangement, ThemedPanel, sheet};
use crate::files::fixed_decimals::fixed_decimals;
use crate::tables::paper_figures::PaperScore;

/// One detector.
#[derive(Debug, Clone, PartialEq)]
pub struct RankingRow {
    /// Its name.
    pub name: String,
    /// Its index in the order of the run, which determines the colour.
    pub detector_idx: usize,
    /// Its rate in percent; `None` if that is undefined.
    pub percent: Option<f64>,
    /// The 95 % interval of the rate.
    pub interval_percent: Option<[f64; 2]>,
    /// What a paper states for its counterpart.
    pub published: Option<PaperScore>,
}

impl RankingRow {
    /// Its rate, or that it has none.
    pub(super) fn value_text(&self) -> String {
        self.percent.map_or_else(|| "undefined".to_owned(), |it| format!("{} %", fixed_decimals(it, 1)))
    }
}

/// Width of a panel, and bounds of the width of its column of names.
struct Layout {
    width_px: u32,
    names_px: RangeInclusive<i32>,
}

/// Layout of panels of which three are side by side on a page.
const ON_PAGE: Layout = Layout { width_px: 430, names_px: 100..=190 };
/// Layout of a figure of its own, whose names are sentences.
const ALONE: Layout = Layout { width_px: 820, names_px: 100..=440 };
const HEADING_PX: u32 = 26;
const ROW_PX: u32 = 30;
const AXIS_PX: u32 = 44;
/// Beginning of the caveat at the end of a rate; the caveat is drawn as a second line.
const CAVEAT: &str = ", intervals ";
const CAVEAT_PX: u32 = 16;
const VALUES_PX: f64 = 62.0;
/// The width of a letter over the size of the text: a wide letter, so that no name is cut off in another font.
const LETTER_WIDTH: f64 = 0.62;
/// Gap between a name and its line.
const NAME_GAP_PX: i32 = 10;

/// A panel with a line for every detector; `title` names the task, `rate` the rate.
pub fn ranking_plot(title: &str, rate: &str, rows: &[RankingRow]) -> ThemedPanel {
    panel(title, rate, rows, &ON_PAGE)
}

/// A figure with such a panel for each part of a study; `parts` are titles and lines.
pub fn study_plot(title: &str, rate: &str, parts: &[(String, Vec<RankingRow>)]) -> String {
    let panels: Vec<ThemedPanel> =
        parts.iter().map(|(title, rows)| panel(title, rate, rows, &ALONE)).collect();
    sheet(&panels, Arrangement::Column, &[], title)
}

fn panel(title: &str, rate: &str, rows: &[RankingRow], layout: &Layout) -> ThemedPanel {
    let texts: Vec<String> = rows.iter().map(|it| format!("{} {}", it.name, it.value_text())).collect();
    let caveat_px = if rate.contains(CAVEAT) { CAVEAT_PX } else { 0 };
    let size_px = [layout.width_px, HEADING_PX + ROW_PX * rows.len() as u32 + AXIS_PX + caveat_px];
    Figure::of_marks(size_px, marks(title, rate, rows, layout))
        .panel(format!("{title}: {rate} of {}", texts.join(", ")))
}

/// Number of letters of a name that fit, and width of the column of names in pixels.
fn names_column(rows: &[RankingRow], bounds_px: &RangeInclusive<i32>) -> (usize, i32) {
    let letter_px = LETTER_WIDTH * f64::from(SMALL_TEXT_PX);
    let longest = rows.iter().map(|it| it.name.chars().count()).max().unwrap_or(0);
    let wanted_px = (longest as f64 * letter_px).ceil() as i32 + NAME_GAP_PX;
    let names_px = wanted_px.clamp(*bounds_px.start(), *bounds_px.end());
    ((f64::from(names_px - NAME_GAP_PX) / letter_px) as usize, names_px)
}

/// The name, or its beginning if it is longer than `n_letters`.
fn shortened(name: &str, n_letters: usize) -> String {
    if name.chars().count() <= n_letters {
        return name.to_owned();
    }
    name.chars().take(n_letters.saturating_sub(1)).chain(['…']).collect()
}

fn marks(title: &str, rate: &str, rows: &[RankingRow], layout: &Layout) -> Vec<Mark> {
    let (n_letters, names_px) = names_column(rows, &layout.names_px);
    let (names_px, width_px) = (f64::from(names_px), f64::from(layout.width_px));
    let ends_px = [names_px, width_px - VALUES_PX];
    let bottom_px = f64::from(HEADING_PX + ROW_PX * rows.len() as u32);
    let [low, high] = axis(rows);
    let x_px =
        |percent: f64| ends_px[0] + ((ends_px[1] - ends_px[0]) * (percent - low) / (high - low)).round();
    let mut marks = vec![Mark::text((names_px, 11.0), [0, 0], title, bold_style(SMALL_TEXT_PX))];
    let n_ticks = ((high - low) / TICK_PERCENT).round() as usize;
    for tick in 0..=n_ticks {
        let percent = low + TICK_PERCENT * tick as f64;
        let at_px = x_px(percent);
        marks.push(Mark::line([(at_px, HEADING_PX.into()), (at_px, bottom_px)], QUIET, 1));
        let every = if n_ticks > 6 { 2 } else { 1 };
        if tick.is_multiple_of(every) {
            marks.push(text((at_px, bottom_px + 12.0), fixed_decimals(percent, 0), HPos::Center));
        }
    }
    let middle_px = f64::midpoint(ends_px[0], ends_px[1]).floor();
    let (rate, caveat) = rate.split_at(rate.find(CAVEAT).unwrap_or(rate.len()));
    marks.push(text((middle_px, bottom_px + 32.0), rate.to_owned(), HPos::Center));
    if !caveat.is_empty() {
        let below_px = bottom_px + 32.0 + f64::from(CAVEAT_PX);
        marks.push(text((width_px / 2.0, below_px), caveat.replacen(", ", "", 1), HPos::Center));
    }
    for (row, top_px) in rows.iter().zip((HEADING_PX..).step_by(ROW_PX as usize)) {
        let y_px = f64::from(top_px + ROW_PX / 2);
        let name = shortened(&row.name, n_letters);
        marks.push(text((names_px - f64::from(NAME_GAP_PX), y_px), name, HPos::Right));
        marks.push(text((width_px - 2.0, y_px), row.value_text(), HPos::Right));
        let mark = SeriesMark(row.detector_idx);
        marks.extend(row.published.map(|it| Mark::diamond((x_px(it.f_rate_percent), y_px), mark.color())));
        marks.extend(
            row.interval_percent
                .map(|ends| Mark::line(ends.map(|it| (x_px(it), y_px)), mark.color(), LINE_WIDTH_PX)),
        );
        marks.extend(row.percent.map(|it| mark.marker((x_px(it), y_px))));
    }
    marks
}

fn text(position_px: (f64, f64), text: String, horizontal: HPos) -> Mark {
    Mark::text(position_px, [0, 0], text, text_style(SMALL_TEXT_PX, horizontal, VPos::Center))
}

const TICK_PERCENT: f64 = 10.0;

/// Ends of the axis: whole tens around all that is drawn.
pub(super) fn axis<'a>(rows: impl IntoIterator<Item = &'a RankingRow>) -> [f64; 2] {
    let values = rows.into_iter().flat_map(|it| {
        let [low, high] = it.interval_percent.map_or([None; 2], |ends| ends.map(Some));
        [it.percent, it.published.map(|it| it.f_rate_percent), low, high]
    });
    let [low, high] = values
        .flatten()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
    if low > high {
        return [0.0, 100.0];
    }
    let low = (low / TICK_PERCENT).floor() * TICK_PERCENT;
    let high = (high / TICK_PERCENT).ceil() * TICK_PERCENT;
    if high > low {
        [low, high]
    } else {
        [(low - TICK_PERCENT).max(0.0), high.max(low + TICK_PERCENT).min(100.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    const PUBLISHED: PaperScore = PaperScore { f_rate_percent: 83.0, fps: 28.0 };

    fn row(percent: Option<f64>) -> RankingRow {
        let interval_percent = percent.map(|it| [it - 3.0, it + 3.0]);
        let name = "grid".to_owned();
        RankingRow { name, detector_idx: 0, percent, interval_percent, published: Some(PUBLISHED) }
    }

    #[test]
    fn the_axis_is_whole_tens_around_all_that_is_drawn() {
        assert_eq!(axis(&[row(Some(61.0)), row(None)]), [50.0, 90.0]);
        assert_eq!(axis([]), [0.0, 100.0]);
        let exact = RankingRow { interval_percent: None, published: None, ..row(Some(100.0)) };
        assert_eq!(axis(&[exact]), [90.0, 100.0]);
    }

    #[test]
    fn a_name_has_the_room_it_needs_up_to_a_bound() {
        let named = |name: &str| vec![RankingRow { name: name.to_owned(), ..row(Some(61.0)) }];
        assert_eq!(names_column(&named("pca"), &ON_PAGE.names_px).1, 100);
        let (n_letters, names_px) = names_column(&named("kd-tree-same-walls"), &ON_PAGE.names_px);
        assert!(n_letters >= 18 && names_px > 100, "{n_letters} letters, {names_px} px");
        let long = named("a-detector-with-a-name-that-does-not-end");
        let (n_letters, names_px) = names_column(&long, &ON_PAGE.names_px);
        assert_eq!(names_px, 190);
        let shown = shortened(&long[0].name, n_letters);
        assert!(shown.starts_with("a-detector-with") && shown.ends_with('…'), "{shown}");
        assert!(ranking_plot("", "", &long).inline().contains(&shown));
    }

    #[test]
    fn what_is_undefined_is_said_to_be() {
        let panel = ranking_plot("Task objects", "F-rate (%)", &[row(Some(61.04)), row(None)]);
        assert_eq!(panel.label, "Task objects: F-rate (%) of grid 61.0 %, grid undefined");
        check_holds(&panel.inline(), &["61.0 %", "undefined", "F-rate (%)", "f-d0"]);
        let few =
            ranking_plot("Task objects", "F-rate (%), intervals from only 4 blocks", &[row(Some(61.04))]);
        check_holds(&few.inline(), &[">F-rate (%)</text>", ">intervals from only 4 blocks</text>"]);
    }
}
