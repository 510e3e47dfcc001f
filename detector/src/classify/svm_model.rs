//! A trained classifier as a file.

use std::fmt::Write as _;

use serde::Deserialize;

use crate::describe::trained_file::{Provenance, TrainedFileError, check_head, head_and_provenance};

/// What the file calls itself.
const FORMAT: &str = "scanbench nu-svm";
/// Of the format; other versions are refused.
const VERSION: i64 = 1;
/// The coefficients of both classes cancel; this share of their sum is left over by rounding.
const MAX_IMBALANCE: f64 = 1e-4;

/// A trained ν support vector classifier of `D` values.
#[derive(Debug, Clone, PartialEq)]
pub struct SvmModel<const D: usize> {
    /// What it was made of.
    pub made: Provenance,
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

impl<const D: usize> SvmModel<D> {
    /// A model that decides about `features`, from the text that [`Self::to_toml`] gives.
    ///
    /// # Errors
    ///
    /// [`SvmModelError`] if the text is no model, one of another version or for other values, or damaged.
    pub fn from_toml(text: &str, features: [&'static str; D]) -> Result<Self, SvmModelError> {
        check_head(text, FORMAT, VERSION)?;
        let File { made, svm, n_support_vectors, .. } =
            toml::from_str(text).map_err(TrainedFileError::from)?;
        if svm.features != features {
            return Err(SvmModelError::Features { found: svm.features, expected: features.to_vec() });
        }
        let rows = svm
            .support_vectors
            .into_iter()
            .zip(0..)
            .map(|(row, idx)| array(row, format!("support_vectors[{idx}]")));
        let model = Self {
            made,
            gamma: svm.gamma,
            nu: svm.nu,
            rho: svm.rho,
            features,
            means: array(svm.means, "means".to_owned())?,
            deviations: array(svm.deviations, "deviations".to_owned())?,
            coefficients: svm.coefficients,
            support_vectors: rows.collect::<Result<_, _>>()?,
        };
        model.validate(n_support_vectors)?;
        Ok(model)
    }

    /// The model as text. Numbers are written so that they come back to the bit.
    pub fn to_toml(&self) -> String {
        let n = self.support_vectors.len();
        let mut text =
            head_and_provenance((FORMAT, VERSION), &[("n_support_vectors", n.to_string())], &self.made);
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

    fn validate(&self, n_support_vectors: usize) -> Result<(), SvmModelError> {
        let counted = |list: &str, found: usize| {
            let wrong = SvmModelError::Length { list: list.to_owned(), found, expected: n_support_vectors };
            if found == n_support_vectors { Ok(()) } else { Err(wrong) }
        };
        counted("coefficients", self.coefficients.len())?;
        counted("support_vectors", self.support_vectors.len())?;
        within("n_support_vectors", n_support_vectors as f64, 1.0..=f64::MAX, "1 and more")?;
        within("gamma", self.gamma.into(), 1e-6..=1e6, "0.000001 to 1000000")?;
        within("nu", self.nu, f64::MIN_POSITIVE..=1.0, "0 (exclusive) to 1")?;
        within("rho", self.rho.into(), FINITE, "the finite numbers")?;
        for (name, deviation) in self.features.iter().zip(self.deviations) {
            let positive = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
            within(&format!("deviation of {name}"), deviation.into(), positive, "the positive numbers")?;
        }
        for (name, mean) in self.features.iter().zip(self.means) {
            within(&format!("mean of {name}"), mean.into(), FINITE, "the finite numbers")?;
        }
        for (row_idx, row) in self.support_vectors.iter().enumerate() {
            for (name, &value) in self.features.iter().zip(row) {
                let place = || format!("{name} of support vector {row_idx}");
                within(&place(), value.into(), FINITE, "the finite numbers")?;
            }
        }
        for (idx, &coefficient) in self.coefficients.iter().enumerate() {
            within(&format!("coefficient {idx}"), coefficient.into(), FINITE, "the finite numbers")?;
        }
        let sum: f64 = self.coefficients.iter().map(|&it| f64::from(it)).sum();
        let size: f64 = self.coefficients.iter().map(|&it| f64::from(it).abs()).sum();
        let balance = -MAX_IMBALANCE..=MAX_IMBALANCE;
        within("sum of the coefficients over that of their sizes", sum / size, balance, "0, but for rounding")
    }
}

const FINITE: std::ops::RangeInclusive<f64> = -3.4e38..=3.4e38;

fn within(
    name: &str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    allowed: &'static str,
) -> Result<(), SvmModelError> {
    // NaN is within nothing.
    if range.contains(&value) {
        Ok(())
    } else {
        Err(SvmModelError::OutOfRange { name: name.to_owned(), value, allowed })
    }
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
        assert_eq!(SvmModel::from_toml(&model.to_toml(), model.features).unwrap(), model);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let text = model().to_toml();
        assert!(text.contains(from), "{text}");
        let damaged = text.replacen(from, to, 1);
        let error = SvmModel::from_toml(&damaged, model().features).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }

    #[test]
    fn other_files_versions_and_values_are_named() {
        check_refused("scanbench nu-svm", "recipe", "format is \"recipe\"");
        check_refused("version = 1", "version = 2", "version 2 of the format, this program reads 1");
        check_refused("\"width_m\"", "\"depth_m\"", "trained on the values [\"length_m\", \"depth_m\"]");
        check_refused("gamma", "gama", "unknown field `gama`");
    }

    #[test]
    fn damaged_models_say_what_is_wrong() {
        check_refused("[-1.0, 2.0]", "[-1.0]", "support_vectors[1] holds 1 values instead of 2");
        check_refused("    [-1.0, 2.0],\n", "", "support_vectors holds 2 values instead of 3");
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
            assert!(SvmModel::from_toml(&text[..end], model().features).is_err(), "{}", &text[..end]);
        }
    }
}
