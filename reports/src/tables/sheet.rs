//! All that a table says, before a format lays it out.

use crate::tables::grid::Grid;
use crate::tables::notes::Notes;

/// What can be laid out as tables.
pub trait Tabular {
    /// All of it.
    fn sheet(&self) -> Sheet;

    /// What a paper prints of it: all, unless there is more than fits into one.
    fn printed(&self) -> Sheet {
        self.sheet()
    }
}

/// Tables with what is said above and beneath them, in the order in which it is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Names it where others refer to it.
    pub(crate) label: String,
    /// Lines above all tables, the first of which says it all.
    pub(crate) lead: Vec<String>,
    /// The tables.
    pub(crate) parts: Vec<Part>,
    /// What is too long for a table.
    pub(crate) listing: Option<Listing>,
    /// What has to be said, and what signs mean.
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
    /// Each with what there is to say of it.
    pub(crate) entries: Vec<(String, Vec<String>)>,
    /// Where all of it is.
    pub(crate) in_full: &'static str,
}

impl Sheet {
    /// One table with sentences beneath, and what its marks mean.
    pub(crate) fn of(title: String, grid: Grid, sentences: Vec<String>) -> Self {
        Self::of_parts(vec![Part { title: Some(title), grid }], sentences)
    }

    /// The same with a name for others to refer to.
    pub(crate) fn labelled(self, label: &str) -> Self {
        Self { label: label.to_owned(), ..self }
    }

    /// Tables with sentences beneath them all, and what their marks mean.
    pub(crate) fn of_parts(parts: Vec<Part>, sentences: Vec<String>) -> Self {
        let notes = Notes::beneath(parts.iter().map(|it| &it.grid), sentences);
        Self { label: String::new(), lead: Vec::new(), parts, listing: None, notes }
    }
}
