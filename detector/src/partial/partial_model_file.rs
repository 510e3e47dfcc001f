//! A trained bag of graphs as a model file.

use std::sync::{Arc, LazyLock};

use serde::{Deserialize, Serialize};

use super::bag::Vocabulary;
use super::decision::{Center, ClassWeights, Decision, DecisionRule};
use super::labels::Labeler;
use super::partial_model::PartialModel;
use super::partial_params::PartialParams;
use super::patch_descriptor::{Descriptor, N_DESCRIPTOR_VALUES};
use super::patterns::Pattern;
use crate::classify::model_file::{ModelFile, ModelFileError, f32_bytes, f32_numbers};
use crate::params::ParamsError;

/// Kind of the model in its file.
const PARTIAL_MODEL: &str = "partial";
/// The units of descriptors, and behind them the centre of each label; `f64`.
const LABELS: &str = "labels";
/// A `u64` for each column.
const PATTERNS: &str = "patterns";
/// The mean bags, one behind the other.
const BAGS: &str = "mean bags";
/// Of each class the offset, and the weights of all columns; empty where the nearest mean bag decides.
const WEIGHTS: &str = "weights";
/// For each bin of evidence how sharp scores are.
const SHARPNESS: &str = "sharpness";
/// For each bin of evidence how strange a cloud may be; may be infinite.
const STRANGEST: &str = "strangest";

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum PartialModelError {
    /// The file is no such model.
    #[error(transparent)]
    File(#[from] ModelFileError),
    /// A parameter that makes no sense.
    #[error(transparent)]
    Params(#[from] ParamsError),
    /// Mean bags of classes that do not exist, or classes without one.
    #[error("the mean bags are of the classes {found:?}, and there are {n_classes} classes")]
    Classes {
        /// The class of each mean bag.
        found: Vec<usize>,
        /// Number of classes.
        n_classes: usize,
    },
}

/// Constants in the head, which people can read.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Constants {
    classes: Vec<String>,
    center_classes: Vec<usize>,
    params: PartialParams,
}

impl PartialModel {
    /// The model that comes with the program, trained on simulated objects. It is read when it is first asked for, and once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<PartialModel>> = LazyLock::new(|| {
            let model = PartialModel::from_bytes(include_bytes!("../params/partial.model"));
            Arc::new(model.expect("the embedded file is tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// The content of the file of this model. The same model gives the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { made, params, classes, labeler, vocabulary, decision } = self;
        let constants = Constants {
            classes: classes.clone(),
            center_classes: decision.centers.iter().map(|it| it.class_idx).collect(),
            params: params.clone(),
        };
        let constants = toml::Table::try_from(constants).expect("parameters are tables of numbers and words");
        let labels = std::iter::once(&labeler.units).chain(&labeler.centers).flatten();
        let patterns = vocabulary.patterns().iter();
        let bags = decision.centers.iter().flat_map(|it| &it.bag);
        let weights = decision.weights.iter();
        let weights = weights.flat_map(|it| std::iter::once(&it.offset).chain(&it.of_columns));
        let parts = [
            (LABELS, labels.flat_map(|it| it.to_le_bytes()).collect()),
            (PATTERNS, patterns.flat_map(|it| it.0.to_le_bytes()).collect()),
            (BAGS, f32_bytes(bags).collect()),
            (WEIGHTS, f32_bytes(weights).collect()),
            (SHARPNESS, f32_bytes(decision.sharpness.iter()).collect()),
            (STRANGEST, f32_bytes(decision.strangest.iter()).collect()),
        ];
        let file = ModelFile::new(PARTIAL_MODEL, made.clone(), constants);
        parts.into_iter().fold(file, |file, (name, bytes)| file.with_part(name, Vec::new(), bytes)).to_bytes()
    }

    /// The model that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    ///
    /// [`PartialModelError`] if the bytes are no model, one of another version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PartialModelError> {
        let file = ModelFile::from_bytes(bytes, PARTIAL_MODEL, &toml::Table::new())?;
        let constants = toml::Value::Table(file.constants().clone()).try_into::<Constants>();
        let constants = constants.map_err(|error| ModelFileError::Head(error.message().to_owned()))?;
        let Constants { classes, center_classes, params } = constants;
        params.validate()?;
        let n_classes = classes.len();
        if n_classes < 2
            || !(0..n_classes).all(|it| center_classes.contains(&it))
            || center_classes.iter().any(|&it| it >= n_classes)
        {
            return Err(PartialModelError::Classes { found: center_classes, n_classes });
        }
        let labeler = labeler_of(&file, params.labels.n_labels)?;
        let vocabulary = vocabulary_of(&file)?;
        let decision = decision_of(&file, &params, n_classes, &center_classes, vocabulary.patterns().len())?;
        Ok(Self { made: file.made().clone(), params, classes, labeler, vocabulary, decision })
    }
}

fn labeler_of(file: &ModelFile, most_labels: usize) -> Result<Labeler, ModelFileError> {
    let damaged = ModelFileError::Part { name: LABELS };
    let (numbers, []) = file.part_of_values(LABELS, &[])?.as_chunks() else { return Err(damaged) };
    let numbers: Vec<f64> = numbers.iter().map(|it| f64::from_le_bytes(*it)).collect();
    let (descriptors, []) = numbers.as_chunks::<N_DESCRIPTOR_VALUES>() else { return Err(damaged) };
    let Some((units, centers)) = descriptors.split_first() else { return Err(damaged) };
    let is_sound = units.iter().all(|&it| it > 0.0)
        && numbers.iter().all(|it| it.is_finite())
        && (1..=most_labels).contains(&centers.len());
    let centers: Vec<Descriptor> = centers.to_vec();
    if is_sound { Ok(Labeler { units: *units, centers }) } else { Err(damaged) }
}

fn vocabulary_of(file: &ModelFile) -> Result<Vocabulary, ModelFileError> {
    let damaged = ModelFileError::Part { name: PATTERNS };
    let (numbers, []) = file.part_of_values(PATTERNS, &[])?.as_chunks() else { return Err(damaged) };
    let patterns = numbers.iter().map(|it| Pattern::from_number(u64::from_le_bytes(*it)));
    patterns.collect::<Option<Vec<_>>>().and_then(Vocabulary::new).ok_or(damaged)
}

fn decision_of(
    file: &ModelFile,
    params: &PartialParams,
    n_classes: usize,
    center_classes: &[usize],
    n_columns: usize,
) -> Result<Decision, ModelFileError> {
    let n_weights = match params.decision.rule {
        DecisionRule::Nearest => 0,
        DecisionRule::Weighted => n_classes,
    };
    let rows = |name, n_rows: usize, n_in_row: usize| {
        let numbers = f32_numbers(file.part_of_values(name, &[])?);
        let numbers = numbers.filter(|it| it.len() == n_rows * n_in_row);
        let numbers = numbers.ok_or(ModelFileError::Part { name })?;
        let row = |idx: usize| numbers[idx * n_in_row..][..n_in_row].to_vec();
        Ok::<_, ModelFileError>((0..n_rows).map(row).collect::<Vec<_>>())
    };
    let bags = rows(BAGS, center_classes.len(), n_columns)?;
    let center = |(&class_idx, bag)| Center { class_idx, bag };
    let weights = rows(WEIGHTS, n_weights, 1 + n_columns)?;
    let weight = |row: Vec<f32>| ClassWeights { offset: row[0], of_columns: row[1..].to_vec() };
    let n_bins = params.decision.evidence_edges.len() + 1;
    Ok(Decision {
        centers: center_classes.iter().zip(bags).map(center).collect(),
        weights: weights.into_iter().map(weight).collect(),
        sharpness: rows(SHARPNESS, 1, n_bins)?.concat(),
        strangest: strangest_of(file, n_bins)?,
    })
}

fn strangest_of(file: &ModelFile, n_bins: usize) -> Result<Vec<f32>, ModelFileError> {
    let damaged = ModelFileError::Part { name: STRANGEST };
    let (numbers, []) = file.part_of_values(STRANGEST, &[])?.as_chunks() else { return Err(damaged) };
    let numbers: Vec<f32> = numbers.iter().map(|it| f32::from_le_bytes(*it)).collect();
    let is_sound = |it: &f32| it.is_finite() || *it == f32::INFINITY;
    if numbers.len() == n_bins && numbers.iter().all(is_sound) { Ok(numbers) } else { Err(damaged) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::trained_file::Provenance;

    fn model() -> PartialModel {
        let mut params = PartialParams::shipped();
        params.decision.evidence_edges = vec![4];
        let center = |class_idx, bag: [f32; 2]| Center { class_idx, bag: bag.to_vec() };
        let weights = |offset, of_columns: [f32; 2]| ClassWeights { offset, of_columns: of_columns.to_vec() };
        PartialModel {
            made: Provenance::default(),
            params,
            classes: vec!["tree".to_owned(), "a \"pole\"".to_owned()],
            labeler: Labeler {
                units: [0.5; N_DESCRIPTOR_VALUES],
                centers: vec![[1.0 / 3.0; N_DESCRIPTOR_VALUES]; 3],
            },
            vocabulary: Vocabulary::new(vec![Pattern(7), Pattern(1 << 48)]).unwrap(),
            decision: Decision {
                centers: vec![center(0, [1.0, 0.1]), center(1, [0.0, 1.0]), center(1, [-1e-20, 0.7])],
                weights: vec![weights(0.1, [0.2, 0.3]), weights(-0.1, [0.4, 0.5])],
                sharpness: vec![1.0, 2.5],
                strangest: vec![f32::INFINITY, 0.5],
            },
        }
    }

    #[test]
    fn the_shipped_model_was_made_with_the_shipped_parameters() {
        let shipped = PartialModel::shipped();
        assert_eq!(shipped.params, PartialParams::shipped());
        assert_eq!(shipped.classes, ["tree", "car", "pole", "pedestrian", "other"]);
        assert!(shipped.to_bytes() == include_bytes!("../params/partial.model"));
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        assert_eq!(PartialModel::from_bytes(&model().to_bytes()).unwrap(), model());
        let mut nearest = model();
        nearest.params.decision.rule = DecisionRule::Nearest;
        nearest.decision.weights.clear();
        assert_eq!(PartialModel::from_bytes(&nearest.to_bytes()).unwrap(), nearest);
    }

    #[test]
    fn what_no_training_gives_is_refused_by_the_name_of_its_part() {
        type Change = fn(&mut PartialModel);
        let changes: [(Change, &str); 11] = [
            (|it| it.labeler.units[0] = -0.5, "\"labels\" is damaged"),
            (|it| it.labeler.centers.clear(), "\"labels\" is damaged"),
            (|it| it.labeler.centers[0][3] = f64::NAN, "\"labels\" is damaged"),
            (|it| it.decision.centers[0].class_idx = 2, "classes [2, 1, 1], and there are 2 classes"),
            (|it| it.decision.centers[0].class_idx = 1, "classes [1, 1, 1], and there are 2 classes"),
            (|it| it.decision.centers[1].bag[0] = f32::NAN, "\"mean bags\" is damaged"),
            (|it| it.decision.weights.truncate(1), "\"weights\" is damaged"),
            (|it| it.decision.sharpness[1] = f32::INFINITY, "\"sharpness\" is damaged"),
            (|it| it.decision.strangest.truncate(1), "\"strangest\" is damaged"),
            (
                |it| it.vocabulary = Vocabulary::new(vec![Pattern(7), Pattern(5 << 48)]).unwrap(),
                "\"patterns\"",
            ),
            (|it| it.params.decision.min_keypoints = 0, "decision.min_keypoints = 0 is not within"),
        ];
        for (change, message) in changes {
            let mut changed = model();
            change(&mut changed);
            let error = PartialModel::from_bytes(&changed.to_bytes()).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
        let error = PartialModel::from_bytes(include_bytes!("../params/groupings.model")).unwrap_err();
        assert_eq!(error.to_string(), "it is a model of \"groupings\", not of \"partial\"");
    }
}
