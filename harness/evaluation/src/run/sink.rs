//! Sinks: they watch a run scan by scan.

use reports::rows::pose_row::PoseRow;
use scans::annotation::ScanId;
use scans::dataset::{Dataset, DatasetDescription, DatasetError};

use super::rows::{DetectorRows, RowsOf};
use super::running_detector::RunningDetector;
use super::side_by_side::{RunError, ScanResults, SideBySide};
use crate::matching::criterion::Criterion;

/// A data set that detectors run on.
#[derive(Clone, Copy)]
pub struct WatchedDataset<'a> {
    /// The data set.
    pub dataset: &'a dyn Dataset,
    /// The selected scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: &'a [usize],
    /// How many of them are run: all, or those of a shard.
    pub n_scans: usize,
    /// Number of scans that were selected of the data sets before this one.
    pub n_before: usize,
    /// How detections are judged.
    pub criterion: Criterion,
}

/// A scan with the results of all detectors.
pub struct JudgedScan<'a> {
    /// Its data set.
    pub watched: WatchedDataset<'a>,
    /// Results of the detectors.
    pub results: &'a ScanResults<'a>,
    /// Rows of the results, in the order of the detectors.
    pub rows: Vec<DetectorRows>,
}

/// Watches a run: writes files, sums up, draws, or reports progress. `E` is its error.
pub trait RunSink<E> {
    /// A data set begins.
    ///
    /// # Errors
    ///
    /// If nothing can be written for it.
    fn begin_dataset(&mut self, _watched: &WatchedDataset<'_>) -> Result<(), E> {
        Ok(())
    }

    /// A scan of it has been judged.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), E>;

    /// The data set has ended.
    ///
    /// # Errors
    ///
    /// If the output for it is not complete.
    fn end_dataset(&mut self) -> Result<(), E> {
        Ok(())
    }

    /// The run has ended.
    ///
    /// # Errors
    ///
    /// If the output is not complete.
    fn finish(self: Box<Self>) -> Result<(), E> {
        Ok(())
    }

    /// The run was interrupted. By default this is as [`Self::finish`]; a sink whose files would look like those of the
    /// whole run does otherwise.
    ///
    /// # Errors
    ///
    /// If the output is not complete.
    fn break_off(self: Box<Self>) -> Result<(), E> {
        self.finish()
    }
}

/// The sinks of a run.
pub type Sinks<'a, E> = Vec<Box<dyn RunSink<E> + 'a>>;

/// Numbers of judged scans and annotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Judged {
    /// Number of scans.
    pub n_scans: u64,
    /// Annotations that count, in the task with the most of them.
    pub n_annotations: u64,
}

impl<'a> JudgedScan<'a> {
    /// Makes the rows of `results`.
    pub fn new(watched: WatchedDataset<'a>, results: &'a ScanResults<'a>) -> Self {
        let description = watched.dataset.description();
        let scan = RowsOf { scan: results.scan, checksum: results.checksum, time_s: results.time.known_s };
        let rows = results.results.iter().map(|it| DetectorRows::new(description, scan, it));
        Self { watched, results, rows: rows.collect() }
    }

    /// Index of the scan in its data set.
    pub fn scan_idx(&self) -> usize {
        self.watched.scan_indices[self.results.run_idx]
    }

    /// Its number among all selected scans of the run, from 0, whichever part of them is run.
    pub fn number(&self) -> usize {
        self.watched.n_before + self.results.run_idx
    }

    /// Where the sensor was, if the data set says so.
    ///
    /// # Errors
    ///
    /// If the file that says so is damaged.
    pub fn pose_row(&self) -> Result<Option<PoseRow>, DatasetError> {
        let pose = self.watched.dataset.world_from_sensor(self.scan_idx())?;
        Ok(pose.map(|it| {
            let ([x_m, y_m, z_m], turn) = (it.translation.vector.into(), it.rotation.coords);
            PoseRow {
                dataset: self.dataset().id.clone(),
                sequence: self.results.scan.id.sequence.clone(),
                scan: self.results.scan.id.index,
                x_m,
                y_m,
                z_m,
                qx: turn.x,
                qy: turn.y,
                qz: turn.z,
                qw: turn.w,
            }
        }))
    }

    /// Description of its data set.
    pub fn dataset(&self) -> &'a DatasetDescription {
        self.watched.dataset.description()
    }

    /// Annotations that count, in the task with the most of them.
    fn n_annotations(&self) -> u64 {
        let tasks = self.rows.iter().flat_map(|it| &it.tasks);
        tasks.filter_map(|it| Some(it.scan.numbers()?.counts.no())).max().unwrap_or(0)
    }
}

/// Runs `detectors` on one data set, and reports to all `sinks`: the beginning, every scan in order, and the end.
///
/// # Errors
///
/// As [`SideBySide::run_past_damage`], and errors of the sinks.
pub fn run_watched<E: From<RunError>>(
    side_by_side: &SideBySide<'_>,
    detectors: &mut [Box<dyn RunningDetector>],
    on_damage: impl FnMut(&ScanId, DatasetError) -> Result<(), DatasetError>,
    sinks: &mut Sinks<'_, E>,
) -> Result<Judged, E> {
    let watched = WatchedDataset {
        dataset: side_by_side.dataset,
        scan_indices: side_by_side.scan_indices,
        n_scans: side_by_side.part.len(),
        n_before: side_by_side.n_before,
        criterion: side_by_side.matching.criterion,
    };
    sinks.iter_mut().try_for_each(|it| it.begin_dataset(&watched))?;
    let mut judged_so_far = Judged::default();
    side_by_side.run_past_damage(detectors, on_damage, |results| -> Result<(), E> {
        let judged = JudgedScan::new(watched, &results);
        judged_so_far.n_scans += 1;
        judged_so_far.n_annotations += judged.n_annotations();
        sinks.iter_mut().try_for_each(|it| it.add_scan(&judged))
    })?;
    sinks.iter_mut().try_for_each(|it| it.end_dataset())?;
    Ok(judged_so_far)
}

/// A sink that is `None` does nothing.
impl<E, S: RunSink<E>> RunSink<E> for Option<S> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), E> {
        self.as_mut().map_or(Ok(()), |it| it.begin_dataset(watched))
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), E> {
        self.as_mut().map_or(Ok(()), |it| it.add_scan(judged))
    }

    fn end_dataset(&mut self) -> Result<(), E> {
        self.as_mut().map_or(Ok(()), S::end_dataset)
    }

    fn finish(self: Box<Self>) -> Result<(), E> {
        self.map_or(Ok(()), |it| Box::new(it).finish())
    }

    fn break_off(self: Box<Self>) -> Result<(), E> {
        self.map_or(Ok(()), |it| Box::new(it).break_off())
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::matching::assign::MatchingParams;
    use crate::matching::eligibility::EligibilityParams;
    use crate::run::compared_detector::ComparedDetector;
    use crate::run::config::RunConfig;
    use crate::run::detector_list::detectors_named;
    use crate::run::side_by_side::OnDetectorFailure;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    /// A sink that writes down all its calls.
    struct Diary<'a>(&'a mut Vec<String>);

    impl RunSink<RunError> for Diary<'_> {
        fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), RunError> {
            let id = &watched.dataset.description().id;
            self.0.push(format!("{id} begins with {} scans", watched.scan_indices.len()));
            Ok(())
        }

        fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), RunError> {
            let detectors: Vec<&str> =
                judged.rows.iter().map(|it| it.tasks[0].scan.detector.as_str()).collect();
            self.0.push(format!("{} {}", judged.results.scan.id, detectors.join("+")));
            Ok(())
        }

        fn end_dataset(&mut self) -> Result<(), RunError> {
            self.0.push("ends".to_owned());
            Ok(())
        }

        fn finish(self: Box<Self>) -> Result<(), RunError> {
            self.0.push("finished".to_owned());
            Ok(())
        }
    }

    #[test]
    fn every_sink_sees_every_scan_once_and_in_order() {
        let options = OpenOptions {
            n_simulated_scans: Some(4),
            sensor: Some("vlp-16".to_owned()),
            ..OpenOptions::default()
        };
        let street = open_dataset("street-narrow", &options, &built_in_catalogue().unwrap()).unwrap();
        let config = RunConfig::load(None).unwrap();
        let names = ["simple-grid".to_owned(), "hierarchical".to_owned()];
        let chosen = detectors_named(&names, &config).unwrap();
        let compared_detectors = chosen.into_iter().map(|it| ComparedDetector::of(it, &config));
        let mut detectors: Vec<_> = compared_detectors.map(|it| it.begin(street.description())).collect();
        let side_by_side = SideBySide {
            dataset: &*street,
            scan_indices: &[3, 0, 2],
            part: 0..3,
            n_before: 0,
            class_criteria: &config.class_criteria,
            matching: MatchingParams {
                criterion: Criterion::POINTS,
                eligibility: EligibilityParams::STANDARD,
            },
            n_warmup: 1,
            n_repeats: NonZeroUsize::MIN,
            counter: None,
            // Scans that are read at once are still reported in order.
            n_jobs: 2,
            on_failure: OnDetectorFailure::Stop,
            interrupted: &AtomicBool::new(false),
        };
        let (mut first, mut second) = (Vec::new(), Vec::new());
        let mut sinks: Sinks<'_, RunError> = vec![
            Box::new(Diary(&mut first)),
            Box::new(None::<Diary<'_>>),
            Box::new(Some(Diary(&mut second))),
        ];
        let judged = run_watched(&side_by_side, &mut detectors, |_, error| Err(error), &mut sinks).unwrap();
        sinks.into_iter().try_for_each(RunSink::finish).unwrap();

        let of_scan = |scan_idx: usize| format!("{} simple-grid+hierarchical", street.scan_ids()[scan_idx]);
        let expected = ["street-narrow begins with 3 scans".to_owned(), of_scan(3), of_scan(0), of_scan(2)];
        let expected = expected.into_iter().chain(["ends", "finished"].map(str::to_owned));
        assert_eq!(first, expected.collect::<Vec<_>>());
        assert_eq!(second, first);
        assert_eq!(judged.n_scans, 3);
        assert!(judged.n_annotations > 0);
    }
}
