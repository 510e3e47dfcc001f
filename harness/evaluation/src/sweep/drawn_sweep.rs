//! Numbers of each point, made of the sums of a sweep, and intervals of the numbers and their differences.

use detector::grid::cell_fitness::FitnessReading;
use rayon::prelude::*;
use reports::numbers::blocks::{BlockCount, DriveSecond};
use reports::numbers::latencies::Latencies;
use reports::numbers::pools::Pool;
use reports::numbers::run_report::{RunReport, RunReportError};
use reports::numbers::sweep_score::{
    CellScore, FitnessValue, SweepScore, SweepScores, SweepSubject, SweepTime,
};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::swept_numbers::{SweptNumber, SweptNumbers};
use reports::uncertainty::bootstrap::{Distribution, N_RESAMPLES};
use reports::uncertainty::sample::{Draw, Question, Sample};
use reports::verdicts::paired_difference::paired_difference;
use reports::vocabulary::extent::Extent;
use reports::vocabulary::metric::Metric;
use reports::vocabulary::origin::Origin;
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use crate::sweep::scan_at_point::TimedScan;
use crate::sweep::sweep_tally::{AtPoint, CellSums, SweepTally};

/// A sweep, and resamples of its scans that all points share.
pub struct DrawnSweep<'a> {
    tally: &'a SweepTally<'a>,
    // Of each data set its resamples.
    draws: Vec<Draw>,
}

/// Data sets that are evaluated together.
struct Group {
    extent: Extent,
    origin: Origin,
    sensor: String,
    dataset_idxs: Vec<usize>,
}

impl SweepTally<'_> {
    /// Draws the resamples of the scans.
    pub fn draw(&self) -> DrawnSweep<'_> {
        DrawnSweep { draws: self.counts.draw(), tally: self }
    }

    /// Times by processor, if the scans were timed on several processors; else empty.
    pub fn times_of_processors(&self) -> Vec<(String, Vec<SweepTime>)> {
        let processors = self.processors();
        let unlike = processors.iter().filter(|_| processors.len() > 1);
        unlike.map(|it| ((*it).to_owned(), self.times_on(it))).collect()
    }

    /// Numbers under official protocols, of each data set and, if there are several, of all of one origin together.
    /// `on_point` is called after each point.
    pub fn protocol_numbers(&self, on_point: impl Fn()) -> SweptNumbers {
        let groups = self.groups();
        let names = groups.iter().map(|it| it.extent.name());
        let drawn: Vec<(&str, DrawnScans)> = names.map(|it| (it, DrawnScans::of(&self.counts, it))).collect();
        let detectors: Vec<&str> = self.manifest.detectors.iter().map(|it| it.name.as_str()).collect();
        let mut numbers = Vec::new();
        for (point_idx, tally) in self.protocols.iter().enumerate() {
            for number in tally.numbers_on(&drawn, &detectors) {
                let group = groups.iter().find(|it| it.extent.name() == number.dataset);
                let detector_idx = detectors.iter().position(|it| *it == number.detector);
                let Some((group, detector_idx)) = group.zip(detector_idx) else { continue };
                let subject = self.subject(group, AtPoint { detector_idx, point_idx });
                numbers.push(SweptNumber { subject, number });
            }
            on_point();
        }
        SweptNumbers { parameters: self.entry.parameters(), n_swept: self.entry.swept.len(), numbers }
    }

    /// Each data set, and then the data sets of one origin together, if there are several.
    fn groups(&self) -> Vec<Group> {
        let entries = &self.manifest.datasets;
        let group = |extent, origin, dataset_idxs: Vec<usize>| {
            let mut sensors: Vec<&str> = dataset_idxs.iter().map(|it| entries[*it].sensor.as_str()).collect();
            sensors.sort_unstable();
            sensors.dedup();
            Group { extent, origin, sensor: sensors.join("+"), dataset_idxs }
        };
        let mut groups: Vec<Group> = Vec::new();
        for (dataset_idx, it) in entries.iter().enumerate() {
            groups.push(group(Extent::Dataset(it.id.clone()), it.origin(), vec![dataset_idx]));
        }
        for pool in self.manifest.pools().into_iter().filter(Pool::is_of_several) {
            let is_in_it = |it: &usize| pool.datasets.contains(&entries[*it].id);
            groups.push(group(pool.extent, pool.origin, (0..entries.len()).filter(is_in_it).collect()));
        }
        groups
    }

    /// All points of a detector.
    fn points_of(&self, detector_idx: usize) -> impl Iterator<Item = AtPoint> + use<> {
        (0..self.entry.points.len()).map(move |point_idx| AtPoint { detector_idx, point_idx })
    }

    fn subject(&self, group: &Group, at: AtPoint) -> SweepSubject {
        SweepSubject {
            extent: group.extent.clone(),
            origin: group.origin,
            sensor: group.sensor.clone(),
            detector: self.manifest.detectors[at.detector_idx].name.clone(),
            point_idx: at.point_idx,
            values: self.entry.points[at.point_idx].clone(),
        }
    }

    fn times_on(&self, processor: &str) -> Vec<SweepTime> {
        let mut times = Vec::new();
        for group in self.groups() {
            let is_asked =
                |it: &&TimedScan| it.processor == processor && group.dataset_idxs.contains(&it.dataset_idx);
            let scans: Vec<&TimedScan> = self.times.iter().filter(is_asked).collect();
            let at_points = (0..self.manifest.detectors.len()).flat_map(|it| self.points_of(it));
            times.extend(at_points.filter_map(|it| self.time(&group, &scans, it)));
        }
        times
    }

    fn time(&self, group: &Group, scans: &[&TimedScan], at: AtPoint) -> Option<SweepTime> {
        let ms = |time_ns: &u64| *time_ns as f64 / 1e6;
        let times_ns = |it: &&TimedScan| it.times_ns[at.point_idx][at.detector_idx].clone();
        let all = Latencies::new(scans.iter().flat_map(times_ns).map(|it| ms(&it)).collect());
        let shortest = scans.iter().filter_map(|it| times_ns(it).iter().min().map(ms));
        let shortest = Latencies::new(shortest.collect());
        Some(SweepTime {
            subject: self.subject(group, at),
            n_scans: scans.len() as u64,
            n_detections: all.n() as u64,
            typical_ms: shortest.percentile_ms(50)?,
            min_ms: all.percentile_ms(0)?,
            p50_ms: all.percentile_ms(50)?,
            p90_ms: all.percentile_ms(90)?,
            max_ms: all.percentile_ms(100)?,
        })
    }
}

impl DrawnSweep<'_> {
    /// Numbers of each data set and, if there are several, of all of one origin together. There are no times if they were
    /// taken on several processors.
    pub fn summary(&self) -> SweepScores {
        let SweepTally { manifest, entry, .. } = self.tally;
        let mut asked = Vec::new();
        let groups = self.tally.groups();
        for group in &groups {
            for detector_idx in 0..manifest.detectors.len() {
                for task in Task::ALL {
                    asked.extend(self.tally.points_of(detector_idx).map(|at| (group, task, at)));
                }
            }
        }
        let scores = asked.par_iter().filter_map(|(group, task, at)| self.score(group, *task, *at));
        let times = match self.tally.processors()[..] {
            [only] => self.tally.times_on(only),
            _ => Vec::new(),
        };
        SweepScores {
            parameters: entry.parameters(),
            n_swept: entry.swept.len(),
            configured: entry.configured.clone(),
            scores: scores.collect(),
            times,
        }
    }

    /// Numbers of every detector at every point, as a run has them.
    ///
    /// # Errors
    ///
    /// [`RunReportError`] if a number is there twice.
    pub fn report(&self, scoring_version: u32) -> Result<RunReport, RunReportError> {
        self.tally.counts.report(scoring_version, &self.draws)
    }

    /// The 95 % interval of a difference of rates: that of the first of two scores of one detector, task and extent minus
    /// that of the second. `None` if a data set has a single block.
    pub fn difference(&self, [first, second]: [&SweepScore; 2]) -> Option<[f64; 2]> {
        let [of_first, of_second] = [first, second].map(|it| self.sample(&self.question(it)?));
        let difference = paired_difference(&of_second?, &of_first?, &first.rate_metric())?;
        difference.interval.map(|it| it.ends)
    }

    /// Held-out rate of the points of `scores`: each block of scans is judged at the point that is best on all other
    /// blocks, so no scan influences the choice of its own point. `None` with fewer than two blocks.
    pub fn held_out(&self, scores: &[&SweepScore]) -> Option<f64> {
        let of_blocks = |it: &&SweepScore| {
            let question = self.question(it)?;
            Some(self.tally.counts.terms_of_blocks(&question, &it.rate_metric(), &self.draws))
        };
        held_out(&scores.iter().map(of_blocks).collect::<Option<Vec<_>>>()?)
    }

    /// The question that `score` answers.
    fn question<'b>(&'b self, score: &'b SweepScore) -> Option<Question<'b>> {
        let SweepSubject { detector, point_idx, extent, .. } = &score.subject;
        let detector_idx = self.tally.manifest.detectors.iter().position(|it| it.name == *detector)?;
        Some(self.question_about(extent, score.task, AtPoint { detector_idx, point_idx: *point_idx }))
    }

    fn question_about<'b>(&'b self, extent: &'b Extent, task: Task, at: AtPoint) -> Question<'b> {
        let detector = &self.tally.counts.detectors()[self.tally.index_of(at)];
        Question { dataset: extent.name(), task, detector, slice: Slice::All }
    }

    fn sample(&self, question: &Question<'_>) -> Option<Sample> {
        self.tally.counts.sample(question, &self.draws)
    }

    /// `None` if no scan was evaluated.
    fn score(&self, group: &Group, task: Task, at: AtPoint) -> Option<SweepScore> {
        let question = self.question_about(&group.extent, task, at);
        let sample = self.sample(&question)?;
        let within = |metric| sample.interval(&metric).map(|it| it.ends);
        Some(SweepScore {
            subject: self.tally.subject(group, at),
            task,
            n_scans: sample.n_scans,
            blocks: sample.blocks,
            f_rate_within: within(Metric::FRate),
            recall_within: within(Metric::Recall),
            cells: self.cells(group, at, sample.blocks),
            counts: self.tally.counts.counts(question.dataset, task, question.detector)?,
        })
    }

    fn cells(&self, group: &Group, at: AtPoint, blocks: BlockCount) -> Option<CellScore> {
        let total = group.dataset_idxs.iter().filter_map(|dataset_idx| {
            self.cells_of(*dataset_idx, at).map(|(_, it)| it).reduce(CellSums::with)
        });
        let total = total.reduce(CellSums::with)?;
        let interval = |idx: usize| {
            let mut resampled = vec![[0.0; 2]; N_RESAMPLES];
            for &dataset_idx in &group.dataset_idxs {
                let terms = self.cells_of(dataset_idx, at).map(|(second, it)| (second, it.readings[idx]));
                self.draws[dataset_idx].add_terms(terms, &mut resampled);
            }
            let values = resampled.into_iter().map(ratio);
            Distribution::new(values, blocks).map(|it| it.interval().ends)
        };
        let reading = |(idx, reading): (usize, FitnessReading)| {
            let value = ratio(total.readings[idx]);
            let within = value.and_then(|_| interval(idx));
            FitnessValue { name: reading.name(), value, within, range: reading.range() }
        };
        Some(CellScore {
            // The decimal number as it was written, without the error of its 32-bit representation.
            cell_size_m: format!("{}", total.cell_size_m).parse().unwrap_or_default(),
            n_dense_sparse_empty: total.n_dense_sparse_empty,
            readings: FitnessReading::ALL.into_iter().enumerate().map(reading).collect(),
        })
    }

    /// Sums of the cells of a data set, second by second.
    fn cells_of(&self, dataset_idx: usize, at: AtPoint) -> impl Iterator<Item = (&DriveSecond, CellSums)> {
        let index = self.tally.index_of(at);
        let of_seconds = self.tally.cells[dataset_idx].iter();
        of_seconds.filter_map(move |(second, sums)| Some((second, sums[index]?)))
    }
}

fn ratio([numerator, denominator]: [f64; 2]) -> Option<f64> {
    (denominator != 0.0).then(|| numerator / denominator)
}

/// The ratio of sums over blocks. Each block is taken from the point that is best on all other blocks; of equal points, from
/// the first.
fn held_out(points: &[Vec<[f64; 2]>]) -> Option<f64> {
    let n_blocks = points.first()?.len();
    if n_blocks < 2 {
        return None;
    }
    let sum = |terms: &mut dyn Iterator<Item = &[f64; 2]>| {
        terms.fold([0.0; 2], |sum: [f64; 2], it| [sum[0] + it[0], sum[1] + it[1]])
    };
    let ratio =
        |[numerator, denominator]: [f64; 2]| if denominator > 0.0 { numerator / denominator } else { -1.0 };
    let chosen = |block_idx: usize| {
        let of_others = |it: &Vec<[f64; 2]>| {
            ratio(sum(&mut it.iter().enumerate().filter(|(other, _)| *other != block_idx).map(|(_, it)| it)))
        };
        let rates: Vec<f64> = points.iter().map(of_others).collect();
        let best = (0..points.len()).reduce(|best, it| if rates[it] > rates[best] { it } else { best })?;
        Some(points[best][block_idx])
    };
    let chosen: Vec<[f64; 2]> = (0..n_blocks).map(chosen).collect::<Option<_>>()?;
    Some(ratio(sum(&mut chosen.iter()))).filter(|it| *it >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_block_has_a_say_in_what_it_is_judged_at() {
        // Two points that differ only in the first two blocks: over all three blocks each has 6 of 12.
        let first = vec![[4.0, 4.0], [0.0, 4.0], [2.0, 4.0]];
        let second = vec![[0.0, 4.0], [4.0, 4.0], [2.0, 4.0]];
        // The others choose the second point for the first block and the first point for the second one.
        assert_eq!(held_out(&[first.clone(), second]), Some(2.0 / 12.0));
        assert_eq!(held_out(std::slice::from_ref(&first)), Some(0.5));
        assert_eq!(held_out(&[vec![[1.0, 2.0]]]), None);
        assert_eq!(held_out(&[]), None);
    }
}
