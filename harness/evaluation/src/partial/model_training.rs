//! Training of a bag of graphs on objects that are seen in several ways.

use std::collections::BTreeMap;

use detector::describe::trained_file::Provenance;
use detector::partial::partial_model::PartialModel;
use detector::partial::partial_params::PartialParams;
use detector::partial::training::{TrainingCloud, TrainingError, train};
use rayon::prelude::*;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use serde::Deserialize;

use super::object_parts::{PartsSeen, parts_of};

/// Training data of the shipped model. `partial_recipe.toml` has the values.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialRecipe {
    /// Names of simulated sets of objects, of which the training part is taken.
    pub objects: Vec<String>,
    /// Number of objects of each set and class.
    pub per_class: u32,
}

impl PartialRecipe {
    /// The recipe of the model that comes with the program.
    pub fn shipped() -> Self {
        toml::from_str(include_str!("partial_recipe.toml")).expect("a test reads the embedded file")
    }
}

/// The simulated objects that a vehicle drives toward.
pub const APPROACHED: &str = "objects-approach";

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum ModelTrainingError {
    /// An object cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// There is too little training data.
    #[error("the bag of graphs learned nothing")]
    Training(#[from] TrainingError),
}

/// Trains a model of the classes of `sets` on all parts of their objects. Objects that are driven toward have as parts the
/// points seen up to ten moments of the drive; all others are uncovered from below and from above, as they are judged.
/// `on_object` is called after each object.
///
/// Within a class all sets weigh the same, however many parts of objects they have. Objects of simulated sets with the same
/// name are one object, seen in different ways: they are held out together. The same sets give the same model to the bit,
/// with any number of threads.
///
/// # Errors
///
/// [`ModelTrainingError`] if an object cannot be read, or there is too little training data.
pub fn train_on_sets(
    sets: &[Box<dyn ObjectCloudSet>],
    params: &PartialParams,
    made: Provenance,
    on_object: impl Fn() + Sync,
) -> Result<PartialModel, ModelTrainingError> {
    let is_there = |class: &PartialClass| sets.iter().any(|it| it.classes().contains(class));
    let classes: Vec<PartialClass> = PartialClass::ALL.into_iter().filter(is_there).collect();
    let mut number_of = BTreeMap::new();
    let mut clouds = Vec::new();
    for (way_idx, set) in sets.iter().enumerate() {
        for (name, of_object) in described_objects(&**set, &classes, params, &on_object)? {
            let n_known = number_of.len();
            let object_idx = *number_of.entry(name).or_insert(n_known);
            clouds.extend(of_object.into_iter().map(|it| TrainingCloud { object_idx, way_idx, ..it }));
        }
    }
    let names: Vec<String> = classes.iter().map(|it| it.name().to_owned()).collect();
    Ok(train(&names, &clouds, params, made)?)
}

/// Name of an object, and the descriptions of its parts.
type DescribedObject = (String, Vec<TrainingCloud>);

/// Describes the objects of a set. Clouds are dropped as soon as they are described: all together are too large for some
/// machines.
fn described_objects(
    set: &dyn ObjectCloudSet,
    classes: &[PartialClass],
    params: &PartialParams,
    on_object: impl Fn() + Sync,
) -> Result<Vec<DescribedObject>, DatasetError> {
    let description = set.description();
    let describe = |object_idx: usize| -> Result<DescribedObject, DatasetError> {
        let growing = set.read(object_idx)?;
        let seen = if description.id == APPROACHED { PartsSeen::Driven } else { PartsSeen::Uncovered };
        let parts = parts_of(object_idx, &growing, seen);
        let class_idx = classes.iter().position(|it| *it == set.classes()[object_idx]);
        let class_idx = class_idx.expect("the classes are those of the sets");
        let described = parts.iter().map(|part| {
            TrainingCloud::described(part.cloud.positions_m(), class_idx, object_idx, part.index(), params)
        });
        let described = described.collect();
        on_object();
        let object = growing.whole.id;
        let name = if description.is_simulated() { object } else { format!("{}/{object}", description.id) };
        Ok((name, described))
    };
    (0..set.classes().len()).into_par_iter().map(describe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use simulator::object_clouds::simulated_objects::{OBJECT_SETS, ObjectPart, open_simulated_objects};

    fn made() -> Provenance {
        Provenance { command: String::new(), data: Vec::new(), seed: 0, split: String::new() }
    }

    #[test]
    fn the_recipe_names_simulated_sets() {
        let recipe = PartialRecipe::shipped();
        assert!(recipe.objects.iter().all(|it| OBJECT_SETS.contains(&it.as_str())), "{recipe:?}");
        assert!(recipe.per_class > 1);
    }

    #[test]
    fn all_sets_are_learned_from_and_threads_change_nothing() {
        let learned = |n_threads: usize| {
            let open = |name| {
                let set = open_simulated_objects(name, ObjectPart::Training, 2).unwrap();
                Box::new(set) as Box<dyn ObjectCloudSet>
            };
            let sets = ["objects-vlp-16", "objects-approach"].map(open);
            let n_objects = AtomicUsize::new(0);
            let count = || {
                n_objects.fetch_add(1, Ordering::Relaxed);
            };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            let learn = || train_on_sets(&sets, &PartialParams::shipped(), made(), count).unwrap();
            let model = pool.install(learn);
            assert_eq!(n_objects.into_inner(), 20);
            model
        };
        let model = learned(1);
        assert_eq!(model.classes, ["tree", "car", "pole", "pedestrian", "other"]);
        assert_eq!(model.rejected_idx(), Some(4));
        assert_eq!(model, learned(3));
    }
}
