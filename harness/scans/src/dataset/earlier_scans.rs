//! The scans before a scan of a drive, in its frame: what detectors are given that look back.

use std::collections::BTreeMap;

use detector::PointCloud;
use nalgebra::{Isometry3, Point3};

use super::scan_times::SECONDS_PER_NUMBER;
use super::{Dataset, DatasetError};
use crate::annotation::LabeledScan;

/// A scan that nobody has annotated, such as those of nuScenes between its keyframes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Its name within its drive.
    pub name: String,
    /// When it was taken, in nanoseconds since the same start as the scans of its data set.
    pub time_ns: u64,
    /// Pose of the sensor.
    pub world_from_sensor: Isometry3<f64>,
    /// Its points, in its own frame.
    pub cloud: PointCloud,
}

/// A scan before another one.
#[derive(Debug, Clone, PartialEq)]
pub struct EarlierScan {
    /// Drive, slash, scan.
    pub name: String,
    /// Seconds from this scan to the other.
    pub before_s: f64,
    /// Its points, in the frame of the other.
    pub cloud: PointCloud,
}

/// Reads the scans before others; keeps the points of the latest ones, since the next scan asks for most of them again.
#[derive(Debug, Default)]
pub struct EarlierScans {
    // By index of the scan.
    kept: BTreeMap<usize, PointCloud>,
}

impl EarlierScans {
    /// The last `n` scans before `scan`, which is scan `scan_idx` of `dataset`, in its drive, the latest first; fewer at the
    /// beginning of the drive. Scans between annotated ones count, and those that the user has not selected. `None` if the
    /// data set does not know where the sensor was. One `EarlierScans` serves one data set.
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if one of them cannot be read.
    pub fn before(
        &mut self,
        dataset: &dyn Dataset,
        (scan_idx, scan): (usize, &LabeledScan),
        n: usize,
    ) -> Result<Option<Vec<EarlierScan>>, DatasetError> {
        let Some(world_from_sensor) = dataset.world_from_sensor(scan_idx)? else { return Ok(None) };
        let sensor_from_world = world_from_sensor.inverse();
        let id = &scan.id;
        if let Some(sweeps) = dataset.sweeps_before(scan_idx, n)? {
            let time_ns = dataset.scan_time_ns(scan_idx).unwrap_or_default();
            let earlier = sweeps.into_iter().map(|it| EarlierScan {
                name: format!("{}/{}", id.sequence, it.name),
                before_s: 1e-9 * time_ns.saturating_sub(it.time_ns) as f64,
                cloud: moved(it.cloud, &(sensor_from_world * it.world_from_sensor)),
            });
            return Ok(Some(earlier.collect()));
        }
        let ids = dataset.scan_ids();
        let of_drive = (0..scan_idx).rev().take_while(|it| ids[*it].sequence == id.sequence);
        let wanted: Vec<usize> = of_drive.take(n).collect();
        self.kept.retain(|scan_idx, _| wanted.contains(scan_idx));
        let mut earlier = Vec::with_capacity(wanted.len());
        for before_idx in wanted {
            let Some(world_from_then) = dataset.world_from_sensor(before_idx)? else { return Ok(None) };
            let cloud = match self.kept.get(&before_idx) {
                Some(kept) => kept.clone(),
                None => dataset.read_scan(before_idx)?.cloud,
            };
            self.kept.entry(before_idx).or_insert_with(|| cloud.clone());
            earlier.push(EarlierScan {
                name: ids[before_idx].to_string(),
                before_s: seconds_between(dataset, before_idx, scan_idx),
                cloud: moved(cloud, &(sensor_from_world * world_from_then)),
            });
        }
        if n > 0 {
            self.kept.insert(scan_idx, scan.cloud.clone());
        }
        Ok(Some(earlier))
    }
}

fn seconds_between(dataset: &dyn Dataset, earlier_idx: usize, later_idx: usize) -> f64 {
    let ids = dataset.scan_ids();
    match dataset.scan_time_ns(earlier_idx).zip(dataset.scan_time_ns(later_idx)) {
        Some((earlier_ns, later_ns)) => 1e-9 * later_ns.saturating_sub(earlier_ns) as f64,
        None => SECONDS_PER_NUMBER * f64::from(ids[later_idx].index.saturating_sub(ids[earlier_idx].index)),
    }
}

/// `cloud` with its points moved; rings and times stay.
pub(super) fn moved(mut cloud: PointCloud, target_from_source: &Isometry3<f64>) -> PointCloud {
    cloud.move_points(|position_m| {
        let moved_m = target_from_source * Point3::from(position_m.map(f64::from));
        [moved_m.x, moved_m.y, moved_m.z].map(|it| it as f32)
    });
    cloud
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::ScanId;
    use crate::dataset::{AnnotatedClasses, DatasetDescription, Listing};
    use nalgebra::Vector3;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Two drives of five scans; the sensor goes 1 m ahead between two scans and turns left by a right angle at scan 3. Each
    /// scan has one point, which rests at (10, 0, 0) of the world.
    struct Turning {
        listing: Listing,
        has_poses: bool,
        n_read: AtomicUsize,
    }

    impl Turning {
        fn new(has_poses: bool) -> Self {
            let id = |it: u32| ScanId { sequence: (it / 5).to_string(), index: it % 5 };
            let description = DatasetDescription {
                id: "turning".to_owned(),
                format: "made".to_owned(),
                root: None,
                annotated: AnnotatedClasses::EveryObject,
                sensor_height_m: 1.7,
                sensor: "hdl-64e-s2".to_owned(),
                licence: None,
                checksum: None,
                simulation: None,
            };
            let listing = Listing { description, scan_ids: (0..10).map(id).collect() };
            Self { listing, has_poses, n_read: AtomicUsize::new(0) }
        }

        fn pose(scan_idx: usize) -> Isometry3<f64> {
            let index = scan_idx % 5;
            let yaw_rad = if index < 3 { 0.0 } else { std::f64::consts::FRAC_PI_2 };
            Isometry3::new(Vector3::x() * index as f64, Vector3::z() * yaw_rad)
        }

        fn before(&self, kept: &mut EarlierScans, scan_idx: usize, n: usize) -> Option<Vec<EarlierScan>> {
            let scan = self.read_scan(scan_idx).unwrap();
            self.n_read.store(0, Ordering::Relaxed);
            kept.before(self, (scan_idx, &scan), n).unwrap()
        }
    }

    impl Dataset for Turning {
        fn listing(&self) -> &Listing {
            &self.listing
        }

        fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
            self.n_read.fetch_add(1, Ordering::Relaxed);
            let at_m = Self::pose(scan_idx).inverse() * Point3::new(10.0, 0.0, 0.0);
            let cloud = PointCloud::from_iter([[at_m.x, at_m.y, at_m.z].map(|it| it as f32)]);
            Ok(LabeledScan::everywhere(self.listing.scan_ids[scan_idx].clone(), cloud, Vec::new()))
        }

        fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
            Ok(self.has_poses.then(|| Self::pose(scan_idx)))
        }
    }

    #[test]
    fn what_rests_is_at_one_place_in_all_of_them() {
        let (turning, mut kept) = (Turning::new(true), EarlierScans::default());
        for scan_idx in 5..10 {
            let here_m = turning.read_scan(scan_idx).unwrap().cloud.position_m(0);
            let earlier = turning.before(&mut kept, scan_idx, 3).expect("there are poses");
            let names: Vec<&str> = earlier.iter().map(|it| it.name.as_str()).collect();
            let expected = ["1/000003", "1/000002", "1/000001", "1/000000"];
            assert_eq!(names, expected[4 - (scan_idx - 5)..].iter().take(3).copied().collect::<Vec<_>>());
            for (it, n_before) in earlier.iter().zip(1..) {
                assert!((it.before_s - 0.1 * f64::from(n_before)).abs() < 1e-9, "{it:?}");
                let at_m = it.cloud.position_m(0);
                let off_m = (0..3).map(|axis| (at_m[axis] - here_m[axis]).abs()).fold(0.0, f32::max);
                assert!(off_m < 1e-5, "{it:?} {here_m:?}");
            }
            // The scan before was given when it was asked for.
            assert_eq!(turning.n_read.load(Ordering::Relaxed), 0);
        }
        // Out of order they are read.
        assert_eq!(turning.before(&mut kept, 4, 2).unwrap().len(), 2);
        assert_eq!(turning.n_read.load(Ordering::Relaxed), 2);
    }

    #[test]
    fn without_poses_there_are_none() {
        assert_eq!(Turning::new(false).before(&mut EarlierScans::default(), 3, 2), None);
    }
}
