//! From what was counted scan by scan to the numbers of each point.

use detector::grid::cell_fitness::{CellTally, FitnessReading};
use rayon::prelude::*;
use reports::numbers::blocks::BlockCount;
use reports::numbers::latencies::Latencies;
use reports::numbers::sums::{FalseObjects, Sums};
use reports::numbers::sweep_score::{
    CellScore, FitnessValue, SweepScore, SweepScores, SweepSubject, SweepTime,
};
use reports::vocabulary::extent::Extent;
use reports::vocabulary::metric::Metric;
use reports::vocabulary::origin::Origin;
use reports::vocabulary::task::Task;

use scans::dataset::scan_times::scan_times_s;

use crate::metrics::counts::{Counts, FalseDetections};
use crate::sweep::block_resamples::{BlockResamples, ratio_interval};
use crate::sweep::quality_pass::SweptDataset;
use crate::sweep::scan_at_point::{DetectorAtPoint, ScanAtPoint};
use crate::sweep::sweep_plan::SweepPlan;
use crate::sweep::timed_scan::TimedScan;

/// Everything that a sweep has counted.
pub struct SweepResults<'a> {
    /// The points and detectors.
    pub plan: &'a SweepPlan,
    /// The data sets.
    pub datasets: &'a [SweptDataset<'a>],
    /// Every scan at every point, in the order of data sets, scans and points.
    pub scans: &'a [ScanAtPoint],
    /// The scans that were timed.
    pub times: &'a [TimedScan],
}

/// Data sets that are looked at together.
struct Group<'a> {
    extent: Extent,
    origin: Origin,
    sensor: String,
    members: Vec<Member<'a>>,
}

/// A data set with what was counted on it.
struct Member<'a> {
    dataset_idx: usize,
    swept: SweptDataset<'a>,
    resamples: &'a BlockResamples,
    /// Scan by scan, and of each scan point by point.
    scans: &'a [ScanAtPoint],
}

impl SweepResults<'_> {
    /// The numbers of each data set and, if there are several, of all together.
    pub fn summary(&self) -> SweepScores {
        let draw = |it: &SweptDataset<'_>| {
            let (ids, times_s) = (it.dataset.scan_ids(), scan_times_s(it.dataset));
            let scans = it.scan_indices.iter().map(|&scan_idx| (&ids[scan_idx], times_s[scan_idx]));
            BlockResamples::draw(&it.dataset.description().id, scans)
        };
        let resamples: Vec<BlockResamples> = self.datasets.iter().map(draw).collect();
        let groups = self.groups(&resamples);
        let (mut scores, mut times) = (Vec::new(), Vec::new());
        for group in &groups {
            for detector_idx in 0..self.plan.detectors.len() {
                let places: Vec<(usize, usize)> = (0..Task::ALL.len())
                    .flat_map(|task_idx| {
                        (0..self.plan.points.len()).map(move |point_idx| (task_idx, point_idx))
                    })
                    .collect();
                let score = |&(task_idx, point_idx): &(usize, usize)| {
                    self.score(group, detector_idx, task_idx, point_idx)
                };
                scores.extend(places.par_iter().map(score).collect::<Vec<_>>());
                let time = |point_idx| self.time(group, detector_idx, point_idx);
                times.extend((0..self.plan.points.len()).filter_map(time));
            }
        }
        let configured = self.plan.base.value_of(&self.plan.swept[0].name).map(ToString::to_string);
        let (parameters, n_swept) = (self.plan.parameters(), self.plan.swept.len());
        SweepScores { parameters, n_swept, configured, scores, times }
    }

    fn groups<'b>(&'b self, resamples: &'b [BlockResamples]) -> Vec<Group<'b>> {
        let member = |(dataset_idx, swept): (usize, &'b SweptDataset<'b>)| Member {
            dataset_idx,
            swept: *swept,
            resamples: &resamples[dataset_idx],
            scans: self.scans_of(dataset_idx),
        };
        let origin = |it: &SweptDataset<'_>| {
            if it.dataset.description().is_simulated() { Origin::Simulated } else { Origin::Recorded }
        };
        let alone = |(dataset_idx, swept): (usize, &'b SweptDataset<'b>)| {
            let description = swept.dataset.description();
            Group {
                extent: Extent::Dataset(description.id.clone()),
                origin: origin(swept),
                sensor: description.sensor.clone(),
                members: vec![member((dataset_idx, swept))],
            }
        };
        let mut groups: Vec<Group<'b>> = self.datasets.iter().enumerate().map(alone).collect();
        if groups.len() > 1 {
            let mut sensors: Vec<&str> = groups.iter().map(|it| it.sensor.as_str()).collect();
            sensors.sort_unstable();
            sensors.dedup();
            groups.push(Group {
                extent: Extent::Overall,
                origin: self.datasets.iter().map(origin).reduce(Origin::with).unwrap_or(Origin::Recorded),
                sensor: sensors.join("+"),
                members: self.datasets.iter().enumerate().map(member).collect(),
            });
        }
        groups
    }

    fn scans_of(&self, dataset_idx: usize) -> &[ScanAtPoint] {
        let start = self.scans.partition_point(|it| it.dataset_idx < dataset_idx);
        let end = self.scans.partition_point(|it| it.dataset_idx <= dataset_idx);
        &self.scans[start..end]
    }

    fn subject(&self, group: &Group<'_>, detector_idx: usize, point_idx: usize) -> SweepSubject {
        SweepSubject {
            extent: group.extent.clone(),
            origin: group.origin,
            sensor: group.sensor.clone(),
            detector: self.plan.detectors[detector_idx].name().to_owned(),
            point_idx,
            values: self.plan.points[point_idx].values.clone(),
        }
    }

    fn score(&self, group: &Group<'_>, detector_idx: usize, task_idx: usize, point_idx: usize) -> SweepScore {
        let n_points = self.plan.points.len();
        let at_point = |member: &Member<'_>| -> Vec<DetectorAtPoint> {
            let scans = member.scans.iter().skip(point_idx).step_by(n_points);
            scans.map(|it| it.detectors[detector_idx].clone()).collect()
        };
        let found: Vec<Found<'_>> =
            group.members.iter().map(|member| Found { member, scans: at_point(member) }).collect();
        let of_member = |it: &Found<'_>| {
            let mut counts = Counts::default();
            it.scans.iter().for_each(|scan| counts += scan.counts[task_idx]);
            let annotated = &it.member.swept.dataset.description().annotated;
            counts.scored(FalseDetections::of(annotated, Task::ALL[task_idx]))
        };
        let counts = found.iter().map(of_member).reduce(|mut sum, it| {
            sum += it;
            sum
        });
        let counts = counts.unwrap_or_default();
        let within = |metric: &Metric| {
            interval(&found, |it| {
                let counts = it.counts[task_idx].scored(FalseDetections::Known);
                Sums::of_counts(counts).ratio(metric, FalseObjects::Known).unwrap_or_default()
            })
        };
        SweepScore {
            subject: self.subject(group, detector_idx, point_idx),
            task: Task::ALL[task_idx],
            n_scans: found.iter().map(|it| it.scans.len() as u64).sum(),
            blocks: blocks_of(group),
            f_rate_within: counts.fo().and_then(|_| within(&Metric::FRate)),
            recall_within: within(&Metric::Recall),
            cells: cells(&found),
            counts,
        }
    }

    fn time(&self, group: &Group<'_>, detector_idx: usize, point_idx: usize) -> Option<SweepTime> {
        let is_member =
            |it: &&TimedScan| group.members.iter().any(|member| member.dataset_idx == it.dataset_idx);
        let scans: Vec<&TimedScan> = self.times.iter().filter(is_member).collect();
        let ms = |time_ns: &u64| *time_ns as f64 / 1e6;
        let all = scans.iter().flat_map(|it| &it.times_ns[point_idx][detector_idx]).map(ms);
        let all = Latencies::new(all.collect());
        let shortest = scans.iter().filter_map(|it| it.times_ns[point_idx][detector_idx].iter().min());
        let shortest = Latencies::new(shortest.map(ms).collect());
        Some(SweepTime {
            subject: self.subject(group, detector_idx, point_idx),
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

/// The blocks of all members together.
fn blocks_of(group: &Group<'_>) -> BlockCount {
    let blocks = group.members.iter().map(|it| it.resamples.blocks()).reduce(BlockCount::with);
    blocks.expect("a group has members")
}

/// What one detector made of the scans of a data set at one point.
struct Found<'a> {
    member: &'a Member<'a>,
    scans: Vec<DetectorAtPoint>,
}

/// The interval of a ratio whose terms are sums over scans.
fn interval(found: &[Found<'_>], terms: impl Fn(&DetectorAtPoint) -> [f64; 2]) -> Option<[f64; 2]> {
    let of_member = |it: &Found<'_>| it.scans.iter().map(&terms).collect::<Vec<_>>();
    let members: Vec<_> = found.iter().map(|it| (it.member.resamples, of_member(it))).collect();
    ratio_interval(&members)
}

fn cells(found: &[Found<'_>]) -> Option<CellScore> {
    let scans = found.iter().flat_map(|it| &it.scans);
    let tallies: Option<Vec<CellTally>> = scans.map(|it| it.cells).collect();
    let tallies = tallies.filter(|it| !it.is_empty())?;
    let sum = |number: fn(&CellTally) -> u64| tallies.iter().map(number).sum::<u64>();
    let reading = |reading: FitnessReading| {
        let terms = |it: &DetectorAtPoint| it.cells.map_or([0.0; 2], |it| reading.ratio(&it));
        let sums = tallies
            .iter()
            .map(|it| reading.ratio(it))
            .fold([0.0; 2], |sum, it| [sum[0] + it[0], sum[1] + it[1]]);
        let value = (sums[1] != 0.0).then(|| sums[0] / sums[1]);
        let within = value.and_then(|_| interval(found, terms));
        FitnessValue { name: reading.name(), value, within, range: reading.range() }
    };
    // As it was written, and not as a 32-bit number comes out.
    let cell_size_m = format!("{}", tallies[0].cell_size_m).parse().unwrap_or_default();
    Some(CellScore {
        cell_size_m,
        n_dense_sparse_empty: [sum(|it| it.n_dense), sum(|it| it.n_sparse), sum(|it| it.n_empty)],
        readings: FitnessReading::ALL.map(reading).to_vec(),
    })
}
