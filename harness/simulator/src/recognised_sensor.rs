//! Which sensor took a scan, recognised by its beams.

use std::collections::BTreeSet;

use detector::PointCloud;
use nalgebra::{Isometry3, Vector3};

use crate::sensor::{EMBEDDED_SENSORS, SensorModel};

/// Beams are separated in sectors of this width, in degrees.
const SECTOR_DEG: f32 = 1.0;
const N_SECTORS: usize = (360.0 / SECTOR_DEG) as usize;
/// Every fourth is looked into.
const SECTOR_STEP: usize = 4;
/// Elevations farther apart than this are of two beams, in degrees.
const LEAST_STEP_DEG: f32 = 0.12;
/// Share of the sectors that see fewer beams than are counted: others look into the sky.
const FULL_SECTOR: f32 = 0.98;
/// Share of the points below the lowest and above the highest elevation that is reported: noise and mirror images.
const OUTSIDE: f32 = 0.002;
/// Nearer points are of the car, in metres.
const LEAST_RANGE_M: f32 = 1.2;
/// A sensor fits if its differences are less than this, see [`SeenBeams::difference`].
const MOST_DIFFERENT: f32 = 1.1;
/// A sensor that is said to have taken a scan surely has not if its differences are greater.
const SURELY_DIFFERENT: f32 = 1.5 * MOST_DIFFERENT;
/// Scans of fewer points may be parts of those that the sensor took: they do not speak against it.
const ENOUGH_POINTS: usize = 20_000;
/// No beam of a rotating sensor sends more pulses in a turn: 0.08 degrees apart. More points a beam are of several beams.
const MOST_FIRINGS: usize = 4600;

/// The beams that points lie on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenBeams {
    /// How many; `None` if they lie too close to each other to be counted.
    pub n_beams: Option<usize>,
    /// Elevation of the lowest and of the highest, in degrees.
    pub elevations_deg: [f32; 2],
    /// Points of the scan that has most.
    pub n_points: usize,
}

impl SeenBeams {
    /// The beams of `clouds`, all of one sensor at the origin. By the rings of the points if they are known; otherwise by
    /// elevations in narrow sectors. `None` if there are too few points.
    ///
    /// Elevations are those after the turn `upright_from_scan`.
    pub fn of<'a>(
        clouds: impl IntoIterator<Item = &'a PointCloud>,
        upright_from_scan: &Isometry3<f64>,
    ) -> Option<Self> {
        let turn = upright_from_scan.rotation.cast::<f32>();
        let mut elevations_deg = Vec::new();
        let mut of_sectors = vec![Vec::new(); N_SECTORS];
        let (mut rings, mut n_by_sector) = (BTreeSet::new(), Vec::new());
        let mut most_points = 0;
        for cloud in clouds {
            most_points = most_points.max(cloud.len());
            for (point_idx, position_m) in cloud.positions_m().enumerate() {
                let [x_m, y_m, z_m] = (turn * Vector3::from(position_m)).into();
                let range_m = x_m.hypot(y_m);
                if range_m < LEAST_RANGE_M {
                    continue;
                }
                let sector = (y_m.atan2(x_m).to_degrees() + 180.0) / SECTOR_DEG;
                let sector = (sector as usize).min(N_SECTORS - 1);
                if !sector.is_multiple_of(SECTOR_STEP) {
                    continue;
                }
                let elevation_deg = z_m.atan2(range_m).to_degrees();
                of_sectors[sector].push(elevation_deg);
                elevations_deg.push(elevation_deg);
                rings.extend(cloud.ring().map(|it| it[point_idx]));
            }
            n_by_sector.extend(of_sectors.iter_mut().step_by(SECTOR_STEP).map(n_steps));
        }
        if elevations_deg.len() < N_SECTORS {
            return None;
        }
        elevations_deg.sort_unstable_by(f32::total_cmp);
        n_by_sector.sort_unstable();
        let at = |share: f32| elevations_deg[((elevations_deg.len() - 1) as f32 * share) as usize];
        let in_full_sector = n_by_sector[((n_by_sector.len() - 1) as f32 * FULL_SECTOR) as usize];
        let counted = if rings.len() > 1 { rings.len() } else { in_full_sector };
        let n_beams = (most_points <= counted * MOST_FIRINGS).then_some(counted);
        let elevations_deg = [at(OUTSIDE), at(1.0 - OUTSIDE)];
        Some(Self { n_beams, elevations_deg, n_points: most_points })
    }

    /// The id of the embedded sensor whose beams these may be.
    pub fn sensor(&self) -> Option<&'static str> {
        let differences = EMBEDDED_SENSORS.iter().filter_map(|(id, _)| {
            let model = SensorModel::embedded(id)?;
            Some((self.difference(&model), *id))
        });
        let (least, id) = differences.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (least < MOST_DIFFERENT).then_some(id)
    }

    /// Whether these are surely not the beams of the embedded sensor of this id; `false` of other ids and of too few points.
    pub fn contradict(&self, id: &str) -> bool {
        let model = SensorModel::embedded(id).filter(|_| self.n_points >= ENOUGH_POINTS);
        model.is_some_and(|it| self.difference(&it) > SURELY_DIFFERENT)
    }

    /// How far these beams differ from those of `model`; infinitely far if they cannot be counted. A third more beams, or a
    /// quarter fewer, are 0.7; as much is 3 degrees at the lower end, or twice that at the upper end: the sky is empty.
    fn difference(&self, model: &SensorModel) -> f32 {
        let ends = model
            .beams()
            .map(|it| it.elevation_deg)
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
        let Some(n_beams) = self.n_beams else { return f32::INFINITY };
        let beams = (n_beams as f32 / model.n_beams() as f32).ln().abs();
        let [low, high] = [0, 1].map(|it| (self.elevations_deg[it] - ends[it]).abs());
        2.4 * beams + low / 4.3 + high / 8.6
    }
}

/// Number of groups of elevations with less than [`LEAST_STEP_DEG`] from one to the next; empties the list.
fn n_steps(elevations_deg: &mut Vec<f32>) -> usize {
    elevations_deg.sort_unstable_by(f32::total_cmp);
    let n = elevations_deg.chunk_by(|a, b| b - a < LEAST_STEP_DEG).count();
    elevations_deg.clear();
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::built_in_catalogue;
    use crate::open::{OpenOptions, open_dataset};

    #[test]
    fn every_embedded_sensor_is_recognised_by_elevations_alone() {
        let catalogue = built_in_catalogue().unwrap();
        for (id, _) in EMBEDDED_SENSORS {
            for street in ["street-main-road", "street-narrow"] {
                let options = OpenOptions { sensor: Some(id.to_owned()), ..OpenOptions::default() };
                let dataset = open_dataset(street, &options, &catalogue).unwrap();
                let cloud = dataset.read_scan(0).unwrap().cloud;
                let without_rings: PointCloud = cloud.positions_m().collect();
                for cloud in [cloud, without_rings] {
                    let seen = SeenBeams::of([&cloud], &Isometry3::identity()).unwrap();
                    assert_eq!(seen.sensor(), Some(id), "{street}: {seen:?}");
                }
            }
        }
    }

    #[test]
    fn other_beams_are_of_no_embedded_sensor() {
        let seen =
            |n_beams, elevations_deg| SeenBeams { n_beams: Some(n_beams), elevations_deg, n_points: 30_000 };
        assert_eq!(seen(16, [-15.0, 15.0]).sensor(), Some("vlp-16"));
        assert_eq!(seen(5, [-2.0, 2.0]).sensor(), None);
        assert_eq!(seen(40, [-60.0, 50.0]).sensor(), None);
        // A Pandar40P and a VLP-32C.
        assert_eq!(seen(40, [-25.0, 15.0]).sensor(), None);
        assert_eq!(seen(32, [-25.0, 15.0]).sensor(), None);
        assert_eq!(SeenBeams::of([&PointCloud::default()], &Isometry3::identity()), None);
    }

    #[test]
    fn a_sensor_that_is_said_to_be_is_doubted_only_where_beams_are_quite_others() {
        let seen = |n_beams, elevations_deg| SeenBeams { n_beams, elevations_deg, n_points: 30_000 };
        assert!(seen(Some(37), [-23.2, 10.0]).contradict("hdl-64e-s2"));
        let few = SeenBeams { n_points: 900, ..seen(Some(37), [-23.2, 10.0]) };
        assert!(!few.contradict("hdl-64e-s2"));
        assert!(!seen(Some(50), [-24.0, 3.0]).contradict("hdl-64e-s2"));
        assert!(!seen(Some(37), [-23.2, 10.0]).contradict("a sensor of one's own"));
    }

    #[test]
    fn beams_that_lie_closer_than_can_be_told_apart_are_not_counted() {
        // Two hundred beams 0.05 degrees apart.
        let point = |beam: u16, turn: u16| {
            let [up, around] = [f32::from(beam) * 0.05 - 5.0, f32::from(turn) * 0.36].map(f32::to_radians);
            [20.0 * up.cos() * around.cos(), 20.0 * up.cos() * around.sin(), 20.0 * up.sin()]
        };
        let cloud: PointCloud =
            (0..200).flat_map(|beam| (0..1000).map(move |turn| point(beam, turn))).collect();
        let seen = SeenBeams::of([&cloud], &Isometry3::identity()).unwrap();
        assert_eq!((seen.n_beams, seen.sensor()), (None, None));
    }
}
