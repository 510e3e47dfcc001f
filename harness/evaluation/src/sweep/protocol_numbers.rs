//! From the rows of every point to the numbers of a sweep under protocols of others.

use std::collections::BTreeMap;

use reports::numbers::sweep_score::{SweepScores, SweepSubject};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::swept_numbers::{SweptNumber, SweptNumbers};
use reports::rows::scan_name::ScanName;
use reports::vocabulary::extent::Extent;
use reports::vocabulary::origin::Origin;
use scans::dataset::scan_times::scan_times;

use crate::run::detector_list::ChosenDetector;
use crate::sweep::quality_pass::SweptDataset;
use crate::sweep::sweep_plan::SweepPlan;
use crate::sweep::swept_protocols::SweptProtocols;

/// A sweep that was evaluated under protocols of others.
#[derive(Clone, Copy)]
pub struct SweptOfficially<'a> {
    /// Points and detectors.
    pub plan: &'a SweepPlan,
    /// The scans.
    pub datasets: &'a [SweptDataset<'a>],
    /// What came of them.
    pub protocols: &'a SweptProtocols,
}

impl SweptOfficially<'_> {
    /// The numbers of each data set and, if there are several, of all together; `scores` is the summary of the same sweep. `on_point` is
    /// called after each point.
    pub fn numbers(&self, scores: &SweepScores, on_point: impl Fn()) -> SweptNumbers {
        let key = |it: &SweepSubject| (it.point_idx, it.extent.name().to_owned(), it.detector.clone());
        let subjects: BTreeMap<_, &SweepSubject> =
            scores.scores.iter().map(|it| (key(&it.subject), &it.subject)).collect();
        let detectors: Vec<&str> = self.plan.detectors.iter().map(ChosenDetector::name).collect();
        let drawn: Vec<(&str, DrawnScans)> =
            scores.extents().into_iter().map(|it| (it.name(), self.drawn_scans(it))).collect();
        let mut numbers = Vec::new();
        for point_idx in 0..self.plan.points.len() {
            for number in self.protocols.tally(point_idx).numbers_on(&drawn, &detectors) {
                let subject = &subjects[&(point_idx, number.dataset.clone(), number.detector.clone())];
                numbers.push(SweptNumber { subject: (*subject).clone(), number });
            }
            on_point();
        }
        SweptNumbers { parameters: scores.parameters.clone(), n_swept: scores.n_swept, numbers }
    }

    fn drawn_scans(&self, extent: &Extent) -> DrawnScans {
        let is_asked = |it: &&SweptDataset<'_>| match extent {
            Extent::Dataset(id) => it.dataset.description().id == *id,
            Extent::Overall => true,
            Extent::OverallOf(origin) => {
                it.dataset.description().is_simulated() == (*origin == Origin::Simulated)
            }
        };
        DrawnScans::of_datasets(self.datasets.iter().filter(is_asked).map(|it| {
            let (id, times) = (it.dataset.description().id.as_str(), scan_times(it.dataset));
            let scan = |&scan_idx: &usize| {
                let scan_id = &it.dataset.scan_ids()[scan_idx];
                let sequence = scan_id.sequence.clone();
                let second = times[scan_idx].second.clone();
                (ScanName { dataset: id.to_owned(), sequence, scan: scan_id.index }, second)
            };
            (id, it.scan_indices.iter().map(scan).collect())
        }))
    }
}
