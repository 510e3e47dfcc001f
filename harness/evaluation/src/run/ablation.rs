//! The hierarchical detector whole, without each of its parts, and built up from what the papers print.

use reports::vocabulary::task::Task;

use crate::run::config::override_option::OverrideOption;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::detector_list::{ListedDetector, PAPER};
use crate::run::entrant::Entrant;

/// What the method is judged by: its parts are there to find objects, whatever they are.
pub const TASK: Task = Task::Objects;

/// The parts that can be switched off, in the order of the stages: what is left, and the override that switches off.
const PARTS: &[(&str, &str)] = &[
    ("without terrain", "hierarchical.terrain.enabled=false"),
    ("without walls", "hierarchical.walls.enabled=false"),
    ("without distance weighting", "hierarchical.density_weighting.enabled=false"),
    ("without completion", "hierarchical.completion.enabled=false"),
];

/// What leads from the papers to the method, in the order of the stages: what a row adds to those above it, and how the detector of the
/// papers does so. Overrides that end in `=` get the value that the method has for the same parameter.
const STEPS: &[(&str, &[&str])] = &[
    ("and points clear of the ground", &["paper.foreground.clearance_m="]),
    (
        "and cells by the terrain",
        &["paper.ground.fewer_far_away=", "paper.ground.low_itself=", "paper.ground.tall_over="],
    ),
    ("and walls by their support", &["paper.walls.as_printed=", "paper.walls.min_support="]),
    (
        "and smaller objects",
        &[
            "paper.cluster.min_points=",
            // Tuned on simulated streets, for objects of so few points.
            "paper.separation.low_density_share=0.3",
            "paper.separation.object_density_ratio=5.0",
        ],
    ),
];

/// The last step: the method, with what follows the best cut switched off.
const BEST_CUT: (&str, &str) = ("and the best cut of groups", "hierarchical.completion.enabled=false");

/// `method` with the parameters of `config`, then without each of its parts in turn, then without all of them; then the
/// detector of the papers, the same with one after another of the steps that lead from it to the method, and the method
/// without what the whole adds.
///
/// # Errors
///
/// [`ConfigError`] if the switches do not go with the other parameters.
pub fn variants(method: ListedDetector, config: &RunConfig) -> Result<Vec<Entrant>, ConfigError> {
    let without = |name: &'static str, parts: &[(&str, &str)]| {
        let switches = parts.iter().map(|(_, off)| off.parse().expect("the list of parts is tested"));
        let switches: Vec<OverrideOption> = switches.collect();
        Ok(Entrant { name, chosen: method.into(), config: config.overridden(&switches, &[])? })
    };
    let whole = Entrant { name: "whole method", chosen: method.into(), config: config.clone() };
    let lacking = PARTS.iter().map(|part| without(part.0, &[*part]));
    let bare = without("without all of these", PARTS);
    let papers = Entrant { name: "the papers", chosen: PAPER.into(), config: config.clone() };
    let built_up = (0..STEPS.len()).map(|step_idx| {
        let config = with_steps(&STEPS[..=step_idx], config)?;
        Ok(Entrant { name: STEPS[step_idx].0, chosen: PAPER.into(), config })
    });
    let before_whole = without(BEST_CUT.0, &[BEST_CUT]);
    [Ok(whole)]
        .into_iter()
        .chain(lacking)
        .chain([bare, Ok(papers)])
        .chain(built_up)
        .chain([before_whole])
        .collect()
}

/// The parameters of `config` with what `steps` add to the detector of the papers.
fn with_steps(steps: &[(&str, &[&str])], config: &RunConfig) -> Result<RunConfig, ConfigError> {
    let of_method = |switch: &str| {
        let same = switch.strip_suffix('=')?.replacen("paper", "hierarchical", 1);
        Some(config.value_of(&same).expect("the list of steps is tested").to_string())
    };
    let switches = steps.iter().flat_map(|(_, added)| added.iter());
    let switches = switches.map(|it| {
        format!("{it}{}", of_method(it).unwrap_or_default()).parse().expect("the list of steps is tested")
    });
    let switches: Vec<OverrideOption> = switches.collect();
    config.overridden(&switches, &[])
}

#[cfg(test)]
mod tests {
    use detector::params::HierarchicalParams;

    use super::*;
    use crate::run::detector_list::built_in_named;

    #[test]
    fn every_part_is_there_in_the_whole_and_missing_in_its_variant() {
        let config = RunConfig::load(None).unwrap();
        let method = built_in_named(&["hierarchical".to_owned()], &config).unwrap()[0];
        let variants = variants(method, &config).unwrap();
        assert_eq!(variants.len(), PARTS.len() + 4 + STEPS.len());
        let variants = &variants[..PARTS.len() + 2];
        let is_on = |variant: &Entrant, part: &(&str, &str)| {
            let keys = part.1.trim_end_matches("=false").split('.');
            let value =
                keys.fold(toml::Value::Table(variant.config.resolved.clone()), |it, key| it[key].clone());
            value.as_bool().expect("a switch")
        };
        for (variant, lacking) in variants.iter().zip([None].into_iter().chain((0..PARTS.len()).map(Some))) {
            for (part_idx, part) in PARTS.iter().enumerate() {
                assert_eq!(is_on(variant, part), lacking != Some(part_idx), "{} of {}", part.0, variant.name);
            }
        }
        assert!(PARTS.iter().all(|part| !is_on(variants.last().unwrap(), part)));
    }

    #[test]
    fn the_steps_lead_from_the_papers_to_the_method() {
        let config = RunConfig::load(None).unwrap();
        let method = built_in_named(&["hierarchical".to_owned()], &config).unwrap()[0];
        let variants = variants(method, &config).unwrap();
        let built_up = &variants[PARTS.len() + 2..];
        assert_eq!((built_up[0].name, built_up[0].chosen.name()), ("the papers", "paper"));
        for pair in built_up[..=STEPS.len()].windows(2) {
            assert_ne!(pair[0].config.paper, pair[1].config.paper, "{}", pair[1].name);
        }
        // With all of them the stages up to the foreground are those of the method.
        let all = &built_up[STEPS.len()].config;
        let stages = all.paper.stages(&config.hierarchical);
        let HierarchicalParams { ground, walls, foreground, .. } = &config.hierarchical;
        assert_eq!((&stages.ground, &stages.walls, &stages.foreground), (ground, walls, foreground));
        let [.., last] = built_up else { unreachable!("there are some") };
        assert_eq!((last.name, last.chosen.name()), (BEST_CUT.0, "hierarchical"));
    }
}
