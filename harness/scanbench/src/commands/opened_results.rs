//! The results of other programs, opened before anything is run.

use std::cell::RefCell;
use std::collections::BTreeMap;

use evaluation::run::entrant::Entrant;
use scans::dataset::folder_name::folder_name;
use scans::dataset::source::DamagePolicy;
use scans::foreign::foreign_results::{ForeignResults, MissingResults, ResultRequest, open_results};

use crate::commands::failure::Failure;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::standard_streams::print_detail;

/// Results by the names of detector and data set, until a run takes them.
#[derive(Default)]
pub struct OpenedResults(RefCell<BTreeMap<(&'static str, String), ForeignResults>>);

impl OpenedResults {
    /// Opens the results of all `entrants` that left some, for all `datasets`: of each those in the folder of its name, if there is one, or else
    /// those at the path itself.
    ///
    /// # Errors
    ///
    /// If there are none, they are damaged, or lack scans and `missing` refuses that.
    pub fn open(
        entrants: &[Entrant],
        datasets: &[OpenedDataset],
        missing: MissingResults,
        damage: DamagePolicy,
    ) -> Result<Self, Failure> {
        let mut opened = BTreeMap::new();
        for (entrant, path) in entrants.iter().filter_map(|it| Some((it, it.results()?))) {
            for it in datasets {
                let dataset = &*it.dataset;
                let id = &dataset.description().id;
                // A scan that cannot be read is told of when it is its turn.
                let is_asked = |scan_idx: &usize| {
                    damage == DamagePolicy::Refuse || dataset.foreign_frame(*scan_idx).is_ok()
                };
                let scan_indices: Vec<usize> = it.scan_indices.iter().copied().filter(is_asked).collect();
                let request = ResultRequest { scan_indices: &scan_indices, classes: &it.classes, missing };
                let of_dataset = path.join(folder_name(id));
                let path = if of_dataset.is_dir() { &of_dataset } else { path };
                let results = open_results(path, dataset, &request)?;
                print_detail(format_args!(
                    "{}: results for {id} in the format of {}, {}",
                    entrant.name,
                    results.format().name(),
                    path.display()
                ));
                opened.insert((entrant.name, id.clone()), results);
            }
        }
        Ok(Self(RefCell::new(opened)))
    }

    /// Takes those of `detector` for the data set called `id`, if it left some.
    pub fn take(&self, detector: &'static str, id: &str) -> Option<ForeignResults> {
        self.0.borrow_mut().remove(&(detector, id.to_owned()))
    }
}
