//! Parts of objects that are seen step by step.

use detector::PointCloud;
use rayon::prelude::*;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::object_cloud::growing_cloud::GrowingCloud;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use scans::object_cloud::uncover::{UNCOVER_STEPS, UncoverFrom, uncover};

/// The part of an object that is seen up to one step.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectPart {
    /// Index of the object in its set.
    pub object_idx: usize,
    /// Name of the object.
    pub object: String,
    /// Class of the object.
    pub class: PartialClass,
    /// From which end it is seen: `below`, `above`, or `drive` as it was driven toward.
    pub direction: &'static str,
    /// Number of the step, from 1 to 10.
    pub step: u32,
    /// Its points.
    pub cloud: PointCloud,
    /// Share of the points of the object.
    pub share_of_points: f64,
}

impl ObjectPart {
    /// Number of the part within any object, made of direction and step.
    pub fn index(&self) -> usize {
        let from = match self.direction {
            DRIVE => 2,
            "above" => 1,
            _ => 0,
        };
        from * 100 + self.step as usize
    }
}

/// The direction of objects that were driven toward.
pub const DRIVE: &str = "drive";

/// Which parts of objects are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartsSeen {
    /// The whole object.
    Whole,
    /// Ten steps from below, and ten from above.
    Uncovered,
    /// Ten of the moments at which it was seen on a drive, evenly spread, including the last one.
    Driven,
}

/// The parts of the objects `object_indices` of a set, object by object.
///
/// # Errors
///
/// [`DatasetError`] of the first object that cannot be read.
pub fn object_parts(
    set: &dyn ObjectCloudSet,
    object_indices: &[usize],
    seen: PartsSeen,
) -> Result<Vec<ObjectPart>, DatasetError> {
    let of_object = |&it: &usize| Ok(parts_of(it, &set.read(it)?, seen));
    let of_objects: Vec<Result<_, DatasetError>> = object_indices.par_iter().map(of_object).collect();
    let of_objects: Vec<Vec<ObjectPart>> = of_objects.into_iter().collect::<Result<_, _>>()?;
    Ok(of_objects.into_iter().flatten().collect())
}

/// The parts of `growing`, object `object_idx` of its set.
pub fn parts_of(object_idx: usize, growing: &GrowingCloud, seen: PartsSeen) -> Vec<ObjectPart> {
    let whole = &growing.whole;
    let part = |direction, step, cloud: PointCloud| ObjectPart {
        object_idx,
        object: whole.id.clone(),
        class: whole.class,
        direction,
        step,
        share_of_points: cloud.len() as f64 / whole.cloud.len().max(1) as f64,
        cloud,
    };
    let last = *UNCOVER_STEPS.end();
    match seen {
        PartsSeen::Whole => vec![part(UncoverFrom::Below.name(), last, whole.cloud.clone())],
        PartsSeen::Uncovered => UncoverFrom::ALL
            .into_iter()
            .flat_map(|from| UNCOVER_STEPS.map(move |step| (from, step)))
            .map(|(from, step)| part(from.name(), step, uncover(&whole.cloud, from, step)))
            .collect(),
        PartsSeen::Driven => UNCOVER_STEPS
            .map(|step| {
                let index = (growing.moments.len() * step as usize).div_ceil(last as usize).max(1);
                part(DRIVE, step, growing.seen_at(&growing.moments[index - 1]))
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::object_clouds::simulated_objects::{ObjectPart as Purpose, open_simulated_objects};

    #[test]
    fn parts_grow_until_all_is_seen() {
        let set = open_simulated_objects("objects-approach", Purpose::Training, 1).unwrap();
        for (seen, n_parts) in [(PartsSeen::Whole, 1), (PartsSeen::Uncovered, 20), (PartsSeen::Driven, 10)] {
            let parts = object_parts(&set, &[2], seen).unwrap();
            assert_eq!(parts.len(), n_parts);
            for of_end in parts.chunk_by(|a, b| a.direction == b.direction) {
                assert!(of_end.is_sorted_by_key(|it| it.cloud.len()));
                assert_eq!(of_end.last().map(|it| it.share_of_points), Some(1.0));
            }
        }
    }
}
