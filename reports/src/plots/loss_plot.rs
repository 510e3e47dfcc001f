//! The plot of the losses of annotated objects, stage by stage of a detector.

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::Figure;
use super::marks::{Mark, QUIET, SeriesMark, bold_style, text_style};
use super::small_panel::SMALL_TEXT_PX;
use super::themed_panel::ThemedPanel;
use crate::files::fixed_decimals::percent;
use crate::rows::error_row::ErrorRow;
use crate::tables::error_table::ErrorTable;
use crate::vocabulary::reason::MistakeKind;
use crate::vocabulary::slice::Slice;

const WIDTH_PX: u32 = 400;
const HEADING_PX: u32 = 24;
const ROW_PX: u32 = 22;
/// Room for the reasons and for the numbers.
const NAMES_PX: f64 = 186.0;
const NUMBERS_PX: f64 = 96.0;

/// The objects that a detector had to find, and those that it missed, by reason in the order of the stages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Losses {
    /// Title of the panel: the detector, or its work.
    pub title: String,
    /// Index of the detector in the order of the run, which determines the colour.
    pub detector_idx: usize,
    /// Annotations that count.
    pub n_annotations: u64,
    /// Reasons, each with the number of missed objects.
    pub missed: Vec<(String, u64)>,
}

impl Losses {
    /// The losses of each detector of `errors` that missed any object; all have the same reasons. `detector_idx` returns the
    /// index of a detector in the order of the run.
    pub fn of(errors: &ErrorTable<'_>, detector_idx: impl Fn(&str) -> usize) -> Vec<Self> {
        let is_missed = |it: &ErrorRow| it.slice == Slice::All && it.mistake == MistakeKind::Missed;
        let reasons = errors.reasons(is_missed);
        let of_detector = |detector: &&str| {
            let is_its = |it: &&ErrorRow| is_missed(it) && it.detector == **detector;
            let rows: Vec<&ErrorRow> = errors.rows.iter().copied().filter(is_its).collect();
            let n_missed = |reason: &str| rows.iter().find(|it| it.reason == reason).map_or(0, |it| it.n);
            let n_annotations = rows.first()?.of;
            let missed = reasons.iter().map(|(_, reason)| ((*reason).to_owned(), n_missed(reason))).collect();
            let title = (*detector).to_owned();
            Some(Self { title, detector_idx: detector_idx(detector), n_annotations, missed })
        };
        errors.detectors.iter().filter_map(of_detector).collect()
    }
}

/// A panel with a bar for all objects, one for the objects lost for each reason, which begins where the remaining ones
/// end, and one for the found objects.
pub fn loss_plot(losses: &Losses) -> ThemedPanel {
    let bars = bars(losses);
    let size_px = [WIDTH_PX, HEADING_PX + ROW_PX * bars.len() as u32 + 4];
    let said: Vec<String> = bars.iter().map(|it| format!("{} {}", it.name, number(it, losses))).collect();
    let label = format!("objects of {} by what became of them: {}", losses.title, said.join(", "));
    Figure::of_marks(size_px, marks(losses, &bars)).panel(label)
}

/// A bar; its ends are numbers of objects.
struct Bar<'a> {
    name: &'a str,
    ends: [u64; 2],
    is_lost: bool,
}

fn bars(losses: &Losses) -> Vec<Bar<'_>> {
    let mut left = losses.n_annotations;
    let mut bars = vec![Bar { name: "annotated", ends: [0, left], is_lost: false }];
    for (reason, n) in &losses.missed {
        let ends = [left.saturating_sub(*n), left];
        left = ends[0];
        bars.push(Bar { name: reason, ends, is_lost: true });
    }
    bars.push(Bar { name: "found", ends: [0, left], is_lost: false });
    bars
}

fn number(bar: &Bar<'_>, losses: &Losses) -> String {
    let n = bar.ends[1] - bar.ends[0];
    if n == losses.n_annotations {
        return n.to_string();
    }
    let share = n as f64 / losses.n_annotations.max(1) as f64;
    format!("{n} ({} %)", percent(share))
}

fn marks(losses: &Losses, bars: &[Bar<'_>]) -> Vec<Mark> {
    let text = |x_px: f64, y_px: f64, text: String, horizontal: HPos| {
        Mark::text((x_px, y_px), [0, 0], text, text_style(SMALL_TEXT_PX - 1, horizontal, VPos::Center))
    };
    let mut marks = vec![Mark::text((2.0, 11.0), [0, 0], losses.title.clone(), bold_style(SMALL_TEXT_PX))];
    let room_px = f64::from(WIDTH_PX) - NAMES_PX - NUMBERS_PX;
    let x_px = |n: u64| NAMES_PX + (room_px * n as f64 / losses.n_annotations.max(1) as f64).round();
    let color = SeriesMark(losses.detector_idx).color();
    for (bar, top_px) in bars.iter().zip((HEADING_PX..).step_by(ROW_PX as usize)) {
        let [top_px, row_px] = [top_px, ROW_PX].map(f64::from);
        let (middle_px, [from_px, to_px]) = (top_px + row_px / 2.0, bar.ends.map(x_px));
        let of_height = |from_px, to_px| [(from_px, top_px + 4.0), (to_px, top_px + row_px - 4.0)];
        marks.push(text(NAMES_PX - 8.0, middle_px, bar.name.to_owned(), HPos::Right));
        if bar.is_lost {
            // The objects that remain after this stage.
            marks.push(Mark::rectangle(of_height(NAMES_PX, from_px), QUIET));
        }
        // A bar that is too short to be seen becomes a hair line.
        let to_px = if bar.ends[1] > bar.ends[0] { to_px.max(from_px + 1.0) } else { to_px };
        marks.push(Mark::rectangle(of_height(from_px, to_px), color));
        marks.push(text(f64::from(WIDTH_PX) - 2.0, middle_px, number(bar, losses), HPos::Right));
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    #[test]
    fn objects_flow_from_annotated_to_found() {
        let missed = vec![("taken for ground".to_owned(), 10), ("merged with others".to_owned(), 30)];
        let losses = Losses { title: "grid".to_owned(), detector_idx: 0, n_annotations: 80, missed };
        let panel = loss_plot(&losses);
        assert_eq!(
            panel.label,
            "objects of grid by what became of them: annotated 80, taken for ground 10 (12.5 %), merged with others 30 \
             (37.5 %), found 40 (50.0 %)"
        );
        check_holds(&panel.inline(), &["taken for ground", "30 (37.5 %)", "f-d0"]);
        let ends: Vec<_> = bars(&losses).iter().map(|it| it.ends).collect();
        assert_eq!(ends, [[0, 80], [70, 80], [40, 70], [0, 40]]);
    }
}
