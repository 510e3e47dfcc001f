//! What the results of every format can do.

use crate::annotation::LabeledScan;
use crate::dataset::Dataset;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassRules;

use super::detections::ForeignDetections;

/// Results of another program, in some format. Scans are named by their places in [`Dataset::scan_ids`].
pub trait ResultReader: Send {
    /// Whether there is something for the scan. That nothing was found there is something, too.
    fn has(&self, scan_idx: usize) -> bool;

    /// Reads what was found in scan `scan_idx`, which is `scan`; `None` if there is nothing for it.
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if a file is damaged or belongs to another scan, or classes in it are unknown.
    fn read(
        &mut self,
        scan_idx: usize,
        scan: &LabeledScan,
    ) -> Result<Option<ForeignDetections>, DatasetError>;

    /// The names of what is there for scans that the data set does not have.
    fn left_over(&self) -> Vec<String>;

    /// What may be wrong with the results as a whole, a line each.
    fn oddities(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Whose results are read.
#[derive(Clone, Copy)]
pub struct ResultsOf<'a, 'd> {
    /// The data set.
    pub dataset: &'d dyn Dataset,
    /// Which of its scans are asked for, as places in [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// What names of classes stand for.
    pub classes: &'a ClassRules,
}

impl ResultsOf<'_, '_> {
    /// The data set, as errors call it.
    pub fn dataset_name(&self) -> String {
        let description = self.dataset.description();
        format!("{:?} ({})", description.id, description.format)
    }
}
