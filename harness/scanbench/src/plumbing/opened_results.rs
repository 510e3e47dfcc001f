//! The results of other programs, opened before anything is run.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write as _;

use evaluation::run::compared_detector::ComparedDetector;
use reports::run_folder::detector_changes::first_digits;
use reports::run_folder::manifest::DetectorEntry;
use scans::dataset::checksum::sha256;
use scans::dataset::folder_name::folder_name;
use scans::dataset::source::DamagePolicy;
use scans::foreign::foreign_results::{ForeignResults, MissingResults, ResultRequest, open_results};

use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::standard_streams::print_detail;

/// Results by the names of detector and data set, until a run takes them.
#[derive(Default)]
pub struct OpenedResults {
    results: RefCell<BTreeMap<(&'static str, String), ForeignResults>>,
    // By detector, a line for each data set.
    checksums: BTreeMap<&'static str, String>,
    // By detector, by data set and name.
    files: BTreeMap<&'static str, BTreeMap<String, String>>,
}

impl OpenedResults {
    /// Opens the results of all `compared_detectors` that left some, for all `datasets`: those in the folder with the name of
    /// the data set if there is one, or else those at the path itself.
    pub fn open(
        compared_detectors: &[ComparedDetector],
        datasets: &[OpenedDataset],
        missing: MissingResults,
        damage: DamagePolicy,
    ) -> Result<Self, Failure> {
        let (mut opened, mut checksums) = (BTreeMap::new(), BTreeMap::<_, String>::new());
        let mut files = BTreeMap::<_, BTreeMap<_, _>>::new();
        for (compared_detector, path) in compared_detectors.iter().filter_map(|it| Some((it, it.results()?)))
        {
            for it in datasets {
                let dataset = &*it.dataset;
                let id = &dataset.description().id;
                // A scan that cannot be read is reported when it is its turn.
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
                    compared_detector.name,
                    results.format().name(),
                    path.display()
                ));
                let _ = writeln!(
                    checksums.entry(compared_detector.name).or_default(),
                    "{id} {}",
                    results.checksum()
                );
                let of_dataset = results.files().iter();
                files.entry(compared_detector.name).or_default().extend(
                    of_dataset.map(|(name, checksum)| (format!("{id}/{name}"), first_digits(checksum))),
                );
                opened.insert((compared_detector.name, id.clone()), results);
            }
        }
        Ok(Self { results: RefCell::new(opened), checksums, files })
    }

    /// `entry` with the checksums of the results of its detector, if it left some.
    pub fn with_checksums(&self, mut entry: DetectorEntry) -> DetectorEntry {
        if let Some(foreign) = &mut entry.foreign {
            foreign.results_checksum = self.checksums.get(entry.name.as_str()).map(sha256);
            foreign.result_files = self.files.get(entry.name.as_str()).cloned().unwrap_or_default();
        }
        entry
    }

    /// Takes the results of `detector` for the data set called `id`, if it left some.
    pub fn take(&self, detector: &'static str, id: &str) -> Option<ForeignResults> {
        self.results.borrow_mut().remove(&(detector, id.to_owned()))
    }
}
