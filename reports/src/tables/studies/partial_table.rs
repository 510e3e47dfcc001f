//! The tables of how objects are told of which a part has been seen.

use crate::files::fixed_decimals::fixed_decimals;
use crate::partial_study::partial_claims::claims;
use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::rows::partial_row::Told;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::vocabulary::partial_class::PartialClass;

/// The mean of recalls of every method at every step; of one method the confusion, and what of the paper holds.
#[derive(Debug, Clone, Copy)]
pub struct PartialTable<'a> {
    /// What was done, in words: the data sets, and whether they are simulated.
    pub title: &'a str,
    /// Of every method, data set and direction.
    pub curves: &'a [PartialCurve],
    /// The method of which there is more.
    pub method: &'a str,
}

/// Steps of which the confusion is shown.
const CONFUSION_AT: [u32; 3] = [3, 5, 10];

impl Tabular for PartialTable<'_> {
    fn sheet(&self) -> Sheet {
        let mut parts =
            vec![Part { title: Some(format!("{} Mean of recalls in %.", self.title)), grid: self.recalls() }];
        for curve in self.curves.iter().filter(|it| it.method == self.method) {
            for step in curve.steps.iter().filter(|it| CONFUSION_AT.contains(&it.step)) {
                let title =
                    format!("{} at step {}: what objects were told to be.", name_of(curve), step.step);
                parts.push(Part { title: Some(title), grid: confusion(step) });
            }
            parts.push(Part {
                title: Some(format!("{}: claims of the paper.", name_of(curve))),
                grid: claim_grid(curve),
            });
        }
        let sentences = vec![
            "Columns 1 to 10: steps, each a tenth of the largest extent more. kept: of the objects that are right at the last step, the mean \
             share of steps after which they are right and stay so. end: share that is right at the last step."
                .to_owned(),
        ];
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
        let texts = ["data set", "seen from", "method", "trained on"].map(Column::left);
        let numbers = STEP_TITLES.into_iter().chain(["kept", "end"]).map(Column::number);
        let lines = self.curves.iter().map(|curve| {
            let texts = [&curve.data, &curve.direction, &curve.method, &curve.trained_on]
                .map(|it| Cell::new(it.clone()));
            let at_step = |step: u32| curve.steps.iter().find(|it| it.step == step)?.mean_recall;
            let steps = (1..=STEP_TITLES.len() as u32).map(|it| percent(at_step(it)));
            let more = [curve.right_and_kept_from, curve.right_in_the_end].map(percent);
            Line { kind: LineKind::Dataset, cells: texts.into_iter().chain(steps).chain(more).collect() }
        });
        Grid { columns: texts.into_iter().chain(numbers).collect(), lines: lines.collect() }
    }
}

fn percent(share: Option<f64>) -> Cell {
    Cell::new(share.map_or_else(|| "–".to_owned(), |it| fixed_decimals(100.0 * it, 1)))
}

fn confusion(step: &PartialStep) -> Grid {
    let columns = [Column::left("is"), Column::number("objects")];
    let columns = columns.into_iter().chain(Told::ALL.map(|it| Column::number(it.name())));
    let line = |(class, at_step): (&PartialClass, &crate::partial_study::partial_curves::ClassAtStep)| {
        let counts = [at_step.n_objects].into_iter().chain(at_step.told);
        let cells = counts.map(|it| Cell::new(it.to_string()));
        Line { kind: LineKind::Dataset, cells: [Cell::new(class.name())].into_iter().chain(cells).collect() }
    };
    Grid { columns: columns.collect(), lines: step.classes.iter().map(line).collect() }
}

fn claim_grid(curve: &PartialCurve) -> Grid {
    let line = |claim: crate::partial_study::partial_claims::Claim| {
        let verdict = match claim.holds {
            Some(true) => "holds",
            Some(false) => "does not hold",
            None => "cannot be told",
        };
        let cells = [claim.text.to_owned(), verdict.to_owned(), claim.number].map(Cell::new);
        Line { kind: LineKind::Dataset, cells: cells.to_vec() }
    };
    let columns = ["claim", "verdict", "measured"].map(Column::left);
    Grid { columns: columns.to_vec(), lines: claims(curve).into_iter().map(line).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial_study::partial_curves::tests::rows;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::latex::Latex;
    use crate::tables::formats::markdown::Markdown;

    #[test]
    fn every_format_has_the_recalls_the_confusion_and_the_claims() {
        let curves = PartialCurve::all(&rows());
        let table = PartialTable { title: "Objects (simulated).", curves: &curves, method: "graphs" };
        let text = Markdown.text(&table);
        for part in [
            "Mean of recalls",
            "75.0",
            "street from below, graphs trained on parts at step 3",
            "does not hold",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
        assert!(Latex.text(&table).contains("75.0"));
    }
}
