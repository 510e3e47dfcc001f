//! A seeded street and the scans of a drive through it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::Duration;

use parry3d::math::{Pose, Vector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::named::named;
use scans::annotation::{Annotation, LabeledScan, ScanId};

use super::crowd::crowd;
use super::gardens::gardens;
use super::intersection::intersection;
use super::labeling::{VisibleObject, annotation};
use super::main_road::main_road;
use super::narrow_street::narrow_street;
use super::object_shape::ObjectShape;
use super::overhead::{bridges, garages, wires};
use super::pulse_path::Surroundings;
use super::rain::Rain;
use super::rounded_bodies::rounded_bodies;
use super::scan::{Turn, beam_errors, turn};
use super::scene::{Leaf, Scene};
use super::sensor::SensorModel;
use super::street_conditions::StreetConditions;
use super::traffic::leading_truck;
use super::works::works;
use super::world::{Motion, World, world_from_placement};

/// Bumped whenever the same street, seed and sensor give other scans.
pub const SIMULATOR_VERSION: u32 = 3;

named! {
    /// The kinds of streets there are.
    pub enum StreetKind {
        /// Traffic both ways, parked rows, pavements with trees, houses on both sides.
        MainRoad = "street-main-road",
        /// One way between close houses, parked rows, slim pavements.
        NarrowStreet = "street-narrow",
        /// Two roads that cross; vehicles wait on one of them.
        Intersection = "street-intersection",
    }
}

impl StreetKind {
    /// The beginning of the names of its drives.
    fn sequence_prefix(self) -> &'static str {
        self.name().trim_start_matches("street-")
    }
}

/// A street and a drive through it, the same for the same kind and seed.
#[derive(Debug, Clone)]
pub struct Street {
    kind: StreetKind,
    seed: u64,
    conditions: StreetConditions,
    world: World,
    standing: Scene,
    rain: Option<Rain>,
}

/// Where the car with the sensor is during a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EgoPose {
    /// Time since the start of the drive.
    pub time: Duration,
    /// Position of the sensor in the world: x, y, z in metres.
    pub position_m: [f32; 3],
    /// Rotation from sensor to world: quaternion x, y, z, w.
    pub world_from_sensor_xyzw: [f32; 4],
}

/// Use of the random streams of a seed; each use has a stream of its own.
#[derive(Debug, Clone, Copy)]
enum StreamUse {
    World = 0,
    BeamErrors = 1,
    Pulses = 2,
    LeadingTruck = 3,
    Bridges = 4,
    Wires = 5,
    Garages = 6,
    Gardens = 7,
    Works = 8,
    Crowd = 9,
    RoundedBodies = 10,
}

impl Street {
    /// Draws the street of this kind and seed.
    pub fn new(kind: StreetKind, seed: u64) -> Self {
        Self::under(kind, seed, &StreetConditions::default())
    }

    /// Draws the street of this kind and seed under `conditions`.
    pub fn under(kind: StreetKind, seed: u64, conditions: &StreetConditions) -> Self {
        let mut rng = random_stream(kind, seed, StreamUse::World);
        let mut world = match kind {
            StreetKind::MainRoad => main_road(conditions, &mut rng),
            StreetKind::NarrowStreet => narrow_street(conditions, &mut rng),
            StreetKind::Intersection => intersection(conditions, &mut rng),
        };
        if let Some(height_m) = conditions.truck_ahead_height_m {
            leading_truck(&mut world, height_m, &mut random_stream(kind, seed, StreamUse::LeadingTruck));
        }
        for (is_built, build, purpose) in [
            (conditions.bridges, bridges as fn(&mut World, &mut ChaCha8Rng), StreamUse::Bridges),
            (conditions.wires, wires, StreamUse::Wires),
            (conditions.garages, garages, StreamUse::Garages),
            (conditions.gardens, gardens, StreamUse::Gardens),
            (conditions.works, works, StreamUse::Works),
            (conditions.crowd, crowd, StreamUse::Crowd),
            // Last, so that it rounds the cars that the others put there.
            (conditions.rounded_bodies, rounded_bodies, StreamUse::RoundedBodies),
        ] {
            if is_built {
                build(&mut world, &mut random_stream(kind, seed, purpose));
            }
        }
        let mut leaves = world.walls.clone();
        for (object, object_idx) in world.objects.iter().zip(0..) {
            if let Motion::Standing(pose) = &object.motion {
                leaves.extend(Leaf::of_object(&object.shape_at(0.0), pose, object_idx));
            }
        }
        Self { kind, seed, conditions: *conditions, world, standing: Scene::new(leaves), rain: None }
    }

    /// This street while it rains.
    #[must_use = "the street itself stays dry"]
    pub fn in_rain(self, rain: Rain) -> Self {
        Self { rain: Some(rain), ..self }
    }

    /// Which kind it is.
    pub fn kind(&self) -> StreetKind {
        self.kind
    }

    /// The seed it was drawn with.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The name of the drive, such as `main-road-7`.
    pub fn sequence(&self) -> String {
        format!("{}-{}", self.kind.sequence_prefix(), self.seed)
    }

    /// How many scans `sensor` makes until the end of the drive. The car then stands still.
    pub fn n_scans(&self, sensor: &SensorModel) -> u32 {
        (self.world.drive_duration_s * sensor.turns_per_second) as u32
    }

    /// Everything a scan of this street depends on but its number, as text: the same text, the same scans.
    pub fn provenance(&self, sensor: &SensorModel) -> String {
        let Self { kind, seed, .. } = self;
        let rain = self.rain.map_or_else(String::new, |it| format!("rain {} mm/h\n", it.mm_per_h()));
        let conditions = match self.conditions {
            drawn if drawn == StreetConditions::default() => String::new(),
            set => format!("conditions {set:?}\n"),
        };
        format!(
            "simulator {SIMULATOR_VERSION}\nstreet {}\nseed {seed}\nsensor {sensor:?}\n{rain}{conditions}",
            kind.name()
        )
    }

    /// Where the sensor is, and when, during scan `scan_idx`.
    pub fn ego_pose(&self, sensor: &SensorModel, scan_idx: u32) -> EgoPose {
        let pose = self.world_from_sensor(sensor, time_s(sensor, scan_idx));
        let seconds = f64::from(scan_idx) / f64::from(sensor.turns_per_second);
        EgoPose {
            time: Duration::from_secs_f64(seconds),
            position_m: pose.translation.into(),
            world_from_sensor_xyzw: pose.rotation.into(),
        }
    }

    /// Makes scan `scan_idx`, which does not depend on any other.
    ///
    /// The scan is taken in an instant: nothing moves during a turn, as in recordings whose motion was compensated.
    /// Every object with a point is annotated, ordered by track. Scans after the end of the drive show the traffic
    /// from a car that stands.
    pub fn scan(&self, sensor: &SensorModel, scan_idx: u32) -> LabeledScan {
        self.labeled_turn(sensor, scan_idx, 1)
    }

    /// Makes scan `scan_idx` as [`Self::scan`], but lets the car and all others move on while the sensor turns.
    ///
    /// Points are relative to the sensor where it was when it saw them, as in recordings that were not compensated.
    /// The turn begins behind the car and goes clockwise; its middle is the time of the scan. The box of an object is
    /// where it was when the median of its points was seen.
    pub fn rolling_scan(&self, sensor: &SensorModel, scan_idx: u32) -> LabeledScan {
        self.labeled_turn(sensor, scan_idx, N_ROLLING_MOMENTS)
    }

    fn labeled_turn(&self, sensor: &SensorModel, scan_idx: u32, n_moments: u32) -> LabeledScan {
        let moments: Vec<Moment<'_>> = (0..n_moments)
            .map(|moment| {
                self.moment(sensor, (scan_idx as f32 + turned(moment, n_moments)) / sensor.turns_per_second)
            })
            .collect();
        let surroundings: Vec<Surroundings<'_>> = moments
            .iter()
            .map(|moment| Surroundings {
                ground: &self.world.ground,
                standing: &self.standing,
                moving: &moment.moving,
                world_from_sensor: moment.world_from_sensor,
                rain: self.rain,
            })
            .collect();
        let errors = beam_errors(sensor, &mut random_stream(self.kind, self.seed, StreamUse::BeamErrors));
        let mut turn = turn(sensor, &errors, &surroundings, |beam| {
            let mut rng = random_stream(self.kind, self.seed, StreamUse::Pulses);
            rng.set_stream(u64::from(scan_idx) << 32 | u64::from(beam));
            rng
        });
        if n_moments > 1 {
            let offset_s = |moment: &usize| turned(*moment as u32, n_moments) / sensor.turns_per_second;
            turn.cloud.set_time_offset_s(turn.moments.iter().map(offset_s).collect());
        }
        let annotations = self.annotations(&turn, sensor, &moments);
        let id = ScanId { sequence: self.sequence(), index: scan_idx };
        LabeledScan::everywhere(id, turn.cloud, annotations)
    }

    fn world_from_sensor(&self, sensor: &SensorModel, time_s: f32) -> Pose {
        let time_s = time_s.min(self.world.drive_duration_s);
        let placement = self.world.ego.placement_at(time_s).expect("the drive ends within the street");
        let world_from_car = world_from_placement(&self.world.ground, &placement);
        let sensor_in_car = Vector::Z * sensor.height_above_road_m;
        Pose::from_parts(world_from_car * sensor_in_car, world_from_car.rotation)
    }

    /// The moving objects within the sensor's range, and the pose of the sensor, at one time.
    fn moment(&self, sensor: &SensorModel, time_s: f32) -> Moment<'_> {
        let world_from_sensor = self.world_from_sensor(sensor, time_s);
        let objects = self.world.objects.iter().zip(0..);
        let moving = objects.filter(|(object, _)| matches!(object.motion, Motion::Following(_)));
        let placed = moving.filter_map(|(object, object_idx)| {
            let pose = object.world_from_object(&self.world.ground, time_s)?;
            // Half of a long bus may reach into the range.
            let distance_m = (pose.translation - world_from_sensor.translation).length();
            let is_near = distance_m < sensor.max_range_m + 10.0;
            is_near.then(|| (object_idx, (object.shape_at(time_s), pose)))
        });
        let movers: BTreeMap<u32, (Cow<'_, ObjectShape>, Pose)> = placed.collect();
        let leaves = movers.iter().flat_map(|(idx, (shape, pose))| Leaf::of_object(shape, pose, *idx));
        let moving = Scene::new(leaves.collect());
        Moment { world_from_sensor, movers, moving }
    }

    fn annotations(&self, turn: &Turn, sensor: &SensorModel, moments: &[Moment<'_>]) -> Vec<Annotation> {
        let mut points_of: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (object_idx, point_idx) in turn.objects.iter().zip(0_u32..) {
            if let Some(object_idx) = object_idx {
                points_of.entry(*object_idx).or_default().push(point_idx);
            }
        }
        let visible = points_of.into_iter().map(|(object_idx, point_indices)| {
            let mut seen_in: Vec<usize> =
                point_indices.iter().map(|point_idx| turn.moments[*point_idx as usize]).collect();
            seen_in.sort_unstable();
            let moment = &moments[seen_in[seen_in.len() / 2]];
            let object = &self.world.objects[object_idx as usize];
            let (shape, world_from_object) = match (&object.motion, moment.movers.get(&object_idx)) {
                (_, Some((shape, pose))) => (shape.clone(), *pose),
                (Motion::Standing(pose), None) => (object.shape_at(0.0), *pose),
                (Motion::Following(_), None) => unreachable!("a point of it was seen at this moment"),
            };
            let sensor_from_object = moment.world_from_sensor.inverse() * world_from_object;
            let object = VisibleObject { object_idx, shape: &shape, sensor_from_object, point_indices };
            annotation(object, turn, sensor)
        });
        visible.collect()
    }
}

/// Number of moments of a turn if things move meanwhile: at 30 m/s and 10 turns a second they jump by 6 cm from one to the
/// next.
const N_ROLLING_MOMENTS: u32 = 48;

/// The state of the street at one time.
#[derive(Debug)]
struct Moment<'a> {
    world_from_sensor: Pose,
    /// The moving objects within the sensor's range: form and position, world from object.
    movers: BTreeMap<u32, (Cow<'a, ObjectShape>, Pose)>,
    /// The moving objects, arranged for casting rays.
    moving: Scene,
}

/// Share of a turn that the sensor has made at one of the moments, counted from its middle.
fn turned(moment: u32, n_moments: u32) -> f32 {
    (moment as f32 + 0.5) / n_moments as f32 - 0.5
}

fn time_s(sensor: &SensorModel, scan_idx: u32) -> f32 {
    scan_idx as f32 / sensor.turns_per_second
}

fn random_stream(kind: StreetKind, seed: u64, purpose: StreamUse) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = purpose as u8;
    for (byte, letter) in key[9..].iter_mut().zip(kind.name().bytes()) {
        *byte = letter;
    }
    ChaCha8Rng::from_seed(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road_axis::RoadPosition;
    use scans::annotation::PointRegion;
    use sha2::{Digest, Sha256};

    fn scan(kind: StreetKind, seed: u64, scan_idx: u32) -> LabeledScan {
        Street::new(kind, seed).scan(&SensorModel::hdl_64e_s2(), scan_idx)
    }

    /// A sensor with few pulses, for tests that need many streets.
    fn coarse_sensor() -> SensorModel {
        SensorModel { n_firings_per_turn: 200, ..SensorModel::hdl_64e_s2() }
    }

    fn checksum(scan: &LabeledScan) -> String {
        let mut hasher = Sha256::new();
        for (position_m, intensity) in scan.cloud.positions_m().zip(scan.cloud.intensity()) {
            position_m.iter().chain([intensity]).for_each(|it| hasher.update(it.to_le_bytes()));
        }
        for it in &scan.annotations {
            hasher.update(format!("{it:?}"));
        }
        let digest = hasher.finalize();
        let start = digest.first_chunk().expect("SHA-256 has 32 bytes");
        format!("{:016x}", u64::from_be_bytes(*start))
    }

    /// Checksums of scan 3 of street 1 of each kind. A change here means other scans: bump [`SIMULATOR_VERSION`].
    #[test]
    fn streets_give_the_same_bytes_on_every_machine() {
        let found = StreetKind::ALL.map(|kind| checksum(&scan(kind, 1, 3)));
        assert_eq!(found, ["9ab7b083a7a15d73", "98c07ef7ce7e8c39", "f0dc4cdbe9530bac"]);
    }

    #[test]
    fn a_scan_does_not_depend_on_those_made_before_or_beside_it() {
        let street = Street::new(StreetKind::MainRoad, 5);
        let sensor = coarse_sensor();
        let alone = street.scan(&sensor, 7);
        let beside = std::thread::scope(|scope| {
            let other = scope.spawn(|| street.scan(&sensor, 8));
            let seven = street.scan(&sensor, 7);
            let _ = other.join();
            seven
        });
        assert_eq!(beside, alone);
        assert_eq!(Street::new(StreetKind::MainRoad, 5).scan(&sensor, 7), alone);
    }

    #[test]
    fn seeds_and_numbers_make_different_scans() {
        let sensor = coarse_sensor();
        let one = Street::new(StreetKind::MainRoad, 1);
        let other = Street::new(StreetKind::MainRoad, 2);
        assert_ne!(one.scan(&sensor, 0).cloud, other.scan(&sensor, 0).cloud);
        assert_ne!(one.scan(&sensor, 0).cloud, one.scan(&sensor, 1).cloud);
        assert_ne!(one.provenance(&sensor), other.provenance(&sensor));
        assert_ne!(one.provenance(&sensor), one.provenance(&SensorModel::hdl_64e_s2()));
    }

    #[test]
    fn a_full_scan_has_as_many_returns_as_the_real_sensor() {
        for kind in StreetKind::ALL {
            for seed in 0..3 {
                let scan = scan(kind, seed, 40);
                assert!((100_000..128_000).contains(&scan.cloud.len()), "{}", scan.cloud.len());
                assert_eq!(scan.point_regions, vec![PointRegion::Labeled; scan.cloud.len()]);
                assert_eq!(
                    scan.id,
                    ScanId { sequence: format!("{}-{seed}", kind.sequence_prefix()), index: 40 }
                );
            }
        }
    }

    #[test]
    fn every_point_of_an_annotation_lies_in_its_box_but_for_noise() {
        let noise_m = 0.1;
        for kind in StreetKind::ALL {
            for seed in 0..8 {
                let scan = Street::new(kind, seed).scan(&coarse_sensor(), 60);
                for it in &scan.annotations {
                    let mut grown = it.bounding_box.unwrap();
                    grown.length_width_height_m =
                        grown.length_width_height_m.map(|edge| edge + 2.0 * noise_m);
                    for point_idx in &it.point_indices {
                        let position_m = scan.cloud.position_m(*point_idx as usize);
                        assert!(grown.contains(position_m), "seed {seed} {it:?} {position_m:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn annotations_share_no_points_and_have_some() {
        let scan = Street::new(StreetKind::MainRoad, 9).scan(&coarse_sensor(), 10);
        let mut seen = vec![false; scan.cloud.len()];
        for it in &scan.annotations {
            assert!(!it.point_indices.is_empty() && it.point_indices.is_sorted_by(|a, b| a < b));
            for point_idx in &it.point_indices {
                assert!(!std::mem::replace(&mut seen[*point_idx as usize], true));
            }
        }
        let tracks: Vec<_> = scan.annotations.iter().map(|it| it.track.unwrap()).collect();
        assert!(tracks.is_sorted_by(|a, b| a < b), "one annotation a track");
    }

    #[test]
    fn close_by_there_are_enough_objects_to_separate() {
        for kind in StreetKind::ALL {
            for seed in 0..4 {
                let scan = scan(kind, seed, 100);
                let n_seen_well = scan.annotations.iter().filter(|it| {
                    it.point_indices.len() >= 20 && it.bounding_box.is_some_and(|it| it.range_m() < 80.0)
                });
                let n_seen_well = n_seen_well.count();
                assert!((15..140).contains(&n_seen_well), "{} {seed}: {n_seen_well}", kind.name());
            }
        }
    }

    #[test]
    fn what_stands_keeps_its_position_and_size_while_the_car_drives_on() {
        let street = Street::new(StreetKind::MainRoad, 3);
        let sensor = coarse_sensor();
        let world_centers = |scan_idx: u32| -> BTreeMap<u32, [f32; 3]> {
            let world_from_sensor = street.world_from_sensor(&sensor, time_s(&sensor, scan_idx));
            let scan = street.scan(&sensor, scan_idx);
            let standing = scan.annotations.iter().filter(|it| {
                let object = &street.world.objects[it.track.unwrap() as usize];
                matches!(object.motion, Motion::Standing(_))
            });
            let centers = standing.map(|it| {
                let center = Vector::from(it.bounding_box.unwrap().center_m);
                (it.track.unwrap(), (world_from_sensor * center).into())
            });
            centers.collect()
        };
        let (before, after) = (world_centers(20), world_centers(25));
        let in_both: Vec<_> =
            before.iter().filter_map(|(track, one)| Some((one, after.get(track)?))).collect();
        assert!(in_both.len() > 20);
        for (one, other) in in_both {
            assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 0.02), "{one:?} {other:?}");
        }
        let moved_m = street.ego_pose(&sensor, 25).position_m[0] - street.ego_pose(&sensor, 20).position_m[0];
        assert!(moved_m > 2.0);
    }

    /// Points of the standing objects by track.
    fn points_of_standing(street: &Street, scan: &LabeledScan) -> BTreeMap<u32, Vec<[f32; 3]>> {
        let standing = scan.annotations.iter().filter(|it| {
            matches!(street.world.objects[it.track.unwrap() as usize].motion, Motion::Standing(_))
        });
        let positions = standing.map(|it| {
            let points = it.point_indices.iter().map(|point_idx| scan.cloud.position_m(*point_idx as usize));
            (it.track.unwrap(), points.collect())
        });
        positions.collect()
    }

    /// How far ahead a rolling scan sees the standing objects to the left of the car, compared with an instant one,
    /// less what the car drives in a quarter of a turn.
    fn excess_shifts_m(seed: u64) -> Vec<f32> {
        let street = Street::new(StreetKind::MainRoad, seed);
        let sensor = coarse_sensor();
        let (instant, rolling) = (street.scan(&sensor, 30), street.rolling_scan(&sensor, 30));
        assert!(rolling.cloud.x_m()[0] < 0.0, "a turn begins behind the car");
        let (instant, rolling) =
            (points_of_standing(&street, &instant), points_of_standing(&street, &rolling));
        let mean_x =
            |points: &Vec<[f32; 3]>| points.iter().map(|it| it[0]).sum::<f32>() / points.len() as f32;
        let quarter_turn_m = street.world.ego.speed_m_per_s / sensor.turns_per_second / 4.0;
        let left = instant.iter().filter_map(|(track, points)| {
            let [x, y, _] = points[0];
            let is_left = y > 4.0 && x.abs() < 3.0 && points.len() > 15;
            is_left.then_some(mean_x(rolling.get(track)?) - mean_x(points) - quarter_turn_m)
        });
        left.collect()
    }

    #[test]
    fn a_turn_takes_time_only_if_asked_for() {
        // Objects to the left were seen a quarter of a turn before the middle, when they were farther ahead.
        let mut excess_m: Vec<f32> = (0..20).flat_map(excess_shifts_m).collect();
        excess_m.sort_by(f32::total_cmp);
        // Of a few that stand behind others, the two scans see different parts.
        let median_m = excess_m[excess_m.len() / 2];
        assert!(excess_m.len() > 10 && median_m.abs() < 0.1, "{excess_m:?}");
    }

    #[test]
    fn no_two_vehicles_stand_or_drive_in_one_another() {
        use reports::vocabulary::class::AnnotationClass::{Bus, Car, Truck, Van};
        let fleets = [[false, false], [true, false], [false, true]];
        for (kind, [haulage, north_american]) in
            StreetKind::ALL.into_iter().flat_map(|kind| fleets.map(|fleet| (kind, fleet)))
        {
            let conditions = StreetConditions { haulage, north_american, ..StreetConditions::default() };
            for seed in 0..10 {
                let scan = Street::under(kind, seed, &conditions).scan(&coarse_sensor(), 45);
                let vehicles =
                    scan.annotations.iter().filter(|it| matches!(it.class, Car | Van | Truck | Bus));
                let boxes: Vec<_> = vehicles.filter_map(|it| it.bounding_box).collect();
                for (one, one_idx) in boxes.iter().zip(0..) {
                    for (_, other) in boxes.iter().enumerate().filter(|(other_idx, _)| *other_idx != one_idx)
                    {
                        // The slope of the road widens upright boxes a little.
                        let mut core = *other;
                        core.length_width_height_m = core.length_width_height_m.map(|edge| edge * 0.9);
                        for [x, y] in one.footprint_m() {
                            let is_inside = core.contains([x, y, core.center_m[2]]);
                            assert!(!is_inside, "{} {seed}: {one:?} {other:?}", kind.name());
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_road_below_the_sensor_lies_at_its_mounting_height() {
        let sensor = SensorModel { carrier_roof: None, ..SensorModel::hdl_64e_s2() };
        let scan = Street::new(StreetKind::MainRoad, 4).scan(&sensor, 50);
        let near = scan.cloud.positions_m().filter(|[x, y, _]| x.abs() < 6.0 && y.abs() < 1.0);
        let mut heights_m: Vec<f32> = near.map(|[_, _, z]| z).collect();
        heights_m.sort_by(f32::total_cmp);
        let median_m = heights_m[heights_m.len() / 2];
        assert!((median_m + sensor.height_above_road_m).abs() < 0.06, "{median_m}");
    }

    #[test]
    fn rain_loses_points_adds_near_drops_and_mirrors_below_the_road() {
        let sensor = coarse_sensor();
        let street = Street::new(StreetKind::MainRoad, 4);
        let rainy = street.clone().in_rain(Rain::new(50.0));
        let dry_scan = street.scan(&sensor, 30);
        let wet_scan = rainy.scan(&sensor, 30);
        let count = |scan: &LabeledScan, is_meant: fn([f32; 3]) -> bool| {
            scan.cloud.positions_m().filter(|it| is_meant(*it)).count()
        };
        // Points that water mirrors lie lower.
        let far = |[x, y, z]: [f32; 3]| x * x + y * y > 2500.0 && z > -0.5;
        let near_in_the_air = |[x, y, z]: [f32; 3]| x * x + y * y < 9.0 && z > -1.0;
        let world_from_sensor = street.world_from_sensor(&sensor, time_s(&sensor, 30));
        let n_below_ground = |scan: &LabeledScan| {
            let positions = scan.cloud.positions_m().map(|it| world_from_sensor * Vector::from(it));
            positions.filter(|it| it.z < street.world.ground.height_m([it.x, it.y]) - 0.5).count()
        };
        let n_far = [count(&wet_scan, far), count(&dry_scan, far)];
        assert!(n_far[0] < n_far[1], "{n_far:?}");
        assert!(count(&wet_scan, near_in_the_air) > count(&dry_scan, near_in_the_air) + 20);
        let n_deep = [n_below_ground(&wet_scan), n_below_ground(&dry_scan)];
        assert!(n_deep[0] > n_deep[1] + 20, "{n_deep:?}");
        assert_eq!(rainy.scan(&sensor, 30), wet_scan);
        assert_ne!(rainy.provenance(&sensor), street.provenance(&sensor));
    }

    #[test]
    fn a_truck_ahead_is_as_high_as_said_and_stays_there() {
        let conditions = StreetConditions { truck_ahead_height_m: Some(3.0), ..StreetConditions::default() };
        let sensor = coarse_sensor();
        for kind in StreetKind::ALL {
            let street = Street::under(kind, 2, &conditions);
            assert_ne!(street.provenance(&sensor), Street::new(kind, 2).provenance(&sensor));
            for scan_idx in [0, 90] {
                let scan = street.scan(&sensor, scan_idx);
                let boxes = scan.annotations.iter().filter_map(|it| it.bounding_box);
                let ahead = boxes.filter(|it| {
                    let [x, y, _] = it.center_m;
                    (12.0..14.5).contains(&x) && y.abs() < 0.8
                });
                let heights_m: Vec<f32> = ahead.map(|it| it.length_width_height_m[2]).collect();
                // Hills tilt its box a little.
                assert!(matches!(heights_m[..], [it] if (2.9..3.4).contains(&it)), "{heights_m:?}");
            }
        }
    }

    #[test]
    fn kerbs_are_as_high_as_said() {
        let rise_m = |kerb_height_m: Option<f32>| {
            let conditions = StreetConditions { kerb_height_m, ..StreetConditions::default() };
            let ground = Street::under(StreetKind::MainRoad, 4, &conditions).world.ground;
            let height_m = |beyond_kerb_m: f32| {
                let left_m = ground.roads[0].section.left_kerb_m + beyond_kerb_m;
                ground.height_m(ground.roads[0].axis.world_plan(RoadPosition { along_m: 20.0, left_m }).0)
            };
            height_m(0.1) - height_m(-0.1)
        };
        assert!((rise_m(Some(0.25)) - rise_m(Some(0.0)) - 0.25).abs() < 1e-4);
        assert!((0.05..0.16).contains(&(rise_m(None) - rise_m(Some(0.0)))), "kerbs are drawn if not set");
    }

    #[test]
    fn the_car_stands_when_the_drive_is_over() {
        let street = Street::new(StreetKind::MainRoad, 6);
        let sensor = coarse_sensor();
        let last = street.n_scans(&sensor);
        let position_at = |scan_idx| street.ego_pose(&sensor, scan_idx).position_m;
        assert_eq!(position_at(last), position_at(last + 5000));
        assert!(!street.scan(&sensor, last + 5000).cloud.is_empty());
    }
}
