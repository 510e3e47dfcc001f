//! Where labelled objects are at any time: between two scans they are interpolated along their tracks.

use std::collections::BTreeMap;

use detector::PointCloud;
use nalgebra::Isometry3;
use reports::rows::match_outcome::AnnotationFacts;
use reports::vocabulary::reason::IgnoredAnnotation;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::conversion::results::detection_rows::oriented_box;

use super::logged_drive::{Label, LoggedDrive, LoggedScan};
use super::moving::{TimeUs, between, beyond, box_at, pose_of};
use crate::matching::outcome::AnnotationOutcome;

/// A speed is that of the way within this much before and after.
const SPEED_WINDOW_US: TimeUs = 500_000;

/// The truth of one task along a drive.
pub struct TaskTruth<'a> {
    drive: &'a LoggedDrive,
    labels: &'a [Vec<Label>],
    // Of each scan, the index of the label of each track that has a box.
    by_track: Vec<BTreeMap<u32, usize>>,
    // Of each scan, the speed of each of its labels over ground, in metres per second.
    speeds: Vec<Vec<Option<f64>>>,
}

/// What is true at a moment.
pub struct TrueMoment {
    /// Pose of the sensor.
    pub world_from_sensor: Isometry3<f64>,
    /// The labelled objects, in the frame of the sensor, without points.
    pub scan: LabeledScan,
    /// Facts about each.
    pub facts: Vec<AnnotationFacts>,
    /// Why it does not count; `None` if it counts.
    pub exclusions: Vec<Option<AnnotationOutcome>>,
    /// Its speed over ground, in metres per second, where that is known.
    pub speeds_m_per_s: Vec<Option<f64>>,
    // Tracks that are labelled.
    tracks: Vec<u32>,
}

impl<'a> TaskTruth<'a> {
    /// Of `labels`, those of each scan of `drive`.
    pub fn of(drive: &'a LoggedDrive, labels: &'a [Vec<Label>]) -> Self {
        let of_scan = |labels: &Vec<Label>| {
            let boxed = labels.iter().enumerate().filter(|(_, it)| it.facts.bounding_box.is_some());
            // Of two labels of a track the first counts.
            let tracked = boxed.filter_map(|(idx, it)| Some((it.facts.track?, idx)));
            tracked.rev().collect()
        };
        let truth =
            Self { drive, labels, by_track: labels.iter().map(of_scan).collect(), speeds: Vec::new() };
        let speeds = labels.iter().enumerate().map(|(scan_idx, labels)| {
            labels.iter().map(|it| truth.speed_m_per_s(scan_idx, it.facts.track?)).collect()
        });
        Self { speeds: speeds.collect(), ..truth }
    }

    /// What is true at `at_us`, which is not before the first scan nor after the last.
    ///
    /// At the time of a scan it is what is labelled there. Between two scans, an object that is labelled in both goes straight
    /// from one place to the other; all else about it is as in the nearer scan. One that is labelled in a single one of both
    /// goes on as before and does not count. One without box or track cannot be followed, and does not count.
    pub fn at(&self, at_us: TimeUs) -> TrueMoment {
        let scans = &self.drive.scans;
        let before = scans.partition_point(|it| it.time_us <= at_us).saturating_sub(1);
        let after = (before + 1).min(scans.len() - 1);
        let [from_us, to_us] = [before, after].map(|it| scans[it].time_us);
        let share = if to_us > from_us { (at_us - from_us) as f64 / (to_us - from_us) as f64 } else { 0.0 };
        let world_from_sensor =
            between(&scans[before].world_from_sensor, &scans[after].world_from_sensor, share);
        let mut moment = TrueMoment::empty(world_from_sensor);
        if share == 0.0 {
            for (label, speed) in self.labels[before].iter().zip(&self.speeds[before]) {
                let unboxed = label.facts.bounding_box.is_none().then_some(IgnoredAnnotation::NoBox);
                moment.push(label.facts.clone(), label.ignored.or(unboxed), *speed);
            }
            return moment;
        }
        let nearer = if share < 0.5 { before } else { after };
        let mut tracks: Vec<u32> =
            [before, after].iter().flat_map(|it| self.by_track[*it].keys().copied()).collect();
        tracks.sort_unstable();
        tracks.dedup();
        for track in tracks {
            let places = [before, after].map(|it| self.placed(it, track));
            let (label_scan, pose, is_followed) = match places {
                [Some(from), Some(to)] => (nearer, between(&from, &to, share), true),
                [Some(from), None] => {
                    let earlier = before.checked_sub(1).and_then(|it| self.placed(it, track));
                    (before, earlier.map_or(from, |it| beyond(&it, &from, 1.0 + share)), false)
                }
                [None, Some(to)] => {
                    let later = self.placed(after + 1, track);
                    (after, later.map_or(to, |it| beyond(&it, &to, 2.0 - share)), false)
                }
                [None, None] => continue,
            };
            let label_idx = self.by_track[label_scan][&track];
            let Label { facts, ignored } = &self.labels[label_scan][label_idx];
            let size_m = facts.bounding_box.map_or([0.0; 3], |it| it.length_width_height_m);
            let bounding_box = Some(box_at(&(world_from_sensor.inverse() * pose), size_m));
            let unfollowed = (!is_followed).then_some(IgnoredAnnotation::Unscorable);
            let speed = self.speeds[label_scan][label_idx];
            moment.push(AnnotationFacts { bounding_box, ..facts.clone() }, ignored.or(unfollowed), speed);
        }
        moment
    }

    /// The labels that cannot be followed, and all: annotations of the task that would count.
    pub fn n_unfollowed(&self) -> [u64; 2] {
        let counted = || self.labels.iter().flatten().filter(|it| it.ignored.is_none());
        let unfollowed = counted().filter(|it| it.facts.track.is_none() || it.facts.bounding_box.is_none());
        [unfollowed.count() as u64, counted().count() as u64]
    }

    /// The box of a track at a scan, in the frame that rests.
    fn placed(&self, scan_idx: usize, track: u32) -> Option<Isometry3<f64>> {
        let label_idx = self.by_track.get(scan_idx)?.get(&track)?;
        let LoggedScan { world_from_sensor, .. } = &self.drive.scans[scan_idx];
        Some(world_from_sensor * pose_of(&self.labels[scan_idx][*label_idx].facts.bounding_box?))
    }

    fn speed_m_per_s(&self, scan_idx: usize, track: u32) -> Option<f64> {
        let scans = &self.drive.scans;
        let time_us = scans[scan_idx].time_us;
        let is_near = |it: &usize| (scans[*it].time_us - time_us).abs() <= SPEED_WINDOW_US;
        let has_it = |it: &usize| self.by_track[*it].contains_key(&track);
        let last = (scan_idx..scans.len()).take_while(|it| is_near(it) && has_it(it)).last()?;
        let first = (0..=scan_idx).rev().take_while(|it| is_near(it) && has_it(it)).last()?;
        let way =
            self.placed(last, track)?.translation.vector - self.placed(first, track)?.translation.vector;
        let duration_s = (scans[last].time_us - scans[first].time_us) as f64 / 1e6;
        (self.drive.has_poses && duration_s > 0.0).then(|| way.xy().norm() / duration_s)
    }
}

impl TrueMoment {
    fn empty(world_from_sensor: Isometry3<f64>) -> Self {
        let id = ScanId { sequence: String::new(), index: 0 };
        Self {
            world_from_sensor,
            scan: LabeledScan::everywhere(id, PointCloud::default(), Vec::new()),
            facts: Vec::new(),
            exclusions: Vec::new(),
            speeds_m_per_s: Vec::new(),
            tracks: Vec::new(),
        }
    }

    fn push(&mut self, facts: AnnotationFacts, ignored: Option<IgnoredAnnotation>, speed: Option<f64>) {
        let bounding_box = facts.bounding_box.as_ref().map(oriented_box);
        self.scan.annotations.push(Annotation { bounding_box, ..Annotation::of(facts.class) });
        self.tracks.extend(facts.track);
        self.exclusions.push(ignored.map(AnnotationOutcome::Ignored));
        self.speeds_m_per_s.push(speed);
        self.facts.push(facts);
    }

    /// Whether an object of this track is labelled.
    pub fn has(&self, track: u32) -> bool {
        self.tracks.contains(&track)
    }
}
