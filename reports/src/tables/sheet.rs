//! The content of tables, before a format lays it out.

use crate::tables::grid::Grid;
use crate::tables::notes::Notes;

/// Content that can be laid out as tables.
pub trait Tabular {
    /// All of it.
    fn sheet(&self) -> Sheet;

    /// The part that a paper prints: all, unless there is more than fits into one.
    fn printed(&self) -> Sheet {
        self.sheet()
    }
}

/// Tables with the texts above and beneath them, in the order in which they are read.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Its name for references.
    pub(crate) label: String,
    /// Lines above all tables; the first is the conclusion.
    pub(crate) lead: Vec<String>,
    /// The tables.
    pub(crate) parts: Vec<Part>,
    /// A list that is too long for a table.
    pub(crate) listing: Option<Listing>,
    /// Sentences beneath, and the meanings of signs.
    pub(crate) notes: Notes,
}

/// A table with its title.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub(crate) title: Option<String>,
    pub(crate) grid: Grid,
}

/// A list of lists.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Listing {
    /// Each entry with its items.
    pub(crate) entries: Vec<(String, Vec<String>)>,
    /// Where the whole list is.
    pub(crate) in_full: &'static str,
}

impl Sheet {
    /// One table with sentences beneath, and the meanings of its marks.
    pub(crate) fn of(title: String, grid: Grid, sentences: Vec<String>) -> Self {
        Self::of_parts(vec![Part { title: Some(title), grid }], sentences)
    }

    /// Gives it a name for references.
    pub(crate) fn labelled(self, label: &str) -> Self {
        Self { label: label.to_owned(), ..self }
    }

    /// Tables with sentences beneath them all, and the meanings of their marks.
    pub(crate) fn of_parts(parts: Vec<Part>, sentences: Vec<String>) -> Self {
        let notes = Notes::beneath(parts.iter().map(|it| &it.grid), sentences);
        Self { label: String::new(), lead: Vec::new(), parts, listing: None, notes }
    }
}
