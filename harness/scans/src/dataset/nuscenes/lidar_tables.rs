//! Reads the keyframes of the lidar and their annotations from the tables.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use nalgebra::{Isometry3, Vector3};
use serde::Deserialize;

use super::table::read_table;
use super::world_objects::{WorldObject, read_objects};
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;
use crate::dataset::pose::pose;
use crate::dataset::python_json::{check_finite, numbers};

/// The lidar on the roof.
const LIDAR: &str = "LIDAR_TOP";

/// A scan that is annotated.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyframe {
    /// The token of its sample.
    pub sample_token: String,
    /// The scene it belongs to.
    pub scene: String,
    /// When it was taken, in nanoseconds.
    pub time_ns: u64,
    /// Its file, below the folder of the data set.
    pub file: PathBuf,
    /// The pose of the lidar, with x forward and y left.
    pub world_from_sensor: Isometry3<f64>,
    /// The position of the car, in the frame of the world, in metres.
    pub ego_m: [f64; 3],
    /// The annotated objects, in the frame of the world.
    pub objects: Vec<WorldObject>,
}

/// Times in nanoseconds, files and poses of all scans of the lidar, by scene.
pub type ScansOfScenes = BTreeMap<String, Vec<(u64, PathBuf, Isometry3<f64>)>>;

/// The scans of the lidar in the tables.
#[derive(Debug, Clone, PartialEq)]
pub struct LidarTables {
    /// Its keyframes.
    pub keyframes: Vec<Keyframe>,
    /// Samples that have annotations but no keyframe of it.
    pub samples_without_scan: BTreeSet<String>,
}

#[derive(Deserialize)]
struct SensorRecord {
    token: String,
    channel: String,
}

#[derive(Deserialize)]
struct CalibratedSensorRecord {
    token: String,
    sensor_token: String,
    #[serde(deserialize_with = "numbers")]
    translation: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    rotation: [f64; 4],
}

#[derive(Deserialize)]
struct NamedRecord {
    token: String,
    name: String,
}

#[derive(Deserialize)]
struct SampleRecord {
    token: String,
    scene_token: String,
    #[serde(default)]
    timestamp: Option<u64>,
}

#[derive(Deserialize)]
struct SampleDataRecord {
    sample_token: String,
    ego_pose_token: String,
    calibrated_sensor_token: String,
    timestamp: u64,
    is_key_frame: bool,
    filename: String,
}

#[derive(Deserialize)]
struct EgoPoseRecord {
    token: String,
    #[serde(deserialize_with = "numbers")]
    translation: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    rotation: [f64; 4],
}

/// A scan whose pose is not known yet.
struct Unplaced {
    sample: String,
    scene: String,
    sample_time_us: Option<u64>,
    ego_pose: String,
    ego_from_sensor: Isometry3<f64>,
    time_ns: u64,
    file: PathBuf,
}

/// Reads the tables in `folder`: the keyframes of the lidar by scene, each in the order of its times; only those of `scenes`
/// if any are named.
///
/// Annotations of unknown classes are noted in `classes` and left out. Other records, such as images and the scans between
/// keyframes, are skipped and not kept.
pub fn read_keyframes(
    folder: &Path,
    scenes: Option<&BTreeSet<String>>,
    classes: &mut ClassReader<'_>,
) -> Result<LidarTables, DatasetError> {
    let table = |name: &str| folder.join(format!("{name}.json"));
    let unplaced = read_unplaced(&table, scenes, |it| it.is_key_frame)?;
    let poses = read_poses(&table("ego_pose"), &unplaced)?;
    let samples = unplaced.iter().map(|it| (it.sample.as_str(), it.sample_time_us)).collect();
    let (mut objects, elsewhere) = read_objects(&table, &samples, classes)?;
    let mut keyframes = Vec::new();
    for it in unplaced {
        let Some(world_from_ego) = poses.get(&it.ego_pose) else {
            return Err(names_nothing(&table("sample_data"), "ego_pose", &it.ego_pose));
        };
        keyframes.push(Keyframe {
            scene: it.scene,
            time_ns: it.time_ns,
            file: it.file,
            world_from_sensor: world_from_ego * it.ego_from_sensor,
            ego_m: world_from_ego.translation.vector.into(),
            objects: objects.remove(&it.sample).unwrap_or_default(),
            sample_token: it.sample,
        });
    }
    keyframes.sort_by(|a, b| (&a.scene, a.time_ns).cmp(&(&b.scene, b.time_ns)));
    // Samples of other scenes have no scans either.
    let samples_without_scan = if scenes.is_none() { elsewhere } else { BTreeSet::new() };
    Ok(LidarTables { keyframes, samples_without_scan })
}

/// Reads the tables in `folder`: all scans of the lidar in `scenes`, annotated or not, each with its time in nanoseconds, its
/// file and the pose of the lidar, by scene in the order of their times.
pub fn read_all_scans(folder: &Path, scenes: &BTreeSet<String>) -> Result<ScansOfScenes, DatasetError> {
    let table = |name: &str| folder.join(format!("{name}.json"));
    let unplaced = read_unplaced(&table, Some(scenes), |_| true)?;
    let poses = read_poses(&table("ego_pose"), &unplaced)?;
    let mut scans = ScansOfScenes::new();
    for it in unplaced {
        let Some(world_from_ego) = poses.get(&it.ego_pose) else {
            return Err(names_nothing(&table("sample_data"), "ego_pose", &it.ego_pose));
        };
        let of_scene = scans.entry(it.scene).or_default();
        of_scene.push((it.time_ns, it.file, world_from_ego * it.ego_from_sensor));
    }
    for of_scene in scans.values_mut() {
        of_scene.sort_by_key(|(time_ns, ..)| *time_ns);
    }
    Ok(scans)
}

fn names_nothing(path: &Path, table: &str, token: &str) -> DatasetError {
    let problem = format!("names {token:?}, which is not in {table}.json");
    DatasetError::Damaged { path: path.to_path_buf(), problem }
}

fn read_unplaced(
    table: &impl Fn(&str) -> PathBuf,
    scenes: Option<&BTreeSet<String>>,
    is_wanted: impl Fn(&SampleDataRecord) -> bool,
) -> Result<Vec<Unplaced>, DatasetError> {
    let mut lidars = BTreeSet::new();
    read_table(&table("sensor"), |it: SensorRecord| {
        if it.channel == LIDAR {
            lidars.insert(it.token);
        }
        Ok(())
    })?;
    let mut ego_from_sensors = BTreeMap::new();
    read_table(&table("calibrated_sensor"), |it: CalibratedSensorRecord| {
        if lidars.contains(&it.sensor_token) {
            let ego_from_sensor = pose_of(&it.token, it.translation, it.rotation)? * lidar_from_ours();
            ego_from_sensors.insert(it.token, ego_from_sensor);
        }
        Ok(())
    })?;
    let mut scene_names = BTreeMap::new();
    let mut names = BTreeSet::new();
    read_table(&table("scene"), |it: NamedRecord| {
        if scenes.is_none_or(|scenes| scenes.contains(&it.name)) {
            if !names.insert(it.name.clone()) {
                return Err(format!("has several scenes that are called {:?}", it.name));
            }
            scene_names.insert(it.token, it.name);
        }
        Ok(())
    })?;
    let mut samples = BTreeMap::new();
    read_table(&table("sample"), |it: SampleRecord| {
        if let Some(scene) = scene_names.get(&it.scene_token) {
            samples.insert(it.token, (scene.clone(), it.timestamp));
        }
        Ok(())
    })?;
    let mut unplaced = Vec::new();
    read_table(&table("sample_data"), |it: SampleDataRecord| {
        let (Some(ego_from_sensor), true) =
            (ego_from_sensors.get(&it.calibrated_sensor_token), is_wanted(&it))
        else {
            return Ok(());
        };
        let Some((scene, sample_time_us)) = samples.get(&it.sample_token) else { return Ok(()) };
        unplaced.push(Unplaced {
            scene: scene.clone(),
            sample_time_us: *sample_time_us,
            sample: it.sample_token,
            ego_pose: it.ego_pose_token,
            ego_from_sensor: *ego_from_sensor,
            time_ns: it.timestamp.saturating_mul(1000),
            file: file_below(&it.filename)?,
        });
        Ok(())
    })?;
    Ok(unplaced)
}

fn read_poses(path: &Path, unplaced: &[Unplaced]) -> Result<BTreeMap<String, Isometry3<f64>>, DatasetError> {
    let needed: BTreeSet<&String> = unplaced.iter().map(|it| &it.ego_pose).collect();
    let mut poses = BTreeMap::new();
    read_table(path, |it: EgoPoseRecord| {
        if needed.contains(&it.token) {
            let world_from_ego = pose_of(&it.token, it.translation, it.rotation)?;
            poses.insert(it.token, world_from_ego);
        }
        Ok(())
    })?;
    Ok(poses)
}

/// The pose of the record `token`. Errors are the rest of a sentence about the table.
fn pose_of(token: &str, translation: [f64; 3], rotation: [f64; 4]) -> Result<Isometry3<f64>, String> {
    let named = |problem| format!("has a record {token:?} that {problem}");
    check_finite("translation", &translation).map_err(named)?;
    check_finite("rotation", &rotation).map_err(named)?;
    pose(translation, rotation)
}

/// The lidar has x to the right and y forward.
fn lidar_from_ours() -> Isometry3<f64> {
    Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2)
}

/// `name` as a path to a file below the folder.
fn file_below(name: &str) -> Result<PathBuf, String> {
    let path = Path::new(name);
    let is_below = path.components().all(|it| matches!(it, Component::Normal(_))) && !name.is_empty();
    if is_below && !name.contains('\\') && !name.contains('\0') {
        return Ok(path.to_path_buf());
    }
    Err(format!("names the file {name:?}, which is not below its folder"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_lie_below_the_folder() {
        let name = "samples/LIDAR_TOP/a.pcd.bin";
        assert_eq!(file_below(name).unwrap(), Path::new(name));
        for name in ["../secret", "samples/../../secret", "/etc/passwd", "", "..\\secret", "a\0b", "./.."] {
            assert!(file_below(name).is_err(), "{name}");
        }
    }

    #[test]
    fn ahead_of_the_lidar_is_its_y() {
        let ahead = lidar_from_ours() * Vector3::x();
        assert!((ahead - Vector3::y()).norm() < 1e-12, "{ahead}");
    }
}
