//! A learned model, and the parameters that it was learned with.

use super::bag::Vocabulary;
use super::decision::Decision;
use super::labels::Labeler;
use super::partial_params::PartialParams;
use crate::describe::trained_file::Provenance;

/// A trained bag of graphs.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialModel {
    /// Its provenance.
    pub made: Provenance,
    /// Parameters that it was learned with, and is used with.
    pub params: PartialParams,
    /// Names of the classes.
    pub classes: Vec<String>,
    /// Labels of keypoints.
    pub labeler: Labeler,
    /// Patterns that have a column.
    pub vocabulary: Vocabulary,
    /// The learned decision.
    pub decision: Decision,
}

impl PartialModel {
    /// The class that is none of these, if there is one.
    pub fn rejected_idx(&self) -> Option<usize> {
        self.classes.iter().position(|it| *it == self.params.decision.rejected_class)
    }
}
