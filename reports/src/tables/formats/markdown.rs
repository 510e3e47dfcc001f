//! Markdown for pull requests, pages and the summary of a job.

use std::fmt::Write as _;

use crate::tables::formats::format::Format;
use crate::tables::grid::{Alignment, Grid, Line, LineKind};
use crate::tables::notes::Notes;
use crate::tables::sheet::{Listing, Part, Sheet, Tabular};

/// Entries of a listing, and items of each, that are written; the summary of a job may not be long.
const MOST_LISTED: usize = 20;

/// Markdown with pipe tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Markdown;

impl<T: Tabular + ?Sized> Format<T> for Markdown {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.md")
    }

    fn text(&self, subject: &T) -> String {
        let Sheet { lead, parts, listing, notes, .. } = subject.sheet();
        let mut text = String::new();
        for (line_idx, line) in lead.iter().map(|it| escaped(it)).enumerate() {
            push_line(&mut text, &if line_idx == 0 { format!("**{line}**\n") } else { format!("{line}\n") });
        }
        for Part { title, grid } in &parts {
            if let Some(title) = title {
                push_line(&mut text, &format!("**{}**\n", escaped(title)));
            }
            write_grid(&mut text, grid, &notes);
            text.push('\n');
        }
        if let Some(listing) = &listing {
            write_listing(&mut text, listing);
        }
        for sentence in &notes.sentences {
            push_line(&mut text, &format!("- {}", escaped(sentence)));
        }
        text
    }
}

/// The first of the entries, and the first items of each.
fn write_listing(text: &mut String, listing: &Listing) {
    for (head, items) in listing.entries.iter().take(MOST_LISTED) {
        push_line(text, &format!("- {}", escaped(head)));
        for item in items.iter().take(MOST_LISTED) {
            push_line(text, &format!("  - {}", escaped(item)));
        }
        if items.len() > MOST_LISTED {
            push_line(text, &format!("  - and {} more; {}", items.len() - MOST_LISTED, listing.in_full));
        }
    }
    if listing.entries.len() > MOST_LISTED {
        let n_more = listing.entries.len() - MOST_LISTED;
        push_line(text, &format!("- and {n_more} more; {}", listing.in_full));
    }
    text.push('\n');
}

/// The grid as a pipe table.
fn write_grid(text: &mut String, grid: &Grid, notes: &Notes) {
    // Pipe tables have no cells across columns: the group's name goes into the head of its first column.
    let mut group_before = None;
    let heads = grid.columns.iter().map(|column| {
        let begins_group = column.group.is_some() && column.group.as_ref() != group_before;
        group_before = column.group.as_ref();
        let group = column.group.as_deref().filter(|_| begins_group);
        group.map_or(column.title.clone().into_owned(), |it| format!("{}: {}", escaped(it), column.title))
    });
    push_line(text, &format!("| {} |", heads.collect::<Vec<_>>().join(" | ")));
    let rules = grid.columns.iter().map(|it| match it.alignment {
        Alignment::Left => ":--",
        Alignment::Decimal => "--:",
    });
    push_line(text, &format!("| {} |", rules.collect::<Vec<_>>().join(" | ")));
    for line in &grid.lines {
        let cells = (0..line.cells.len()).map(|column_idx| cell_text(line, column_idx, notes));
        push_line(text, &format!("| {} |", cells.collect::<Vec<_>>().join(" | ")));
    }
}

fn cell_text(line: &Line, column_idx: usize, notes: &Notes) -> String {
    let cell = &line.cells[column_idx];
    let text = escaped(&cell.text);
    let text = match line.kind {
        _ if text.is_empty() => text,
        LineKind::Paper => format!("*{text}*"),
        LineKind::Overall if column_idx == 0 => format!("**{text}**"),
        LineKind::Dataset | LineKind::Detail | LineKind::Overall => text,
    };
    let tag = Notes::tag(cell).map_or_else(String::new, |it| format!(" (*{it}*)"));
    format!("{text}{}{tag}", notes.sign(cell))
}

fn push_line(text: &mut String, line: &str) {
    writeln!(text, "{line}").expect("a string takes all that is written");
}

/// `text` with a backslash before every character that would mean something to Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    while let Some(character) = rest.next() {
        let within_word = before.is_alphanumeric() && rest.peek().is_some_and(|it| it.is_alphanumeric());
        let is_special = match character {
            '\\' | '|' | '*' | '`' | '<' | '[' => true,
            '_' => !within_word,
            _ => false,
        };
        if is_special {
            escaped.push('\\');
        }
        escaped.push(if character.is_control() { ' ' } else { character });
        before = character;
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::sample;

    #[test]
    fn a_table_is_a_pipe_table() {
        insta::assert_snapshot!(Markdown.text(&sample::tables()[0]), @r"
        **Task objects. Rates in %. Matched by a point-set IoU of at least 0.5.**

        | data set | NO | paper: ND | F-rate | fps | kd-tree: ND | F-rate | fps | pca: ND | F-rate | fps |
        | :-- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |
        | main_road (*simulated*) | 412 | 423 | 88.9 | 121 | 480 | 76.2 | 8.04 | 415 | 76.9 | 46.0 |
        | 95 % interval |  |  | 86.4–90.4 |  |  | 73.7–77.7 |  |  | 74.4–78.4 |  |
        | kitti_tracking | 318 | –¹ | –¹ | 98.2 | –¹ | –¹ | 0.47 | –¹ | –¹ | 39.9 |
        | recall, TP / NO |  |  | 91.2 |  |  | 85.2 |  |  | 64.2 |  |
        | kitti_object | 61 | –¹ | –¹ | 104 | –¹ | –¹ | 0.50 | –¹ | –¹ | 41.0 |
        | recall, TP / NO |  |  | 90.2 |  |  | 100.0 |  |  | 65.6 |  |
        | **overall** (*recorded*) | 379 | –¹ | –¹ | 101 | –¹ | –¹ | 0.49 | –¹ | –¹ | 40.4 |
        | recall, TP / NO |  |  | 91.0 |  |  | 87.6 |  |  | 64.4 |  |
        | *published: Budapest #1*† | *669* |  | *89* | *29* |  | *77* | *0.38* |  |  |  |
        | *published: Budapest #2*† | *429* |  | *79* | *25* |  | *64* | *0.22* |  |  |  |
        | *published: KITTI* | *496* |  | *82* | *29* |  | *75* | *0.46* |  |  |  |
        | *published: overall*† | *1594* |  | *83* | *28* |  | *72* | *0.35* |  |  |  |

        | data set | detector | scans | NO | TP | MO | FO | P | R | IA | ID |
        | :-- | :-- | --: | --: | --: | --: | --: | --: | --: | --: | --: |
        | main_road (*simulated*) | paper | 20 | 412 | 371 | 41 | 52 | 87.7 | 90.0 | 17 | 230 |
        |  | kd-tree | 20 | 412 | 340 | 72 | 140 | 70.8 | 82.5 | 17 | 230 |
        |  | pca | 20 | 412 | 318 | 94 | 97 | 76.6 | 77.2 | 17 | 230 |
        | kitti_tracking | paper | 20 | 318 | 290 | 28 | –¹ | –¹ | 91.2 | 17 | 230 |
        |  | kd-tree | 20 | 318 | 271 | 47 | –¹ | –¹ | 85.2 | 17 | 230 |
        |  | pca | 20 | 318 | 204 | 114 | –¹ | –¹ | 64.2 | 17 | 230 |
        | kitti_object | paper | 20 | 61 | 55 | 6 | –¹ | –¹ | 90.2 | 17 | 230 |
        |  | kd-tree | 20 | 61 | 61 | 0 | –¹ | –¹ | 100.0 | 17 | 230 |
        |  | pca | 20 | 61 | 40 | 21 | –¹ | –¹ | 65.6 | 17 | 230 |
        | **overall** (*recorded*) | paper | 40 | 379 | 345 | 34 | –¹ | –¹ | 91.0 | 34 | 460 |
        |  | kd-tree | 40 | 379 | 332 | 47 | –¹ | –¹ | 87.6 | 34 | 460 |
        |  | pca | 40 | 379 | 244 | 135 | –¹ | –¹ | 64.4 | 34 | 460 |

        - NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). fps: scans per second, detection only, on Example CPU @ 2 GHz.
        - P: precision, TP / ND. R: recall, TP / NO. IA, ID: ignored annotations and detections, neither right nor wrong.
        - 95 % interval: cluster bootstrap, 10000 resamples of whole drives.
        - overall: ratios of counts and times summed over the data sets, recorded and simulated ones apart.
        - Numbers of data sets are measured here, and may be compared within a row. Published rows are printed in Börcs, Nagy, Benedek: Fast 3-D Urban Object Detection on Streaming Point Clouds, table 1; connected component analysis under kd-tree, hierarchical grid under paper. They are of other scans, annotations and machines: for orientation, and not to be compared with the numbers measured here.
        - recorded: from a sensor.
        - simulated: from a simulator, not recorded.
        - † Budapest recordings, not public; overall with those of KITTI.
        - ¹ undefined: not every class of object is annotated, so false objects cannot be counted.
        ");
    }

    #[test]
    fn what_means_something_to_markdown_is_escaped() {
        assert_eq!(escaped("a|b *c* <d> [e] _f_ g_h\ni"), r"a\|b \*c\* \<d> \[e] \_f\_ g_h i");
    }
}
