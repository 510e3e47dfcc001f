//! Numbers of KITTI's protocol, each with its name.

use super::averages::Recalls;
use super::rules::{Demand, Plane, Question};

/// Prefix of the names of the sound reading.
const SOUND: &str = "sound_";

/// The numbers that stand in short tables: of the kit, over 40 recalls, in space and on the plan, at the usual overlaps.
pub const SHORT_FORM: [&str; 6] = [
    "ap_3d_easy_r40",
    "ap_3d_moderate_r40",
    "ap_3d_hard_r40",
    "ap_bev_easy_r40",
    "ap_bev_moderate_r40",
    "ap_bev_hard_r40",
];

/// Whether a number of this name is of the sound reading.
pub fn is_sound(id: &str) -> bool {
    id.starts_with(SOUND)
}

/// Matching and mean: the development kit's or ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reading {
    /// That of the development kit, which depends on the order of files, and under which annotations fed back need not reach
    /// the maximum.
    Official,
    /// Ours, which does not, and under which they do.
    Sound,
}

/// Quantity that is averaged over recalls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Averaged {
    /// The share of the detections that are right.
    Precision,
    /// The share of the detections that are right, each weighted by how near its heading is: AOS.
    Similarity,
}

/// A number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Measure {
    /// The question.
    pub question: Question,
    /// The reading.
    pub reading: Reading,
    /// The averaged quantity.
    pub averaged: Averaged,
    /// The recalls.
    pub recalls: Recalls,
}

impl Measure {
    /// All measures of one question, in the order of tables.
    pub fn of(question: Question) -> Vec<Self> {
        let mut all = Vec::new();
        let averaged: &[Averaged] = match question.plane {
            Plane::Image => &[Averaged::Precision, Averaged::Similarity],
            Plane::BirdsEye | Plane::Volume => &[Averaged::Precision],
        };
        for &averaged in averaged {
            for recalls in Recalls::ALL {
                for reading in [Reading::Official, Reading::Sound] {
                    all.push(Self { question, reading, averaged, recalls });
                }
            }
        }
        all
    }

    /// The name used in files, without that of the class: such as `ap_3d_moderate_r40` or `sound_ap_bev_loose_easy_r11`.
    pub fn id(&self) -> String {
        let reading = match self.reading {
            Reading::Official => "",
            Reading::Sound => SOUND,
        };
        let averaged = match self.averaged {
            Averaged::Precision => format!("ap_{}", self.question.plane.name()),
            Averaged::Similarity => "aos".to_owned(),
        };
        let demand = match self.question.demand {
            Demand::Strict => "",
            Demand::Loose => "_loose",
        };
        format!("{reading}{averaged}{demand}_{}_{}", self.question.difficulty.name(), self.recalls.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::protocol::Protocol;

    #[test]
    fn names_distinguish_all_numbers_of_a_class() {
        let of_cars = Question::all().into_iter().filter(|it| it.class.name() == "car");
        let ids: Vec<String> = of_cars.flat_map(Measure::of).map(|it| it.id()).collect();
        let distinct: std::collections::BTreeSet<&String> = ids.iter().collect();
        assert_eq!((ids.len(), distinct.len()), (72, 72));
        let some = ["ap_2d_easy_r11", "aos_hard_r40", "sound_ap_bev_loose_moderate_r40"];
        let principal = Protocol::KittiObject.principal_metrics().iter().copied();
        for id in some.into_iter().chain(SHORT_FORM).chain(principal) {
            assert!(ids.iter().any(|it| it == id), "{id}");
        }
    }
}
