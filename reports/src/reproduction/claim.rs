//! The claims of the papers, as data.

use serde::{Deserialize, Serialize};

use crate::partial_study::partial_claims::PartialClaim;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::task::Task;

/// A paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Paper {
    /// Objects over a hierarchical grid.
    #[serde(rename = "HG")]
    HierarchicalGrid,
    /// Vehicles by their model.
    #[serde(rename = "VM")]
    VehicleModel,
    /// Partly seen objects, by bags of graphs.
    #[serde(rename = "BG")]
    BagOfGraphs,
}

impl Paper {
    /// All.
    pub const ALL: [Self; 3] = [Self::HierarchicalGrid, Self::VehicleModel, Self::BagOfGraphs];

    /// Its letters.
    pub fn short_name(self) -> &'static str {
        match self {
            Self::HierarchicalGrid => "HG",
            Self::VehicleModel => "VM",
            Self::BagOfGraphs => "BG",
        }
    }

    /// Authors, title and year.
    pub fn citation(self) -> &'static str {
        match self {
            Self::HierarchicalGrid => {
                "Börcs, Nagy, Benedek: Fast 3-D Urban Object Detection on Streaming Point Clouds, 2014 (HG)"
            }
            Self::VehicleModel => {
                "Börcs, Nagy, Baticz, Benedek: A Model-based Approach for Fast Vehicle Detection in Continuously Streamed \
                 Urban LIDAR Point Clouds, 2014 (VM)"
            }
            Self::BagOfGraphs => {
                "Rózsa, Szirányi: LIDAR alapú gépi látás a közlekedésben részleges pontfelhőkből, 2016 (BG)"
            }
        }
    }
}

/// A claim of a paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The paper.
    pub paper: Paper,
    /// Section, table and figure.
    pub place: String,
    /// The claim, in our words.
    pub says: String,
    /// The numbers that it prints for the claim, in words.
    pub printed: String,
    /// The test that decides it.
    pub test: ClaimTest,
}

/// Test of a claim: the condition under which it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ClaimTest {
    /// A rate of one detector is higher than that of another, surely.
    Lead {
        /// The task.
        task: Task,
        /// The rate.
        metric: RateName,
        /// The detector that is to lead.
        method: String,
        /// Its rival.
        rival: String,
        /// `every` for each data set, `overall` for all together, or part of the names of those that count.
        scenes: String,
    },
    /// The lead is greater on some data sets than on the others, surely.
    LeadsMost {
        /// The task.
        task: Task,
        /// The detector that leads.
        method: String,
        /// Its rival.
        rival: String,
        /// Parts of the names of the data sets.
        scenes: Vec<String>,
    },
    /// One detector is so many times as fast as another.
    Faster {
        /// The faster detector.
        method: String,
        /// Its rival.
        rival: String,
        /// The same rival, made faster than the paper says.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sped_up: Option<String>,
        /// How many times.
        at_least: f64,
    },
    /// One detector joins fewer objects than another.
    LessJoined {
        /// The detector that joins fewer.
        method: String,
        /// Its rival.
        rival: String,
    },
    /// Points become fewer with range.
    DensityFalls,
    /// Points divided by the weights do not become fewer with range.
    DensityEvened,
    /// The printed fitness of cell sizes has its maximum between these, within 0 and 1.
    PeakOfFitness {
        /// In metres.
        from_m: f64,
        /// In metres.
        to_m: f64,
    },
    /// The F-rate has its maximum between these cell sizes.
    PeakOfFRate {
        /// In metres.
        from_m: f64,
        /// In metres.
        to_m: f64,
    },
    /// Some steps take the longest, in this order, and another the least time.
    OrderOfSteps {
        /// Their names in the paper, longest first.
        longest: Vec<String>,
        /// The name of the other.
        shortest: String,
    },
    /// Hulls give more boxes a right heading than principal axes do.
    TurnedRight {
        /// How far they may be off.
        within_deg: f64,
    },
    /// Spheres at the front are larger than those at the back.
    FrontSpheres,
    /// Most missed objects are strongly occluded.
    MissesAreOccluded {
        /// The detector.
        method: String,
    },
    /// The method of BG does as claimed with objects of which more and more is seen.
    Partial {
        /// The claim.
        claim: PartialClaim,
    },
    /// It cannot be tested here.
    None {
        /// Why.
        because: String,
    },
}

impl ClaimTest {
    /// The condition under which a claim holds, in words; `None` if it is not tested, or not by numbers of ours.
    pub fn rule(&self) -> Option<String> {
        let cells = |[from_m, to_m]: [&f64; 2]| format!("from {from_m} to {to_m} m");
        Some(match self {
            Self::Lead { metric, method, rival, scenes, .. } => {
                let on = match scenes.as_str() {
                    "every" => "on each data set".to_owned(),
                    "overall" => "over all data sets".to_owned(),
                    part => format!("on each data set called {part}"),
                };
                let rate = metric.metric().id().replace('_', "-").replace("f-rate", "F-rate");
                format!("the {rate} of {method} is surely above that of {rival} (95 %) {on}")
            }
            Self::LeadsMost { method, rival, scenes, .. } => format!(
                "{method} surely leads {rival} by more (95 %) on each data set called {} than on any other",
                scenes.join(" or ")
            ),
            Self::Faster { method, rival, at_least, .. } => {
                format!("the median time of {rival} is at least {at_least} times that of {method}")
            }
            Self::LessJoined { method, rival } => {
                format!("under-segmentation of {method} is surely below that of {rival} (95 %)")
            }
            Self::PeakOfFitness { from_m, to_m } => {
                format!(
                    "the fitness lies within 0 and 1 and is greatest at a cell size {}",
                    cells([from_m, to_m])
                )
            }
            Self::PeakOfFRate { from_m, to_m } => {
                format!("the F-rate is greatest at a cell size {}", cells([from_m, to_m]))
            }
            Self::OrderOfSteps { longest, shortest } => {
                format!("{} take the longest, in this order, and {shortest} the least", longest.join(", "))
            }
            Self::TurnedRight { within_deg } => {
                format!("hulls turn more boxes right, within {within_deg}°, than principal axes do")
            }
            Self::DensityFalls
            | Self::DensityEvened
            | Self::FrontSpheres
            | Self::MissesAreOccluded { .. }
            | Self::Partial { .. }
            | Self::None { .. } => return None,
        })
    }
}

/// A rate in a file of claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RateName {
    /// The F-rate.
    FRate,
    /// Precision.
    Precision,
    /// Recall.
    Recall,
}

impl RateName {
    /// The metric.
    pub fn metric(self) -> Metric {
        match self {
            Self::FRate => Metric::FRate,
            Self::Precision => Metric::Precision,
            Self::Recall => Metric::Recall,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimFile {
    claim: Vec<Claim>,
}

/// All claims that we know of, in the order of the papers.
pub fn claims() -> Vec<Claim> {
    let file: ClaimFile = toml::from_str(include_str!("claims.toml")).expect("the embedded file is tested");
    file.claim
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_names_its_bounds() {
        let rule =
            |says: &str| claims().iter().find(|it| it.says.contains(says)).unwrap().test.rule().unwrap();
        assert_eq!(
            rule("clear maximum near 0.6 m"),
            "the fitness lies within 0 and 1 and is greatest at a cell size from 0.4 to 0.8 m"
        );
        assert_eq!(
            rule("connected components over a kd-tree, in every scene"),
            "the F-rate of paper is surely above that of kd-tree (95 %) on each data set"
        );
    }

    #[test]
    fn each_paper_has_claims_and_none_is_there_twice() {
        let claims = claims();
        for paper in Paper::ALL {
            assert!(claims.iter().filter(|it| it.paper == paper).count() >= 3, "{paper:?}");
        }
        for (idx, claim) in claims.iter().enumerate() {
            assert!(claims[..idx].iter().all(|it| it.says != claim.says), "{}", claim.says);
        }
    }
}
