//! From the rows of every point to the numbers of a sweep under protocols of others.

use std::collections::BTreeMap;

use reports::numbers::sweep_score::{SweepScores, SweepSubject};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::swept_numbers::{SweptNumber, SweptNumbers};
use reports::vocabulary::extent::Extent;

use crate::sweep::sweep_tally::SweepTally;

impl SweepTally<'_> {
    /// The numbers of each data set and, if there are several, of all together; `scores` is the summary of the same sweep.
    /// `on_point` is called after each point.
    pub fn protocol_numbers(&self, scores: &SweepScores, on_point: impl Fn()) -> SweptNumbers {
        let key = |it: &SweepSubject| (it.point_idx, it.extent.name().to_owned(), it.detector.clone());
        let subjects: BTreeMap<_, &SweepSubject> =
            scores.scores.iter().map(|it| (key(&it.subject), &it.subject)).collect();
        let detectors: Vec<&str> = self.manifest.detectors.iter().map(|it| it.name.as_str()).collect();
        let drawn: Vec<(&str, DrawnScans)> =
            scores.extents().into_iter().map(|it| (it.name(), self.drawn_scans(it))).collect();
        let mut numbers = Vec::new();
        for (point_idx, tally) in self.protocols.iter().enumerate() {
            for number in tally.numbers_on(&drawn, &detectors) {
                let subject = &subjects[&(point_idx, number.dataset.clone(), number.detector.clone())];
                numbers.push(SweptNumber { subject: (*subject).clone(), number });
            }
            on_point();
        }
        SweptNumbers { parameters: scores.parameters.clone(), n_swept: scores.n_swept, numbers }
    }

    fn drawn_scans(&self, extent: &Extent) -> DrawnScans {
        let datasets = self.manifest.datasets.iter().zip(&self.datasets);
        let is_asked = datasets.filter(|(entry, _)| match extent {
            Extent::Dataset(id) => entry.id == *id,
            Extent::Overall => true,
            Extent::OverallOf(origin) => entry.origin() == *origin,
        });
        DrawnScans::of_datasets(is_asked.map(|(entry, sums)| (entry.id.as_str(), sums.scans.clone())))
    }
}
