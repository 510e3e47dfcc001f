//! Whether a result of `scanbench partial` is as good as the one that was accepted.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::partial_study::object_draws::PartialMetric;
use crate::run_folder::partial_archive::PartialArchive;
use crate::verdicts::comparability::NotComparable;
use crate::verdicts::finding::Finding;
use crate::verdicts::partial_difference::{
    ChangedPrediction, PartialDifference, changed_predictions, check_comparable_results, differences,
    rows_of_curves,
};
use crate::verdicts::tolerances::DriftRule;
use crate::verdicts::verdict::Conclusion;

/// How much worse a result may become.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartialTolerances {
    /// Of the mean of recalls, at any step.
    pub mean_recall: f64,
    /// Of the share of strangers that is rejected.
    pub strangers_rejected: f64,
    /// Of the share of known objects that is rejected.
    pub known_rejected: f64,
    /// What becomes of a result that is no worse but not the same.
    pub drift: DriftRule,
}

/// The built-in tolerances as a file.
pub const BUILT_IN_TOLERANCES: &str = include_str!("partial_tolerances.toml");

/// Why tolerances cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PartialTolerancesError {
    /// The file cannot be read.
    #[error("cannot read the tolerances {path:?}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not what it should be; the source says at which line.
    #[error("the tolerances {path:?} of partial clouds cannot be used")]
    Toml {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: toml::de::Error,
    },
    /// A number that is no share.
    #[error("the tolerances {path:?} have {name} = {value}, which is not within 0 to 1")]
    Range {
        /// The file.
        path: PathBuf,
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
    },
}

impl PartialTolerances {
    /// Those that come with the program.
    pub fn built_in() -> Self {
        toml::from_str(BUILT_IN_TOLERANCES).expect("the embedded file is tested")
    }

    /// Those in the file at `path`.
    ///
    /// # Errors
    ///
    /// [`PartialTolerancesError`] if it cannot be read, a number is missing or unknown, or none is a share.
    pub fn read(path: &Path) -> Result<Self, PartialTolerancesError> {
        let path = path.to_path_buf();
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(source) => return Err(PartialTolerancesError::Read { path, source }),
        };
        let read: Self = match toml::from_str(&text) {
            Ok(read) => read,
            Err(source) => return Err(PartialTolerancesError::Toml { path, source }),
        };
        let is_bad = |it: &PartialMetric| !(0.0..=1.0).contains(&read.of(*it));
        match PartialMetric::ALL.into_iter().find(is_bad) {
            Some(metric) => {
                Err(PartialTolerancesError::Range { path, name: metric.id(), value: read.of(metric) })
            }
            None => Ok(read),
        }
    }

    /// How much worse `metric` may become.
    pub fn of(&self, metric: PartialMetric) -> f64 {
        match metric {
            PartialMetric::MeanRecall => self.mean_recall,
            PartialMetric::StrangersRejected => self.strangers_rejected,
            PartialMetric::KnownRejected => self.known_rejected,
        }
    }
}

/// The result of a gate.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialVerdict {
    /// What was done, in words.
    pub title: String,
    /// Every number, with what its difference means.
    pub findings: Vec<(PartialDifference, Finding)>,
    /// Objects whose predicted class changed.
    pub drift: Vec<ChangedPrediction>,
    /// What it was judged by.
    pub tolerances: PartialTolerances,
}

impl PartialVerdict {
    /// What it comes to.
    pub fn conclusion(&self) -> Conclusion {
        if self.n(Finding::Regression) > 0 {
            Conclusion::Regression
        } else {
            Conclusion::without_loss(!self.drift.is_empty(), self.tolerances.drift)
        }
    }

    /// How many numbers are worse than tolerated, whether or not that may be chance.
    pub fn n_worse(&self) -> usize {
        self.n(Finding::Regression) + self.n(Finding::Inconclusive)
    }

    /// Number of numbers with this finding.
    pub fn n(&self, finding: Finding) -> usize {
        self.findings.iter().filter(|it| it.1 == finding).count()
    }
}

/// Judges `after` by `before`.
///
/// # Errors
///
/// [`NotComparable`] if they are not of the same parts of the same objects, or a method is missing.
pub fn judge_partial(
    before: &PartialArchive,
    after: &PartialArchive,
    tolerances: &PartialTolerances,
) -> Result<PartialVerdict, NotComparable> {
    check_comparable_results(before, after)?;
    let later = rows_of_curves(after);
    let finding = |it: PartialDifference| {
        let finding = Finding::of(it.worsening(), it.sure_worsening(), tolerances.of(it.metric));
        (it, finding)
    };
    let of_curves = rows_of_curves(before);
    let found = of_curves.iter().flat_map(|(name, rows)| differences(name, rows, &later[name]));
    Ok(PartialVerdict {
        title: after.manifest.title(),
        findings: found.map(finding).collect(),
        drift: changed_predictions(before, after),
        tolerances: tolerances.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdicts::partial_difference::tests::archive;

    #[track_caller]
    fn check(n_right: usize, drift: DriftRule, expected: Conclusion) {
        let tolerances = PartialTolerances { drift, ..PartialTolerances::built_in() };
        let verdict = judge_partial(&archive(38), &archive(n_right), &tolerances).unwrap();
        assert_eq!(verdict.conclusion(), expected, "{verdict:?}");
    }

    #[test]
    fn a_sure_loss_is_a_regression_and_less_is_drift() {
        check(38, DriftRule::Fail, Conclusion::Same);
        check(30, DriftRule::Warn, Conclusion::Regression);
        check(37, DriftRule::Fail, Conclusion::Drift);
        check(40, DriftRule::Warn, Conclusion::AllowedDrift);
    }

    #[test]
    fn tolerances_are_read_and_what_makes_no_sense_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tolerances.toml");
        let built_in = BUILT_IN_TOLERANCES;
        let read = |content: &str| {
            std::fs::write(&path, content).unwrap();
            PartialTolerances::read(&path)
        };
        assert_eq!(read(built_in).unwrap(), PartialTolerances::built_in());
        let error = read(&built_in.replace("mean_recall = 0.02", "mean_recall = 2")).unwrap_err().to_string();
        assert!(error.contains("mean_recall = 2, which is not within 0 to 1"), "{error}");
        assert!(read(&built_in.replace("drift", "drfit")).is_err());
        assert!(read("").is_err() && PartialTolerances::read(&folder.path().join("no.toml")).is_err());
    }
}
