//! Tables that are too wide, in pieces below each other.

use crate::tables::grid::{Alignment, Column, Grid, Line, LineKind};
use crate::tables::notes::Notes;

/// Between columns.
pub(crate) const GAP: &str = "  ";
/// Between groups of columns, in addition.
pub(crate) const GROUP_GAP: &str = " ";

/// The grid in as many pieces below each other as it takes for each to fit into `width` characters. Every piece begins with the
/// columns that say what its lines are about; a group of columns stays together where it fits.
pub(crate) fn pieces(grid: &Grid, notes: &Notes, width: usize) -> Vec<Grid> {
    let has_groups = grid.columns.iter().any(|it| it.group.is_some());
    let is_head = |column: &Column| {
        if has_groups { column.group.is_none() } else { column.alignment == Alignment::Left }
    };
    let n_heads = grid.columns.iter().take_while(|it| is_head(it)).count();
    let fits = |columns: &[usize]| {
        let piece = grid.with_columns(columns);
        let widths = widths(&piece, notes);
        grid_width(&piece, &widths).max(group_heads_width(&piece, &widths)) <= width
    };
    let heads: Vec<usize> = (0..n_heads).collect();
    let mut pieces = vec![heads.clone()];
    let rest: Vec<usize> = (n_heads..grid.columns.len()).collect();
    // An interval stays beside its number.
    let is_interval = |idx: usize| grid.lines.iter().any(|it| it.cells[idx].is_interval);
    let together = |a: &usize, b: &usize| {
        if has_groups { grid.columns[*a].group == grid.columns[*b].group } else { is_interval(*b) }
    };
    // A group that is too wide by itself comes apart.
    let groups = rest.chunk_by(together).flat_map(|group| {
        let is_whole = fits(&[heads.as_slice(), group].concat());
        group.chunks(if is_whole { group.len() } else { 1 })
    });
    for group in groups {
        let last = pieces.last_mut().expect("there is a first piece");
        let longer = [last.as_slice(), group].concat();
        if last.len() == n_heads || fits(&longer) {
            *last = longer;
        } else {
            pieces.push([heads.as_slice(), group].concat());
        }
    }
    let piece = |columns: &Vec<usize>| {
        let mut piece = grid.with_columns(columns);
        // A paper has no figures for most detectors. A table of words has no columns but its heads.
        piece.lines.retain(|line| {
            columns.len() == n_heads || line.cells[n_heads..].iter().any(|it| !it.text.is_empty())
        });
        piece
    };
    pieces.iter().map(piece).collect()
}

/// Width of a column.
pub(crate) struct Width {
    /// The whole width.
    pub(crate) total: usize,
    /// The width from the decimal point on, signs included; zero for text.
    pub(crate) fraction: usize,
}

/// Widths of the columns.
pub(crate) fn widths(grid: &Grid, notes: &Notes) -> Vec<Width> {
    let n_chars = |text: &str| text.chars().count();
    let columns = grid.columns.iter().enumerate().map(|(column_idx, column)| {
        let (mut total, mut fraction_width, mut interval_width) = (0, 0, 0);
        for line in &grid.lines {
            let cell = &line.cells[column_idx];
            match column.alignment {
                Alignment::Left => total = total.max(n_chars(&left_text(line, column_idx, notes))),
                Alignment::Decimal => {
                    let whole = n_chars(&cell.text) - n_chars(cell.fraction());
                    let behind = n_chars(cell.fraction()) + n_chars(&notes.sign(cell));
                    // An interval reaches into the cell before it, if that is empty; only its sign is behind it.
                    let has_room = column_idx > 0 && line.cells[column_idx - 1].text.is_empty();
                    if !cell.is_interval {
                        total = total.max(whole);
                        fraction_width = fraction_width.max(behind);
                    } else if !has_room {
                        interval_width = interval_width.max(whole + behind);
                    }
                }
            }
        }
        let total = n_chars(&column.title).max(total + fraction_width).max(interval_width);
        Width { total, fraction: fraction_width }
    });
    columns.collect()
}

/// Width of the line above the heads, where names of groups may be wider than their columns.
fn group_heads_width(grid: &Grid, widths: &[Width]) -> usize {
    let groups = grid.groups();
    let mut widths = widths.iter();
    let of_groups = groups.iter().map(|(name, n_columns)| {
        let of_columns: usize = widths.by_ref().take(*n_columns).map(|it| it.total).sum();
        let columns_width = of_columns + GAP.len() * (n_columns - 1);
        columns_width.max(name.map_or(0, |it| it.chars().count()))
    });
    of_groups.sum::<usize>() + (GAP.len() + GROUP_GAP.len()) * (groups.len() - 1)
}

/// Width of all columns.
pub(crate) fn grid_width(grid: &Grid, widths: &[Width]) -> usize {
    let columns: usize = widths.iter().map(|it| it.total).sum();
    columns + GAP.len() * (widths.len() - 1) + GROUP_GAP.len() * (grid.groups().len() - 1)
}

/// The text of a cell of words.
pub(crate) fn left_text(line: &Line, column_idx: usize, notes: &Notes) -> String {
    let cell = &line.cells[column_idx];
    let is_beneath = column_idx == 0 && line.kind == LineKind::Detail;
    let indent = if is_beneath { "  " } else { "" };
    let tag = Notes::tag(cell).map_or_else(String::new, |it| format!(" ({it})"));
    if cell.text.is_empty() {
        String::new()
    } else {
        format!("{indent}{}{}{tag}", cell.text, notes.sign(cell))
    }
}
