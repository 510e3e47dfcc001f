//! Who leads and who is faster, for a terminal.

use crate::tables::terminal::wrapped_to;
use crate::verdicts::standing::{Speeds, Standing};

/// The sentences for a terminal of `width` columns.
pub fn standing_to_terminal(standings: &[Standing], speeds: &Speeds, width: usize) -> String {
    let sentences = standings.iter().map(Standing::sentence).chain(speeds.sentence());
    sentences.map(|it| wrapped_to(&it, width)).collect()
}
