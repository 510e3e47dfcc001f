//! What a detector that looks back is told of a drive, and what has to be asked before so that it remembers the rest.

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
        let ScansBefore { scan_indices, times } = before;
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
                return Err(lacks(&format!("{n} earlier scans, and this scan stands for itself")));
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
