//! Steps from the letter of HG and VM to a method that does as they claim, and readings of their rivals.

use serde::{Deserialize, Serialize};

/// The basis of a reading of a paper; the later, the less of it is in the text.
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

/// A step away from the letter, taken after those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Detector that takes this step and those before it, as tables name it.
    pub detector: &'static str,
    /// The step in a few words.
    pub name: &'static str,
    /// Section and figure that it rests on, or what it departs from.
    pub place: &'static str,
    /// The passage, and how the step reads it.
    pub says: &'static str,
    /// The basis of the step.
    pub basis: Basis,
    /// Parameters of `paper` with their values.
    pub parameters: &'static [&'static str],
}

/// The letter first, then the steps: those of the text, then others.
pub const STEPS: [Step; 5] = [
    Step {
        detector: "paper, to the letter",
        name: "to the letter",
        place: "HG 3.1",
        says: "Clutter are 5 points at every range, and a cell is tall by its height over a level road below the sensor.",
        basis: Basis::Text,
        parameters: &["paper.ground.fewer_far_away=false", "paper.ground.tall_over=level_road"],
    },
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
        detector: GOOD_FAITH,
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

/// The method read in good faith, as the program has it: the last of [`STEPS`] that the text allows.
pub const GOOD_FAITH: &str = "paper";

/// Another rival than that of HG, whose one sentence says neither what it clusters nor what is an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalReading {
    /// The rival, as tables name it.
    pub detector: &'static str,
    /// The rival in words.
    pub name: &'static str,
    /// The parameter of `kd_tree` that distinguishes it, with its value.
    pub parameter: &'static str,
}

/// The rival of HG as its library searches: the same components as those of `kd-tree`, which finds them in cells.
pub const SEARCHED_RIVAL: RivalReading = RivalReading {
    detector: "kd-tree, searched",
    name: "kd-tree, searched around every point",
    parameter: "kd_tree.neighbors=tree",
};

/// The rivals of HG that get less than `kd-tree`, which gets short cells without those on walls: most first.
pub const DENIED_RIVALS: [RivalReading; 2] = [
    RivalReading {
        detector: "kd-tree, walls left in",
        name: "kd-tree over short cells, walls left in",
        parameter: "kd_tree.foreground=short",
    },
    RivalReading {
        detector: "kd-tree, all that stands",
        name: "kd-tree over all that is no ground",
        parameter: "kd_tree.foreground=standing",
    },
];

/// Name of a reading: the method after the step at `step_idx`, and the rival if something is denied to it.
pub fn reading(step_idx: usize, rival: Option<&RivalReading>) -> String {
    let step = &STEPS[step_idx];
    let method = match step_idx {
        0 => step.name.to_owned(),
        _ if step.detector == GOOD_FAITH => "good faith".to_owned(),
        1 => format!("step 1 alone, {}", step.name),
        _ => format!("steps 1 to {step_idx}, the last: {}", step.name),
    };
    let rival = rival.map(|rival| format!("against {}", rival.name));
    [method].into_iter().chain(rival).collect::<Vec<_>>().join("; ")
}

/// The weakest basis of a step and the rival together. Good faith is the text; a method with fewer of the text's readings is
/// another reading.
pub fn basis(step_idx: usize, rival: Option<&RivalReading>) -> Basis {
    match STEPS[step_idx] {
        _ if rival.is_some() => Basis::RivalDenied,
        Step { detector: GOOD_FAITH, .. } => Basis::Text,
        Step { basis: Basis::Text, .. } => Basis::Open,
        Step { basis, .. } => basis,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_the_text_come_first_and_each_has_a_name_of_its_own() {
        assert!(STEPS.iter().is_sorted_by_key(|step| step.basis));
        let mut detectors: Vec<&str> = STEPS.iter().map(|step| step.detector).collect();
        detectors.extend(DENIED_RIVALS.iter().chain([&SEARCHED_RIVAL]).map(|rival| rival.detector));
        let n = detectors.len();
        detectors.sort_unstable();
        detectors.dedup();
        assert_eq!(detectors.len(), n);
    }

    #[test]
    fn good_faith_is_the_last_step_that_the_text_allows() {
        let last = STEPS.iter().rfind(|step| step.basis <= Basis::Open);
        assert_eq!(last.map(|step| step.detector), Some(GOOD_FAITH));
    }

    #[test]
    fn a_reading_names_its_steps_and_what_its_rival_is_denied() {
        let [walls_left_in, _] = &DENIED_RIVALS;
        assert_eq!(reading(0, None), "to the letter");
        assert_eq!(reading(1, None), "step 1 alone, fewer points are enough far away");
        assert_eq!(
            reading(2, Some(walls_left_in)),
            "good faith; against kd-tree over short cells, walls left in"
        );
        assert_eq!(reading(3, None), "steps 1 to 3, the last: road in the cells of objects is left out");
        assert_eq!(
            [0, 1, 2, 3].map(|it| basis(it, None)),
            [Basis::Open, Basis::Open, Basis::Text, Basis::Ours]
        );
        assert_eq!(basis(1, Some(walls_left_in)), Basis::RivalDenied);
    }
}
