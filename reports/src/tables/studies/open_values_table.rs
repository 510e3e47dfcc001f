//! The values that the papers leave open, and how much hangs on each.

use crate::files::fixed_decimals::{decimals_or_dash, fixed_decimals};
use crate::reproduction::sensitivity::Sensitivity;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};

/// Open values with what they were set to, and how rates go with them.
#[derive(Debug, Clone, Copy)]
pub struct OpenValuesTable<'a> {
    /// The settings.
    pub sensitivity: &'a Sensitivity,
}

impl Tabular for OpenValuesTable<'_> {
    fn sheet(&self) -> Sheet {
        let Sensitivity { values, settings, rates, seed, scans } = self.sensitivity;
        let mut columns: Vec<Column> =
            ["value", "what the papers say", "range", "in good faith"].map(Column::left).into();
        columns.extend(rates.iter().map(|it| Column::number("correlation").within(it.name.clone())));
        let correlations: Vec<_> = rates.iter().map(|it| self.sensitivity.correlations(it)).collect();
        let line = |it: &crate::reproduction::sensitivity::SetValue| {
            let texts = [&it.parameter, &it.said, &it.range, &it.chosen].map(Clone::clone);
            let of_rate = |correlations: &Vec<(String, Option<f64>)>| {
                let found = correlations.iter().find(|(name, _)| *name == it.parameter);
                decimals_or_dash(found.and_then(|it| it.1), 2)
            };
            let cells = texts.into_iter().chain(correlations.iter().map(of_rate)).map(Cell::new).collect();
            Line { kind: LineKind::Dataset, cells }
        };
        let lines = values.iter().map(line).collect();
        let groups = self.sensitivity.by_words();
        let mut sentences = vec![format!(
            "{} joint settings, a Latin hypercube (seed {seed}), on {scans}. correlation: Spearman's, between value and rate within the \
             settings of one criterion.",
            settings.len()
        )];
        sentences.extend(rates.iter().filter_map(|it| {
            let [low, middle, high] = it.quantiles([0.05, 0.5, 0.95])?.map(|it| fixed_decimals(100.0 * it, 1));
            let [n_leading, n] = it.n_leading();
            let of_group = |(words, settings): (&String, &Vec<usize>)| {
                let [n_leading, n] = it.n_leading_among(settings.iter().copied());
                format!("{words} {n_leading} of {n}")
            };
            let of_groups: Vec<String> = groups.iter().map(of_group).collect();
            Some(format!(
                "{}: {} has {middle} in the median, and {low} to {high} in nine of ten settings; it is ahead of {} in {n_leading} of {n} \
                 ({}).",
                it.name,
                it.method,
                it.rival,
                of_groups.join(", ")
            ))
        }));
        Sheet::of("Values that the papers leave open".to_owned(), Grid { columns, lines }, sentences)
            .labelled("open-values")
    }
}
