//! The numbers of detectors on drives: scored per scan, and as they stream.

use crate::numbers::average_precision::average_precision;
use crate::numbers::blocks::Interval;
use crate::numbers::pools::Pool;
use crate::numbers::tally::Tally;
use crate::rows::counts::Counts;
use crate::streaming::machine_speed::MachineSpeed;
use crate::streaming::stream_sums::{DetectorSums, StreamSums, lower_median};
use crate::uncertainty::sample::{Draw, Question};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::forecast::Forecast;
use crate::vocabulary::formula::Term;
use crate::vocabulary::metric::{Metric, RecallPositions};
use crate::vocabulary::origin::Origin;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// One detector in one task on one data set, or on all of one origin together.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamed {
    /// The data sets.
    pub extent: Extent,
    /// Where their scans come from.
    pub origin: Origin,
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: String,
    /// Counts over scans, each answer judged at the time of its own scan.
    pub per_scan: Counts,
    /// Counts over moments, the newest answer judged at each, moved on by the car's motion.
    pub streamed: Counts,
    /// Interval of the headline rate of `streamed`.
    pub within: Option<Interval>,
    /// Average precision over moments at 101 recalls; `None` without scores.
    pub average_precision: Option<f64>,
    /// Slices by range and speed, with the counts of both.
    pub slices: Vec<StreamedSlice>,
    /// Sums that need no interval.
    pub sums: DetectorSums,
}

/// Counts of a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamedSlice {
    /// The slice.
    pub slice: Slice,
    /// Counts over scans.
    pub per_scan: Counts,
    /// Counts over moments.
    pub streamed: Counts,
}

/// The rate that a detector is judged by: the F-rate, or recall where false detections are unknown.
pub fn headline(counts: Counts) -> Option<f64> {
    if counts.fo().is_some() { counts.f_rate() } else { counts.recall() }
}

impl Streamed {
    /// The numbers of all detectors: `per_scan` has the rows of scans, `streamed` those of moments. Data sets of one origin
    /// come first, each by itself, then all of them together.
    pub fn all(per_scan: &Tally, streamed: &Tally, sums: &StreamSums) -> Vec<Self> {
        let draws = streamed.draw();
        let mut all = Vec::new();
        for pool in streamed.pools() {
            let singles = pool.datasets.iter().filter(|_| pool.is_of_several());
            let singles = singles.map(|it| Pool {
                extent: Extent::Dataset(it.clone()),
                origin: pool.origin,
                datasets: vec![it.clone()],
            });
            for part in singles.chain([pool.clone()]) {
                for task in streamed.tasks() {
                    let of_detector = |detector: &String| {
                        let question = Question {
                            dataset: part.extent.name(),
                            task: *task,
                            detector,
                            slice: Slice::All,
                        };
                        Self::of((per_scan, streamed), &part, &question, (&draws, sums))
                    };
                    all.extend(streamed.detectors().iter().filter_map(of_detector));
                }
            }
        }
        all
    }

    fn of(
        (per_scan, streamed): (&Tally, &Tally),
        part: &Pool,
        question: &Question<'_>,
        (draws, sums): (&[Draw], &StreamSums),
    ) -> Option<Self> {
        let Question { dataset, task, detector, .. } = *question;
        let mut own = DetectorSums::default();
        for id in &part.datasets {
            if let Some(of_dataset) = sums.get(&(id.clone(), task, detector.to_owned())) {
                own.add(of_dataset.clone());
            }
        }
        let counts = |tally: &Tally| tally.counts(dataset, task, detector);
        let streamed_counts = counts(streamed)?;
        let metric = if streamed_counts.fo().is_some() { Metric::FRate } else { Metric::Recall };
        let ranked = streamed.ranked(question).filter(|_| streamed_counts.fo().is_some());
        let of_slice = |tally: &Tally, slice: Slice| {
            let total = tally.sample(&Question { slice, ..*question }, &tally.undrawn())?.total;
            let term = |it| total.of(it) as u64;
            let is_known = streamed_counts.fo().is_some() && slice.has_false_detections();
            Counts::new(term(Term::Annotations), term(Term::Matched), is_known.then(|| term(Term::False)))
        };
        let is_shown = |it: &Slice| matches!(it, Slice::Range(_) | Slice::Speed(_));
        let slices = streamed.slices(task, detector).into_iter().filter(is_shown).filter_map(|slice| {
            let none = Counts::new(0, 0, streamed_counts.fo().map(|_| 0));
            Some(StreamedSlice {
                slice,
                per_scan: of_slice(per_scan, slice).or(none)?,
                streamed: of_slice(streamed, slice)?,
            })
        });
        Some(Self {
            extent: part.extent.clone(),
            origin: part.origin,
            task,
            detector: detector.to_owned(),
            per_scan: counts(per_scan)?,
            streamed: streamed_counts,
            within: streamed.sample(question, draws)?.interval(&metric),
            average_precision: ranked
                .and_then(|it| average_precision(&it, streamed_counts.no(), RecallPositions::Points101)),
            slices: slices.collect(),
            sums: own,
        })
    }

    /// Age of what was known in milliseconds: median and 95th percentile of the moments at which anything was, by nearest rank.
    pub fn ages_ms(&self) -> Option<[f64; 2]> {
        let mut ages = self.sums.ages_ms.clone();
        ages.sort_by(f64::total_cmp);
        let at =
            |share: f64| ages.get(((share * ages.len() as f64).ceil() as usize).saturating_sub(1)).copied();
        Some([at(0.5)?, at(0.95)?])
    }

    /// The median time of detection in milliseconds.
    pub fn latency_ms(&self) -> Option<f64> {
        lower_median(&self.sums.latencies_ms)
    }

    /// The share of scans that were dropped.
    pub fn dropped(&self) -> Option<f64> {
        let n_scans = self.sums.latencies_ms.len() as f64;
        (n_scans > 0.0).then(|| 1.0 - self.sums.n_taken as f64 / n_scans)
    }

    /// The counts with a forecast.
    pub fn forecast(&self, forecast: Forecast) -> Option<Counts> {
        self.sums.forecasts.get(&forecast).copied()
    }

    /// The headline rate on machines of other speeds.
    pub fn by_machine(&self) -> impl Iterator<Item = (MachineSpeed, Option<f64>)> {
        self.sums.by_machine.iter().map(|(speed, counts)| (*speed, headline(*counts)))
    }
}
