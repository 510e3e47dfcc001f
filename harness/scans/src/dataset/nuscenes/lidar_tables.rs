//! From the tables to the keyframes of the lidar and their annotations.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use detector::OrientedBox;
use nalgebra::{Isometry3, Vector3};
use reports::vocabulary::class::{AnnotationClass, Occlusion};
use serde::Deserialize;

use super::table::read_table;
use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;
use crate::dataset::mcap::ros_messages::isometry;

/// The lidar on the roof.
const LIDAR: &str = "LIDAR_TOP";

/// A scan that is annotated.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyframe {
    /// The scene it belongs to.
    pub scene: String,
    /// When it was taken, in nanoseconds.
    pub time_ns: u64,
    /// Its file, below the folder of the data set.
    pub file: PathBuf,
    /// Where the lidar was, with x forward and y left.
    pub world_from_sensor: Isometry3<f64>,
    /// What is annotated, in the frame of the world.
    pub objects: Vec<WorldObject>,
}

/// What the tables say about the lidar.
#[derive(Debug, Clone, PartialEq)]
pub struct LidarTables {
    /// Its keyframes.
    pub keyframes: Vec<Keyframe>,
    /// Samples that are annotated and have no keyframe of it.
    pub samples_without_scan: BTreeSet<String>,
}

/// An annotation, before it is brought into the frame of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldObject {
    class: AnnotationClass,
    track: u32,
    occlusion: Option<Occlusion>,
    world_from_box: Isometry3<f64>,
    length_width_height_m: [f32; 3],
}

impl WorldObject {
    /// The annotation without points, for a sensor that was there. The box is set upright.
    pub fn annotation(&self, world_from_sensor: &Isometry3<f64>) -> Annotation {
        let sensor_from_box = world_from_sensor.inverse() * self.world_from_box;
        let center_m = sensor_from_box.translation.vector;
        let heading = sensor_from_box.rotation * Vector3::x();
        Annotation {
            class: self.class,
            bounding_box: Some(OrientedBox {
                center_m: [center_m.x as f32, center_m.y as f32, center_m.z as f32],
                length_width_height_m: self.length_width_height_m,
                yaw_rad: heading.y.atan2(heading.x) as f32,
            }),
            point_indices: Vec::new(),
            track: Some(self.track),
            occlusion: self.occlusion,
            truncation: None,
        }
    }
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
    translation: [f64; 3],
    rotation: [f64; 4],
}

#[derive(Deserialize)]
struct NamedRecord {
    token: String,
    name: String,
}

#[derive(Deserialize)]
struct VisibilityRecord {
    token: String,
    level: String,
}

#[derive(Deserialize)]
struct SampleRecord {
    token: String,
    scene_token: String,
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
    translation: [f64; 3],
    rotation: [f64; 4],
}

#[derive(Deserialize)]
struct InstanceRecord {
    token: String,
    category_token: String,
}

#[derive(Deserialize)]
struct AnnotationRecord {
    sample_token: String,
    instance_token: String,
    #[serde(default)]
    visibility_token: Option<String>,
    #[serde(default)]
    attribute_tokens: Vec<String>,
    translation: [f64; 3],
    size: [f64; 3],
    rotation: [f64; 4],
}

/// A keyframe whose pose is not known yet.
struct Unplaced {
    sample: String,
    scene: String,
    ego_pose: String,
    ego_from_sensor: Isometry3<f64>,
    time_ns: u64,
    file: PathBuf,
}

/// Reads the tables in `folder`: the keyframes of the lidar by scene, each in the order of its times; only those of `scenes` if
/// any are named.
///
/// Annotations whose class nobody knows are noted in `classes` and left out. Everything else, such as images and the scans between keyframes, is passed over and not kept.
///
/// # Errors
///
/// [`DatasetError::Io`] if a table is missing; [`DatasetError::Damaged`] if one is, or names what another does not have.
pub fn read_keyframes(
    folder: &Path,
    scenes: Option<&BTreeSet<String>>,
    classes: &mut ClassReader<'_>,
) -> Result<LidarTables, DatasetError> {
    let table = |name: &str| folder.join(format!("{name}.json"));
    let unplaced = read_unplaced(&table, scenes)?;
    let poses = read_poses(&table("ego_pose"), &unplaced)?;
    let (mut objects, elsewhere) = read_objects(&table, &unplaced, classes)?;
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
            objects: objects.remove(&it.sample).unwrap_or_default(),
        });
    }
    keyframes.sort_by(|a, b| (&a.scene, a.time_ns).cmp(&(&b.scene, b.time_ns)));
    // Of scenes that are not asked for there are no scans either.
    let samples_without_scan = if scenes.is_none() { elsewhere } else { BTreeSet::new() };
    Ok(LidarTables { keyframes, samples_without_scan })
}

fn names_nothing(path: &Path, table: &str, token: &str) -> DatasetError {
    let problem = format!("names {token:?}, which is not in {table}.json");
    DatasetError::Damaged { path: path.to_path_buf(), problem }
}

fn read_unplaced(
    table: &impl Fn(&str) -> PathBuf,
    scenes: Option<&BTreeSet<String>>,
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
            ego_from_sensors.insert(it.token, pose(it.translation, it.rotation)? * lidar_from_ours());
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
    let mut scenes_of_samples = BTreeMap::new();
    read_table(&table("sample"), |it: SampleRecord| {
        if let Some(scene) = scene_names.get(&it.scene_token) {
            scenes_of_samples.insert(it.token, scene.clone());
        }
        Ok(())
    })?;
    let mut unplaced = Vec::new();
    read_table(&table("sample_data"), |it: SampleDataRecord| {
        let (Some(ego_from_sensor), true) =
            (ego_from_sensors.get(&it.calibrated_sensor_token), it.is_key_frame)
        else {
            return Ok(());
        };
        let Some(scene) = scenes_of_samples.get(&it.sample_token) else { return Ok(()) };
        unplaced.push(Unplaced {
            scene: scene.clone(),
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
            poses.insert(it.token, pose(it.translation, it.rotation)?);
        }
        Ok(())
    })?;
    Ok(poses)
}

/// Annotations by the token of their sample.
type ObjectsBySample = BTreeMap<String, Vec<WorldObject>>;

/// The annotations of each sample, and the other samples that have any.
fn read_objects(
    table: &impl Fn(&str) -> PathBuf,
    unplaced: &[Unplaced],
    classes: &mut ClassReader<'_>,
) -> Result<(ObjectsBySample, BTreeSet<String>), DatasetError> {
    let instances = read_instances(table)?;
    let with_rider = read_with_rider(&table("attribute"))?;
    let occlusions = read_occlusions(&table("visibility"))?;
    let wanted: BTreeSet<&String> = unplaced.iter().map(|it| &it.sample).collect();
    let mut objects: BTreeMap<String, Vec<WorldObject>> = BTreeMap::new();
    let mut elsewhere = BTreeSet::new();
    read_table(&table("sample_annotation"), |it: AnnotationRecord| {
        if !wanted.contains(&it.sample_token) {
            elsewhere.insert(it.sample_token);
            return Ok(());
        }
        let named = instances.get(&it.instance_token);
        let (track, category) =
            named.ok_or_else(|| format!("has the unknown instance {:?}", it.instance_token))?;
        let [width_m, length_m, height_m] = it.size;
        if !it.size.iter().all(|side_m| *side_m > 0.0 && *side_m < 1e4) {
            return Err(format!("has a box with the size {:?}", it.size));
        }
        let has_rider = it.attribute_tokens.iter().any(|token| with_rider.contains(token));
        let place = || format!("the instance {:?} of {:?}", it.instance_token, table("sample_annotation"));
        let class = match classes.class_of(category, place) {
            None => return Ok(()),
            Some(AnnotationClass::ParkedCycle) if has_rider => AnnotationClass::Cyclist,
            Some(class) => class,
        };
        let occlusion = it.visibility_token.and_then(|token| occlusions.get(&token).copied().flatten());
        objects.entry(it.sample_token).or_default().push(WorldObject {
            class,
            track: *track,
            occlusion,
            world_from_box: pose(it.translation, it.rotation)?,
            length_width_height_m: [length_m, width_m, height_m].map(|side_m| side_m as f32),
        });
        Ok(())
    })?;
    Ok((objects, elsewhere))
}

/// The number and the category of each instance. Numbered by their place in the table, which is the same whichever scenes are read.
fn read_instances(table: &impl Fn(&str) -> PathBuf) -> Result<BTreeMap<String, (u32, String)>, DatasetError> {
    let mut categories = BTreeMap::new();
    read_table(&table("category"), |it: NamedRecord| {
        categories.insert(it.token, it.name);
        Ok(())
    })?;
    let mut instances = BTreeMap::new();
    let mut n_instances = 0;
    read_table(&table("instance"), |it: InstanceRecord| {
        let category = categories.get(&it.category_token).cloned();
        let category = category.ok_or_else(|| format!("has the unknown category {:?}", it.category_token))?;
        instances.insert(it.token, (n_instances, category));
        n_instances += 1;
        Ok(())
    })?;
    Ok(instances)
}

/// The attributes that say that somebody rides the cycle.
fn read_with_rider(path: &Path) -> Result<BTreeSet<String>, DatasetError> {
    let mut with_rider = BTreeSet::new();
    read_table(path, |it: NamedRecord| {
        if it.name == "cycle.with_rider" {
            with_rider.insert(it.token);
        }
        Ok(())
    })?;
    Ok(with_rider)
}

/// What each level of visibility says.
fn read_occlusions(path: &Path) -> Result<BTreeMap<String, Option<Occlusion>>, DatasetError> {
    let mut occlusions = BTreeMap::new();
    read_table(path, |it: VisibilityRecord| {
        occlusions.insert(it.token, occlusion_of(&it.level));
        Ok(())
    })?;
    Ok(occlusions)
}

/// How much of an object all cameras together see, in classes of a fifth.
fn occlusion_of(level: &str) -> Option<Occlusion> {
    match level {
        "v80-100" => Some(Occlusion::None),
        "v60-80" | "v40-60" => Some(Occlusion::Partly),
        "v0-40" => Some(Occlusion::Largely),
        _ => None,
    }
}

/// Of a translation and a quaternion whose real part comes first.
fn pose(translation: [f64; 3], [w, x, y, z]: [f64; 4]) -> Result<Isometry3<f64>, String> {
    isometry(translation, [x, y, z, w])
}

/// The lidar has x to the right and y forward.
fn lidar_from_ours() -> Isometry3<f64> {
    Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2)
}

/// `name` as a path that leads down and nowhere else.
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
