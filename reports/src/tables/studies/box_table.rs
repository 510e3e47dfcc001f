//! The table of how far fitted boxes are from annotated ones.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::box_errors::{BoxErrorLine, by_data};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Mark};
use crate::tables::notes::about_interval;
use crate::tables::sheet::{Part, Sheet, Tabular};

/// A part for each of the data, a row for each error of each slice.
#[derive(Debug, Clone, Copy)]
pub struct BoxTable<'a> {
    /// The errors.
    pub lines: &'a [BoxErrorLine],
    /// What has to be said beneath.
    pub notes: &'a [&'a str],
}

impl Tabular for BoxTable<'_> {
    /// Beneath it stands how intervals are made, then the notes.
    fn sheet(&self) -> Sheet {
        let part = |lines: &[BoxErrorLine]| Part { title: Some(title(&lines[0])), grid: grid(lines) };
        let intervals = self.lines.iter().flat_map(|it| &it.fits).filter_map(|(_, it)| (*it)?.within);
        let mut sentences: Vec<String> = Vec::new();
        for interval in intervals {
            let sentence = format!("low, high: 95 % interval, {}", about_interval(interval.blocks.kind));
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        }
        sentences.extend(self.notes.iter().map(|it| (*it).to_owned()));
        Sheet::of_parts(by_data(self.lines).map(part).collect(), sentences).labelled("box-errors")
    }
}

fn title(line: &BoxErrorLine) -> String {
    let simulated = if line.is_simulated { " (simulated)" } else { "" };
    format!("Box errors of matched vehicles: {}{simulated}", line.data)
}

fn grid(lines: &[BoxErrorLine]) -> Grid {
    let mut columns = ["by", "slice"].map(Column::left).to_vec();
    columns.extend(["pairs", "tracks"].map(Column::number));
    columns.push(Column::left("error"));
    for (fit, _) in &lines[0].fits {
        columns.extend(["median", "low", "high"].map(|title| Column::number(title).within(fit)));
    }
    let mut before = None;
    let lines = lines.iter().map(|line| {
        let slice = Some((&line.by, &line.slice));
        let is_first = std::mem::replace(&mut before, slice) != slice;
        let head = [line.by.clone(), line.slice.clone(), line.n_pairs.to_string(), line.n_tracks.to_string()];
        let head = head.map(|text| if is_first { text } else { String::new() });
        let error = format!("{}, {}", line.error.name(), line.error.unit());
        let number = |it: Option<f64>| {
            Cell::new(it.map_or_else(|| "–".to_owned(), |it| fixed_decimals(it, line.error.decimals())))
        };
        let medians = line.fits.iter().flat_map(|(_, it)| {
            let interval = it.and_then(|it| it.within);
            let end = |it| Cell { mark: interval.and_then(|it| Mark::of_blocks(it.blocks)), ..number(it) };
            let [low, high] = [0, 1].map(|idx| end(interval.map(|it| it.ends[idx])));
            [number(it.map(|it| it.median)), low, high]
        });
        let cells = head.into_iter().chain([error]).map(Cell::new).chain(medians);
        Line { kind: LineKind::Dataset, cells: cells.collect() }
    });
    Grid { columns, lines: lines.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::box_errors::tests::lines;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_median_has_its_interval_and_its_denominators() {
        let lines = [
            lines("street", "all", "", 80),
            lines("street", "occlusion", "none", 0),
            lines("drive", "all", "", 8),
        ]
        .concat();
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&BoxTable { lines: &lines, notes: &["A note."] }), @r"
        Box errors of matched vehicles: street (simulated)

                                                          hull box             PCA box
                                                     ──────────────────   ──────────────────
        by         slice  pairs  tracks  error       median   low  high   median   low  high
        ────────────────────────────────────────────────────────────────────────────────────
        all                  80      20  centre, m     0.50  0.45  0.60     1.00  0.90  1.20
                                         length, m     0.50  0.45  0.60     1.00  0.90  1.20
                                         width, m      0.50  0.45  0.60     1.00  0.90  1.20
                                         yaw, deg      0.5   0.5   0.6      1.0   0.9   1.2
        occlusion  none       0       0  centre, m     –     –     –        –     –     –
                                         length, m     –     –     –        –     –     –
                                         width, m      –     –     –        –     –     –
                                         yaw, deg      –     –     –        –     –     –

        Box errors of matched vehicles: drive

                                                     hull box               PCA box
                                               ────────────────────   ────────────────────
        by   slice  pairs  tracks  error       median    low   high   median    low   high
        ──────────────────────────────────────────────────────────────────────────────────
        all             8       2  centre, m     0.50  0.45§  0.60§     1.00  0.90§  1.20§
                                   length, m     0.50  0.45§  0.60§     1.00  0.90§  1.20§
                                   width, m      0.50  0.45§  0.60§     1.00  0.90§  1.20§
                                   yaw, deg      0.5   0.5§   0.6§      1.0   0.9§   1.2§

        low, high: 95 % interval, cluster bootstrap, 10000 resamples of objects, each with all its scans:
          they cover other scans of the same drives, but not other drives.
        A note.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
        insta::assert_snapshot!(Markdown.text(&BoxTable { lines: &lines[4..8], notes: &["A note."] }), @r"
        **Box errors of matched vehicles: street (simulated)**

        | by | slice | pairs | tracks | error | hull box: median | low | high | PCA box: median | low | high |
        | :-- | :-- | --: | --: | :-- | --: | --: | --: | --: | --: | --: |
        | occlusion | none | 0 | 0 | centre, m | – | – | – | – | – | – |
        |  |  |  |  | length, m | – | – | – | – | – | – |
        |  |  |  |  | width, m | – | – | – | – | – | – |
        |  |  |  |  | yaw, deg | – | – | – | – | – | – |

        - A note.
        ");
    }
}
