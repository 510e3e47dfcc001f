//! Criteria of single classes, which have priority over that of the run.

use std::collections::BTreeMap;

use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::task::Task;

use super::class_rule::ClassRule;
use super::criterion::Criterion;
use super::criterion_preset::CriterionPreset;

/// Criteria of the tasks of classes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClassCriteria {
    by_class: BTreeMap<AnnotationClass, ClassRule>,
    preset: Option<CriterionPreset>,
}

impl ClassCriteria {
    /// These rules, by the names of classes; classes without one have that of `preset`.
    ///
    /// # Errors
    ///
    /// A sentence if a name is no class, or a value no criterion.
    pub fn new(rules: BTreeMap<String, ClassRule>, preset: Option<CriterionPreset>) -> Result<Self, String> {
        let rule = |(name, rule): (String, ClassRule)| {
            let unknown = || format!("matching.class.{name}: there is no class {name:?}");
            let class = AnnotationClass::from_name(&name).ok_or_else(unknown)?;
            match rule.problem() {
                Some(problem) => Err(format!("matching.class.{name}.{problem}")),
                None => Ok((class, rule)),
            }
        };
        let mut by_class = preset.map(CriterionPreset::rules).unwrap_or_default();
        for entry in rules.into_iter().map(rule) {
            let (class, rule) = entry?;
            by_class.insert(class, rule);
        }
        Ok(Self { by_class, preset })
    }

    /// The criterion of `task` in a run with the criterion `of_run`.
    pub fn of(&self, task: Task, of_run: Criterion) -> Criterion {
        let rule = task.class().and_then(|it| self.by_class.get(&it));
        rule.map_or(of_run, |it| it.over(of_run))
    }

    /// The benchmark that gives the classes their criteria, as far as they have none of the user.
    pub fn preset(&self) -> Option<CriterionPreset> {
        self.preset
    }

    /// The classes with a criterion of their own, in a run with the criterion `of_run`.
    pub fn all(&self, of_run: Criterion) -> impl Iterator<Item = (AnnotationClass, Criterion)> {
        self.by_class.iter().map(move |(class, rule)| (*class, rule.over(of_run)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criteria(text: &str) -> Result<ClassCriteria, String> {
        ClassCriteria::new(toml::from_str(text).expect("the text is TOML"), None)
    }

    #[test]
    fn a_class_changes_what_its_table_says() {
        let text = "[car]\nmin_iou = 0.7\n[pedestrian]\ncriterion = \"centre\"\n[bus]\ncriterion = \"bev-iou\"\nmin_iou = 0.6";
        let criteria = criteria(text).unwrap();
        let of = |class, run| criteria.of(Task::Class(class), run);
        let run = Criterion::Points { min_iou: 0.4 };
        assert_eq!(of(AnnotationClass::Car, run), Criterion::Points { min_iou: 0.7 });
        assert_eq!(of(AnnotationClass::Car, Criterion::CENTRE), Criterion::CENTRE);
        assert_eq!(of(AnnotationClass::Pedestrian, run), Criterion::CENTRE);
        assert_eq!(of(AnnotationClass::Bus, run), Criterion::BevIou { min_iou: 0.6 });
        assert_eq!(of(AnnotationClass::Van, run), run);
        assert_eq!(criteria.of(Task::Vehicles, run), run);
    }

    #[test]
    fn a_benchmark_gives_criteria_to_classes_that_have_none() {
        let mine = toml::from_str("[car]\ncriterion = \"bev-iou\"\nmin_iou = 0.6").unwrap();
        let criteria = ClassCriteria::new(mine, Some(CriterionPreset::Kitti)).unwrap();
        let of = |class| criteria.of(Task::Class(class), Criterion::POINTS);
        assert_eq!(of(AnnotationClass::Car), Criterion::BevIou { min_iou: 0.6 });
        assert_eq!(of(AnnotationClass::Cyclist), Criterion::Iou3d { min_iou: 0.5 });
        assert_eq!(of(AnnotationClass::Truck), Criterion::POINTS);
        let nuscenes = ClassCriteria::new(BTreeMap::new(), Some(CriterionPreset::Nuscenes)).unwrap();
        assert_eq!(nuscenes.of(Task::Class(AnnotationClass::Animal), Criterion::POINTS), Criterion::CENTRE);
    }

    #[test]
    fn what_is_no_class_and_no_gate_is_refused() {
        for (text, problem) in [
            ("[boat]\nmin_iou = 0.7", "there is no class \"boat\""),
            ("[car]\nmin_iou = 1.7", "matching.class.car.min_iou = 1.7 is not within 0.01 to 1"),
            ("[car]\nmax_centre_distance_m = 0.0", "= 0 is not within 0.01 to 100"),
        ] {
            assert!(criteria(text).unwrap_err().contains(problem), "{text}");
        }
    }
}
