//! Cells of text in rows and columns, for any renderer to lay out.

use std::borrow::Cow;

use crate::numbers::blocks::BlockCount;
use crate::vocabulary::extent::Extent;

/// A table ready to be laid out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grid {
    pub(crate) columns: Vec<Column>,
    /// Each has one cell for every column.
    pub(crate) lines: Vec<Line>,
}

/// The head of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// The common head of neighbouring columns; stands above them.
    pub(crate) group: Option<String>,
    pub(crate) title: Cow<'static, str>,
    pub(crate) alignment: Alignment,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Alignment {
    Left,
    /// Numbers one below the other, by their decimal points.
    Decimal,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) kind: LineKind,
    pub(crate) cells: Vec<Cell>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineKind {
    /// About one data set.
    Dataset,
    /// More about the data set, or the sum, of the line above.
    Detail,
    /// About all data sets.
    Overall,
    /// A paper's figures.
    Paper,
}

impl LineKind {
    /// The kind of a line about `extent`.
    pub(crate) fn of(extent: &Extent) -> Self {
        if extent.is_overall() { Self::Overall } else { Self::Dataset }
    }
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Cell {
    pub(crate) text: String,
    pub(crate) mark: Option<Mark>,
    /// Two numbers, which are not aligned by a decimal point.
    pub(crate) is_interval: bool,
}

/// A remark about a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Mark {
    /// From a sensor, beside what a simulator made.
    Recorded,
    /// Made by a simulator.
    Simulated,
    /// Recordings that are not public.
    NotPublic,
    /// A time on a machine that was busy.
    BusyMachine,
    /// Of fewer scans than it takes to know a percentile.
    FewScans,
    /// An interval of fewer blocks of scans than it takes for anything to rest on it.
    FewBlocks,
    /// An interval over scans of which it is not known which are near others.
    MaybeNeighbours,
    /// There is no such number.
    Undefined(Undefined),
}

/// Why there is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Undefined {
    /// Detections beyond the annotations may be right or false.
    FalseObjectsUnknown,
    /// Nothing to be found and nothing found.
    ZeroDenominator,
    /// No scan was timed.
    NotTimed,
}

impl Mark {
    /// The mark of an interval drawn from these blocks of scans; `None` if it needs none.
    pub(crate) fn of_blocks(blocks: BlockCount) -> Option<Self> {
        if blocks.may_be_neighbours() {
            return Some(Self::MaybeNeighbours);
        }
        blocks.are_too_few().then_some(Self::FewBlocks)
    }
}

impl Column {
    /// A column of text.
    pub(crate) fn left(title: impl Into<Cow<'static, str>>) -> Self {
        Self { group: None, title: title.into(), alignment: Alignment::Left }
    }

    /// A column of numbers.
    pub(crate) fn number(title: impl Into<Cow<'static, str>>) -> Self {
        Self { group: None, title: title.into(), alignment: Alignment::Decimal }
    }

    /// Puts the column below the name of a group.
    pub(crate) fn within(self, group: impl Into<String>) -> Self {
        Self { group: Some(group.into()), ..self }
    }
}

impl Cell {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), mark: None, is_interval: false }
    }

    pub(crate) fn marked(text: impl Into<String>, mark: Mark) -> Self {
        Self { text: text.into(), mark: Some(mark), is_interval: false }
    }

    /// The cell of an interval drawn from these blocks of scans.
    pub(crate) fn interval(text: String, blocks: BlockCount) -> Self {
        Self { text, mark: Mark::of_blocks(blocks), is_interval: true }
    }

    /// The text from the decimal point on; empty for an interval.
    pub(crate) fn fraction(&self) -> &str {
        if self.is_interval { "" } else { fraction(&self.text) }
    }

    /// The cell of a number that does not exist.
    pub(crate) fn undefined(why: Undefined) -> Self {
        Self::marked("–", Mark::Undefined(why))
    }
}

impl Grid {
    /// A grid with a rule above only the first of the lines about all data sets.
    pub(crate) fn with_one_rule(columns: Vec<Column>, mut lines: Vec<Line>) -> Self {
        let overall = lines.iter_mut().filter(|it| it.kind == LineKind::Overall);
        overall.skip(1).for_each(|it| it.kind = LineKind::Dataset);
        Self { columns, lines }
    }

    /// Groups of neighbouring columns, each with its number of columns.
    pub(crate) fn groups(&self) -> Vec<(Option<&str>, usize)> {
        let same_group = self.columns.chunk_by(|left, right| left.group == right.group);
        same_group.map(|columns| (columns[0].group.as_deref(), columns.len())).collect()
    }

    /// Whether a rule stands above a line: that about all data sets, and the first of a paper.
    pub(crate) fn begins_part(&self, line_idx: usize) -> bool {
        match self.lines[line_idx].kind {
            LineKind::Overall => true,
            LineKind::Paper => line_idx > 0 && self.lines[line_idx - 1].kind != LineKind::Paper,
            LineKind::Dataset | LineKind::Detail => false,
        }
    }

    /// The grid with these columns alone.
    pub(crate) fn with_columns(&self, columns: &[usize]) -> Self {
        let lines = self.lines.iter().map(|line| Line {
            kind: line.kind,
            cells: columns.iter().map(|&idx| line.cells[idx].clone()).collect(),
        });
        Self {
            lines: lines.collect(),
            columns: columns.iter().map(|&idx| self.columns[idx].clone()).collect(),
        }
    }

    /// For every column the largest number of characters from the decimal point on.
    pub(crate) fn fraction_widths(&self) -> Vec<usize> {
        let width = |column_idx: usize| {
            self.lines.iter().map(move |it| it.cells[column_idx].fraction().chars().count()).max()
        };
        (0..self.columns.len()).map(|column_idx| width(column_idx).unwrap_or(0)).collect()
    }
}

/// The decimal point of a number and what follows.
fn fraction(text: &str) -> &str {
    text.find('.').map_or("", |point| &text[point..])
}
