//! Aligned text for a terminal, without colour.

use std::fmt::Write as _;

use crate::tables::folding::{GAP, GROUP_GAP, Width, grid_width, left_text, pieces, widths};
use crate::tables::formats::format::Format;
use crate::tables::grid::{Alignment, Cell, Grid, Line, LineKind};
use crate::tables::notes::Notes;
use crate::tables::sheet::{Part, Sheet, Tabular};

/// Sentences are broken to this many characters.
const LINE_WIDTH: usize = 100;
/// Aligned text, without colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terminal {
    /// Its width in characters; wider tables are folded. Without it none is, and sentences are broken as for a page.
    pub width: Option<usize>,
}

impl Terminal {
    /// A text as wide as its tables are.
    pub const UNFOLDED: Self = Self { width: None };

    /// Sentences, each from the beginning of a line on.
    pub fn sentences(self, sentences: impl IntoIterator<Item = String>) -> String {
        sentences.into_iter().map(|it| wrapped_to(&it, self.width.unwrap_or(LINE_WIDTH))).collect()
    }

    /// An item of a list: indented, all of its lines.
    fn item(self, item: &str) -> String {
        let Some(width) = self.width else { return format!("  {item}\n") };
        let lines = wrapped_to(item, width.saturating_sub(2));
        format!("  {}\n", lines.trim_end().replace('\n', "\n  "))
    }

    /// A title stays as it is where nothing is folded, however long, for those who search in it.
    fn title(self, title: &str) -> String {
        self.width.map_or_else(|| format!("{title}\n"), |width| wrapped_to(title, width))
    }
}

impl<T: Tabular + ?Sized> Format<T> for Terminal {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.txt")
    }

    /// Titles, tables, lists and notes below each other.
    ///
    /// Three detectors with names of the usual length fit into 100 columns; where they do not fit, one follows the other.
    fn text(&self, subject: &T) -> String {
        let Sheet { lead, parts, listing, notes, .. } = subject.sheet();
        let mut text: String = lead.iter().map(|it| self.title(it)).collect();
        if !lead.is_empty() {
            text.push('\n');
        }
        for Part { title, grid } in &parts {
            if let Some(title) = title {
                text.push_str(&self.title(title));
                text.push('\n');
            }
            match self.width {
                Some(width) => {
                    write_folded(&mut text, &with_broken_words(grid, &notes, width), &notes, width);
                }
                None => write_grid(&mut text, grid, &notes),
            }
            text.push('\n');
        }
        for (head, items) in listing.iter().flat_map(|it| &it.entries) {
            text.push_str(&self.title(head));
            for it in items {
                text.push_str(&self.item(it));
            }
        }
        if listing.is_some() {
            text.push('\n');
        }
        text.push_str(&self.sentences(notes.sentences));
        text
    }
}

/// The pieces of a grid below each other.
fn write_folded(text: &mut String, grid: &Grid, notes: &Notes, width: usize) {
    for (piece_idx, piece) in pieces(grid, notes, width).iter().enumerate() {
        if piece_idx > 0 {
            text.push('\n');
        }
        write_grid(text, piece, notes);
    }
}

/// A table of words with its last column broken into lines where it does not fit into `width`.
fn with_broken_words(grid: &Grid, notes: &Notes, width: usize) -> Grid {
    let widths = widths(grid, notes);
    let is_of_words = grid.columns.iter().all(|it| it.alignment == Alignment::Left);
    let (true, Some(last)) = (is_of_words, widths.last()) else { return grid.clone() };
    let rest = width.saturating_sub(grid_width(grid, &widths) - last.total);
    if last.total <= rest {
        return grid.clone();
    }
    let last_idx = widths.len() - 1;
    let broken = |line: &Line| -> Vec<Line> {
        let pieces = wrapped_to(&line.cells[last_idx].text, rest);
        let pieces = pieces.lines().map(str::to_owned).enumerate();
        let piece = |(piece_idx, text): (usize, String)| {
            let next = || Line { kind: LineKind::Detail, cells: vec![Cell::default(); widths.len()] };
            let mut piece = if piece_idx == 0 { line.clone() } else { next() };
            piece.cells[last_idx].text = text;
            piece
        };
        pieces.map(piece).collect()
    };
    Grid { columns: grid.columns.clone(), lines: grid.lines.iter().flat_map(broken).collect() }
}

/// The grid with its heads.
fn write_grid(text: &mut String, grid: &Grid, notes: &Notes) {
    let widths = widths(grid, notes);
    let total = grid_width(grid, &widths);
    write_group_heads(text, grid, &widths);
    let heads = grid.columns.iter().zip(&widths).map(|(column, width)| match column.alignment {
        Alignment::Left => format!("{:<1$}", column.title, width.total),
        Alignment::Decimal => format!("{:>1$}", column.title, width.total),
    });
    write_cells(text, grid, &widths, heads.collect());
    push_line(text, &"─".repeat(total));
    for (line_idx, line) in grid.lines.iter().enumerate() {
        if grid.begins_part(line_idx) {
            push_line(text, &"─".repeat(total));
        }
        let cells =
            widths.iter().enumerate().map(|(column_idx, width)| match grid.columns[column_idx].alignment {
                Alignment::Left => format!("{:<1$}", left_text(line, column_idx, notes), width.total),
                Alignment::Decimal => decimal_text(&line.cells[column_idx], width, notes),
            });
        write_cells(text, grid, &widths, cells.collect());
    }
}

/// The names of the groups above their columns, with a rule each; nothing if there are no groups.
fn write_group_heads(text: &mut String, grid: &Grid, widths: &[Width]) {
    let groups = grid.groups();
    if groups.iter().all(|(name, _)| name.is_none()) {
        return;
    }
    let (mut names, mut rules) = (Vec::new(), Vec::new());
    let mut widths = widths.iter();
    for (name, n_columns) in groups {
        let of_columns: usize = widths.by_ref().take(n_columns).map(|it| it.total).sum();
        let width = of_columns + GAP.len() * (n_columns - 1);
        names.push(format!("{:^1$}", name.unwrap_or(""), width));
        rules.push(if name.is_some() { "─".repeat(width) } else { " ".repeat(width) });
    }
    let gap = format!("{GAP}{GROUP_GAP}");
    push_line(text, &names.join(&gap));
    push_line(text, &rules.join(&gap));
}

fn write_cells(text: &mut String, grid: &Grid, widths: &[Width], cells: Vec<String>) {
    let mut line = String::new();
    for (column_idx, cell) in cells.into_iter().enumerate() {
        if column_idx > 0 {
            line.push_str(GAP);
            if grid.columns[column_idx].group != grid.columns[column_idx - 1].group {
                line.push_str(GROUP_GAP);
            }
        }
        // Text that is too wide begins in the cell before it.
        for _ in widths[column_idx].total..cell.chars().count() {
            if line.ends_with("  ") {
                line.pop();
            }
        }
        line.push_str(&cell);
    }
    push_line(text, &line);
}

fn push_line(text: &mut String, line: &str) {
    writeln!(text, "{}", line.trim_end()).expect("a string takes all that is written");
}

fn decimal_text(cell: &Cell, width: &Width, notes: &Notes) -> String {
    if cell.is_interval {
        return format!("{:>1$}", format!("{}{}", cell.text, notes.sign(cell)), width.total);
    }
    let fraction = format!("{}{}", cell.fraction(), notes.sign(cell));
    let whole = cell.text.split('.').next().unwrap_or("");
    format!("{whole:>0$}{fraction:<1$}", width.total - width.fraction, width.fraction)
}

/// `sentence` in lines of at most `width` characters, and at most [`LINE_WIDTH`], all but the first indented.
fn wrapped_to(sentence: &str, width: usize) -> String {
    let width = width.clamp(20, LINE_WIDTH);
    if sentence.chars().count() <= width {
        return format!("{sentence}\n");
    }
    let mut lines = vec![String::new()];
    for word in sentence.split_whitespace() {
        let last = lines.last_mut().expect("there is a first line");
        let is_start = last.trim().is_empty();
        if !is_start && last.chars().count() + 1 + word.chars().count() > width {
            lines.push(format!("  {word}"));
        } else {
            last.push_str(if is_start { "" } else { " " });
            last.push_str(word);
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::grid::Column;
    use crate::tables::sample;

    #[test]
    fn objects_are_printed_with_recall_where_the_f_rate_is_undefined() {
        insta::assert_snapshot!(Terminal { width: Some(100) }.text(&sample::tables()[0]), @r"
        Task objects. Rates in %. Matched by a point-set IoU of at least 0.5.

                                               paper               kd-tree                pca
                                        ───────────────────   ──────────────────   ──────────────────
        data set                   NO     ND  F-rate    fps     ND  F-rate   fps     ND  F-rate   fps
        ─────────────────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)     412   423     88.9  121     480     76.2  8.04   415     76.9  46.0
          95 % interval                    86.4–90.4             73.7–77.7            74.4–78.4
        kitti_tracking            318     –¹     –¹    98.2     –¹     –¹   0.47     –¹     –¹   39.9
          recall, TP / NO                       91.2                  85.2                 64.2
        kitti_object               61     –¹     –¹   104       –¹     –¹   0.50     –¹     –¹   41.0
          recall, TP / NO                       90.2                 100.0                 65.6
        ─────────────────────────────────────────────────────────────────────────────────────────────
        overall (recorded)        379     –¹     –¹   101       –¹     –¹   0.49     –¹     –¹   40.4
          recall, TP / NO                       91.0                  87.6                 64.4
        ─────────────────────────────────────────────────────────────────────────────────────────────
        published: Budapest #1†   669           89     29             77    0.38
        published: Budapest #2†   429           79     25             64    0.22
        published: KITTI          496           82     29             75    0.46
        published: overall†      1594           83     28             72    0.35

        data set               detector  scans   NO   TP   MO    FO     P      R  IA   ID
        ─────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)  paper        20  412  371   41   52   87.7   90.0  17  230
                               kd-tree      20  412  340   72  140   70.8   82.5  17  230
                               pca          20  412  318   94   97   76.6   77.2  17  230
        kitti_tracking         paper        20  318  290   28    –¹   –¹    91.2  17  230
                               kd-tree      20  318  271   47    –¹   –¹    85.2  17  230
                               pca          20  318  204  114    –¹   –¹    64.2  17  230
        kitti_object           paper        20   61   55    6    –¹   –¹    90.2  17  230
                               kd-tree      20   61   61    0    –¹   –¹   100.0  17  230
                               pca          20   61   40   21    –¹   –¹    65.6  17  230
        ─────────────────────────────────────────────────────────────────────────────────
        overall (recorded)     paper        40  379  345   34    –¹   –¹    91.0  34  460
                               kd-tree      40  379  332   47    –¹   –¹    87.6  34  460
                               pca          40  379  244  135    –¹   –¹    64.4  34  460

        NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). fps: scans
          per second, detection only, on Example CPU @ 2 GHz.
        P: precision, TP / ND. R: recall, TP / NO. IA, ID: ignored annotations and detections, neither right
          nor wrong.
        95 % interval: cluster bootstrap, 10000 resamples of whole drives.
        overall: ratios of counts and times summed over the data sets, recorded and simulated ones apart.
        Numbers of data sets are measured here, and may be compared within a row. Published rows are printed
          in Börcs, Nagy, Benedek: Fast 3-D Urban Object Detection on Streaming Point Clouds, table 1;
          connected component analysis under kd-tree, hierarchical grid under paper. They are of other
          scans, annotations and machines: for orientation, and not to be compared with the numbers measured
          here.
        recorded: from a sensor.
        simulated: from a simulator, not recorded.
        † Budapest recordings, not public; overall with those of KITTI.
        ¹ undefined: not every class of object is annotated, so false objects cannot be counted.
        ");
    }

    #[test]
    fn vehicles_are_printed_with_a_note_on_each_undefined_number() {
        insta::assert_snapshot!(Terminal { width: Some(100) }.text(&sample::tables()[1]), @r"
        Task vehicles. Rates in %. Matched by a point-set IoU of at least 0.5.

                                              paper               kd-tree                pca
                                        ──────────────────   ──────────────────   ─────────────────
        data set                   NO    ND  F-rate    fps     ND  F-rate   fps    ND  F-rate   fps
        ───────────────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)     190   189    95.5  121      214    84.2  8.04   190   100.0  46.0
        kitti_tracking            240   244    87.2   98.2   1239    26.9  0.47   179    71.6  39.9
        kitti_object                0     0     –¹     –²       3     0.0  –²       0     –¹   41.0
        ───────────────────────────────────────────────────────────────────────────────────────────
        overall (recorded)        240   244    87.2   98.2   1242    26.9  0.47   179    71.6  40.4
        ───────────────────────────────────────────────────────────────────────────────────────────
        published: Budapest #1†   567          89     24                                 73    15
        published: Budapest #2†  1141          90     21                                 71    12
        published: Budapest #3†   368          80     22                                 57    13
        published: KITTI          614          78     25                                 62    14
        published: overall†      2690          86     23                                 68    13.5

        data set               detector  scans   NO   TP  MO    FO      P      R  IA   ID
        ─────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)  paper        20  190  181   9     8   95.8   95.3  17  230
                               kd-tree      20  190  170  20    44   79.4   89.5  17  230
                               pca          20  190  190   0     0  100.0  100.0  17  230
        kitti_tracking         paper        20  240  211  29    33   86.5   87.9  17  230
                               kd-tree      20  240  199  41  1040   16.1   82.9  17  230
                               pca          20  240  150  90    29   83.8   62.5  17  230
        kitti_object           paper        20    0    0   0     0    –¹     –¹   17  230
                               kd-tree      20    0    0   0     3    0.0    –¹   17  230
                               pca          20    0    0   0     0    –¹     –¹   17  230
        ─────────────────────────────────────────────────────────────────────────────────
        overall (recorded)     paper        40  240  211  29    33   86.5   87.9  34  460
                               kd-tree      40  240  199  41  1043   16.0   82.9  34  460
                               pca          40  240  150  90    29   83.8   62.5  34  460

        NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). fps: scans
          per second, detection only, on Example CPU @ 2 GHz.
        P: precision, TP / ND. R: recall, TP / NO. IA, ID: ignored annotations and detections, neither right
          nor wrong.
        overall: ratios of counts and times summed over the data sets, recorded and simulated ones apart.
        Numbers of data sets are measured here, and may be compared within a row. Published rows are printed
          in Börcs, Nagy, Baticz, Benedek: A Model-based Approach for Fast Vehicle Detection in Continuously
          Streamed Urban LIDAR Point Clouds, table 1; PCA based approach under pca, model-based approach
          under paper. They are of other scans, annotations and machines: for orientation, and not to be
          compared with the numbers measured here.
        recorded: from a sensor.
        simulated: from a simulator, not recorded.
        † Budapest recordings, not public; overall with those of KITTI.
        ¹ undefined: the denominator is zero.
        ² undefined: no scan was timed.
        ");
    }

    #[test]
    fn tables_fit_into_the_columns_there_are() {
        for width in [60, 80, 100, 200] {
            let texts = sample::tables().map(|it| Terminal { width: Some(width) }.text(&it)).concat();
            for line in texts.lines() {
                assert!(line.chars().count() <= width, "{width}: {line}");
            }
        }
    }

    #[test]
    fn a_table_of_words_keeps_its_lines() {
        let word = |it: &str| Cell::new(it);
        let line = Line { kind: LineKind::Dataset, cells: vec![word("sky"), word("is blue")] };
        let grid = Grid { columns: ["what", "says"].map(Column::left).to_vec(), lines: vec![line] };
        let sheet = crate::tables::sheet::Sheet::of("Words.".to_owned(), grid, Vec::new());
        let mut text = String::new();
        write_folded(&mut text, &sheet.parts[0].grid, &sheet.notes, 80);
        assert!(text.contains("sky") && text.contains("is blue"), "{text}");
    }

    #[test]
    fn words_that_do_not_fit_are_broken_into_lines() {
        let cells = ["the more is seen, the better", &"many words ".repeat(20)].map(Cell::new);
        let line = Line { kind: LineKind::Dataset, cells: cells.to_vec() };
        let grid = Grid { columns: ["claim", "measured"].map(Column::left).to_vec(), lines: vec![line] };
        let sheet = crate::tables::sheet::Sheet::of("Words.".to_owned(), grid, Vec::new());
        let mut text = String::new();
        let grid = with_broken_words(&sheet.parts[0].grid, &sheet.notes, 80);
        write_folded(&mut text, &grid, &sheet.notes, 80);
        assert!(text.lines().all(|it| it.chars().count() <= 80), "{text}");
        assert_eq!(text.matches("many").count(), 20, "{text}");
    }

    #[test]
    fn one_detector_follows_the_other_where_they_do_not_fit_side_by_side() {
        let text = Terminal { width: Some(60) }.text(&sample::tables()[1]);
        let narrow = text.split("NO:").next().unwrap_or_default();
        let heads: Vec<&str> = narrow.lines().filter(|it| it.contains("F-rate")).collect();
        assert_eq!(heads.len(), 3, "{narrow}");
        assert_eq!(narrow.matches("kitti_object").count(), narrow.matches("data set ").count(), "{narrow}");
        assert_eq!(narrow.matches("published: KITTI").count(), 2, "{narrow}");
        // Nothing is lost: every number of the wide table is in the narrow one.
        let wide = Terminal { width: Some(200) }.text(&sample::tables()[1]);
        let words = |text: &str| {
            let words = text.split_whitespace().filter(|it| it.starts_with(|it: char| it.is_ascii_digit()));
            words.map(str::to_owned).collect::<std::collections::BTreeSet<_>>()
        };
        assert_eq!(words(&wide), words(&text));
    }
}
