//! A trained bag of graphs as a file.

use std::fmt::Write as _;
use std::sync::{Arc, LazyLock};

use serde::Deserialize;

use super::bag::Vocabulary;
use super::decision::{Center, ClassWeights, Decision, DecisionRule};
use super::labels::Labeler;
use super::partial_model::PartialModel;
use super::partial_params::PartialParams;
use super::patch_descriptor::{Descriptor, N_DESCRIPTOR_VALUES};
use super::patterns::Pattern;
use crate::describe::trained_file::{
    AtLine, Provenance, TrainedFileError, head_and_provenance, line_of, read_file,
};
use crate::params::ParamsError;

/// What the file calls itself.
const FORMAT: &str = "scanbench bag-of-graphs";
/// Of the format; other versions are refused.
const VERSION: i64 = 3;

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum PartialModelError {
    /// No such file.
    #[error(transparent)]
    File(TrainedFileError),
    /// A parameter that makes no sense.
    #[error(transparent)]
    Params(ParamsError),
    /// A list is damaged.
    #[error("{list}: {problem}")]
    List {
        /// Which list.
        list: &'static str,
        /// What is wrong with it.
        problem: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    classes: Vec<String>,
    units: String,
    labels: Vec<String>,
    center_classes: Vec<usize>,
    offsets: String,
    sharpness: String,
    strangest: String,
    columns: Vec<String>,
    params: PartialParams,
    made: Provenance,
}

impl PartialModel {
    /// The model that comes with the program, trained on simulated objects. It is read when it is first asked for, and once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<PartialModel>> = LazyLock::new(|| {
            let model = PartialModel::from_toml(include_str!("../params/partial_model.toml"));
            Arc::new(model.expect("the embedded file is tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// The model as text: numbers as the hexadecimal digits of their bits, so that none is rounded.
    pub fn to_toml(&self) -> String {
        let Self { made, params, classes, labeler, vocabulary, decision } = self;
        let quoted: Vec<String> =
            classes.iter().map(|it| toml::Value::from(it.as_str()).to_string()).collect();
        let labels: Vec<String> =
            labeler.centers.iter().map(|it| format!("  \"{}\",\n", of_doubles(it))).collect();
        let center_classes: Vec<usize> = decision.centers.iter().map(|it| it.class_idx).collect();
        let offsets: Vec<f32> = decision.weights.iter().map(|it| it.offset).collect();
        let mut columns = String::new();
        for (column, pattern) in vocabulary.patterns().iter().enumerate() {
            let centers = decision.centers.iter().map(|it| it.bag[column]);
            let weights = decision.weights.iter().map(|it| it.of_columns[column]);
            let numbers: Vec<f32> = centers.chain(weights).collect();
            writeln!(columns, "  \"{:016x}{}\",", pattern.0, of_singles(&numbers)).expect("text grows");
        }
        let params = toml::Value::try_from(params).expect("parameters are tables of numbers and words");
        let heads = [
            ("params", params.to_string()),
            ("classes", format!("[{}]", quoted.join(", "))),
            ("units", format!("\"{}\"", of_doubles(&labeler.units))),
            ("labels", format!("[\n{}]", labels.concat())),
            ("center_classes", format!("{center_classes:?}")),
            ("offsets", format!("\"{}\"", of_singles(&offsets))),
            ("sharpness", format!("\"{}\"", of_singles(&decision.sharpness))),
            ("strangest", format!("\"{}\"", of_singles(&decision.strangest))),
            ("columns", format!("[\n{columns}]")),
        ];
        head_and_provenance((FORMAT, VERSION), &heads, made)
    }

    /// The model that [`Self::to_toml`] wrote.
    ///
    /// # Errors
    ///
    /// [`PartialModelError`] with its line if the text is no model, one of another version, or damaged.
    pub fn from_toml(text: &str) -> Result<Self, AtLine<PartialModelError>> {
        let file: File = read_file(text, FORMAT, VERSION)
            .map_err(|it| AtLine { line: it.line, problem: PartialModelError::File(it.problem) })?;
        if let Err(problem) = file.params.validate() {
            return Err(AtLine {
                line: line_of(text, &["params"], None),
                problem: PartialModelError::Params(problem),
            });
        }
        let refused = |(list, element_idx, problem): Refused| AtLine {
            line: line_of(text, &[list], element_idx),
            problem: PartialModelError::List { list, problem },
        };
        model_of(file).map_err(refused)
    }
}

/// A list, an element of it if it is one, and what is wrong.
type Refused = (&'static str, Option<usize>, &'static str);

fn model_of(file: File) -> Result<PartialModel, Refused> {
    let labeler = labeler_of(&file)?;
    let n_classes = file.classes.len();
    let n_weights = match file.params.decision.rule {
        DecisionRule::Nearest => 0,
        DecisionRule::Weighted => n_classes,
    };
    if n_classes < 2 {
        return Err(("classes", None, "fewer than two classes"));
    }
    if !(0..n_classes).all(|it| file.center_classes.contains(&it))
        || file.center_classes.iter().any(|&it| it >= n_classes)
    {
        return Err(("center_classes", None, "not a number of every class, and of no other"));
    }
    let singles = |list, text: &str, n, allows_infinity| {
        let numbers = singles_of(text).filter(|it| it.len() == n);
        let is_sound = |it: &f32| it.is_finite() || allows_infinity && *it == f32::INFINITY;
        numbers.filter(|it| it.iter().all(is_sound)).ok_or((
            list,
            None,
            "not as many numbers as there should be",
        ))
    };
    let n_bins = file.params.decision.evidence_edges.len() + 1;
    let mut centers: Vec<Center> =
        file.center_classes.iter().map(|&class_idx| Center { class_idx, bag: Vec::new() }).collect();
    let offsets = singles("offsets", &file.offsets, n_weights, false)?;
    let mut weights: Vec<ClassWeights> =
        offsets.into_iter().map(|offset| ClassWeights { offset, of_columns: Vec::new() }).collect();
    let mut patterns = Vec::with_capacity(file.columns.len());
    for (column, text) in file.columns.iter().enumerate() {
        let (pattern, numbers) = column_of(text, centers.len() + n_weights).ok_or((
            "columns",
            Some(column),
            "not a pattern and its numbers",
        ))?;
        patterns.push(pattern);
        let (of_centers, of_weights) = numbers.split_at(centers.len());
        centers.iter_mut().zip(of_centers).for_each(|(it, &value)| it.bag.push(value));
        weights.iter_mut().zip(of_weights).for_each(|(it, &value)| it.of_columns.push(value));
    }
    let vocabulary = Vocabulary::new(patterns).ok_or(("columns", None, "patterns do not ascend"))?;
    let sharpness = singles("sharpness", &file.sharpness, n_bins, false)?;
    let strangest = singles("strangest", &file.strangest, n_bins, true)?;
    let decision = Decision { centers, weights, sharpness, strangest };
    Ok(PartialModel {
        made: file.made,
        params: file.params,
        classes: file.classes,
        labeler,
        vocabulary,
        decision,
    })
}

fn labeler_of(file: &File) -> Result<Labeler, Refused> {
    let units = doubles_of(&file.units).filter(|it| it.iter().all(|&it| it > 0.0));
    let units = units.ok_or(("units", None, "not twelve positive numbers"))?;
    let center = |(label, text): (usize, &String)| {
        doubles_of(text).ok_or(("labels", Some(label), "not twelve numbers"))
    };
    let centers: Vec<Descriptor> = file.labels.iter().enumerate().map(center).collect::<Result<_, _>>()?;
    if centers.is_empty() || centers.len() > file.params.labels.n_labels {
        return Err(("labels", None, "not as many as the parameters say"));
    }
    Ok(Labeler { units, centers })
}

fn of_doubles(values: &Descriptor) -> String {
    values.iter().fold(String::new(), |text, it| text + &format!("{:016x}", it.to_bits()))
}

fn of_singles(values: &[f32]) -> String {
    values.iter().fold(String::new(), |text, it| text + &format!("{:08x}", it.to_bits()))
}

fn doubles_of(text: &str) -> Option<Descriptor> {
    let numbers: Vec<f64> = hexadecimal(text, 16)?.into_iter().map(f64::from_bits).collect();
    let values: [f64; N_DESCRIPTOR_VALUES] = numbers.try_into().ok()?;
    values.iter().all(|it| it.is_finite()).then_some(values)
}

fn singles_of(text: &str) -> Option<Vec<f32>> {
    Some(hexadecimal(text, 8)?.into_iter().map(|it| f32::from_bits(it as u32)).collect())
}

fn column_of(text: &str, n_numbers: usize) -> Option<(Pattern, Vec<f32>)> {
    let (pattern, numbers) = text.split_at_checked(16)?;
    let numbers = singles_of(numbers)?;
    let is_sound = numbers.len() == n_numbers && numbers.iter().all(|it| it.is_finite());
    let pattern = Pattern::from_number(u64::from_str_radix(pattern, 16).ok()?)?;
    is_sound.then_some((pattern, numbers))
}

/// Numbers of so many digits each.
fn hexadecimal(text: &str, n_digits: usize) -> Option<Vec<u64>> {
    let is_sound = text.len().is_multiple_of(n_digits) && text.bytes().all(|it| it.is_ascii_hexdigit());
    let number = |digits: &[u8]| u64::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok();
    if is_sound { text.as_bytes().chunks(n_digits).map(number).collect() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> PartialModel {
        let mut params = PartialParams::shipped();
        params.decision.evidence_edges = vec![4];
        let center = |class_idx, bag: [f32; 2]| Center { class_idx, bag: bag.to_vec() };
        let weights = |offset, of_columns: [f32; 2]| ClassWeights { offset, of_columns: of_columns.to_vec() };
        PartialModel {
            made: Provenance {
                command: "train".to_owned(),
                data: vec!["objects".to_owned()],
                seed: 1,
                split: "none".to_owned(),
            },
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
        assert_eq!(shipped.to_toml(), include_str!("../params/partial_model.toml"));
        // It is part of the program and of the repository.
        assert!(include_str!("../params/partial_model.toml").len() < 1_500_000);
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        assert_eq!(PartialModel::from_toml(&model().to_toml()).unwrap(), model());
        let mut nearest = model();
        nearest.params.decision.rule = DecisionRule::Nearest;
        nearest.decision.weights.clear();
        assert_eq!(PartialModel::from_toml(&nearest.to_toml()).unwrap(), nearest);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let text = model().to_toml();
        assert!(text.contains(from), "{text}");
        let error = PartialModel::from_toml(&text.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn other_and_damaged_files_are_refused_with_their_line() {
        check_refused("bag-of-graphs", "nu-svm", "line 1: the format is");
        check_refused("version = 3", "version = 9", "line 2: the format has version 9");
        check_refused("units = \"3fe", "units = \"bfe", "line 5: units: not twelve positive numbers");
        check_refused("  \"3fd5", "  \"3fd", "line 7: labels: not twelve numbers");
        check_refused("[0, 1, 1]", "[0, 1, 2]", "center_classes: not a number of every class");
        check_refused("[0, 1, 1]", "[0, 0, 0]", "center_classes: not a number of every class");
        check_refused("sharpness = \"3f", "sharpness = \"ff", "sharpness: not as many numbers");
        check_refused("strangest = \"7f800000", "strangest = \"", "strangest: not as many numbers");
        check_refused("  \"0000000000000007", "  \"0005000000000007", "columns: not a pattern");
        check_refused("  \"0000000000000007", "  \"0001000000000007", "columns: patterns do not ascend");
        check_refused("min_keypoints = 1", "min_keypoints = 0", "decision.min_keypoints = 0 is not within");
        check_refused("radius_m", "radios_m", "unknown field `radios_m`");
    }

    #[test]
    fn a_model_cut_off_anywhere_is_no_model() {
        let text = model().to_toml();
        for end in 0..text.trim_end().len() {
            assert!(PartialModel::from_toml(&text[..end]).is_err(), "{}", &text[..end]);
        }
    }
}
