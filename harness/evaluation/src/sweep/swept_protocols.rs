//! Protocols of others that a sweep is evaluated under, with what came of them so far at every point.

use std::sync::{Mutex, PoisonError};

use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::protocol::Protocol;

use crate::protocols::chosen_protocols::ChosenProtocols;

/// Some protocols, and the rows of every point. Rows of different scans may come in any order.
pub struct SweptProtocols {
    /// The protocols.
    pub chosen: ChosenProtocols,
    tallies: Vec<Mutex<ProtocolTally>>,
}

impl SweptProtocols {
    /// By `protocols`, at `n_points` points; `None` if there are no protocols.
    pub fn of(protocols: &[Protocol], n_points: usize) -> Option<Self> {
        let chosen = ChosenProtocols::of(protocols)?;
        Some(Self { chosen, tallies: (0..n_points).map(|_| Mutex::default()).collect() })
    }

    /// Adds the rows of a scan at a point.
    pub fn add(&self, point_idx: usize, rows: &OfficialRows) {
        self.tallies[point_idx].lock().unwrap_or_else(PoisonError::into_inner).add(rows);
    }

    /// What came of a point so far.
    pub fn tally(&self, point_idx: usize) -> ProtocolTally {
        self.tallies[point_idx].lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
