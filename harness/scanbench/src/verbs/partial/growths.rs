//! Objects that `scanbench partial` records as they grow.

use std::sync::Arc;

use detector::partial::decision::Choice;
use detector::partial::partial_model::PartialModel;
use evaluation::partial::growth::{Growth, GrowthModel, growths};
use evaluation::partial::model_training::APPROACHED;
use evaluation::partial::object_parts::PartsSeen;
use reports::vocabulary::partial_class::PartialClass;
use simulator::object_clouds::simulated_objects::open_simulated_objects;

use crate::cli::PartialArgs;
use crate::plumbing::failure::Failure;
use crate::verbs::partial::sets::Compared;

/// The first judged object of each class as it grows, classified by `model`.
pub fn first_growths(
    arguments: &PartialArgs,
    set: &Compared,
    model: &Arc<PartialModel>,
) -> Result<Vec<Growth>, Failure> {
    let model = GrowthModel::new(Arc::clone(model)).map_err(|error| Failure::Usage(error.into()))?;
    let (classes, choice) = if arguments.others {
        (&PartialClass::ALL[..], Choice::OrNoneOfThese)
    } else {
        (&PartialClass::LEARNT[..], Choice::OfClasses)
    };
    let seen = if arguments.drives { PartsSeen::Driven } else { PartsSeen::Uncovered };
    let options = arguments.choice.options();
    let approached = if arguments.drives {
        Some(open_simulated_objects(APPROACHED, options.part, options.n_per_class)?)
    } else {
        None
    };
    let mut found = Vec::new();
    for class in classes {
        let is_of_class = |it: &&usize| set.judged.classes()[**it] == *class;
        let Some(&object_idx) = set.judged_indices().iter().find(is_of_class) else { continue };
        let drive = approached.as_ref().and_then(|it| it.drive(object_idx));
        found.extend(growths(&*set.judged, object_idx, seen, drive, &model, choice)?);
    }
    Ok(found)
}
