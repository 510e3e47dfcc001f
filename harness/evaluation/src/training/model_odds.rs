//! Odds of vehicles calibrated for recorded scans.

use std::str::FromStr;

use detector::classify::forest::Forest;

/// Correction of the log odds of a vehicle that a model learned on simulated streets: they are multiplied by `slope`, then
/// `offset` is added. On recorded scans fewer objects that look like vehicles are vehicles, so the odds are too high.
///
/// Platt 1999, *Probabilistic outputs for support vector machines and comparisons to regularized likelihood methods*,
/// applied to the reports of a detector.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelOdds {
    /// The model, by the name in its file.
    pub model: String,
    /// Above 0.
    pub slope: f32,
    /// In log odds.
    pub offset: f32,
}

impl ModelOdds {
    /// The vehicle forest of `model`, with the correction in `all` for this model, if there is one.
    pub fn applied<const D: usize>(all: &[Self], model: &str, forest: Forest<D>) -> Forest<D> {
        match all.iter().find(|it| it.model == model) {
            Some(odds) => forest.rescaled(odds.slope, odds.offset),
            None => forest,
        }
    }
}

impl std::fmt::Display for ModelOdds {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}={},{}", self.model, self.slope, self.offset)
    }
}

impl FromStr for ModelOdds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = text.split_once('=').and_then(|(model, numbers)| {
            let (slope, offset) = numbers.split_once(',')?;
            let number = |it: &str| it.parse::<f32>().ok().filter(|it| it.abs() <= MOST);
            Some(Self { model: model.to_owned(), slope: number(slope)?, offset: number(offset)? })
        });
        let expected = || format!("expected MODEL=SLOPE,OFFSET with a slope above 0, and both up to {MOST}");
        parsed.filter(|it| it.slope > 0.0).ok_or_else(expected)
    }
}

/// Numbers beyond this are taken for typing errors.
const MOST: f32 = 20.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_is_read_back_and_nonsense_is_refused() {
        let odds = ModelOdds { model: "kd-tree-tree".to_owned(), slope: 1.5, offset: -1.15 };
        assert_eq!(odds.to_string(), "kd-tree-tree=1.5,-1.15");
        assert_eq!(odds.to_string().parse(), Ok(odds));
        for text in [
            "groupings",
            "groupings=1.5",
            "groupings=0,1",
            "groupings=-1,1",
            "groupings=NaN,0",
            "groupings=1,99",
        ] {
            assert!(text.parse::<ModelOdds>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_forest_keeps_its_odds_unless_there_are_some_for_its_model() {
        let forest = Forest::<3>::new(Vec::new(), 2.0).unwrap();
        let all = ["groupings=1.5,-1".parse().unwrap()];
        let base = |model: &str| ModelOdds::applied(&all, model, forest.clone()).base();
        assert_eq!((base("groupings"), base("clusters")), (2.0, 2.0));
    }
}
