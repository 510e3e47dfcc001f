//! The trained trees of the rivals over a kd-tree.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use detector::classify::grouping_model::GroupingModel;
use detector::classify::model_file::{ModelFile, ModelFileError};
use detector::describe::trained_file::Provenance;
use detector::params::PAPER_SENSOR;

/// Kind of the model of components in its file: the name of the detector that reads it.
pub const KD_TREE_TRAINED: &str = "kd-tree-trained";
/// Kind of the model of components within components.
pub const KD_TREE_TREE: &str = "kd-tree-tree";

/// The constant of the model that says the tolerance for each sensor.
const TOLERANCES: &str = "tolerance_m";

/// Trees that judge components at one tolerance, which was chosen for each sensor on the scans that the trees are trained
/// on.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedComponents {
    /// Trees that keep or drop a component, and say whether it is a vehicle.
    pub judge: Arc<GroupingModel>,
    // By sensor, in metres.
    tolerances_m: BTreeMap<String, f32>,
}

impl TrainedComponents {
    /// The model that comes with the program. It is read when it is first asked for, and once.
    pub fn shipped() -> Self {
        static SHIPPED: LazyLock<TrainedComponents> = LazyLock::new(|| {
            let model = TrainedComponents::from_bytes(include_bytes!("params/kd_tree_trained.model"));
            model.expect("the embedded file is tested")
        });
        SHIPPED.clone()
    }

    /// A model of trees and tolerances, in metres, by sensor.
    pub fn new(judge: Arc<GroupingModel>, tolerances_m: BTreeMap<String, f32>) -> Self {
        Self { judge, tolerances_m }
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, trained with other constants, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let file = ModelFile::from_bytes(bytes, KD_TREE_TRAINED, &GroupingModel::constants())?;
        let problem = || ModelFileError::Head(format!("{TOLERANCES} is no table of metres for each sensor"));
        let table = file.constants().get(TOLERANCES).and_then(toml::Value::as_table).ok_or_else(problem)?;
        let metres =
            |it: &toml::Value| it.as_float().map(|it| it as f32).filter(|it| *it > 0.0 && it.is_finite());
        let tolerances_m = table.iter().map(|(sensor, it)| Some((sensor.clone(), metres(it)?)));
        let tolerances_m: BTreeMap<String, f32> = tolerances_m.collect::<Option<_>>().ok_or_else(problem)?;
        if !tolerances_m.contains_key(PAPER_SENSOR) {
            return Err(problem());
        }
        Ok(Self { judge: Arc::new(GroupingModel::of(&file)?), tolerances_m })
    }

    /// Its file.
    pub fn to_file(&self, made: Provenance) -> ModelFile {
        let metres = |it: f32| it.to_string().parse::<f64>().expect("a number was printed").into();
        let tolerances: toml::Table =
            self.tolerances_m.iter().map(|(sensor, &it)| (sensor.clone(), metres(it))).collect();
        let more = [(TOLERANCES.to_owned(), toml::Value::Table(tolerances))].into_iter().collect();
        self.judge.to_file(KD_TREE_TRAINED, made, more)
    }

    /// The tolerance for scans of `sensor`, in metres; for one that it was not trained on, that for the paper's sensor.
    pub fn tolerance_m(&self, sensor: Option<&str>) -> f32 {
        let of_sensor = sensor.and_then(|it| self.tolerances_m.get(it));
        *of_sensor.unwrap_or_else(|| &self.tolerances_m[PAPER_SENSOR])
    }
}

/// The trees that judge components within components. They are read when they are first asked for, and once.
pub fn shipped_tree() -> Arc<GroupingModel> {
    static SHIPPED: LazyLock<Arc<GroupingModel>> = LazyLock::new(|| {
        let model = tree_from_bytes(include_bytes!("params/kd_tree_tree.model"));
        Arc::new(model.expect("the embedded file is tested"))
    });
    Arc::clone(&SHIPPED)
}

/// The trees that judge components within components, from the content of their file.
///
/// # Errors
///
/// [`ModelFileError`] if it is of another kind or version, trained with other constants, or damaged.
pub fn tree_from_bytes(bytes: &[u8]) -> Result<GroupingModel, ModelFileError> {
    GroupingModel::of(&ModelFile::from_bytes(bytes, KD_TREE_TREE, &GroupingModel::constants())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_files_are_models() {
        let (components, tree) = (TrainedComponents::shipped(), shipped_tree());
        assert!(components.judge.objects != tree.objects);
        assert!((0.3..=1.2).contains(&components.tolerance_m(None)));
        assert_eq!(components.tolerance_m(Some("of nobody")), components.tolerance_m(Some(PAPER_SENSOR)));
        assert_eq!(
            TrainedComponents::from_bytes(&components.to_file(Provenance::default()).to_bytes()).unwrap(),
            components
        );
    }

    #[test]
    fn models_of_others_and_without_tolerances_are_refused() {
        let error = tree_from_bytes(include_bytes!("params/kd_tree_trained.model")).unwrap_err();
        assert_eq!(error.to_string(), "it is a model of \"kd-tree-trained\", not of \"kd-tree-tree\"");
        let judge = TrainedComponents::shipped().judge;
        for tolerances_m in [BTreeMap::new(), [(PAPER_SENSOR.to_owned(), -0.5)].into()] {
            let bytes = TrainedComponents::new(Arc::clone(&judge), tolerances_m)
                .to_file(Provenance::default())
                .to_bytes();
            let error = TrainedComponents::from_bytes(&bytes).unwrap_err().to_string();
            assert_eq!(error, "bad head: tolerance_m is no table of metres for each sensor");
        }
    }
}
