//! Counts of true and predicted ground points, by each of the definitions in use.

use reports::rows::label_score_row::GroundCounts;
use reports::vocabulary::ground_definition::GroundDefinition;

use super::label_numbers::{class_number, is_ground};

/// Counts the points of a scan by `definition`; `labels`, heights above the sensor `z_m` and `predicted` have an entry for
/// each point.
pub fn ground_counts(
    definition: GroundDefinition,
    labels: &[u32],
    z_m: &[f32],
    predicted: &[bool],
) -> GroundCounts {
    let mut counts = GroundCounts::default();
    for ((&label, &z_m), &is_predicted) in labels.iter().zip(z_m).zip(predicted) {
        let Some(is_ground) = is_ground(definition, class_number(label), z_m) else { continue };
        let count = match (is_ground, is_predicted) {
            (true, true) => &mut counts.n_found,
            (false, true) => &mut counts.n_false,
            (true, false) => &mut counts.n_missed,
            (false, false) => &mut counts.n_others,
        };
        *count += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn points_are_counted_by_true_and_predicted_class() {
        // Road, terrain, low and high vegetation, an outlier, an unlabelled point, a building; each classified as ground and
        // as no ground.
        let labels = [40, 72, 70, 70, 1, 0, 50].map(|it| [it, it]).concat();
        let z_m = [-1.7_f32, -1.5, -1.6, 0.5, -2.0, -1.7, 1.0].map(|it| [it, it]).concat();
        let predicted: Vec<bool> = (0..14).map(|it| it % 2 == 0).collect();
        let counts = GroundDefinition::ALL.map(|it| ground_counts(it, &labels, &z_m, &predicted));
        let of = |n_ground, n_others| GroundCounts {
            n_found: n_ground,
            n_false: n_others,
            n_missed: n_ground,
            n_others,
        };
        assert_eq!(counts, [of(3, 2), of(2, 1), of(2, 4)]);
    }

    proptest! {
        #[test]
        fn truth_fed_back_has_neither_false_nor_missed_points(
            points in prop::collection::vec((prop::sample::select(vec![0_u32, 1, 10, 40, 48, 70, 72]), -3.0_f32..3.0), 0..50),
        ) {
            let (labels, z_m): (Vec<u32>, Vec<f32>) = points.into_iter().unzip();
            for definition in GroundDefinition::ALL {
                let is_predicted = |(&it, &z_m): (&u32, &f32)| is_ground(definition, it as u16, z_m) == Some(true);
                let predicted: Vec<bool> = labels.iter().zip(&z_m).map(is_predicted).collect();
                let counts = ground_counts(definition, &labels, &z_m, &predicted);
                prop_assert_eq!((counts.n_false, counts.n_missed), (0, 0));
            }
        }
    }
}
