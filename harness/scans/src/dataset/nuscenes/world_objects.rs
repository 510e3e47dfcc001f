//! Reads the annotated objects of each sample from the tables, in the frame of the world.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Isometry3;
use reports::vocabulary::class::{AnnotationClass, Occlusion};
use serde::Deserialize;

use super::table::read_table;
use super::velocities::{Sighting, add_velocities};
use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;
use crate::dataset::official::OfficialObject;
use crate::dataset::pose::pose;
use crate::dataset::python_json::{check_finite, numbers};
use crate::dataset::upright_box::upright_box;

/// An annotation before its transform into the frame of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldObject {
    // `None` if the class is unknown.
    class: Option<AnnotationClass>,
    category: Arc<str>,
    track: u32,
    occlusion: Option<Occlusion>,
    world_from_box: Isometry3<f64>,
    length_width_height_m: [f64; 3],
    attribute: Option<Arc<str>>,
    n_points: Option<u64>,
    /// Its velocity on the ground plan; `None` if there is no sighting before or after.
    pub velocity_m_per_s: Option<[f64; 2]>,
}

impl WorldObject {
    /// The annotation without points, for a sensor with this pose; `None` if its class is unknown. The box is set upright.
    pub fn annotation(&self, world_from_sensor: &Isometry3<f64>) -> Option<Annotation> {
        let sensor_from_box = world_from_sensor.inverse() * self.world_from_box;
        Some(Annotation {
            bounding_box: Some(upright_box(&sensor_from_box, self.length_width_height_m)),
            track: Some(self.track),
            occlusion: self.occlusion,
            ..Annotation::of(self.class?)
        })
    }

    /// The object as in the tables.
    pub fn official(&self) -> OfficialObject {
        OfficialObject {
            velocity_m_per_s: self.velocity_m_per_s,
            attribute: self.attribute.as_deref().map(str::to_owned),
            n_points: self.n_points,
            ..OfficialObject::new(&self.category, &self.world_from_box, self.length_width_height_m)
        }
    }
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
    #[serde(default)]
    num_lidar_pts: Option<u64>,
    #[serde(default)]
    num_radar_pts: Option<u64>,
    #[serde(default)]
    prev: String,
    #[serde(default)]
    next: String,
    #[serde(deserialize_with = "numbers")]
    translation: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    size: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    rotation: [f64; 4],
}

/// The records that annotations refer to.
struct References {
    // By token: the number of the instance, and its category.
    instances: BTreeMap<String, (u32, Arc<str>)>,
    attributes: BTreeMap<String, Arc<str>>,
    occlusions: BTreeMap<String, Option<Occlusion>>,
}

/// Annotations by the token of their sample.
pub type ObjectsBySample = BTreeMap<String, Vec<WorldObject>>;

/// The annotations of `samples`, which come with their times in microseconds, and the other samples that have any.
///
/// Unknown classes of annotations are noted in `classes`.
pub fn read_objects(
    table: &impl Fn(&str) -> PathBuf,
    samples: &BTreeMap<&str, Option<u64>>,
    classes: &mut ClassReader<'_>,
) -> Result<(ObjectsBySample, BTreeSet<String>), DatasetError> {
    let references = References {
        instances: read_instances(table)?,
        attributes: read_names(&table("attribute"))?,
        occlusions: read_occlusions(&table("visibility"))?,
    };
    let mut objects = ObjectsBySample::new();
    let mut elsewhere = BTreeSet::new();
    let mut sightings = Vec::new();
    read_table(&table("sample_annotation"), |it: AnnotationRecord| {
        let Some(time_us) = samples.get(it.sample_token.as_str()) else {
            elsewhere.insert(it.sample_token);
            return Ok(());
        };
        let object = references.object(&it, classes, &table("sample_annotation"))?;
        let of_sample = objects.entry(it.sample_token.clone()).or_default();
        if let Some(time_us) = *time_us {
            sightings.push(Sighting {
                track: object.track,
                time_us,
                has_before: !it.prev.is_empty(),
                has_after: !it.next.is_empty(),
                center_m: [it.translation[0], it.translation[1]],
                sample: it.sample_token,
                index: of_sample.len(),
            });
        }
        of_sample.push(object);
        Ok(())
    })?;
    add_velocities(sightings, |sample, index, velocity_m_per_s| {
        if let Some(object) = objects.get_mut(sample).and_then(|it| it.get_mut(index)) {
            object.velocity_m_per_s = Some(velocity_m_per_s);
        }
    });
    Ok((objects, elsewhere))
}

impl References {
    /// The object of a record. Errors are the rest of a sentence about the table at `path`.
    fn object(
        &self,
        it: &AnnotationRecord,
        classes: &mut ClassReader<'_>,
        path: &Path,
    ) -> Result<WorldObject, String> {
        let named = self.instances.get(&it.instance_token);
        let (track, category) =
            named.ok_or_else(|| format!("has the unknown instance {:?}", it.instance_token))?;
        let (sample, instance) = (&it.sample_token, &it.instance_token);
        let named = |problem| {
            format!("has a box of the instance {instance:?} in the sample {sample:?} that {problem}")
        };
        check_finite("translation", &it.translation).map_err(named)?;
        check_finite("size", &it.size).map_err(named)?;
        check_finite("rotation", &it.rotation).map_err(named)?;
        let [width_m, length_m, height_m] = it.size;
        if !it.size.iter().all(|side_m| *side_m > 0.0 && *side_m < 1e4) {
            return Err(format!("has a box with the size {:?}", it.size));
        }
        let attribute = it.attribute_tokens.iter().find_map(|token| self.attributes.get(token));
        let mut attributes = it.attribute_tokens.iter().filter_map(|token| self.attributes.get(token));
        let has_rider = attributes.any(|it| &**it == WITH_RIDER);
        let position = || format!("the instance {:?} of {path:?}", it.instance_token);
        let class = match classes.class_of(category, position) {
            Some(AnnotationClass::ParkedCycle) if has_rider => Some(AnnotationClass::Cyclist),
            class => class,
        };
        let occlusion = it.visibility_token.as_ref().and_then(|token| self.occlusions.get(token));
        Ok(WorldObject {
            class,
            category: Arc::clone(category),
            track: *track,
            occlusion: occlusion.copied().flatten(),
            world_from_box: pose(it.translation, it.rotation)?,
            length_width_height_m: [length_m, width_m, height_m],
            attribute: attribute.cloned(),
            n_points: it
                .num_lidar_pts
                .zip(it.num_radar_pts)
                .map(|(lidar, radar)| lidar.saturating_add(radar)),
            velocity_m_per_s: None,
        })
    }
}

/// The attribute of a cycle with a rider.
const WITH_RIDER: &str = "cycle.with_rider";

/// The number and the category of each instance. The number is the index in the table, so it is the same for any choice of
/// scenes.
fn read_instances(
    table: &impl Fn(&str) -> PathBuf,
) -> Result<BTreeMap<String, (u32, Arc<str>)>, DatasetError> {
    let categories = read_names(&table("category"))?;
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

/// The names in the table at `path` by their tokens.
fn read_names(path: &Path) -> Result<BTreeMap<String, Arc<str>>, DatasetError> {
    let mut names = BTreeMap::new();
    read_table(path, |it: NamedRecord| {
        names.insert(it.token, it.name.into());
        Ok(())
    })?;
    Ok(names)
}

/// The occlusion for each level of visibility.
fn read_occlusions(path: &Path) -> Result<BTreeMap<String, Option<Occlusion>>, DatasetError> {
    let mut occlusions = BTreeMap::new();
    read_table(path, |it: VisibilityRecord| {
        occlusions.insert(it.token, occlusion_of(&it.level));
        Ok(())
    })?;
    Ok(occlusions)
}

/// The occlusion for a level of visibility: the share of an object that all cameras together see, in steps of a fifth.
fn occlusion_of(level: &str) -> Option<Occlusion> {
    match level {
        "v80-100" => Some(Occlusion::None),
        "v60-80" | "v40-60" => Some(Occlusion::Partly),
        "v0-40" => Some(Occlusion::Largely),
        _ => None,
    }
}
