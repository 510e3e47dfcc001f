//! Steps from the letter of HG and VM to a method that does as they claim, and what their rivals could have been given.

use serde::{Deserialize, Serialize};

/// What stands behind a reading of a paper; the later, the less of it is in the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// The words of the text.
    Text,
    /// Words of the text, or figures, that can be read in several ways.
    Open,
    /// A rule that is in the text of no paper.
    Ours,
    /// A rival that gets less than the method.
    RivalDenied,
}

impl Basis {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "the text",
            Self::Open => "a reading of the text",
            Self::Ours => "no text",
            Self::RivalDenied => "a weaker rival",
        }
    }
}

/// A step away from the letter. Each is taken upon those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Detector that takes this step and those before it, as tables name it.
    pub detector: &'static str,
    /// The step in a few words.
    pub name: &'static str,
    /// Section and figure that it rests on, or what it departs from.
    pub place: &'static str,
    /// What stands there, and how the step reads it.
    pub says: &'static str,
    /// What it rests on.
    pub basis: Basis,
    /// Parameters of `paper` with their values.
    pub parameters: &'static [&'static str],
}

/// The steps, those of the text first.
pub const STEPS: [Step; 4] = [
    Step {
        detector: "paper, step 1",
        name: "fewer points are enough far away",
        place: "HG 4",
        says: "Weights enrich the density of the coarse and of the dense cells far from the sensor: then the 4 to 8 points of \
               a cell that is no clutter are weighted, too.",
        basis: Basis::Open,
        parameters: &["paper.ground.fewer_far_away=true"],
    },
    Step {
        detector: "paper, step 2",
        name: "tall is measured from the terrain",
        place: "HG 3.1, VM 3",
        says: "Elevations are compared with a terrain map. The 1.40 m of tall cells are measured from the sensor, which is the \
               same on a level road only.",
        basis: Basis::Open,
        parameters: &["paper.ground.tall_over=terrain"],
    },
    Step {
        detector: "paper, step 3",
        name: "road in the cells of objects is left out",
        place: "HG figs. 1, 3, 8",
        says: "The text gives all points of a cell one class. In the figures the road around the feet of an object is not the \
               object.",
        basis: Basis::Ours,
        parameters: &["paper.foreground.clearance_m=0.15"],
    },
    Step {
        detector: "paper, step 4",
        name: "walls stand and hide what is behind them",
        place: "HG 3.1 has lines alone",
        says: "Lines among tall and short cells are walls. Here cells that are tall, or that the field of view cuts off, have \
               to stand along a line, and no ground is seen behind it.",
        basis: Basis::Ours,
        parameters: &[
            "paper.walls.as_printed=false",
            "paper.walls.min_support=0.6",
            "paper.walls.hough.min_length_cells=10",
        ],
    },
];

/// A foreground that HG's rival could have been given: the paper does not say which.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalReading {
    /// The rival with it, as tables name it.
    pub detector: &'static str,
    /// What it clusters, in words.
    pub name: &'static str,
    /// The value of `kd_tree.foreground`.
    pub foreground: &'static str,
}

/// The rivals of HG that get less than `kd-tree`, which gets short cells without those on walls: most first.
pub const RIVAL_READINGS: [RivalReading; 2] = [
    RivalReading {
        detector: "kd-tree, walls left in",
        name: "kd-tree over short cells, walls left in",
        foreground: "short",
    },
    RivalReading {
        detector: "kd-tree, all that stands",
        name: "kd-tree over all that is no ground",
        foreground: "standing",
    },
];

/// A reading in words: the last of the first `n_steps`, and the rival if it is denied something.
pub fn reading(n_steps: usize, rival: Option<&RivalReading>) -> String {
    let steps = STEPS[..n_steps].last().map(|last| match n_steps {
        1 => format!("step 1, {}", last.name),
        _ => format!("steps 1 to {n_steps}, the last: {}", last.name),
    });
    let rival = rival.map(|rival| format!("against {}", rival.name));
    steps.into_iter().chain(rival).collect::<Vec<_>>().join("; ")
}

/// What the first `n_steps` and the rival rest on together: the weakest of it.
pub fn basis(n_steps: usize, rival: Option<&RivalReading>) -> Basis {
    let steps = STEPS[..n_steps].iter().map(|step| step.basis).max().unwrap_or(Basis::Text);
    if rival.is_some() { Basis::RivalDenied } else { steps }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_the_text_come_first_and_each_has_a_name_of_its_own() {
        assert!(STEPS.iter().is_sorted_by_key(|step| step.basis));
        let mut detectors: Vec<&str> = STEPS.iter().map(|step| step.detector).collect();
        detectors.extend(RIVAL_READINGS.iter().map(|rival| rival.detector));
        let n = detectors.len();
        detectors.sort_unstable();
        detectors.dedup();
        assert_eq!(detectors.len(), n);
    }

    #[test]
    fn a_reading_names_its_steps_and_what_its_rival_is_denied() {
        assert_eq!(reading(1, None), "step 1, fewer points are enough far away");
        assert_eq!(
            reading(2, Some(&RIVAL_READINGS[0])),
            "steps 1 to 2, the last: tall is measured from the terrain; against kd-tree over short cells, walls left in"
        );
        assert_eq!(reading(0, Some(&RIVAL_READINGS[1])), "against kd-tree over all that is no ground");
        assert_eq!((basis(0, None), basis(2, None)), (Basis::Text, Basis::Open));
        assert_eq!((basis(4, None), basis(1, Some(&RIVAL_READINGS[0]))), (Basis::Ours, Basis::RivalDenied));
    }
}
