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
    // Tracks of objects that are followed.
    tracks: Vec<u32>,
    // Whether it is what is labelled in a scan, to be judged as in the run.
    is_of_scan: bool,
}

impl<'a> TaskTruth<'a> {
    /// Of `labels`, those of each scan of `drive`.
    pub fn of(drive: &'a LoggedDrive, labels: &'a [Vec<Label>]) -> Self {
        let of_scan = |labels: &Vec<Label>| {
            let mut by_track: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
            for (idx, it) in labels.iter().enumerate().filter(|(_, it)| it.facts.bounding_box.is_some()) {
                it.facts.track.into_iter().for_each(|track| by_track.entry(track).or_default().push(idx));
            }
            // Two labels of a track cannot be told apart in the next scan.
            let single = by_track.into_iter().filter(|(_, it)| it.len() == 1);
            single.map(|(track, it)| (track, it[0])).collect()
        };
        let truth =
            Self { drive, labels, by_track: labels.iter().map(of_scan).collect(), speeds: Vec::new() };
        let speeds = labels.iter().enumerate().map(|(scan_idx, labels)| {
            labels.iter().map(|it| truth.speed_m_per_s(scan_idx, it.facts.track?)).collect()
        });
        Self { speeds: speeds.collect(), ..truth }
    }

    /// What is labelled in the scan with this index, whether or not it can be followed.
    pub fn at_scan(&self, scan_idx: usize) -> TrueMoment {
        let mut moment = TrueMoment::empty(self.drive.scans[scan_idx].world_from_sensor);
        moment.is_of_scan = true;
        for (label, speed) in self.labels[scan_idx].iter().zip(&self.speeds[scan_idx]) {
            let unboxed = label.facts.bounding_box.is_none().then_some(IgnoredAnnotation::NoBox);
            moment.push(label.facts.clone(), label.ignored.or(unboxed), *speed);
        }
        moment
    }

    /// What is true at `at_us`, which is not before the first scan nor after the last.
    ///
    /// At the time of a scan things are where they are labelled. Between two scans, an object that is labelled in both goes
    /// straight from one place to the other; all else about it is as in the nearer scan. One that is labelled in a single one
    /// of both goes on as before and does not count. One without box, or without a track that is its own, cannot be followed,
    /// and never counts.
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
                let track = label.facts.track.filter(|it| self.by_track[before].contains_key(it));
                let unfollowed = track.is_none().then_some(IgnoredAnnotation::Unscorable);
                moment.tracks.extend(track);
                moment.push(label.facts.clone(), label.ignored.or(unfollowed), *speed);
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
                    let earlier = before.checked_sub(1).and_then(|it| Some((it, self.placed(it, track)?)));
                    let gone = |(scan_idx, it): (usize, Isometry3<f64>)| {
                        beyond(&it, &from, 1.0 + self.share(scan_idx, before, at_us))
                    };
                    (before, earlier.map_or(from, gone), false)
                }
                [None, Some(to)] => {
                    let later = self.placed(after + 1, track);
                    let to_come =
                        |it: Isometry3<f64>| beyond(&it, &to, 1.0 + self.share(after + 1, after, at_us));
                    (after, later.map_or(to, to_come), false)
                }
                [None, None] => continue,
            };
            let label_idx = self.by_track[label_scan][&track];
            let Label { facts, ignored } = &self.labels[label_scan][label_idx];
            let size_m = facts.bounding_box.map_or([0.0; 3], |it| it.length_width_height_m);
            let bounding_box = Some(box_at(&(world_from_sensor.inverse() * pose), size_m));
            let unfollowed = (!is_followed).then_some(IgnoredAnnotation::Unscorable);
            moment.tracks.extend(is_followed.then_some(track));
            let speed = self.speeds[label_scan][label_idx];
            moment.push(AnnotationFacts { bounding_box, ..facts.clone() }, ignored.or(unfollowed), speed);
        }
        moment
    }

    /// How far `at_us` lies beyond the scan `to`, as a multiple of the time from the scan `from` to it, which may run backward.
    fn share(&self, from: usize, to: usize, at_us: TimeUs) -> f64 {
        let [from_us, to_us] = [from, to].map(|it| self.drive.scans[it].time_us);
        (at_us - to_us) as f64 / (to_us - from_us) as f64
    }

    /// How many labels that count cannot be followed, of how many.
    pub fn n_unfollowed(&self) -> [u64; 2] {
        let mut counts = [0, 0];
        for (labels, by_track) in self.labels.iter().zip(&self.by_track) {
            for label in labels.iter().filter(|it| it.ignored.is_none()) {
                let is_followed = label.facts.track.is_some_and(|it| by_track.contains_key(&it));
                counts = [counts[0] + u64::from(!is_followed), counts[1] + 1];
            }
        }
        counts
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
            is_of_scan: false,
        }
    }

    fn push(&mut self, facts: AnnotationFacts, ignored: Option<IgnoredAnnotation>, speed: Option<f64>) {
        let bounding_box = facts.bounding_box.as_ref().map(oriented_box);
        self.scan.annotations.push(Annotation { bounding_box, ..Annotation::of(facts.class) });
        self.exclusions.push(ignored.map(AnnotationOutcome::Ignored));
        self.speeds_m_per_s.push(speed);
        self.facts.push(facts);
    }

    /// Whether the object on this track, if it has one, is followed; in a scan that is judged by itself, every one is.
    pub fn follows(&self, track: Option<u32>) -> bool {
        self.is_of_scan || track.is_some_and(|it| self.tracks.contains(&it))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, Translation3, UnitQuaternion};
    use reports::rows::scan_name::ScanName;
    use reports::vocabulary::class::AnnotationClass;
    use scans::conversion::results::detection_rows::box_facts;
    use simulator::sensor::SensorModel;
    use simulator::{Street, StreetKind};

    use super::super::logged_drive::LoggedScan;

    /// Twenty turns a second with few pulses: every second turn is what is labelled.
    fn sensor() -> SensorModel {
        SensorModel { turns_per_second: 20.0, n_firings_per_turn: 150, ..SensorModel::hdl_64e_s2() }
    }

    fn scan_of(street: &Street, turn: u32) -> (LoggedScan, Vec<Label>) {
        let pose = street.ego_pose(&sensor(), turn);
        let [x, y, z, w] = pose.world_from_sensor_xyzw.map(f64::from);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let at_m = Translation3::from(pose.position_m.map(f64::from));
        let labels = street.scan(&sensor(), turn).annotations.into_iter().zip(0..).map(|(it, id)| Label {
            facts: AnnotationFacts {
                id,
                track: it.track,
                class: it.class,
                occlusion: it.occlusion,
                n_points: it.point_indices.len() as u64,
                n_points_outside: 0,
                bounding_box: it.bounding_box.as_ref().map(box_facts),
                centroid_m: None,
            },
            ignored: None,
        });
        let name = ScanName { dataset: "street".to_owned(), sequence: street.sequence(), scan: turn };
        let scan = LoggedScan {
            name,
            time_us: i64::from(turn) * 50_000,
            world_from_sensor: Isometry3::from_parts(at_m, rotation),
            latencies_ms: Vec::new(),
        };
        (scan, labels.collect())
    }

    fn drive_of(street: &Street, turns: impl Iterator<Item = u32>) -> (LoggedDrive, Vec<Vec<Label>>) {
        let (scans, labels): (Vec<LoggedScan>, Vec<Vec<Label>>) = turns.map(|it| scan_of(street, it)).unzip();
        let (dataset, name) = ("street".to_owned(), street.sequence());
        (LoggedDrive { dataset, name, scans, has_poses: true, tasks: BTreeMap::new() }, labels)
    }

    #[test]
    fn between_scans_things_are_where_the_simulator_has_them() {
        let kinds = StreetKind::ALL.into_iter().flat_map(|kind| (9001..9011).map(move |seed| (kind, seed)));
        let (mut n_compared, mut n_moving) = (0, 0);
        // On the ground, and as seen from the car, whose heading jumps where a road has a kink.
        let (mut on_ground_m, mut seen_m, mut turned_rad) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (kind, seed) in kinds {
            let street = Street::new(kind, seed);
            let (drive, labels) = drive_of(&street, (0..=8).step_by(2));
            let truth = TaskTruth::of(&drive, &labels);
            for turn in [1, 3, 5, 7] {
                let (scan, expected) = scan_of(&street, turn);
                let moment = truth.at(scan.time_us);
                for (idx, facts) in moment.facts.iter().enumerate() {
                    let same = expected.iter().find(|it| it.facts.track == facts.track);
                    // A body that walks has another box at every step.
                    let walks = matches!(facts.class, AnnotationClass::Pedestrian | AnnotationClass::Cyclist);
                    let Some(same) = same.filter(|_| !walks && moment.exclusions[idx].is_none()) else {
                        continue;
                    };
                    let [ours, theirs] =
                        [facts, &same.facts].map(|it| pose_of(&it.bounding_box.expect("all have boxes")));
                    let off_m = |a: Isometry3<f64>, b: Isometry3<f64>| {
                        (a.translation.vector - b.translation.vector).norm()
                    };
                    seen_m = seen_m.max(off_m(ours, theirs));
                    on_ground_m = on_ground_m
                        .max(off_m(moment.world_from_sensor * ours, scan.world_from_sensor * theirs));
                    turned_rad = turned_rad.max(ours.rotation.angle_to(&theirs.rotation));
                    n_compared += 1;
                    n_moving += usize::from(moment.speeds_m_per_s[idx].is_some_and(|it| it > 3.0));
                }
            }
        }
        assert!(n_compared > 5000 && n_moving > 500, "{n_compared} {n_moving}");
        assert!(
            on_ground_m < 0.003 && seen_m < 0.21 && turned_rad < 0.003,
            "{on_ground_m} {seen_m} {turned_rad}"
        );
    }

    #[test]
    fn at_a_scan_the_truth_is_what_is_labelled_there() {
        let street = Street::new(StreetKind::MainRoad, 9001);
        let (drive, labels) = drive_of(&street, (0..=4).step_by(2));
        let truth = TaskTruth::of(&drive, &labels);
        for (scan, labels) in drive.scans.iter().zip(&labels) {
            let moment = truth.at(scan.time_us);
            let facts: Vec<AnnotationFacts> = labels.iter().map(|it| it.facts.clone()).collect();
            assert_eq!(moment.facts, facts);
            assert!(moment.exclusions.iter().all(Option::is_none));
        }
        // What is labelled in one of both scans alone goes on, and does not count.
        let moment = truth.at(50_000);
        let in_both = |track: u32| [0, 1].iter().all(|it| truth.by_track[*it].contains_key(&track));
        for (facts, excluded) in moment.facts.iter().zip(&moment.exclusions) {
            assert_eq!(excluded.is_none(), in_both(facts.track.expect("all have tracks")));
        }
        assert!(moment.exclusions.iter().any(Option::is_some));
        assert_eq!(truth.n_unfollowed()[0], 0);
    }

    #[test]
    fn what_has_no_track_is_judged_in_its_scan_alone() {
        let street = Street::new(StreetKind::MainRoad, 9001);
        let (drive, mut labels) = drive_of(&street, (0..=4).step_by(2));
        labels.iter_mut().flatten().for_each(|it| it.facts.track = None);
        let truth = TaskTruth::of(&drive, &labels);
        let n_labels = labels.iter().flatten().count() as u64;
        assert_eq!(truth.n_unfollowed(), [n_labels, n_labels]);
        assert!(truth.at_scan(1).exclusions.iter().all(Option::is_none));
        let at_it = truth.at(drive.scans[1].time_us);
        assert!(at_it.exclusions.iter().all(Option::is_some));
        assert!(!at_it.follows(None) && truth.at_scan(1).follows(None));
        assert!(truth.at(50_000).facts.is_empty());
    }
}
