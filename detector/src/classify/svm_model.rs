//! A trained classifier as a file.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use serde::Deserialize;

use super::support_lists::{FINITE_NUMBERS, SupportLists, split_lists, write_lists};
use super::svm_model_error::SvmModelError;
use crate::describe::trained_file::{AtLine, Provenance, head_and_provenance, line_of, read_file};

/// What the file calls itself.
const FORMAT: &str = "scanbench nu-svm";
/// Of the format; other versions are refused.
const VERSION: i64 = 2;

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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    n_support_vectors: usize,
    describer: String,
    made: Provenance,
    svm: HeadTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HeadTable {
    gamma: f32,
    nu: f64,
    rho: f32,
    features: Vec<String>,
    means: Vec<f32>,
    deviations: Vec<f32>,
}

/// A value of the head that cannot be used, and where it stands.
struct Refused {
    keys: &'static [&'static str],
    element_idx: Option<usize>,
    problem: SvmModelError,
}

impl<const D: usize> SvmModel<D> {
    /// A model that decides about `features` taken with `describer`, from the text that [`Self::to_toml`] gives.
    ///
    /// All of it is TOML. The two long lists at its end are read line by line, as they are written: that takes milliseconds
    /// where a parser of TOML takes a good part of a second.
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
        let (head_text, list_text) = split_lists(text);
        let head: Head = read_file(head_text, FORMAT, VERSION)
            .map_err(|it| AtLine { line: it.line, problem: SvmModelError::File(it.problem) })?;
        let n_support_vectors = head.n_support_vectors;
        let head = Self::of_head(head, features, describer).map_err(|refused| AtLine {
            line: line_of(head_text, refused.keys, refused.element_idx),
            problem: refused.problem,
        })?;
        let n_lines_before = head_text.bytes().filter(|&byte| byte == b'\n').count();
        let lists = SupportLists::read(list_text, n_lines_before, &features)?;
        lists.check(n_support_vectors)?;
        Ok(Self { coefficients: lists.coefficients, support_vectors: lists.support_vectors, ..head })
    }

    /// The model without its lists.
    fn of_head(head: Head, features: [&'static str; D], describer: &str) -> Result<Self, Refused> {
        let Head { made, svm, n_support_vectors, .. } = head;
        if svm.features != features {
            let problem = SvmModelError::Features { found: svm.features, expected: features.to_vec() };
            return Err(Refused { keys: &["svm", "features"], element_idx: None, problem });
        }
        if head.describer != describer {
            let expected = describer.to_owned();
            let problem = SvmModelError::Describer { found: head.describer, expected };
            return Err(Refused { keys: &["describer"], element_idx: None, problem });
        }
        let column = |values: Vec<f32>, keys: &'static [&'static str]| {
            array(values, keys[1]).map_err(|problem| Refused { keys, element_idx: None, problem })
        };
        let model = Self {
            made,
            describer: head.describer,
            gamma: svm.gamma,
            nu: svm.nu,
            rho: svm.rho,
            features,
            means: column(svm.means, MEANS)?,
            deviations: column(svm.deviations, DEVIATIONS)?,
            coefficients: Vec::new(),
            support_vectors: Vec::new(),
        };
        model.validate_head(n_support_vectors)?;
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
        write_lists(&mut text, &self.coefficients, &self.support_vectors);
        text
    }

    fn validate_head(&self, n_support_vectors: usize) -> Result<(), Refused> {
        within(&["n_support_vectors"], n_support_vectors as f64, 1.0..=f64::MAX, "1 and more")?;
        within(&["svm", "gamma"], self.gamma.into(), 1e-6..=1e6, "0.000001 to 1000000")?;
        within(&["svm", "nu"], self.nu, f64::MIN_POSITIVE..=1.0, "0 (exclusive) to 1")?;
        within(&["svm", "rho"], self.rho.into(), FINITE, FINITE_NUMBERS)?;
        let positive = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
        for (value_idx, deviation) in self.deviations.into_iter().enumerate() {
            within(DEVIATIONS, deviation.into(), positive.clone(), "the positive numbers").map_err(|it| {
                it.of_element(value_idx, format!("deviation of {}", self.features[value_idx]))
            })?;
        }
        for (value_idx, mean) in self.means.into_iter().enumerate() {
            within(MEANS, mean.into(), FINITE, FINITE_NUMBERS)
                .map_err(|it| it.of_element(value_idx, format!("mean of {}", self.features[value_idx])))?;
        }
        Ok(())
    }
}

const MEANS: &[&str] = &["svm", "means"];
const DEVIATIONS: &[&str] = &["svm", "deviations"];
const FINITE: RangeInclusive<f64> = -3.4e38..=3.4e38;

/// Refuses what `keys` lead to unless it is within `range`.
fn within(
    keys: &'static [&'static str],
    value: f64,
    range: RangeInclusive<f64>,
    allowed: &'static str,
) -> Result<(), Refused> {
    if range.contains(&value) {
        return Ok(());
    }
    let problem = SvmModelError::OutOfRange { name: keys[keys.len() - 1].to_owned(), value, allowed };
    Err(Refused { keys, element_idx: None, problem })
}

impl Refused {
    /// The same of an element of the list, which has a name of its own.
    fn of_element(mut self, element_idx: usize, element_name: String) -> Self {
        if let SvmModelError::OutOfRange { name, .. } = &mut self.problem {
            *name = element_name;
        }
        Self { element_idx: Some(element_idx), ..self }
    }
}

fn array<const D: usize>(values: Vec<f32>, list: &str) -> Result<[f32; D], SvmModelError> {
    values.try_into().map_err(|values: Vec<f32>| SvmModelError::Length {
        list: list.to_owned(),
        found: values.len(),
        expected: D,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::paper_features::PaperFeatures;

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

    #[test]
    fn blanks_and_the_line_ends_of_other_systems_change_nothing() {
        let model = model();
        let text = model.to_toml().replace('\n', "\r\n").replace("    [", "[") + "\r\n\r\n";
        assert_eq!(SvmModel::from_toml(&text, model.features, &model.describer).unwrap(), model);
    }

    #[test]
    fn the_lists_are_those_that_a_parser_of_toml_finds() {
        let text = include_str!("../params/paper_model/model.toml");
        let document: toml::Table = text.parse().unwrap();
        let floats = |value: &toml::Value| -> Vec<f32> {
            value.as_array().unwrap().iter().map(|it| it.as_float().unwrap() as f32).collect()
        };
        let svm = &document["svm"];
        let (_, lists) = split_lists(text);
        let lists = SupportLists::read(lists, 0, &PaperFeatures::NAMES).unwrap();
        assert_eq!(lists.coefficients, floats(&svm["coefficients"]));
        let rows: Vec<Vec<f32>> = svm["support_vectors"].as_array().unwrap().iter().map(floats).collect();
        assert!(lists.support_vectors.iter().map(|it| it.to_vec()).eq(rows.iter().cloned()));
        assert_eq!(Some(rows.len() as i64), document["n_support_vectors"].as_integer());
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
        check_refused(
            "version = 2",
            "version = 1",
            "the format has version 1, but this program reads version 2",
        );
        check_refused("\"width_m\"", "\"depth_m\"", "trained on the features [\"length_m\", \"depth_m\"]");
        check_refused("gamma", "gama", "unknown field `gama`");
        check_refused(
            "ruler",
            "compass",
            "computed with a \"compass\", but this program computes them with a \"ruler\"",
        );
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
        check_refused("gamma = 0.1078", "gamma = -1.0", "gamma = -1 is not within");
        check_refused("nu = 0.0377", "nu = 0.0", "nu = 0 is not within");
        check_refused("2.0],", "two],", "\"two\" in support_vectors[1] is not a number");
        check_refused("[1.5, ", "[1.5 ", "\"1.5 -0.5\" in coefficients is not a number");
        check_refused(
            "    [-1.0, 2.0],",
            "    -1.0, 2.0,",
            "expected [a support vector], or ], found \"-1.0, 2.0\"",
        );
        check_refused(
            "support_vectors = [",
            "support = [",
            "expected support_vectors = [, found \"support = [\"",
        );
        let text = model().to_toml() + "more = 1\n";
        let error = SvmModel::from_toml(&text, model().features, &model().describer).unwrap_err();
        assert_eq!(error.to_string(), "line 24: expected the end, found \"more = 1\"");
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
