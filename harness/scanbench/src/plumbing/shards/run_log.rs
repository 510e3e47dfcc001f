//! The log of a run: each event goes into its journal, and into its rows.

use std::cell::RefCell;

use evaluation::journal::Journal;

use super::run_event::RunEvent;
use super::run_rows::RunRows;
use super::run_summary::RunSummary;
use crate::plumbing::failure::Failure;

/// Takes the events of a run as they come.
pub struct RunLog<'a> {
    /// `None` if nothing is kept to continue from.
    journal: Option<&'a Journal>,
    made: RefCell<EventsMade>,
}

/// Summary and rows of the events so far.
#[derive(Default)]
pub struct EventsMade {
    /// Summary for the manifest.
    pub summary: RunSummary,
    /// Rows of a run in one piece; those of a shard are made when it is merged.
    pub rows: Option<RunRows>,
}

impl EventsMade {
    pub fn add(&mut self, event: &RunEvent) -> Result<(), Failure> {
        self.summary.add(event);
        Ok(self.rows.as_mut().map_or(Ok(()), |it| it.add(event, 0))?)
    }
}

impl<'a> RunLog<'a> {
    /// A log that continues from `made`, and keeps events in `journal`.
    pub fn new(journal: Option<&'a Journal>, made: EventsMade) -> Self {
        Self { journal, made: made.into() }
    }

    pub fn add(&self, event: &RunEvent) -> Result<(), Failure> {
        if let Some(journal) = self.journal {
            journal.add(event)?;
        }
        self.made.borrow_mut().add(event)
    }

    /// Summary and rows of all events.
    pub fn into_made(self) -> EventsMade {
        self.made.into_inner()
    }
}
