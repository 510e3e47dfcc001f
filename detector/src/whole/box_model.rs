//! Boosted trees that predict the box of a whole vehicle.

use std::sync::{Arc, LazyLock};

use crate::classify::forest::Forest;
use crate::classify::model_file::{ModelFile, ModelFileError};
use crate::describe::trained_file::Provenance;
use crate::whole::box_values::{BOX_VALUES, N_BOX_VALUES};

/// Kind of the model in its file.
const BOX_MODEL: &str = "boxes";
/// The forests in it.
const TURNED: &str = "turned";
const GROWTH: [&str; 5] = ["near end", "far end", "near side", "far side", "top"];
const AWAY: &str = "away";
const RIGHT: &str = "right";

/// The forests that predict the box of a whole vehicle. All but the first see whether it is turned.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxModel {
    /// The logarithm of the odds that it is longer along the width of its seen part.
    pub turned: Forest<N_BOX_VALUES>,
    /// How far it reaches beyond its seen part, in metres: at the near end, the far end, the near side, the far side and the
    /// top.
    pub growth_m: [Forest<N_BOX_VALUES>; 5],
    /// The logarithm of the odds that its front is the end that is farther away.
    pub away: Forest<N_BOX_VALUES>,
    /// The logarithm of the odds that the box predicted by the others has a volume IoU of at least 0.7 with the annotated
    /// box.
    pub right: Forest<N_BOX_VALUES>,
}

impl BoxModel {
    /// The model that comes with the program, trained on simulated streets. It is read when it is first asked for, and once.
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: LazyLock<Arc<BoxModel>> = LazyLock::new(|| {
            let model = BoxModel::from_bytes(include_bytes!("../params/boxes.model"));
            Arc::new(model.expect("the embedded file is tested"))
        });
        Arc::clone(&SHIPPED)
    }

    /// A model from the content of its file.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if it is of another kind or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let file = ModelFile::from_bytes(bytes, BOX_MODEL, &toml::Table::new())?;
        let forest = |name| file.forest(name, BOX_VALUES);
        let [near_end, far_end, near_side, far_side, top] = GROWTH;
        let growth_m =
            [forest(near_end)?, forest(far_end)?, forest(near_side)?, forest(far_side)?, forest(top)?];
        Ok(Self { turned: forest(TURNED)?, growth_m, away: forest(AWAY)?, right: forest(RIGHT)? })
    }

    /// Its file.
    pub fn to_file(&self, made: Provenance) -> ModelFile {
        let mut file = ModelFile::new(BOX_MODEL, made, toml::Table::new());
        file = file.with_forest(TURNED, BOX_VALUES, &self.turned);
        for (name, forest) in GROWTH.into_iter().zip(&self.growth_m) {
            file = file.with_forest(name, BOX_VALUES, forest);
        }
        file.with_forest(AWAY, BOX_VALUES, &self.away).with_forest(RIGHT, BOX_VALUES, &self.right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_model_comes_back_from_its_file() {
        let shipped = BoxModel::shipped();
        let bytes = shipped.to_file(Provenance::default()).to_bytes();
        assert_eq!(BoxModel::from_bytes(&bytes).as_ref(), Ok(&*shipped));
    }
}
