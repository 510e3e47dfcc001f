//! The tables of how partly seen objects are classified.

use crate::files::fixed_decimals::{fixed_decimals, percent_or_dash};
use crate::numbers::blocks::Interval;
use crate::partial_study::partial_claims::{MeasuredClaim, PartialClaim};
use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::rows::partial_row::Predicted;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::uncertainty::bootstrap::N_RESAMPLES;
use crate::vocabulary::partial_class::PartialClass;

/// The mean of recalls of every method at every step; the confusion of one method, and the claims of the paper that hold.
#[derive(Debug, Clone, Copy)]
pub struct PartialTable<'a> {
    /// The data sets, and whether they are simulated, in words.
    pub title: &'a str,
    /// The curves of every method, data set and direction.
    pub curves: &'a [PartialCurve],
    /// The method that is shown in more detail.
    pub method: &'a str,
    /// The findings, in sentences.
    pub found: &'a [String],
}

/// Steps whose confusion and intervals are shown.
const SHOWN_AT: [u32; 3] = [3, 5, 10];

impl Tabular for PartialTable<'_> {
    fn sheet(&self) -> Sheet {
        let mut parts = vec![
            Part { title: Some(format!("{} Mean of recalls in %.", self.title)), grid: self.recalls() },
            Part {
                title: Some("Mean of recalls in %, with 95 % intervals.".to_owned()),
                grid: self.intervals(),
            },
        ];
        if self.curves.iter().flat_map(|it| &it.steps).any(|it| it.rejected.is_some()) {
            let title = "None of these: rejected share of strangers, which are of other classes, and of objects of known classes, in %.";
            parts.push(Part { title: Some(title.to_owned()), grid: self.rejected() });
        }
        for curve in self.curves.iter().filter(|it| it.method == self.method) {
            for step in curve.steps.iter().filter(|it| SHOWN_AT.contains(&it.step)) {
                let title = format!("{} at step {}: predicted classes.", name_of(curve), step.step);
                parts.push(Part { title: Some(title), grid: confusion(step) });
            }
            parts.push(Part {
                title: Some(format!("{}: claims of the paper.", name_of(curve))),
                grid: claim_grid(curve),
            });
        }
        let mut sentences = vec![
            "Columns 1 to 10: steps, each a tenth of the largest extent more. right from: of the objects that are right at the last step, the \
             mean share of steps until they are right for good. last: share that is right at the last step."
                .to_owned(),
            format!("95 %: from a bootstrap of {N_RESAMPLES} resamples of objects, each with all its steps."),
        ];
        sentences.extend(self.found.iter().cloned());
        Sheet::of_parts(parts, sentences)
    }
}

fn name_of(curve: &PartialCurve) -> String {
    let PartialCurve { data, direction, method, trained_on, .. } = curve;
    format!("{data} from {direction}, {method} trained on {trained_on}")
}

const STEP_TITLES: [&str; 10] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10"];

impl PartialTable<'_> {
    fn recalls(&self) -> Grid {
        let texts = TEXT_TITLES.map(Column::left);
        let numbers = STEP_TITLES.into_iter().chain(["right from", "last"]).map(Column::number);
        let lines = self.curves.iter().map(|curve| {
            let at_step = |step: u32| curve.steps.iter().find(|it| it.step == step)?.mean_recall;
            let steps = (1..=STEP_TITLES.len() as u32).map(|it| percent(at_step(it)));
            let more = [curve.right_and_kept_from, curve.right_in_the_end].map(percent);
            Line { kind: LineKind::Dataset, cells: text_cells(curve).chain(steps).chain(more).collect() }
        });
        Grid { columns: texts.into_iter().chain(numbers).collect(), lines: lines.collect() }
    }
}

const TEXT_TITLES: [&str; 4] = ["data set", "seen from", "method", "trained on"];

fn text_cells(curve: &PartialCurve) -> impl Iterator<Item = Cell> + '_ {
    [&curve.data, &curve.direction, &curve.method, &curve.trained_on]
        .into_iter()
        .map(|it| Cell::new(it.clone()))
}

impl PartialTable<'_> {
    /// A line for each curve, with a number and its interval for each of the shown steps.
    fn intervals(&self) -> Grid {
        let lines = self.curves.iter().map(|curve| {
            let cells = SHOWN_AT.iter().flat_map(|step| {
                let at_step = curve.steps.iter().find(|it| it.step == *step);
                [percent(at_step.and_then(|it| it.mean_recall)), interval(at_step.and_then(|it| it.within))]
            });
            Line { kind: LineKind::Dataset, cells: text_cells(curve).chain(cells).collect() }
        });
        let texts = TEXT_TITLES.map(Column::left).into_iter();
        Grid { columns: texts.chain(interval_columns()).collect(), lines: lines.collect() }
    }

    /// Two lines for each curve: strangers, and known objects.
    fn rejected(&self) -> Grid {
        let lines = self.curves.iter().flat_map(|curve| {
            ["strangers", "known"].into_iter().enumerate().map(move |(index, who)| {
                let cells = SHOWN_AT.iter().flat_map(move |step| {
                    let at_step = curve.steps.iter().find(|it| it.step == *step);
                    let share = at_step.and_then(|it| it.rejected).map(|it| it[index]);
                    [percent(share.map(|it| it.value)), interval(share.and_then(|it| it.within))]
                });
                let texts = text_cells(curve).chain([Cell::new(who)]);
                Line { kind: LineKind::Dataset, cells: texts.chain(cells).collect() }
            })
        });
        let texts = TEXT_TITLES.into_iter().chain(["objects"]).map(Column::left);
        Grid { columns: texts.chain(interval_columns()).collect(), lines: lines.collect() }
    }
}

/// A number and its interval for each of the shown steps.
fn interval_columns() -> impl Iterator<Item = Column> {
    SHOWN_AT.iter().flat_map(|step| {
        let group = format!("step {step}");
        [Column::number("%").within(group.clone()), Column::number("95 %").within(group)]
    })
}

fn interval(within: Option<Interval>) -> Cell {
    let text = |it: Interval| {
        let [low, high] = it.ends.map(|end| fixed_decimals(100.0 * end, 1));
        Cell::interval(format!("{low} to {high}"), it.blocks)
    };
    within.map_or_else(|| Cell::new("–"), text)
}

fn percent(share: Option<f64>) -> Cell {
    Cell::new(percent_or_dash(share))
}

fn confusion(step: &PartialStep) -> Grid {
    let columns = [Column::left("class"), Column::number("objects")];
    let columns = columns.into_iter().chain(Predicted::ALL.map(|it| Column::number(it.name())));
    let line = |(class, at_step): (&PartialClass, &crate::partial_study::partial_curves::ClassAtStep)| {
        let counts = [at_step.n_objects].into_iter().chain(at_step.predicted);
        let cells = counts.map(|it| Cell::new(it.to_string()));
        Line { kind: LineKind::Dataset, cells: [Cell::new(class.name())].into_iter().chain(cells).collect() }
    };
    Grid { columns: columns.collect(), lines: step.classes.iter().map(line).collect() }
}

fn claim_grid(curve: &PartialCurve) -> Grid {
    let line = |claim: PartialClaim| {
        let MeasuredClaim { holds, number } = claim.measured(curve);
        let verdict = match holds {
            Some(true) => "holds",
            Some(false) => "does not hold",
            None => "unknown",
        };
        let cells = [claim.text().to_owned(), verdict.to_owned(), number].map(Cell::new);
        Line { kind: LineKind::Dataset, cells: cells.to_vec() }
    };
    let columns = ["claim", "verdict", "measured"].map(Column::left);
    Grid { columns: columns.to_vec(), lines: PartialClaim::ALL.map(line).to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial_study::partial_curves::tests::rows;
    use crate::rows::partial_row::tests::row;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::latex::Latex;
    use crate::tables::formats::markdown::Markdown;

    #[test]
    fn every_format_has_the_recalls_the_confusion_and_the_claims() {
        let curves = PartialCurve::all(&rows());
        let table =
            PartialTable { title: "Objects (simulated).", curves: &curves, method: "graphs", found: &[] };
        let text = Markdown.text(&table);
        for part in [
            "Mean of recalls",
            "75.0",
            "street from below, graphs trained on parts at step 3",
            "does not hold",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
        assert!(Latex.text(&table).contains("75.0") && !text.contains("None of these"), "{text}");
    }

    #[test]
    fn what_is_rejected_of_whom_stands_with_its_interval() {
        let strangers = (0..20).map(|it| {
            let predicted = if it < 15 { Predicted::NoneOfThese } else { Predicted::Tree };
            row(PartialClass::Other, &format!("fence-{it}"), 3, predicted, [1.0; 4])
        });
        let rows: Vec<_> = rows().into_iter().chain(strangers).collect();
        let curves = PartialCurve::all(&rows);
        let table = PartialTable { title: "Objects.", curves: &curves, method: "graphs", found: &[] };
        let text = Markdown.text(&table);
        let line = text.lines().find(|it| it.contains("| strangers |")).unwrap();
        assert!(line.contains("75.0") && line.contains(" to "), "{line}");
        assert!(text.lines().any(|it| it.contains("| known ") && it.contains("0.0")), "{text}");
    }
}
