//! Criteria of single classes as benchmarks have them.

use std::collections::BTreeMap;

use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::named::named;

use super::class_rule::ClassRule;

named! {
    /// A benchmark whose criteria of classes are used: `matching.preset`. What counts, and how means are taken, is not the
    /// benchmark's: its protocol has that, where there is one.
    pub enum CriterionPreset {
        /// KITTI's object benchmark. Geiger et al. 2012.
        Kitti = "kitti",
        /// Waymo Open Dataset. Sun et al. 2020.
        Waymo = "waymo",
        /// nuScenes: the distance within which it measures the errors of boxes. Caesar et al. 2020.
        Nuscenes = "nuscenes",
        /// Argoverse 2: as nuScenes. Wilson et al. 2021.
        Argoverse2 = "argoverse2",
    }
}

impl CriterionPreset {
    /// Its rules, by class.
    pub(super) fn rules(self) -> BTreeMap<AnnotationClass, ClassRule> {
        use AnnotationClass as Class;
        let in_space = |min_iou| ClassRule {
            criterion: Some(CriterionKind::Iou3d),
            min_iou: Some(min_iou),
            ..ClassRule::default()
        };
        let by_centre = ClassRule {
            criterion: Some(CriterionKind::Centre),
            max_centre_distance_m: Some(2.0),
            ..ClassRule::default()
        };
        let small = [Class::Pedestrian, Class::Cyclist].map(|it| (it, in_space(0.5)));
        let large: &[Class] = match self {
            Self::Kitti => &[Class::Car],
            Self::Waymo => &[Class::Car, Class::Van, Class::Truck, Class::Bus],
            Self::Nuscenes | Self::Argoverse2 => {
                return Class::ALL.into_iter().map(|it| (it, by_centre)).collect();
            }
        };
        large.iter().map(|it| (*it, in_space(0.7))).chain(small).collect()
    }

    /// The benchmark, for people.
    pub fn benchmark(self) -> &'static str {
        match self {
            Self::Kitti => "KITTI's object benchmark",
            Self::Waymo => "Waymo Open Dataset",
            Self::Nuscenes => "nuScenes",
            Self::Argoverse2 => "Argoverse 2",
        }
    }
}
