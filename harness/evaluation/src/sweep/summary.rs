//! From the sums of a sweep to the numbers of each point.

use detector::grid::cell_fitness::FitnessReading;
use rayon::prelude::*;
use reports::numbers::blocks::BlockCount;
use reports::numbers::latencies::Latencies;
use reports::numbers::pools::Pool;
use reports::numbers::sums::{FalseObjects, Sums};
use reports::numbers::sweep_score::{
    CellScore, FitnessValue, SweepScore, SweepScores, SweepSubject, SweepTime,
};
use reports::run_folder::manifest::{AnnotatedClasses, DatasetEntry};
use reports::vocabulary::extent::Extent;
use reports::vocabulary::metric::Metric;
use reports::vocabulary::origin::Origin;
use reports::vocabulary::task::Task;
use scans::dataset;

use crate::metrics::counts::FalseDetections;
use crate::sweep::block_resamples::{BlockResamples, ratio_interval};
use crate::sweep::journal_entry::TimedScan;
use crate::sweep::sweep_tally::{CellSums, DatasetSums, PointSums, SweepTally};

/// Data sets that are looked at together.
struct Group<'a> {
    extent: Extent,
    origin: Origin,
    sensor: String,
    members: Vec<Member<'a>>,
}

/// A data set with what was counted on it.
#[derive(Clone, Copy)]
struct Member<'a> {
    dataset_idx: usize,
    entry: &'a DatasetEntry,
    resamples: &'a BlockResamples,
    sums: &'a DatasetSums,
}

/// A detector at a point.
#[derive(Clone, Copy)]
struct DetectorAtPoint {
    detector_idx: usize,
    point_idx: usize,
}

impl SweepTally<'_> {
    /// The numbers of each data set and, if there are several, of all together. There are no times if they were taken on
    /// unlike processors.
    pub fn summary(&self) -> SweepScores {
        let draw = |(entry, sums): (&DatasetEntry, &DatasetSums)| {
            BlockResamples::draw(&entry.id, sums.of_seconds.keys().cloned())
        };
        let resamples: Vec<BlockResamples> =
            self.manifest.datasets.iter().zip(&self.datasets).map(draw).collect();
        let groups = self.groups(&resamples);
        let mut scores = Vec::new();
        for group in &groups {
            for detector_idx in 0..self.manifest.detectors.len() {
                let at_points: Vec<(usize, DetectorAtPoint)> = (0..Task::ALL.len())
                    .flat_map(|task_idx| {
                        let points = 0..self.entry.points.len();
                        points.map(move |point_idx| (task_idx, DetectorAtPoint { detector_idx, point_idx }))
                    })
                    .collect();
                let score =
                    |&(task_idx, at_point): &(usize, DetectorAtPoint)| self.score(group, task_idx, at_point);
                scores.extend(at_points.par_iter().map(score).collect::<Vec<_>>());
            }
        }
        let times = match self.processors()[..] {
            [only] => self.times_in(&groups, only),
            _ => Vec::new(),
        };
        let configured = self.entry.configured.clone();
        let (parameters, n_swept) = (self.entry.parameters(), self.entry.swept.len());
        SweepScores { parameters, n_swept, configured, scores, times }
    }

    /// The times on each of several unlike processors by themselves; none if there are no such.
    pub fn times_of_processors(&self) -> Vec<(String, Vec<SweepTime>)> {
        let resamples: Vec<BlockResamples> =
            self.manifest.datasets.iter().map(|it| BlockResamples::draw(&it.id, [])).collect();
        let groups = self.groups(&resamples);
        let processors = self.processors();
        let unlike = processors.iter().filter(|_| processors.len() > 1);
        unlike.map(|it| ((*it).to_owned(), self.times_in(&groups, it))).collect()
    }

    fn groups<'b>(&'b self, resamples: &'b [BlockResamples]) -> Vec<Group<'b>> {
        let member = |dataset_idx: usize| Member {
            dataset_idx,
            entry: &self.manifest.datasets[dataset_idx],
            resamples: &resamples[dataset_idx],
            sums: &self.datasets[dataset_idx],
        };
        let alone = |(dataset_idx, entry): (usize, &'b DatasetEntry)| Group {
            extent: Extent::Dataset(entry.id.clone()),
            origin: entry.origin(),
            sensor: entry.sensor.clone(),
            members: vec![member(dataset_idx)],
        };
        let entries = &self.manifest.datasets;
        let mut groups: Vec<Group<'b>> = entries.iter().enumerate().map(alone).collect();
        for pool in self.manifest.pools().into_iter().filter(Pool::is_of_several) {
            let is_in_it = |it: &usize| pool.datasets.contains(&entries[*it].id);
            let members: Vec<Member<'b>> = (0..entries.len()).filter(is_in_it).map(member).collect();
            let mut sensors: Vec<&str> = members.iter().map(|it| it.entry.sensor.as_str()).collect();
            sensors.sort_unstable();
            sensors.dedup();
            let sensor = sensors.join("+");
            groups.push(Group { extent: pool.extent, origin: pool.origin, sensor, members });
        }
        groups
    }

    fn subject(&self, group: &Group<'_>, at_point: DetectorAtPoint) -> SweepSubject {
        SweepSubject {
            extent: group.extent.clone(),
            origin: group.origin,
            sensor: group.sensor.clone(),
            detector: self.manifest.detectors[at_point.detector_idx].name.clone(),
            point_idx: at_point.point_idx,
            values: self.entry.points[at_point.point_idx].clone(),
        }
    }

    fn score(&self, group: &Group<'_>, task_idx: usize, at_point: DetectorAtPoint) -> SweepScore {
        let sums_idx = at_point.detector_idx * self.entry.points.len() + at_point.point_idx;
        let found: Vec<Found<'_>> = group.members.iter().map(|&member| Found::at(member, sums_idx)).collect();
        let of_member = |it: &Found<'_>| {
            it.total.counts[task_idx]
                .scored(false_detections(&it.member.entry.annotated, Task::ALL[task_idx]))
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
            subject: self.subject(group, at_point),
            task: Task::ALL[task_idx],
            n_scans: group.members.iter().map(|it| it.sums.scans.len() as u64).sum(),
            blocks: blocks_of(group),
            f_rate_within: counts.fo().and_then(|_| within(&Metric::FRate)),
            recall_within: within(&Metric::Recall),
            cells: cells(&found),
            counts,
        }
    }

    /// The times of `groups` on `processor`.
    fn times_in(&self, groups: &[Group<'_>], processor: &str) -> Vec<SweepTime> {
        let timed: Vec<&TimedScan> = self.times.iter().filter(|it| it.processor == processor).collect();
        let mut times = Vec::new();
        for group in groups {
            let is_member =
                |it: &&&TimedScan| group.members.iter().any(|member| member.dataset_idx == it.dataset_idx);
            let scans: Vec<&TimedScan> = timed.iter().filter(is_member).copied().collect();
            for detector_idx in 0..self.manifest.detectors.len() {
                let at_points =
                    (0..self.entry.points.len()).map(|point_idx| DetectorAtPoint { detector_idx, point_idx });
                times.extend(at_points.filter_map(|it| self.time(group, &scans, it)));
            }
        }
        times
    }

    fn time(&self, group: &Group<'_>, scans: &[&TimedScan], at_point: DetectorAtPoint) -> Option<SweepTime> {
        let ms = |time_ns: &u64| *time_ns as f64 / 1e6;
        let DetectorAtPoint { detector_idx, point_idx } = at_point;
        let all = scans.iter().flat_map(|it| &it.times_ns[point_idx][detector_idx]).map(ms);
        let all = Latencies::new(all.collect());
        let shortest = scans.iter().filter_map(|it| it.times_ns[point_idx][detector_idx].iter().min());
        let shortest = Latencies::new(shortest.map(ms).collect());
        Some(SweepTime {
            subject: self.subject(group, at_point),
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

/// Whether what is found beside the annotations of `task` is false.
fn false_detections(annotated: &AnnotatedClasses, task: Task) -> FalseDetections {
    let annotated = match annotated {
        AnnotatedClasses::EveryObject => dataset::AnnotatedClasses::EveryObject,
        AnnotatedClasses::Only(classes) => dataset::AnnotatedClasses::Only(classes.clone()),
    };
    FalseDetections::of(&annotated, task)
}

/// The blocks of all members together.
fn blocks_of(group: &Group<'_>) -> BlockCount {
    let blocks = group.members.iter().map(|it| it.resamples.blocks()).reduce(BlockCount::with);
    blocks.expect("a group has members")
}

/// What one detector made of the scans of a data set at one point.
struct Found<'a> {
    member: Member<'a>,
    sums_idx: usize,
    total: PointSums,
}

impl<'a> Found<'a> {
    fn at(member: Member<'a>, sums_idx: usize) -> Self {
        let mut total = PointSums::default();
        member.sums.of_seconds.values().for_each(|it| total.add_sums(&it[sums_idx]));
        Self { member, sums_idx, total }
    }
}

/// The interval of a ratio whose terms are sums over scans.
fn interval(found: &[Found<'_>], terms: impl Fn(&PointSums) -> [f64; 2]) -> Option<[f64; 2]> {
    let mut of_members = Vec::new();
    for Found { member, sums_idx, .. } in found {
        let of_seconds =
            member.sums.of_seconds.iter().map(|(second, sums)| (second, terms(&sums[*sums_idx])));
        of_members.push((member.resamples, member.resamples.of_blocks(of_seconds)));
    }
    ratio_interval(&of_members)
}

fn cells(found: &[Found<'_>]) -> Option<CellScore> {
    let of_members: Vec<CellSums> = found.iter().filter_map(|it| it.total.cells).collect();
    let first = of_members.first()?;
    let number = |idx: usize| of_members.iter().map(|it| it.n_dense_sparse_empty[idx]).sum::<u64>();
    let reading = |(idx, reading): (usize, FitnessReading)| {
        let sums = of_members
            .iter()
            .map(|it| it.readings[idx])
            .fold([0.0; 2], |sum, it| [sum[0] + it[0], sum[1] + it[1]]);
        let value = (sums[1] != 0.0).then(|| sums[0] / sums[1]);
        let terms = |it: &PointSums| it.cells.map_or([0.0; 2], |it| it.readings[idx]);
        let within = value.and_then(|_| interval(found, terms));
        FitnessValue { name: reading.name(), value, within, range: reading.range() }
    };
    // As it was written, and not as a 32-bit number comes out.
    let cell_size_m = format!("{}", first.cell_size_m).parse().unwrap_or_default();
    Some(CellScore {
        cell_size_m,
        n_dense_sparse_empty: [0, 1, 2].map(number),
        readings: FitnessReading::ALL.into_iter().enumerate().map(reading).collect(),
    })
}
