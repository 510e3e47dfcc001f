//! Boosted trees that say which road user an object is.

use crate::classify::forest::Forest;
use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::detection::GivenClass;
use crate::road_user::{MayBe, RoadUser, RoadUserOdds};

/// A forest for each class of road users that a model knows: vehicles, and others if it was trained with them.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadUserForests<const D: usize> {
    /// The logarithm of the odds that it is a vehicle.
    pub vehicles: Forest<D>,
    /// A pedestrian.
    pub pedestrians: Option<Forest<D>>,
    /// A cyclist.
    pub cyclists: Option<Forest<D>>,
}

impl<const D: usize> RoadUserForests<D> {
    /// The forests in `file`, which look at values of these names.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if that of vehicles is missing, or if one is damaged or looks at other values.
    pub fn of(file: &ModelFile, values: [&'static str; D]) -> Result<Self, ModelFileError> {
        let known = |it: RoadUser| {
            file.has_part(it.in_plural()).then(|| file.forest(it.in_plural(), values)).transpose()
        };
        Ok(Self {
            vehicles: file.forest(RoadUser::Vehicle.in_plural(), values)?,
            pedestrians: known(RoadUser::Pedestrian)?,
            cyclists: known(RoadUser::Cyclist)?,
        })
    }

    /// `file` with these forests.
    pub fn in_file(&self, file: ModelFile, values: [&'static str; D]) -> ModelFile {
        let known = RoadUser::ALL.into_iter().filter_map(|it| Some((it, self.of_class(it)?)));
        known.fold(file, |file, (road_user, forest)| file.with_forest(road_user.in_plural(), values, forest))
    }

    /// The forest of a class; `None` if it was not trained with it.
    pub fn of_class(&self, road_user: RoadUser) -> Option<&Forest<D>> {
        match road_user {
            RoadUser::Vehicle => Some(&self.vehicles),
            RoadUser::Pedestrian => self.pedestrians.as_ref(),
            RoadUser::Cyclist => self.cyclists.as_ref(),
        }
    }

    /// These forests, each changed by `change`.
    #[must_use]
    pub fn changed(self, change: impl Fn(RoadUser, Forest<D>) -> Forest<D>) -> Self {
        Self {
            vehicles: change(RoadUser::Vehicle, self.vehicles),
            pedestrians: self.pedestrians.map(|it| change(RoadUser::Pedestrian, it)),
            cyclists: self.cyclists.map(|it| change(RoadUser::Cyclist, it)),
        }
    }

    /// The classes that its objects may be given.
    pub fn given_classes(&self) -> Vec<GivenClass> {
        let known = RoadUser::ALL.into_iter().filter(|it| self.of_class(*it).is_some());
        known.filter_map(RoadUser::given).collect()
    }

    /// The odds of an object with these values. Only those of the classes that `may_be` allows are asked for.
    pub fn odds(&self, may_be: MayBe, values: &[f32; D]) -> RoadUserOdds {
        let of_class = |it: RoadUser| {
            let forest = self.of_class(it).filter(|_| may_be.allows(it));
            forest.map_or(RoadUserOdds::NONE.of(it), |forest| forest.sum(values))
        };
        RoadUserOdds(RoadUser::ALL.map(of_class))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_that_an_object_cannot_have_or_no_forest_knows_are_not_asked_for() {
        let always = |it: f32| Forest::<2>::new(Vec::new(), it).unwrap();
        let forests =
            RoadUserForests { vehicles: always(1.0), pedestrians: Some(always(2.0)), cyclists: None };
        assert_eq!(
            forests.odds(MayBe::ALL, &[0.0; 2]),
            RoadUserOdds([1.0, 2.0, RoadUserOdds::NONE.of(RoadUser::Cyclist)])
        );
        let no_vehicle = MayBe([false, true, true]);
        assert_eq!(
            forests.odds(no_vehicle, &[0.0; 2]),
            RoadUserOdds([
                RoadUserOdds::NONE.of(RoadUser::Vehicle),
                2.0,
                RoadUserOdds::NONE.of(RoadUser::Cyclist)
            ])
        );
    }
}
