//! The table of how far fitted boxes are from annotated ones.

use crate::files::fixed_decimals::decimals_or_dash;
use crate::numbers::box_errors::{BoxErrorLine, by_data};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind, Mark};
use crate::tables::notes::about_interval;
use crate::tables::sheet::{Part, Sheet, Tabular};

/// A part for each of the data, a row for each error of each slice.
#[derive(Debug, Clone, Copy)]
pub struct BoxTable<'a> {
    /// The errors.
    pub lines: &'a [BoxErrorLine],
    /// The notes beneath.
    pub notes: &'a [&'a str],
}

impl Tabular for BoxTable<'_> {
    /// Beneath it stands how intervals are made, then the notes.
    fn sheet(&self) -> Sheet {
        let part = |lines: &[BoxErrorLine]| Part { title: Some(title(&lines[0])), grid: grid(lines) };
        let intervals = self.lines.iter().flat_map(|it| &it.fits).filter_map(|(_, it)| (*it)?.within);
        let mut sentences: Vec<String> = Vec::new();
        for interval in intervals {
            let sentence = format!(
                "box_errors.csv and the plot have 95 % intervals: {}",
                about_interval(interval.blocks.kind)
            );
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
    let mut columns = ["by", "slice", "what"].map(Column::left).to_vec();
    columns.extend(["pairs", "tracks"].map(Column::number));
    for (fit, _) in &lines[0].fits {
        columns.push(Column::number(*fit));
    }
    let (mut slice_before, mut counts_before) = (None, None);
    let lines = lines.iter().map(|line| {
        let (slice, counts) = ([&line.by, &line.slice], [line.n_pairs, line.n_tracks]);
        let is_first = slice_before.replace(slice) != Some(slice);
        // Some numbers are of fewer pairs than the others.
        let are_new = counts_before.replace(counts) != Some(counts) || is_first;
        let shown = |text: String, is_shown: bool| if is_shown { text } else { String::new() };
        let [by, slice] = slice.map(|it| shown(it.clone(), is_first));
        let [n_pairs, n_tracks] = counts.map(|it| shown(it.to_string(), are_new));
        let error = format!("{}, {}", line.error.name(), line.error.unit());
        let head = [by, slice, error, n_pairs, n_tracks];
        let number = |it: Option<f64>| Cell::new(decimals_or_dash(it, line.error.decimals()));
        let numbers = line.fits.iter().map(|(_, it)| {
            let mark = it.and_then(|it| it.within).and_then(|it| Mark::of_blocks(it.blocks));
            Cell { mark, ..number(it.map(|it| it.value)) }
        });
        let cells = head.into_iter().map(Cell::new).chain(numbers);
        Line { kind: LineKind::Dataset, cells: cells.collect() }
    });
    Grid { columns, lines: lines.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::box_errors::tests::lines;
    use crate::tables::formats::format::Format as _;
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

        by         slice  what                    pairs  tracks  hull box  PCA box
        ──────────────────────────────────────────────────────────────────────────
        all               centre, m                  80      20      0.50     1.00
                          length, m                                  0.50     1.00
                          width, m                                   0.50     1.00
                          yaw, deg                                   0.5      1.0
                          yaw within 5 deg, %                        0.5      1.0
                          yaw within 10 deg, %                       0.5      1.0
                          BEV IoU >= 0.5, %                          0.5      1.0
                          BEV IoU >= 0.7, %                          0.5      1.0
                          3D IoU >= 0.5, %                           0.5      1.0
                          3D IoU >= 0.7, %                           0.5      1.0
                          front right, %                             0.5      1.0
                          front sure, %                              0.5      1.0
                          front right if sure, %                     0.5      1.0
        occlusion  none   centre, m                   0       0      –        –
                          yaw, deg                                   –        –
                          yaw within 10 deg, %                       –        –
                          BEV IoU >= 0.7, %                          –        –

        Box errors of matched vehicles: drive

        by   slice  what                    pairs  tracks  hull box  PCA box
        ────────────────────────────────────────────────────────────────────
        all         centre, m                   8       2     0.50§    1.00§
                    length, m                                 0.50§    1.00§
                    width, m                                  0.50§    1.00§
                    yaw, deg                                  0.5§     1.0§
                    yaw within 5 deg, %                       0.5§     1.0§
                    yaw within 10 deg, %                      0.5§     1.0§
                    BEV IoU >= 0.5, %                         0.5§     1.0§
                    BEV IoU >= 0.7, %                         0.5§     1.0§
                    3D IoU >= 0.5, %                          0.5§     1.0§
                    3D IoU >= 0.7, %                          0.5§     1.0§
                    front right, %                            0.5§     1.0§
                    front sure, %                             0.5§     1.0§
                    front right if sure, %                    0.5§     1.0§

        box_errors.csv and the plot have 95 % intervals: cluster bootstrap, 10000 resamples of objects, each
          with all its scans: the intervals cover other scans of the same drives, but not other drives.
        A note.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
    }
}
