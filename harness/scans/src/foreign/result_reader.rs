//! The interface of the results of every format.

use std::collections::BTreeMap;
use std::path::Path;

use super::detections::ForeignDetections;
use crate::annotation::LabeledScan;
use crate::dataset::class_table::ClassRules;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::{Dataset, DatasetError};

/// Results of another program, in some format. Scans are named by their indices in [`Dataset::scan_ids`].
pub trait ResultReader: Send {
    /// Whether there are results for the scan. Results without a detection count, too.
    fn has(&self, scan_idx: usize) -> bool;

    /// Reads the detections in scan `scan_idx`, which is `scan`; `None` if there are no results for it.
    fn read(&mut self, scan_idx: usize, scan: &LabeledScan) -> FoundInScan;
}

/// The detections in a scan; `None` without results.
pub type FoundInScan = Result<Option<ForeignDetections>, DatasetError>;

/// Results that were opened.
pub struct OpenResults {
    /// Their reader.
    pub reader: Box<dyn ResultReader>,
    /// The names of results for scans that the data set does not have.
    pub left_over: Vec<String>,
    /// Possible errors of the results as a whole, a line each.
    pub oddities: Vec<String>,
}

impl OpenResults {
    /// The results of `reader`, without possible errors.
    pub fn new(reader: impl ResultReader + 'static, left_over: Vec<String>) -> Self {
        Self { reader: Box::new(reader), left_over, oddities: Vec::new() }
    }
}

/// The data set and the scans that results are read for.
pub struct ResultsOf<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// The scans that are asked for, as indices in [`Dataset::scan_ids`], each with its name and frame in results.
    pub asked: BTreeMap<usize, ForeignFrame>,
    /// Rules for the names of classes.
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

    /// Makes sure that results, which `say` something about scans, can be of this data set: each asked scan `fits`.
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
