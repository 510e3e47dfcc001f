//! The rules of KITTI's evaluation of object detection: classes, difficulties, planes, and required overlaps.
//!
//! Geiger, Lenz, Urtasun: Are we ready for autonomous driving?, CVPR 2012; the development kit of the object benchmark.

use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::named::named;

named! {
    /// A class that is evaluated.
    pub enum KittiClass {
        /// Passenger cars. Vans are ignored.
        Car = "car",
        /// People on foot. People who sit are ignored.
        Pedestrian = "pedestrian",
        /// Cycles with their riders.
        Cyclist = "cyclist",
    }

    /// How hard annotations may be to find; each includes the one before.
    pub enum Difficulty {
        /// High in the image, not hidden, hardly cut off.
        Easy = "easy",
        /// Partly hidden; the benchmark ranks by it.
        Moderate = "moderate",
        /// Largely hidden.
        Hard = "hard",
    }

    /// In what boxes have to overlap.
    pub enum Plane {
        /// The image.
        Image = "2d",
        /// The ground plan.
        BirdsEye = "bev",
        /// Space.
        Volume = "3d",
    }
}

/// How much boxes have to overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Demand {
    /// As the benchmark has it.
    Strict,
    /// Less on the ground plan and in space, as many publish in addition.
    Loose,
}

/// One evaluation: class, difficulty, plane and demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Question {
    /// The class.
    pub class: KittiClass,
    /// Which annotations count.
    pub difficulty: Difficulty,
    /// The plane in which boxes have to overlap.
    pub plane: Plane,
    /// How much they have to overlap.
    pub demand: Demand,
}

/// Limits of the annotations of a difficulty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// An annotation is higher than this in the image, a detection at least as high, in pixels.
    pub min_height_px: f64,
    /// Hidden at most to this level.
    pub max_occlusion: i64,
    /// Cut off by at most this share.
    pub max_truncation: f64,
}

impl KittiClass {
    /// The class of its annotations.
    pub fn annotation_class(self) -> AnnotationClass {
        match self {
            Self::Car => AnnotationClass::Car,
            Self::Pedestrian => AnnotationClass::Pedestrian,
            Self::Cyclist => AnnotationClass::Cyclist,
        }
    }

    /// The class so similar to it that its annotations are ignored: neither to be found, nor false if they are.
    pub fn neighbor(self) -> Option<AnnotationClass> {
        match self {
            Self::Car => Some(AnnotationClass::Van),
            Self::Pedestrian => Some(AnnotationClass::SittingPerson),
            Self::Cyclist => None,
        }
    }

    /// Overlap that a match has to exceed.
    pub fn min_overlap(self, plane: Plane, demand: Demand) -> f64 {
        match (self, plane, demand) {
            (Self::Car, Plane::Image, _) | (Self::Car, _, Demand::Strict) => 0.7,
            (Self::Car, _, Demand::Loose) | (_, Plane::Image, _) | (_, _, Demand::Strict) => 0.5,
            (_, _, Demand::Loose) => 0.25,
        }
    }
}

impl Difficulty {
    /// Its limits.
    pub fn limits(self) -> Limits {
        let (min_height_px, max_occlusion, max_truncation) = match self {
            Self::Easy => (40.0, 0, 0.15),
            Self::Moderate => (25.0, 1, 0.3),
            Self::Hard => (25.0, 2, 0.5),
        };
        Limits { min_height_px, max_occlusion, max_truncation }
    }
}

impl Question {
    /// All different questions: in the image both demands are the same.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for plane in Plane::ALL {
            let demands: &[Demand] =
                if plane == Plane::Image { &[Demand::Strict] } else { &[Demand::Strict, Demand::Loose] };
            for &demand in demands {
                for class in KittiClass::ALL {
                    let of = |difficulty| Self { class, difficulty, plane, demand };
                    all.extend(Difficulty::ALL.map(of));
                }
            }
        }
        all
    }

    /// Overlap that a match has to exceed.
    pub fn min_overlap(&self) -> f64 {
        self.class.min_overlap(self.plane, self.demand)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlaps_are_those_of_the_benchmark() {
        for plane in Plane::ALL {
            let strict = KittiClass::ALL.map(|it| it.min_overlap(plane, Demand::Strict));
            assert_eq!(strict, [0.7, 0.5, 0.5]);
        }
        let loose = |plane| KittiClass::ALL.map(|it| it.min_overlap(plane, Demand::Loose));
        assert_eq!(loose(Plane::Image), [0.7, 0.5, 0.5]);
        assert_eq!(loose(Plane::BirdsEye), [0.5, 0.25, 0.25]);
        assert_eq!(loose(Plane::Volume), [0.5, 0.25, 0.25]);
    }

    #[test]
    fn no_question_is_asked_twice() {
        let all = Question::all();
        let distinct: std::collections::BTreeSet<Question> = all.iter().copied().collect();
        assert_eq!((all.len(), distinct.len()), (45, 45));
    }
}
