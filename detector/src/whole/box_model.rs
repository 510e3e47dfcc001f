//! Boosted trees that predict the box of a whole road user.

use std::sync::{Arc, LazyLock};

use crate::classify::forest::Forest;
use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::describe::trained_file::Provenance;
use crate::road_user::RoadUser;
use crate::whole::box_values::{BOX_VALUES, N_BOX_VALUES};

/// Kind of the model in its file.
const BOX_MODEL: &str = "boxes";
/// Number of the sides that a whole may reach beyond its seen part at.
pub const N_GROWTHS: usize = 5;

/// The forests that predict the box of a whole road user. All but the first see whether it is turned.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxModel {
    /// The logarithm of the odds that it is longer along the width of its seen part.
    pub turned: Forest<N_BOX_VALUES>,
    /// How far it reaches beyond its seen part, in metres: at the near end, the far end, the near side, the far side and the
    /// top.
    pub growth_m: [Forest<N_BOX_VALUES>; N_GROWTHS],
    /// The logarithm of the odds that its front is the end that is farther away.
    pub away: Forest<N_BOX_VALUES>,
    /// The logarithm of the odds that the box predicted by the others has a volume IoU with the annotated box that KITTI asks
    /// for: at least 0.7 for vehicles, 0.5 for others.
    pub right: Forest<N_BOX_VALUES>,
}

/// The models of each class of road users. Those of a class that is not known have the boxes of what is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxModels {
    /// Of vehicles.
    pub vehicles: BoxModel,
    /// Of pedestrians.
    pub pedestrians: Option<BoxModel>,
    /// Of cyclists.
    pub cyclists: Option<BoxModel>,
}

impl BoxModels {
    /// The models that come with the program, trained on simulated streets. They are read when they are first asked for, and
    /// once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<BoxModels>> = LazyLock::new(|| {
            let models = BoxModels::from_bytes(include_bytes!("../params/boxes.model"));
            Arc::new(models.expect("the embedded file is tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// Models from the content of their file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let file = ModelFile::from_bytes(bytes, BOX_MODEL, &toml::Table::new())?;
        let known = |it: RoadUser| {
            let [turned, ..] = names_of(it);
            file.has_part(turned).then(|| BoxModel::of(&file, it)).transpose()
        };
        Ok(Self {
            vehicles: BoxModel::of(&file, RoadUser::Vehicle)?,
            pedestrians: known(RoadUser::Pedestrian)?,
            cyclists: known(RoadUser::Cyclist)?,
        })
    }

    /// Their file.
    pub fn to_file(&self, made: Provenance) -> ModelFile {
        let file = ModelFile::new(BOX_MODEL, made, toml::Table::new());
        let known = RoadUser::ALL.into_iter().filter_map(|it| Some((it, self.of_class(it)?)));
        known.fold(file, |file, (road_user, model)| model.in_file(file, road_user))
    }

    /// The model of a class; `None` if there is none.
    pub fn of_class(&self, road_user: RoadUser) -> Option<&BoxModel> {
        match road_user {
            RoadUser::Vehicle => Some(&self.vehicles),
            RoadUser::Pedestrian => self.pedestrians.as_ref(),
            RoadUser::Cyclist => self.cyclists.as_ref(),
        }
    }
}

impl BoxModel {
    fn of(file: &ModelFile, road_user: RoadUser) -> Result<Self, ModelFileError> {
        let forest = |name| file.forest(name, BOX_VALUES);
        let [turned, near_end, far_end, near_side, far_side, top, away, right] = names_of(road_user);
        let growth_m =
            [forest(near_end)?, forest(far_end)?, forest(near_side)?, forest(far_side)?, forest(top)?];
        Ok(Self { turned: forest(turned)?, growth_m, away: forest(away)?, right: forest(right)? })
    }

    fn in_file(&self, file: ModelFile, road_user: RoadUser) -> ModelFile {
        let Self { turned, growth_m, away, right } = self;
        let forests = std::iter::once(turned).chain(growth_m).chain([away, right]);
        let named = names_of(road_user).into_iter().zip(forests);
        named.fold(file, |file, (name, forest)| file.with_forest(name, BOX_VALUES, forest))
    }
}

/// The names of the forests of a class in files: whether it is turned, the growths, whether its front is away, and whether
/// the box is right.
fn names_of(road_user: RoadUser) -> [&'static str; N_GROWTHS + 3] {
    match road_user {
        RoadUser::Vehicle => {
            ["turned", "near end", "far end", "near side", "far side", "top", "away", "right"]
        }
        RoadUser::Pedestrian => [
            "pedestrian turned",
            "pedestrian near end",
            "pedestrian far end",
            "pedestrian near side",
            "pedestrian far side",
            "pedestrian top",
            "pedestrian away",
            "pedestrian right",
        ],
        RoadUser::Cyclist => [
            "cyclist turned",
            "cyclist near end",
            "cyclist far end",
            "cyclist near side",
            "cyclist far side",
            "cyclist top",
            "cyclist away",
            "cyclist right",
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_model_comes_back_from_its_file() {
        let shipped = BoxModels::shipped();
        let bytes = shipped.to_file(Provenance::default()).to_bytes();
        assert_eq!(BoxModels::from_bytes(&bytes).as_ref(), Ok(&*shipped));
    }
}
