//! What a detector that looks back is told of a drive, and what has to be asked before so that it remembers the rest.

use std::sync::atomic::Ordering;

use scans::dataset::DatasetError;
use scans::dataset::earlier_scans::EarlierScans;

use super::scan_in_drive::{Place, ScanInDrive, ScansBefore};
use crate::process::conversation::{Asked, InDrive};
use crate::process::message::Wishes;
use crate::process::problem::DetectorProblem;

/// What has been asked of a program since it was configured.
#[derive(Debug, Default)]
pub struct DriveMemory {
    earlier: EarlierScans,
    // The latest scan that it knows of, as an index in its data set.
    latest: Option<usize>,
    // Whether it failed, so that what it knew of the drive is gone.
    is_lost: bool,
}

impl DriveMemory {
    /// Notes that the program failed: it begins anew at the next scan.
    pub fn lose(&mut self) {
        (self.latest, self.is_lost) = (None, true);
    }

    /// Makes sure that a program that wants scans in order knows those before `asked`: asks it for them with `ask`, without
    /// looking at the answers, unless it has just been asked for the last of them. Returns whether it has to begin anew.
    ///
    /// # Errors
    ///
    /// The problem, if the order is not known, or the program gives no answer. Scans that cannot be read are left out, as
    /// they are where a run goes on past damage.
    pub fn catch_up(
        &mut self,
        asked: &ScanInDrive<'_>,
        wishes: Wishes,
        mut ask: impl FnMut(&Asked<'_>) -> Result<(), DetectorProblem>,
    ) -> Result<bool, DetectorProblem> {
        if !wishes.in_order {
            return Ok(false);
        }
        let Some(Place { dataset, scan_idx, before: Some(before) }) = asked.place else {
            return Err(lacks("the scans of a drive in order, which `scanbench run` alone gives"));
        };
        let ScansBefore { scan_indices, times, interrupted } = before;
        let is_lost = std::mem::take(&mut self.is_lost);
        let latest = self.latest.replace(scan_idx);
        if scan_indices.is_empty() || is_lost {
            return Ok(true);
        }
        if latest == scan_indices.last().copied() {
            return Ok(false);
        }
        let mut begins_drive = true;
        for &before_idx in scan_indices {
            if interrupted.load(Ordering::Relaxed) {
                return Err(DetectorProblem::Interrupted);
            }
            let Ok(scan) = dataset.read_scan(before_idx) else { continue };
            let place = Place { dataset, scan_idx: before_idx, before: None };
            let of_drive = ScanInDrive { scan: &scan, time_s: times[before_idx].time_s, place: Some(place) };
            match ask(&self.asked(&of_drive, wishes, begins_drive)?) {
                // As when it was asked for this scan itself: it goes on with the next one.
                Ok(()) | Err(DetectorProblem::Reported(_)) => begins_drive = false,
                Err(problem) => return Err(problem),
            }
        }
        Ok(begins_drive)
    }

    /// What a program of version 2 is asked for `scan`.
    ///
    /// # Errors
    ///
    /// If the data lack something that it asks for, or cannot be read.
    pub fn asked<'a>(
        &mut self,
        &ScanInDrive { scan, time_s, place }: &ScanInDrive<'a>,
        wishes: Wishes,
        begins_drive: bool,
    ) -> Result<Asked<'a>, DetectorProblem> {
        let n = wishes.earlier_scans;
        let Some(Place { dataset, scan_idx, .. }) = place else {
            let in_drive = InDrive { begins_drive, ..InDrive::default() };
            if n > 0 {
                return Err(lacks(&format!("{n} earlier scans, which only `run` and `sweep` give")));
            }
            return Ok(Asked { scan, time_s, in_drive: Some(in_drive) });
        };
        let unreadable = |error: DatasetError| {
            let causes = reports::files::causes::with_causes(&error);
            DetectorProblem::Machine(format!("what it asks for cannot be read: {causes}"))
        };
        let world_from_sensor = dataset.world_from_sensor(scan_idx).map_err(unreadable)?;
        let earlier = self.earlier.before(dataset, (scan_idx, scan), n).map_err(unreadable)?;
        if n > 0 && earlier.is_none() {
            let id = &dataset.description().id;
            let what = "earlier scans in the frame of each, and";
            return Err(lacks(&format!("{n} {what} {id} does not say where the sensor was")));
        }
        let earlier = earlier.unwrap_or_default();
        Ok(Asked { scan, time_s, in_drive: Some(InDrive { begins_drive, world_from_sensor, earlier }) })
    }
}

fn lacks(what: &str) -> DetectorProblem {
    DetectorProblem::Machine(format!("it asks for {what}"))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use detector::PointCloud;
    use scans::annotation::{LabeledScan, ScanId};
    use scans::dataset::scan_times::scan_times;
    use scans::dataset::{AnnotatedClasses, Dataset, DatasetDescription, Listing};

    use super::*;

    /// A drive of six empty scans, of which the third is damaged.
    struct Drive(Listing);

    impl Dataset for Drive {
        fn listing(&self) -> &Listing {
            &self.0
        }

        fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
            if scan_idx == 2 {
                return Err(DatasetError::damaged("000002.bin", "is damaged"));
            }
            let id = self.0.scan_ids[scan_idx].clone();
            Ok(LabeledScan::everywhere(id, PointCloud::default(), Vec::new()))
        }
    }

    fn drive() -> Drive {
        let description = DatasetDescription {
            id: "drive".to_owned(),
            format: "made".to_owned(),
            root: None,
            annotated: AnnotatedClasses::EveryObject,
            sensor_height_m: 1.7,
            sensor: "hdl-64e-s2".to_owned(),
            licence: None,
            checksum: None,
            simulation: None,
        };
        let id = |index| ScanId { sequence: "0".to_owned(), index };
        Drive(Listing { description, scan_ids: (0..6).map(id).collect() })
    }

    const IN_ORDER: Wishes = Wishes { earlier_scans: 0, in_order: true };

    /// Catches up with scan `scan_idx` after the scans `before`. Returns the scans that were asked for before, each with whether
    /// it began the drive, and whether this one does.
    fn catch_up(
        memory: &mut DriveMemory,
        (scan_idx, before): (usize, &[usize]),
        interrupted: bool,
        answer: impl Fn(u32) -> Result<(), DetectorProblem>,
    ) -> Result<(Vec<(u32, bool)>, bool), DetectorProblem> {
        let drive = drive();
        let (times, interrupted) = (scan_times(&drive), AtomicBool::new(interrupted));
        let before = Some(ScansBefore { scan_indices: before, times: &times, interrupted: &interrupted });
        let scan = drive.read_scan(scan_idx).unwrap();
        let place = Some(Place { dataset: &drive, scan_idx, before });
        let asked = ScanInDrive { scan: &scan, time_s: times[scan_idx].time_s, place };
        let mut asked_before = Vec::new();
        let begins_drive = memory.catch_up(&asked, IN_ORDER, |it| {
            let index = it.scan.id.index;
            asked_before.push((index, it.in_drive.as_ref().is_some_and(|it| it.begins_drive)));
            answer(index)
        })?;
        Ok((asked_before, begins_drive))
    }

    #[test]
    fn what_comes_before_is_asked_for_once() {
        let memory = &mut DriveMemory::default();
        let fine = |_| Ok(());
        // In the middle of a drive, past damage; the next one follows.
        let caught_up = catch_up(memory, (4, &[0, 1, 2, 3]), false, fine).unwrap();
        assert_eq!(caught_up, (vec![(0, true), (1, false), (3, false)], false));
        assert_eq!(catch_up(memory, (5, &[0, 1, 2, 3, 4]), false, fine).unwrap(), (vec![], false));
        // The same one again needs all before it; the first of a drive nothing.
        let caught_up = catch_up(memory, (5, &[3, 4]), false, fine).unwrap();
        assert_eq!(caught_up, (vec![(3, true), (4, false)], false));
        assert_eq!(catch_up(memory, (0, &[]), false, fine).unwrap(), (vec![], true));
        // After a failure it begins anew, and goes on from there.
        memory.lose();
        assert_eq!(catch_up(memory, (1, &[0]), false, fine).unwrap(), (vec![], true));
        assert_eq!(catch_up(memory, (3, &[0, 1]), false, fine).unwrap(), (vec![], false));
    }

    #[test]
    fn errors_before_are_passed_over_and_all_else_ends_it() {
        let reported = || Err(DetectorProblem::Reported("no idea".to_owned()));
        let memory = &mut DriveMemory::default();
        let caught_up = catch_up(memory, (3, &[0, 1]), false, |it| if it == 0 { reported() } else { Ok(()) });
        assert_eq!(caught_up.unwrap(), (vec![(0, true), (1, false)], false));
        let memory = &mut DriveMemory::default();
        assert_eq!(
            catch_up(memory, (1, &[0]), false, |_| Err(DetectorProblem::Deaf)),
            Err(DetectorProblem::Deaf)
        );
        let interrupted = catch_up(memory, (3, &[0]), true, |_| Ok(()));
        assert_eq!(interrupted, Err(DetectorProblem::Interrupted));
    }
}
