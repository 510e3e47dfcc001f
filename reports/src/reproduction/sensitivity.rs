//! Rates over joint settings of values that no paper states.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::numbers::rank_correlation::rank_correlation_within;

/// The settings, and the rates under each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivity {
    /// The values that were set.
    pub values: Vec<SetValue>,
    /// The values of each setting as they are written, in the order of `values`.
    pub settings: Vec<Vec<String>>,
    /// The rates, each under all settings.
    pub rates: Vec<SetRate>,
    /// The seed of the draw.
    pub seed: u64,
    /// The scans, in words.
    pub scans: String,
}

/// A value that was set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetValue {
    /// The parameter.
    pub parameter: String,
    /// The statement of the papers about it.
    pub said: String,
    /// Its range, in words.
    pub range: String,
    /// Its value in good faith.
    pub chosen: String,
}

/// A rate under all settings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetRate {
    /// Task and rate.
    pub name: String,
    /// The detector that is to lead.
    pub method: String,
    /// Its rate under each setting; `None` where it is undefined.
    pub of_method: Vec<Option<f64>>,
    /// Its rival.
    pub rival: String,
    /// The rate of the rival under each setting, by the same criterion.
    pub of_rival: Vec<Option<f64>>,
}

impl SetRate {
    /// Number of settings under which the method leads, and number of those where both rates are known.
    pub fn n_leading(&self) -> [usize; 2] {
        self.n_leading_among(0..self.of_method.len())
    }

    /// The numbers of [`Self::n_leading`] among the settings at these indices.
    pub fn n_leading_among(&self, settings: impl IntoIterator<Item = usize>) -> [usize; 2] {
        let leads = |idx: usize| Some(self.of_method[idx]? > self.of_rival[idx]?);
        let known: Vec<bool> = settings.into_iter().filter_map(leads).collect();
        [known.iter().filter(|it| **it).count(), known.len()]
    }

    /// Quantiles of the method's rates at these shares of all settings, 0 the lowest and 1 the highest.
    pub fn quantiles<const N: usize>(&self, shares: [f64; N]) -> Option<[f64; N]> {
        quantiles(&self.of_method, shares)
    }
}

/// Quantiles of the known `rates` at these shares, 0 the lowest and 1 the highest.
pub fn quantiles<const N: usize>(rates: &[Option<f64>], shares: [f64; N]) -> Option<[f64; N]> {
    let mut rates: Vec<f64> = rates.iter().copied().flatten().collect();
    rates.sort_by(f64::total_cmp);
    let last = rates.len().checked_sub(1)?;
    Some(shares.map(|it| rates[(it * last as f64).round() as usize]))
}

impl Sensitivity {
    /// The settings by their values that are words, such as the criterion of matching: the words, and the indices of the
    /// settings.
    pub fn by_words(&self) -> BTreeMap<String, Vec<usize>> {
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (idx, setting) in self.settings.iter().enumerate() {
            let words: Vec<&str> = setting
                .iter()
                .filter(|it| it.parse::<f64>().is_err())
                .map(|it| it.trim_matches('"'))
                .collect();
            groups.entry(words.join(", ")).or_default().push(idx);
        }
        groups
    }

    /// Spearman's rank correlation of the rate with each value that is a number, over the settings, each ranked among those
    /// with the same words.
    pub fn correlations(&self, rate: &SetRate) -> Vec<(String, Option<f64>)> {
        let groups = self.by_words();
        let of_value = |(idx, value): (usize, &SetValue)| {
            let is_known = |it: &&usize| rate.of_method[**it].is_some();
            let pair = |it: &usize| Some((self.settings[*it][idx].parse().ok()?, rate.of_method[*it]?));
            let of_group = |it: &Vec<usize>| it.iter().filter(is_known).map(pair).collect();
            let groups: Option<Vec<Vec<(f64, f64)>>> = groups.values().map(of_group).collect();
            let groups = groups?;
            Some((value.parameter.clone(), rank_correlation_within(groups.iter().map(Vec::as_slice))))
        };
        self.values.iter().enumerate().filter_map(of_value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate() -> SetRate {
        SetRate {
            name: "objects".to_owned(),
            method: "paper".to_owned(),
            of_method: vec![Some(0.5), Some(0.3), None, Some(0.9)],
            rival: "kd-tree".to_owned(),
            of_rival: vec![Some(0.4), Some(0.4), Some(0.1), Some(0.9)],
        }
    }

    #[test]
    fn who_leads_is_counted_where_both_are_known_and_what_ties_does_not_lead() {
        assert_eq!(rate().n_leading(), [1, 3]);
        assert_eq!(rate().quantiles([0.0, 0.5, 1.0]), Some([0.3, 0.5, 0.9]));
    }

    #[test]
    fn a_rate_that_grows_with_a_value_goes_with_it() {
        let value = |parameter: &str| SetValue {
            parameter: parameter.to_owned(),
            said: String::new(),
            range: String::new(),
            chosen: String::new(),
        };
        let setting = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
        let sensitivity = Sensitivity {
            values: vec![value("grows"), value("word")],
            settings: vec![
                setting("2", "\"x\""),
                setting("1", "\"x\""),
                setting("9", "y"),
                setting("3.5", "\"x\""),
            ],
            rates: vec![rate()],
            seed: 1,
            scans: String::new(),
        };
        assert_eq!(sensitivity.correlations(&rate()), [("grows".to_owned(), Some(1.0))]);
        let groups = sensitivity.by_words();
        assert_eq!(groups, BTreeMap::from([("x".to_owned(), vec![0, 1, 3]), ("y".to_owned(), vec![2])]));
        assert_eq!(rate().n_leading_among(groups["x"].clone()), [1, 3]);
        assert_eq!(rate().n_leading_among(groups["y"].clone()), [0, 0]);
    }
}
