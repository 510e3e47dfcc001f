//! Events of `scanbench partial`: lines of its journal, and of the log of a shard.

use evaluation::journal::Journal;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::csv_text;
use reports::rows::partial_row::PartialRow;
use serde::{Deserialize, Serialize};

use crate::plumbing::failure::Failure;

/// An event of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectEvent {
    Answer(Answer),
    /// All methods have classified all objects, and these are the predictions of other people's programs.
    Peers {
        /// Rows of `partial.csv`.
        #[serde(with = "csv_text")]
        rows: Vec<PartialRow>,
    },
}

/// Answer of one method for an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    pub set_idx: usize,
    pub method_idx: usize,
    /// Index of the object in the set.
    pub object_idx: usize,
    /// Rows of `partial.csv`.
    #[serde(with = "csv_text")]
    pub rows: Vec<PartialRow>,
}

/// The rows of a journal or a log: of all answers, in the order of rows, and then of peers.
#[derive(Debug, Default)]
pub struct ObjectRows {
    answers: Vec<Answer>,
    peers: Vec<PartialRow>,
}

impl ObjectRows {
    pub fn add(&mut self, event: ObjectEvent) {
        match event {
            ObjectEvent::Answer(answer) => self.answers.push(answer),
            // Work that was interrupted right before the end asks them again.
            ObjectEvent::Peers { rows } => self.peers = rows,
        }
    }

    /// The rows in order.
    pub fn finish(mut self) -> Vec<PartialRow> {
        self.answers.sort_by_key(|it| (it.set_idx, it.method_idx, it.object_idx));
        self.answers.into_iter().flat_map(|it| it.rows).chain(self.peers).collect()
    }
}

pub fn answers_in(journal: &Journal) -> Result<Vec<PartialRow>, Failure> {
    let mut rows = ObjectRows::default();
    let read = Journal::read(journal.path(), |event| {
        rows.add(event);
        true
    });
    read.map_err(|source| ArchiveError::Read { path: journal.path().to_owned(), source })?;
    rows.peers.clear();
    Ok(rows.finish())
}
