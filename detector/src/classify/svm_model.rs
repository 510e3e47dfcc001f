//! A trained classifier as a file.

use std::fmt::Write as _;

use serde::Deserialize;

use crate::describe::trained_file::{
    AtLine, Provenance, TrainedFileError, head_and_provenance, line_of, read_file,
};

/// What the file calls itself.
const FORMAT: &str = "scanbench nu-svm";
/// Of the format; other versions are refused.
const VERSION: i64 = 2;
/// The coefficients of both classes cancel; this share of their sum is left over by rounding.
const MAX_IMBALANCE: f64 = 1e-4;

/// A trained ν support vector classifier of `D` values.
#[derive(Debug, Clone, PartialEq)]
pub struct SvmModel<const D: usize> {
    /// What it was made of.
    pub made: Provenance,
    /// What its values were taken with and do not show, such as the prototypes they compare with.
    pub describer: String,
    /// Width of the Gaussian kernel.
    pub gamma: f32,
    /// The ν it was trained with.
    pub nu: f64,
    /// Offset of the decision.
    pub rho: f32,
    /// Names of the values.
    pub features: [&'static str; D],
    /// Mean of each value over the training objects.
    pub means: [f32; D],
    /// Standard deviation of each value over the training objects.
    pub deviations: [f32; D],
    /// One for each support vector.
    pub coefficients: Vec<f32>,
    /// Standardised.
    pub support_vectors: Vec<[f32; D]>,
}

/// Why a model cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SvmModelError {
    /// Not TOML, or not a model.
    #[error(transparent)]
    File(#[from] TrainedFileError),
    /// A model for other values.
    #[error("trained on the values {found:?}, not on {expected:?}")]
    Features {
        /// What it says.
        found: Vec<String>,
        /// What it is wanted for.
        expected: Vec<&'static str>,
    },
    /// A model for values that were taken in another way.
    #[error("its values were taken with {found}, those of this program with {expected}")]
    Describer {
        /// What it says.
        found: String,
        /// What it is wanted for.
        expected: String,
    },
    /// A list that is too short or too long.
    #[error("{list} holds {found} values instead of {expected}")]
    Length {
        /// Which list.
        list: String,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A value that no training gives.
    #[error("{name} = {value} is outside of {allowed}")]
    OutOfRange {
        /// Which value.
        name: String,
        /// The value.
        value: f64,
        /// What is possible.
        allowed: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    n_support_vectors: usize,
    describer: String,
    made: Provenance,
    svm: Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    gamma: f32,
    nu: f64,
    rho: f32,
    features: Vec<String>,
    means: Vec<f32>,
    deviations: Vec<f32>,
    coefficients: Vec<f32>,
    support_vectors: Vec<Vec<f32>>,
}

/// A value that cannot be used, and where it stands.
struct Refused {
    keys: &'static [&'static str],
    element_idx: Option<usize>,
    problem: SvmModelError,
}

impl Refused {
    /// Refuses a list of the table `svm`, or an element of it.
    fn of_svm(keys: &'static [&'static str], element_idx: Option<usize>, problem: SvmModelError) -> Self {
        Self { keys, element_idx, problem }
    }
}

const MEANS: &[&str] = &["svm", "means"];
const DEVIATIONS: &[&str] = &["svm", "deviations"];
const COEFFICIENTS: &[&str] = &["svm", "coefficients"];
const SUPPORT_VECTORS: &[&str] = &["svm", "support_vectors"];

impl<const D: usize> SvmModel<D> {
    /// A model that decides about `features` taken with `describer`, from the text that [`Self::to_toml`] gives.
    ///
    /// # Errors
    ///
    /// [`SvmModelError`] with its line if the text is no model, one of another version, for other values or values taken in
    /// another way, or damaged.
    pub fn from_toml(
        text: &str,
        features: [&'static str; D],
        describer: &str,
    ) -> Result<Self, AtLine<SvmModelError>> {
        let file: File = read_file(text, FORMAT, VERSION)
            .map_err(|it| AtLine { line: it.line, problem: SvmModelError::File(it.problem) })?;
        Self::checked(file, features, describer).map_err(|refused| AtLine {
            line: line_of(text, refused.keys, refused.element_idx),
            problem: refused.problem,
        })
    }

    fn checked(file: File, features: [&'static str; D], describer: &str) -> Result<Self, Refused> {
        let File { made, svm, n_support_vectors, .. } = file;
        if svm.features != features {
            let problem = SvmModelError::Features { found: svm.features, expected: features.to_vec() };
            return Err(Refused::of_svm(&["svm", "features"], None, problem));
        }
        if file.describer != describer {
            let expected = describer.to_owned();
            let problem = SvmModelError::Describer { found: file.describer, expected };
            return Err(Refused::of_svm(&["describer"], None, problem));
        }
        let rows = svm.support_vectors.into_iter().enumerate().map(|(row_idx, row)| {
            array(row, format!("support_vectors[{row_idx}]"))
                .map_err(|problem| Refused::of_svm(SUPPORT_VECTORS, Some(row_idx), problem))
        });
        let column = |values: Vec<f32>, keys: &'static [&'static str]| {
            array(values, keys[1].to_owned()).map_err(|problem| Refused::of_svm(keys, None, problem))
        };
        let model = Self {
            made,
            describer: file.describer,
            gamma: svm.gamma,
            nu: svm.nu,
            rho: svm.rho,
            features,
            means: column(svm.means, MEANS)?,
            deviations: column(svm.deviations, DEVIATIONS)?,
            coefficients: svm.coefficients,
            support_vectors: rows.collect::<Result<_, _>>()?,
        };
        model.validate(n_support_vectors)?;
        Ok(model)
    }

    /// The model as text. Numbers are written so that they come back to the bit.
    pub fn to_toml(&self) -> String {
        let n = self.support_vectors.len();
        let describer = toml::Value::from(self.describer.as_str()).to_string();
        let values = [("n_support_vectors", n.to_string()), ("describer", describer)];
        let mut text = head_and_provenance((FORMAT, VERSION), &values, &self.made);
        text.push_str("\n[svm]\n");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "gamma = {:?}\nnu = {:?}\nrho = {:?}", self.gamma, self.nu, self.rho);
        let _ = writeln!(text, "features = {:?}", self.features);
        let _ = writeln!(text, "means = {:?}\ndeviations = {:?}", self.means, self.deviations);
        let _ = writeln!(text, "coefficients = {:?}", self.coefficients);
        text.push_str("support_vectors = [\n");
        for row in &self.support_vectors {
            let _ = writeln!(text, "    {row:?},");
        }
        text.push_str("]\n");
        text
    }

    fn validate(&self, n_support_vectors: usize) -> Result<(), Refused> {
        let counted = |keys: &'static [&'static str], found: usize| {
            let problem =
                SvmModelError::Length { list: keys[1].to_owned(), found, expected: n_support_vectors };
            if found == n_support_vectors { Ok(()) } else { Err(Refused::of_svm(keys, None, problem)) }
        };
        counted(COEFFICIENTS, self.coefficients.len())?;
        counted(SUPPORT_VECTORS, self.support_vectors.len())?;
        within(&["n_support_vectors"], None, n_support_vectors as f64, 1.0..=f64::MAX, "1 and more")?;
        within(&["svm", "gamma"], None, self.gamma.into(), 1e-6..=1e6, "0.000001 to 1000000")?;
        within(&["svm", "nu"], None, self.nu, f64::MIN_POSITIVE..=1.0, "0 (exclusive) to 1")?;
        within(&["svm", "rho"], None, self.rho.into(), FINITE, FINITE_NUMBERS)?;
        for (value_idx, deviation) in self.deviations.into_iter().enumerate() {
            let positive = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
            let named = Some((value_idx, format!("deviation of {}", self.features[value_idx])));
            within(DEVIATIONS, named, deviation.into(), positive, "the positive numbers")?;
        }
        for (value_idx, mean) in self.means.into_iter().enumerate() {
            let named = Some((value_idx, format!("mean of {}", self.features[value_idx])));
            within(MEANS, named, mean.into(), FINITE, FINITE_NUMBERS)?;
        }
        for (row_idx, row) in self.support_vectors.iter().enumerate() {
            for (name, &value) in self.features.iter().zip(row) {
                let named = Some((row_idx, format!("{name} of support vector {row_idx}")));
                within(SUPPORT_VECTORS, named, value.into(), FINITE, FINITE_NUMBERS)?;
            }
        }
        for (row_idx, &coefficient) in self.coefficients.iter().enumerate() {
            let named = Some((row_idx, format!("coefficient {row_idx}")));
            within(COEFFICIENTS, named, coefficient.into(), FINITE, FINITE_NUMBERS)?;
        }
        let sum: f64 = self.coefficients.iter().map(|&it| f64::from(it)).sum();
        let size: f64 = self.coefficients.iter().map(|&it| f64::from(it).abs()).sum();
        let balance = -MAX_IMBALANCE..=MAX_IMBALANCE;
        let named = Some((0, "sum of the coefficients over that of their sizes".to_owned()));
        within(COEFFICIENTS, named, sum / size, balance, "0, but for rounding")
    }
}

const FINITE: std::ops::RangeInclusive<f64> = -3.4e38..=3.4e38;
const FINITE_NUMBERS: &str = "the finite numbers";

/// Refuses what `keys` lead to, or an element of it with a name of its own, unless it is within `range`.
fn within(
    keys: &'static [&'static str],
    element: Option<(usize, String)>,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    allowed: &'static str,
) -> Result<(), Refused> {
    // NaN is within nothing.
    if range.contains(&value) {
        return Ok(());
    }
    let element_idx = element.as_ref().map(|it| it.0);
    let name = element.map_or_else(|| keys[keys.len() - 1].to_owned(), |it| it.1);
    Err(Refused::of_svm(keys, element_idx, SvmModelError::OutOfRange { name, value, allowed }))
}

fn array<const D: usize>(values: Vec<f32>, list: String) -> Result<[f32; D], SvmModelError> {
    values.try_into().map_err(|values: Vec<f32>| SvmModelError::Length {
        list,
        found: values.len(),
        expected: D,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> SvmModel<2> {
        SvmModel {
            made: Provenance {
                command: "scanbench train \"a b\"".to_owned(),
                data: vec!["simulated:main-road".to_owned()],
                seed: 7,
                split: "every fifth street".to_owned(),
            },
            describer: "a \"ruler\"".to_owned(),
            gamma: 0.1078,
            nu: 0.0377,
            rho: -0.3,
            features: ["length_m", "width_m"],
            means: [4.2, 1.8],
            deviations: [1.0e-7, 0.5],
            coefficients: vec![1.5, -0.5, -1.0],
            support_vectors: vec![[0.1, f32::MIN_POSITIVE], [-1.0, 2.0], [1.0 / 3.0, 0.0]],
        }
    }

    #[test]
    fn a_model_comes_back_from_its_file_to_the_bit() {
        let model = model();
        assert_eq!(SvmModel::from_toml(&model.to_toml(), model.features, &model.describer).unwrap(), model);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let text = model().to_toml();
        let n_before = text[..text.find(from).expect("it is there")].matches('\n').count();
        check_refused_at(n_before + 1, from, to, message);
    }

    #[track_caller]
    fn check_refused_at(line: usize, from: &str, to: &str, message: &str) {
        let damaged = model().to_toml().replacen(from, to, 1);
        let error =
            SvmModel::from_toml(&damaged, model().features, &model().describer).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
        assert!(error.starts_with(&format!("line {line}: ")), "{error}\n{damaged}");
    }

    #[test]
    fn other_files_versions_and_values_are_named() {
        check_refused("scanbench nu-svm", "recipe", "format is \"recipe\"");
        check_refused("version = 2", "version = 1", "version 1 of the format, this program reads 2");
        check_refused("\"width_m\"", "\"depth_m\"", "trained on the values [\"length_m\", \"depth_m\"]");
        check_refused("gamma", "gama", "unknown field `gama`");
        check_refused("ruler", "compass", "taken with a \"compass\", those of this program with a \"ruler\"");
    }

    #[test]
    fn damaged_models_say_what_is_wrong() {
        check_refused("[-1.0, 2.0]", "[-1.0]", "support_vectors[1] holds 1 values instead of 2");
        // The list is named where it begins.
        check_refused_at(20, "    [-1.0, 2.0],\n", "", "support_vectors holds 2 values instead of 3");
        check_refused("-0.5, ", "", "coefficients holds 2 values instead of 3");
        check_refused("-0.5, ", "-0.4, ", "sum of the coefficients");
        check_refused("-0.5, ", "nan, ", "coefficient 1 = NaN");
        check_refused("[-1.0, 2.0]", "[-1.0, inf]", "width_m of support vector 1 = inf");
        check_refused("deviations = [1e-7,", "deviations = [0.0,", "deviation of length_m = 0");
        check_refused("gamma = 0.1078", "gamma = -1.0", "gamma = -1 is outside");
        check_refused("nu = 0.0377", "nu = 0.0", "nu = 0 is outside");
    }

    #[test]
    fn a_model_cut_off_anywhere_is_no_model() {
        let text = model().to_toml();
        for end in 0..text.trim_end().len() {
            let cut = SvmModel::from_toml(&text[..end], model().features, &model().describer);
            assert!(cut.is_err(), "{}", &text[..end]);
        }
    }
}
