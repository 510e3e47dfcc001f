//! The whole hierarchical detector, without each of its parts, and built up from the detector of the papers.

use std::path::{Path, PathBuf};

use reports::vocabulary::task::Task;

use crate::run::compared_detector::ComparedDetector;
use crate::run::config::override_option::OverrideOption;
use crate::run::config::{ConfigError, RunConfig, TrainedModel};
use crate::run::detector_list::{ListedDetector, PAPER};

/// Task of the ablation: the parts of the method serve to find objects of any class.
pub const TASK: Task = Task::Objects;

/// A part of the method that can be left out.
struct Part {
    /// Name of the variant without it.
    name: &'static str,
    /// Name of the variant with trees that were trained without it.
    trained: &'static str,
    /// The override that leaves it out.
    off: &'static str,
}

/// The parts, in the order of the stages.
const PARTS: [Part; 7] = [
    Part {
        name: "without terrain",
        trained: "without terrain, trained so",
        off: "hierarchical.terrain.enabled=false",
    },
    Part {
        name: "without walls",
        trained: "without walls, trained so",
        off: "hierarchical.walls.enabled=false",
    },
    Part {
        name: "without distance weighting",
        trained: "without distance weighting, trained so",
        off: "hierarchical.density_weighting.enabled=false",
    },
    Part {
        name: "without surroundings",
        trained: "without surroundings, trained so",
        off: "hierarchical.grouping.surroundings=false",
    },
    Part { name: "two rounds", trained: "two rounds, trained so", off: "hierarchical.grouping.rounds=2" },
    Part { name: "one round", trained: "one round, trained so", off: "hierarchical.grouping.rounds=1" },
    Part {
        name: "without completion",
        trained: "without completion, trained so",
        off: "hierarchical.completion.enabled=false",
    },
];

impl Part {
    /// Name of the folder with the trees that were trained without it.
    fn folder(&self) -> String {
        self.name.replace(' ', "-")
    }
}

/// No folder in `models` has the trees of a part.
#[derive(Debug, thiserror::Error)]
#[error("there is no folder of a part in {}; their names are {}", .models.display(), .names.join(", "))]
pub struct NoTrainedPart {
    models: PathBuf,
    names: Vec<String>,
}

/// The parts with a folder of trees in `models`.
///
/// # Errors
///
/// [`NoTrainedPart`] if there is none.
fn trained_parts(models: &Path) -> Result<Vec<&'static Part>, NoTrainedPart> {
    let found: Vec<&Part> = PARTS.iter().filter(|it| models.join(it.folder()).is_dir()).collect();
    if found.is_empty() {
        let names = PARTS.iter().map(Part::folder).collect();
        return Err(NoTrainedPart { models: models.to_owned(), names });
    }
    Ok(found)
}

/// Steps from the papers to the method, in the order of the stages: name of the addition to the steps above, and its
/// overrides of the detector of the papers. Overrides that end in `=` get the value of the method for the same parameter.
const STEPS: &[(&str, &[&str])] = &[
    ("and points clear of the ground", &["paper.foreground.clearance_m="]),
    (
        "and cells by the terrain",
        &[
            "paper.terrain.low_quantile=",
            "paper.ground.min_points=",
            "paper.ground.ground_band_m=",
            "paper.ground.fewer_far_away=",
            "paper.ground.low_itself=",
            "paper.ground.tall_over=",
        ],
    ),
    (
        "and walls by their support",
        &[
            "paper.walls.as_printed=",
            "paper.walls.min_support=",
            "paper.walls.hough.min_votes=",
            "paper.walls.hough.min_length_cells=",
        ],
    ),
    (
        "and smaller objects",
        &[
            "paper.cluster.min_points=",
            // Tuned on simulated streets, for objects of so few points.
            "paper.merge.max_height_difference_m=1.0",
            "paper.separation.low_density_share=0.3",
            "paper.separation.object_density_ratio=5.0",
            "paper.separation.single_gap_points=1.0",
        ],
    ),
];

/// The last step: the method without the stage that follows the best cut.
const BEST_CUT: (&str, &str) = ("and the best cut of groups", "hierarchical.completion.enabled=false");

/// Why there are no variants.
#[derive(Debug, thiserror::Error)]
pub enum AblationError {
    /// The overrides conflict with the other parameters.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// There are no trees of any part.
    #[error(transparent)]
    Models(#[from] NoTrainedPart),
}

/// `method` with the parameters of `config`; then without each of its parts in turn, also with trees that were trained so if
/// `models` has a folder of the part; then without all parts; then the detector of the papers, alone and with one after
/// another of the steps that lead from it to the method; at last the method without completion.
///
/// # Errors
///
/// [`AblationError`] if the overrides conflict with the other parameters, or `models` has no part.
pub fn variants(
    method: ListedDetector,
    config: &RunConfig,
    models: Option<&Path>,
) -> Result<Vec<ComparedDetector>, AblationError> {
    let variant = |name: &'static str, chosen: ListedDetector, switches: &[String]| {
        let switches = switches.iter().map(|it| it.parse().expect("the lists of switches are tested"));
        let switches: Vec<OverrideOption> = switches.collect();
        let config = config.overridden(&switches, &[])?;
        Ok::<_, ConfigError>(ComparedDetector { name, chosen: chosen.into(), config })
    };
    let of_parts = |off: &[&str]| off.iter().map(|it| (*it).to_owned()).collect::<Vec<_>>();
    let trained = models.map(trained_parts).transpose()?.unwrap_or_default();
    let mut variants = vec![variant("whole method", method, &[])?];
    for part in &PARTS {
        variants.push(variant(part.name, method, &of_parts(&[part.off]))?);
        if let Some(models) = models.filter(|_| trained.iter().any(|it| it.name == part.name)) {
            let directory = toml::Value::String(models.join(part.folder()).display().to_string());
            let trained = format!("{}={directory}", TrainedModel::Groupings.parameter());
            variants.push(variant(part.trained, method, &[part.off.to_owned(), trained])?);
        }
    }
    // Of the overrides of the rounds only the last one is kept.
    let all = PARTS.iter().map(|it| it.off).filter(|it| !it.ends_with("rounds=2")).collect::<Vec<_>>();
    variants.push(variant("without all of these", method, &of_parts(&all))?);
    variants.push(variant("the papers", PAPER, &[])?);
    for step_idx in 0..STEPS.len() {
        variants.push(variant(STEPS[step_idx].0, PAPER, &switches_of(&STEPS[..=step_idx], config))?);
    }
    variants.push(variant(BEST_CUT.0, method, &of_parts(&[BEST_CUT.1]))?);
    Ok(variants)
}

/// Overrides that `steps` add to the detector of the papers.
fn switches_of(steps: &[(&str, &[&str])], config: &RunConfig) -> Vec<String> {
    let of_method = |switch: &str| {
        let same = switch.strip_suffix('=')?.replacen("paper", "hierarchical", 1);
        Some(config.value_of(&same).expect("the list of steps is tested").to_string())
    };
    let switches = steps.iter().flat_map(|(_, added)| added.iter());
    switches.map(|it| format!("{it}{}", of_method(it).unwrap_or_default())).collect()
}

#[cfg(test)]
mod tests {
    use detector::params::HierarchicalParams;

    use super::*;
    use crate::run::detector_list::built_in_named;

    fn all_variants(models: Option<&Path>) -> Result<Vec<ComparedDetector>, AblationError> {
        let config = RunConfig::load(None).unwrap();
        let method = built_in_named(&["hierarchical".to_owned()], &config).unwrap()[0];
        variants(method, &config, models)
    }

    #[test]
    fn every_part_is_there_in_the_whole_and_missing_in_its_variant() {
        let variants = all_variants(None).unwrap();
        assert_eq!(variants.len(), PARTS.len() + 4 + STEPS.len());
        let whole = &variants[0];
        for (variant, part) in variants[1..].iter().zip(&PARTS) {
            assert_eq!(variant.name, part.name);
            let (parameter, off) = part.off.split_once('=').unwrap();
            let value = |it: &ComparedDetector| it.config.value_of(parameter).unwrap().to_string();
            assert_eq!(value(variant), off);
            let others = |it: &ComparedDetector| {
                PARTS
                    .iter()
                    .filter_map(|other| other.off.split_once('='))
                    .filter(|other| other.0 != parameter)
                    .map(|other| it.config.value_of(other.0).unwrap().clone())
                    .collect::<Vec<_>>()
            };
            assert_ne!(value(whole), off);
            assert_eq!(others(variant), others(whole), "{}", part.name);
        }
        let bare = &variants[PARTS.len() + 1];
        for part in PARTS.iter().filter(|it| it.name != "two rounds") {
            let (parameter, off) = part.off.split_once('=').unwrap();
            assert_eq!(bare.config.value_of(parameter).unwrap().to_string(), off);
        }
    }

    #[test]
    fn trees_of_a_part_are_a_row_behind_its_switch() {
        let folder = tempfile::tempdir().unwrap();
        let error = all_variants(Some(folder.path())).unwrap_err().to_string();
        assert!(error.starts_with("there is no folder of a part in "), "{error}");
        assert!(error.contains("without-walls, ") && error.contains("one-round"), "{error}");
        // Its trees are searched.
        std::fs::create_dir(folder.path().join("without-walls")).unwrap();
        let error = all_variants(Some(folder.path())).unwrap_err().to_string();
        assert!(error.contains("groupings.model: "), "{error}");
        let bytes = include_bytes!("../../../../detector/src/params/groupings.model");
        std::fs::write(folder.path().join("without-walls/groupings.model"), bytes).unwrap();
        let variants = all_variants(Some(folder.path())).unwrap();
        let index = variants.iter().position(|it| it.name == "without walls, trained so").unwrap();
        assert_eq!(variants[index - 1].name, "without walls");
        assert_eq!(variants[index].config.hierarchical, variants[index - 1].config.hierarchical);
        assert_eq!(variants.len(), PARTS.len() + 5 + STEPS.len());
    }

    #[test]
    fn the_steps_lead_from_the_papers_to_the_method() {
        let config = RunConfig::load(None).unwrap();
        let variants = all_variants(None).unwrap();
        let built_up = &variants[PARTS.len() + 2..];
        assert_eq!((built_up[0].name, built_up[0].chosen.name()), ("the papers", "paper"));
        for pair in built_up[..=STEPS.len()].windows(2) {
            assert_ne!(pair[0].config.paper, pair[1].config.paper, "{}", pair[1].name);
        }
        // With all of them the stages up to the foreground are those of the method.
        let all = &built_up[STEPS.len()].config;
        let stages = all.paper.front_end(&config.hierarchical);
        let HierarchicalParams { ground, walls, foreground, .. } = &config.hierarchical;
        assert_eq!((&stages.ground, &stages.walls, &stages.foreground), (ground, walls, foreground));
        let [.., last] = built_up else { unreachable!("there are some") };
        assert_eq!((last.name, last.chosen.name()), (BEST_CUT.0, "hierarchical"));
    }
}
