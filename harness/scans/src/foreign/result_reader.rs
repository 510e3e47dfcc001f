//! What the results of every format can do.

use std::collections::BTreeMap;
use std::path::Path;

use super::detections::ForeignDetections;
use crate::annotation::LabeledScan;
use crate::dataset::class_table::ClassRules;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::{Dataset, DatasetError};

/// Results of another program, in some format. Scans are named by their indices in [`Dataset::scan_ids`].
pub trait ResultReader: Send {
    /// Whether there is something for the scan. That nothing was found there is something, too.
    fn has(&self, scan_idx: usize) -> bool;

    /// Reads what was found in scan `scan_idx`, which is `scan`; `None` if there is nothing for it.
    fn read(&mut self, scan_idx: usize, scan: &LabeledScan) -> FoundInScan;
}

/// What was found in a scan, if there is anything for it.
pub type FoundInScan = Result<Option<ForeignDetections>, DatasetError>;

/// Results that were opened.
pub struct OpenResults {
    /// Reads them.
    pub reader: Box<dyn ResultReader>,
    /// The names of what is there for scans that the data set does not have.
    pub left_over: Vec<String>,
    /// What may be wrong with the results as a whole, a line each.
    pub oddities: Vec<String>,
}

impl OpenResults {
    /// Those of `reader`, with nothing odd about them.
    pub fn new(reader: impl ResultReader + 'static, left_over: Vec<String>) -> Self {
        Self { reader: Box::new(reader), left_over, oddities: Vec::new() }
    }
}

/// Whose results are read.
pub struct ResultsOf<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// Which of its scans are asked for, as indices in [`Dataset::scan_ids`], each with what results need to know about it.
    pub asked: BTreeMap<usize, ForeignFrame>,
    /// What names of classes stand for.
    pub classes: &'a ClassRules,
}

impl<'a> ResultsOf<'a> {
    /// Asks for the scans at `scan_indices` of `dataset`.
    pub fn new(
        dataset: &'a dyn Dataset,
        scan_indices: &[usize],
        classes: &'a ClassRules,
    ) -> Result<Self, DatasetError> {
        let frame_of = |&scan_idx: &usize| Ok((scan_idx, dataset.foreign_frame(scan_idx)?));
        let asked = scan_indices.iter().map(frame_of).collect::<Result<_, DatasetError>>()?;
        Ok(Self { dataset, asked, classes })
    }

    /// Makes sure that results which `say` something can be about this data set, one scan of which `fits`.
    pub fn require(
        &self,
        path: &Path,
        fits: impl Fn(&ForeignFrame) -> bool,
        say: &str,
        lacks: &str,
    ) -> Result<(), DatasetError> {
        if self.asked.values().all(fits) {
            return Ok(());
        }
        let description = self.dataset.description();
        let problem = format!("{say}, and {:?} ({}) {lacks}", description.id, description.format);
        Err(DatasetError::UnusableResults { path: path.to_path_buf(), problem })
    }
}
