//! Odds of road users calibrated for recorded scans.

use std::str::FromStr;

use detector::classify::road_user_forests::RoadUserForests;
use detector::road_user::RoadUser;

/// Correction of the log odds of a class that a model learned on simulated streets: they are multiplied by `slope`, then
/// `offset` is added. On recorded scans fewer objects that look like vehicles or people are some, so the odds are too high.
///
/// Platt 1999, *Probabilistic outputs for support vector machines and comparisons to regularized likelihood methods*,
/// applied to the reports of a detector.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelOdds {
    /// The model, by the name in its file.
    pub model: String,
    /// The class.
    pub road_user: RoadUser,
    /// Above 0.
    pub slope: f32,
    /// In log odds.
    pub offset: f32,
}

impl ModelOdds {
    /// `forests` of `model`, each with the correction in `all` for it, if there is one.
    pub fn applied<const D: usize>(
        all: &[Self],
        model: &str,
        forests: RoadUserForests<D>,
    ) -> RoadUserForests<D> {
        forests.changed(|road_user, forest| {
            match all.iter().find(|it| it.model == model && it.road_user == road_user) {
                Some(odds) => forest.rescaled(odds.slope, odds.offset),
                None => forest,
            }
        })
    }

    /// Whether both correct the same odds.
    pub fn is_of_same(&self, other: &Self) -> bool {
        (&self.model, self.road_user) == (&other.model, other.road_user)
    }
}

impl std::fmt::Display for ModelOdds {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}.{}={},{}", self.model, self.road_user.in_plural(), self.slope, self.offset)
    }
}

impl FromStr for ModelOdds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = text.split_once('=').and_then(|(name, numbers)| {
            let (model, class) = name.split_once('.')?;
            let road_user = RoadUser::ALL.into_iter().find(|it| it.in_plural() == class)?;
            let (slope, offset) = numbers.split_once(',')?;
            let number = |it: &str| it.parse::<f32>().ok().filter(|it| it.abs() <= MOST);
            Some(Self { model: model.to_owned(), road_user, slope: number(slope)?, offset: number(offset)? })
        });
        let expected = || {
            let classes = RoadUser::ALL.map(RoadUser::in_plural).join(", ");
            format!(
                "expected MODEL.CLASS=SLOPE,OFFSET with one of {classes}, a slope above 0, and both up to {MOST}"
            )
        };
        parsed.filter(|it| it.slope > 0.0).ok_or_else(expected)
    }
}

/// Numbers beyond this are taken for typing errors.
const MOST: f32 = 20.0;

#[cfg(test)]
mod tests {
    use super::*;
    use detector::classify::forest::Forest;

    #[test]
    fn what_is_printed_is_read_back_and_nonsense_is_refused() {
        let odds = ModelOdds {
            model: "kd-tree-tree".to_owned(),
            road_user: RoadUser::Cyclist,
            slope: 1.5,
            offset: -1.15,
        };
        assert_eq!(odds.to_string(), "kd-tree-tree.cyclists=1.5,-1.15");
        assert_eq!(odds.to_string().parse(), Ok(odds));
        for text in [
            "groupings",
            "groupings=1.5,-1",
            "groupings.vehicle=1.5,-1",
            "groupings.vehicles=1.5",
            "groupings.vehicles=0,1",
            "groupings.vehicles=-1,1",
            "groupings.vehicles=NaN,0",
            "groupings.vehicles=1,99",
        ] {
            assert!(text.parse::<ModelOdds>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_forest_keeps_its_odds_unless_there_are_some_for_it() {
        let always = |it: f32| Forest::<3>::new(Vec::new(), it).unwrap();
        let forests =
            RoadUserForests { vehicles: always(2.0), pedestrians: Some(always(2.0)), cyclists: None };
        let all = ["groupings.pedestrians=1.5,-2".parse().unwrap()];
        let bases = |model: &str| {
            let applied = ModelOdds::applied(&all, model, forests.clone());
            [Some(applied.vehicles), applied.pedestrians].map(|it| it.unwrap().base())
        };
        assert_eq!((bases("groupings"), bases("clusters")), ([2.0, 1.0], [2.0, 2.0]));
    }
}
