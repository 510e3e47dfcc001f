//! Sums of a run, gathered from the rows of scans and matches: by subject, by slice, and by block of scans.

use std::collections::{BTreeMap, BTreeSet};

use crate::numbers::blocks::{Blocks, DriveSecond, FEWEST_DRIVES};
use crate::numbers::gathered::{Gathered, add_box_errors, slices_of_annotation, slices_of_detection};
use crate::numbers::pools::{Pool, pools};
use crate::numbers::sums::{FalseObjects, Sums};
use crate::numbers::times::{TimeKind, Times};
use crate::rows::counts::Counts;
use crate::rows::match_outcome::MatchOutcome;
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::{ScanOutcome, ScanRow};
use crate::rows::stage_row::StageRow;
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::formula::Term;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::own_slice::{Extents, OwnSlice, SliceBounds};
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Numbers of a run, gathered row by row.
///
/// ```
/// use reports::numbers::tally::Tally;
/// use reports::rows::counts::Counts;
/// use reports::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
/// use reports::vocabulary::metric::Metric;
/// use reports::vocabulary::task::Task;
///
/// // One scan with ten vehicles, of which seven were found; three detections are false.
/// let counts = Counts::new(10, 7, Some(3)).expect("no more is found than there is");
/// let mut tally = Tally::default();
/// tally.add_scan(&ScanRow {
///     dataset: "street".to_owned(),
///     sequence: "0000".to_owned(),
///     scan: 0,
///     time_s: Some(0.0),
///     detector: "mine".to_owned(),
///     task: Task::Vehicles,
///     outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(counts)),
/// });
/// let rows = tally.metric_rows();
/// let f_rate = rows.iter().find(|it| it.metric == Metric::FRate).and_then(|it| it.value());
/// assert_eq!(f_rate, Some(14.0 / 20.0));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Tally {
    // All three in the order in which they were first seen.
    datasets: Vec<String>,
    tasks: Vec<Task>,
    detectors: Vec<String>,
    // Of each of `datasets`, the scans of each sequence with the seconds that they are drawn with.
    scans: Vec<BTreeMap<String, BTreeMap<u32, DriveSecond>>>,
    // Of each of `datasets`, the drives that are drawn from.
    drives: Vec<BTreeSet<String>>,
    // Named blocks by id of the data set and name of the scan, as far as the user or the data set names them.
    blocks: BTreeMap<String, BTreeMap<String, String>>,
    // Of each of `datasets`.
    times: Vec<Times>,
    of_key: BTreeMap<Key, Gathered>,
    processors: Processors,
    // Ids of the data sets that are simulated, whether there are rows of them or not.
    simulated: BTreeSet<String>,
    own_slices: Vec<(OwnSlice, SliceBounds)>,
}

/// Whether times of a run may be put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Processors {
    /// All times are of processors of one kind.
    #[default]
    Alike,
    /// They are not: only ratios of times that were taken side by side are meaningful.
    Unlike,
}

/// Indices of data set, task and detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    dataset: usize,
    task: Task,
    detector: usize,
}

impl Tally {
    /// An empty tally for rows that were made on such processors; `simulated` are the ids of the simulated data sets.
    pub fn of_run(processors: Processors, simulated: BTreeSet<String>) -> Self {
        Self { processors, simulated, ..Self::default() }
    }

    /// A tally for rows of the same scans, evaluated in another way.
    pub fn without_rows(&self) -> Self {
        let (blocks, own_slices) = (self.blocks.clone(), self.own_slices.clone());
        let simulated = self.simulated.clone();
        Self { blocks, processors: self.processors, simulated, own_slices, ..Self::default() }
    }

    /// This tally with named blocks: `blocks` holds the block of a scan by id of the data set and name of the scan.
    pub fn with_blocks(self, blocks: BTreeMap<String, BTreeMap<String, String>>) -> Self {
        Self { blocks, ..self }
    }

    /// This tally with slices of the user.
    pub fn with_slices(self, own_slices: Vec<(OwnSlice, SliceBounds)>) -> Self {
        Self { own_slices, ..self }
    }

    /// This tally with these as its first detectors, in this order.
    pub fn with_detectors(self, detectors: Vec<String>) -> Self {
        Self { detectors, ..self }
    }

    /// Adds the row of one detector on one scan in one task.
    pub fn add_scan(&mut self, row: &ScanRow) {
        let key = self.key(&row.dataset, row.task, &row.detector);
        let block = self.block_of(row);
        self.add_block(key.dataset, &row.sequence, row.scan, &block);
        let ScanOutcome::Evaluated(numbers) = &row.outcome else { return };
        let mut sums = Sums::of_scan(numbers);
        let times_ms = numbers.least_latency_ms.zip(numbers.reference_ms);
        if let Some((least_ms, reference_ms)) = times_ms.filter(|it| it.0 > 0.0 && it.1 > 0.0) {
            sums.add(Term::TimedScans, 1.0);
            sums.add(Term::LogTimeRatio, (least_ms / reference_ms).ln());
            let log_reference = match self.processors {
                Processors::Alike => reference_ms.ln(),
                // A mean over unlike processors belongs to none of them.
                Processors::Unlike => f64::NAN,
            };
            sums.add(Term::LogReference, log_reference);
        }
        // They are the same in every task.
        let counted = numbers.n_instructions.zip(numbers.peak_bytes).filter(|_| row.task == Task::ALL[0]);
        if let Some((n_instructions, peak_bytes)) = counted {
            sums.add(Term::CountedScans, 1.0);
            sums.add(Term::Instructions, n_instructions as f64 / 1e6);
            sums.add(Term::PeakMemory, peak_bytes as f64 / f64::from(1 << 20));
        }
        self.count(key, numbers.counts, &block).add_times(&sums, 1.0);
        let times = &mut self.times[key.dataset];
        let of_kinds = [
            (TimeKind::Latency, numbers.latency_ms),
            (TimeKind::Cpu, numbers.cpu_ms),
            (TimeKind::Overhead, numbers.overhead_ms),
        ];
        for (kind, time_ms) in of_kinds {
            if let Some(time_ms) = time_ms.filter(|_| self.processors == Processors::Alike) {
                times.add_scan(kind, key.task, key.detector, time_ms);
            }
        }
        times.add_failures(key.task, key.detector, numbers.failure.is_some());
    }

    /// Adds the time of a stage of a detector on a scan, unless processors are unlike.
    pub fn add_stage(&mut self, row: &StageRow) {
        if self.processors == Processors::Unlike {
            return;
        }
        let dataset = self.dataset_idx(&row.dataset);
        let detector = index_of(&mut self.detectors, &row.detector);
        self.times[dataset].add_stage(detector, &row.stage, row.time_ms);
    }

    /// Adds the outcome of an annotation, a detection or a pair of them. Its scan must have been added before; a row of
    /// another scan is left out.
    pub fn add_match(&mut self, row: &MatchRow) {
        self.add_match_in(row, None);
    }

    /// [`Self::add_match`] of an annotation that is in this slice, too.
    pub fn add_match_in(&mut self, row: &MatchRow, also_in: Option<Slice>) {
        let key = self.key(&row.dataset, row.task, &row.detector);
        let of_sequence = self.scans[key.dataset].get(&row.sequence);
        let Some(block) = of_sequence.and_then(|scans| scans.get(&row.scan)) else { return };
        let has_enough_drives = self.has_enough_drives(key.dataset);
        let gathered =
            self.of_key.entry(key).or_insert_with(|| Gathered::of_task(row.task, has_enough_drives));
        let with_own = |mut slices: Vec<Slice>, extents: &Extents| {
            slices.extend(also_in);
            let own = self.own_slices.iter().filter(|(_, bounds)| bounds.holds(extents));
            slices.extend(own.map(|(slice, _)| Slice::Own(*slice)));
            slices
        };
        match &row.outcome {
            MatchOutcome::Matched { annotation, detection, .. } => {
                let slices = with_own(slices_of_annotation(annotation), &annotation.extents());
                gathered.add_to_slices(&slices, block, Term::Annotations);
                gathered.add_to_slices(&slices, block, Term::Matched);
                gathered.rank(detection, true, &slices);
                if let Some(labelled) = &annotation.bounding_box {
                    add_box_errors(gathered.sums(Slice::All, block), labelled, &detection.bounding_box);
                }
            }
            MatchOutcome::Missed { annotation, .. } => {
                let slices = with_own(slices_of_annotation(annotation), &annotation.extents());
                gathered.add_to_slices(&slices, block, Term::Annotations);
            }
            MatchOutcome::False { detection, .. } => {
                let slices = with_own(slices_of_detection(detection), &detection.extents());
                gathered.add_to_slices(&slices, block, Term::False);
                gathered.rank(detection, false, &slices);
            }
            MatchOutcome::Tall { found_by, .. } => {
                gathered.add_to_slices(&[Slice::Tall], block, Term::Annotations);
                if found_by.is_some() {
                    gathered.add_to_slices(&[Slice::Tall], block, Term::Matched);
                }
            }
            MatchOutcome::IgnoredAnnotation { .. }
            | MatchOutcome::IgnoredDetection { .. }
            | MatchOutcome::Unknowable { .. } => {}
        }
    }

    /// The second, named block or single scan that the scan of a row is drawn with.
    pub fn block_of(&self, row: &ScanRow) -> DriveSecond {
        let named = self.blocks.get(&row.dataset);
        let named = named.and_then(|it| it.get(&format!("{}/{:06}", row.sequence, row.scan)));
        DriveSecond::of_scan(&row.sequence, row.scan, named.map(String::as_str), row.time_s)
    }

    /// Counts a scan, and returns the sums of its block.
    fn count(&mut self, key: Key, counts: Counts, block: &DriveSecond) -> &mut Sums {
        let has_enough_drives = self.has_enough_drives(key.dataset);
        let gathered =
            self.of_key.entry(key).or_insert_with(|| Gathered::of_task(key.task, has_enough_drives));
        gathered.n_scans += 1;
        gathered.add_counts(counts);
        if counts.fo().is_none() {
            gathered.false_objects = FalseObjects::Unknown;
        }
        gathered.sums(Slice::All, block)
    }

    /// Notes the block of a scan.
    fn add_block(&mut self, dataset_idx: usize, sequence: &str, scan: u32, block: &DriveSecond) {
        self.scans[dataset_idx].entry(sequence.to_owned()).or_default().insert(scan, block.clone());
        let drives = &mut self.drives[dataset_idx];
        if drives.insert(block.drive().to_owned()) && drives.len() == FEWEST_DRIVES {
            let of_dataset = self.of_key.iter_mut().filter(|(key, _)| key.dataset == dataset_idx);
            of_dataset.for_each(|(_, gathered)| gathered.forget_seconds());
        }
    }

    /// Whether whole drives of a data set will be drawn.
    fn has_enough_drives(&self, dataset_idx: usize) -> bool {
        self.drives[dataset_idx].len() >= FEWEST_DRIVES
    }

    /// Whether a row of this scan was added.
    pub fn has_scan(&self, dataset: &str, sequence: &str, scan: u32) -> bool {
        let dataset_idx = self.datasets.iter().position(|it| it == dataset);
        let drive = dataset_idx.and_then(|it| self.scans[it].get(sequence));
        drive.is_some_and(|it| it.contains_key(&scan))
    }

    fn key(&mut self, dataset: &str, task: Task, detector: &str) -> Key {
        if !self.tasks.contains(&task) {
            self.tasks.push(task);
            self.tasks.sort_unstable();
        }
        let detector = index_of(&mut self.detectors, detector);
        Key { dataset: self.dataset_idx(dataset), task, detector }
    }

    fn dataset_idx(&mut self, dataset: &str) -> usize {
        let dataset = index_of(&mut self.datasets, dataset);
        self.scans.resize(self.datasets.len(), BTreeMap::new());
        self.drives.resize(self.datasets.len(), BTreeSet::new());
        self.times.resize(self.datasets.len(), Times::default());
        dataset
    }

    /// Ids of the data sets, in the order of their first rows.
    pub fn datasets(&self) -> &[String] {
        &self.datasets
    }

    /// The data sets whose numbers are put together.
    pub fn pools(&self) -> Vec<Pool> {
        let origin = |id: &str| {
            if self.simulated.contains(id) { Origin::Simulated } else { Origin::Recorded }
        };
        pools(self.datasets.iter().map(|id| (id.as_str(), origin(id))))
    }

    /// Indices of the data sets that a number about `extent` is made of: the id of a data set, or the name of several
    /// together.
    pub(crate) fn datasets_in(&self, extent: &str) -> Vec<usize> {
        let pools = self.pools();
        let is_in_pool = |id: &String| {
            // A single pool is all data sets, too.
            let is_all = extent == OVERALL && pools.len() == 1;
            is_all || pools.iter().any(|it| it.extent.name() == extent && it.datasets.contains(id))
        };
        let indices = self.datasets.iter().enumerate();
        indices.filter(|(_, id)| *id == extent || is_in_pool(id)).map(|(index, _)| index).collect()
    }

    /// The tasks, in the order in which they were seen.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Names of the detectors, in the order in which they were seen.
    pub fn detectors(&self) -> &[String] {
        &self.detectors
    }

    /// Counts so far of one detector in one task on the data sets that `extent` names: the id of one, or the name of
    /// several together. `None` if none of these scans was evaluated.
    pub fn counts(&self, extent: &str, task: Task, detector: &str) -> Option<Counts> {
        let datasets = self.datasets_in(extent).into_iter();
        let of_datasets = datasets.filter_map(|it| self.gathered(it, task, detector)?.counts);
        of_datasets.reduce(|mut sum, it| {
            sum += it;
            sum
        })
    }

    /// The times on each of the data sets.
    pub(crate) fn times(&self) -> &[Times] {
        &self.times
    }

    /// The blocks of each data set, in the order of the data sets.
    pub fn blocks(&self) -> Vec<Blocks> {
        let blocks = |scans: &BTreeMap<String, BTreeMap<u32, DriveSecond>>| {
            let seconds: BTreeSet<&DriveSecond> = scans.values().flat_map(BTreeMap::values).collect();
            Blocks::of(seconds.into_iter().cloned())
        };
        self.scans.iter().map(blocks).collect()
    }

    /// The scans of the data set with this index, by sequence and number: sequence, number, and the second that it is drawn
    /// with.
    pub(crate) fn scans(&self, dataset_idx: usize) -> impl Iterator<Item = (&str, u32, DriveSecond)> {
        let sequences = self.scans[dataset_idx].iter();
        sequences.flat_map(|(sequence, scans)| {
            scans.iter().map(move |(scan, second)| (sequence.as_str(), *scan, second.clone()))
        })
    }

    /// All slices in which `detector` has an object in `task`.
    pub fn slices(&self, task: Task, detector: &str) -> BTreeSet<Slice> {
        let is_asked = |key: &Key| key.task == task && self.detectors[key.detector] == detector;
        let gathered = self.of_key.iter().filter(|(key, _)| is_asked(key));
        gathered.flat_map(|(_, gathered)| gathered.slices.keys().copied()).collect()
    }

    pub(crate) fn gathered(&self, dataset_idx: usize, task: Task, detector: &str) -> Option<&Gathered> {
        let detector = self.detectors.iter().position(|it| it == detector)?;
        self.of_key.get(&Key { dataset: dataset_idx, task, detector })
    }
}

fn index_of(names: &mut Vec<String>, name: &str) -> usize {
    names.iter().position(|it| it == name).unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}
