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
    ("without tree of groupings", "hierarchical.grouping.enabled=false"),
    ("without completion", "hierarchical.completion.enabled=false"),
];

/// What the method has beyond the papers, in the order of the stages: what a row adds to those above it, and the overrides
/// that take it away. Overrides that end in `=` get the value of the same parameter of the papers' detector. The last has no
/// row, because with it the method is whole.
const STEPS: &[(&str, &[&str])] = &[
    (
        "and cells by the terrain",
        &[
            "hierarchical.ground.fewer_far_away=false",
            "hierarchical.ground.low_itself=false",
            "hierarchical.ground.tall_over=level_road",
        ],
    ),
    (
        "and walls by their support",
        &["hierarchical.walls.as_printed=true", "hierarchical.walls.min_support="],
    ),
    ("and points clear of the ground", &["hierarchical.foreground.clearance_m=-inf"]),
    (
        "and smaller objects",
        &[
            "hierarchical.separation.low_density_share=",
            "hierarchical.separation.object_density_ratio=",
            "hierarchical.cluster.min_points=",
            "hierarchical.cluster.min_vehicle_points=",
            "hierarchical.vehicle_bounds.enabled=false",
        ],
    ),
    ("and regrouping", &["hierarchical.regrouping.enabled=false"]),
    ("and completion", &["hierarchical.completion.enabled=false"]),
    ("and the tree of groupings", &["hierarchical.grouping.enabled=false"]),
];

/// `method` with the parameters of `config`, then without each of its parts in turn, then without all of them; then the
/// detector of the papers, and `method` with one after another of the steps that lead from it to the whole.
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
    let built_up = (1..STEPS.len()).map(|n_taken| {
        let config = without_steps(&STEPS[n_taken..], config)?;
        Ok(Entrant { name: STEPS[n_taken - 1].0, chosen: method.into(), config })
    });
    [Ok(whole)].into_iter().chain(lacking).chain([bare, Ok(papers)]).chain(built_up).collect()
}

/// The parameters of `config` without what `steps` add.
fn without_steps(steps: &[(&str, &[&str])], config: &RunConfig) -> Result<RunConfig, ConfigError> {
    let of_papers = |switch: &str| {
        let parameter = match switch.strip_suffix('=')? {
            "hierarchical.cluster.min_vehicle_points" => "paper.cluster.min_points".to_owned(),
            same => same.replacen("hierarchical", "paper", 1),
        };
        Some(config.value_of(&parameter).expect("the list of steps is tested").to_string())
    };
    let switches = steps.iter().flat_map(|(_, undone)| undone.iter());
    let switches = switches.map(|it| {
        format!("{it}{}", of_papers(it).unwrap_or_default()).parse().expect("the list of steps is tested")
    });
    let switches: Vec<OverrideOption> = switches.collect();
    config.overridden(&switches, &[])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::detector_list::built_in_named;

    #[test]
    fn every_part_is_there_in_the_whole_and_missing_in_its_variant() {
        let config = RunConfig::load(None).unwrap();
        let method = built_in_named(&["hierarchical".to_owned()], &config).unwrap()[0];
        let variants = variants(method, &config).unwrap();
        assert_eq!(variants.len(), PARTS.len() + 2 + STEPS.len());
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
    fn the_steps_lead_from_the_papers_to_the_whole() {
        let config = RunConfig::load(None).unwrap();
        let method = built_in_named(&["hierarchical".to_owned()], &config).unwrap()[0];
        // Without any, the method has the stages of the papers' detector.
        let printed = without_steps(STEPS, &config).unwrap();
        assert_eq!(printed.hierarchical, config.paper.stages(&config.hierarchical));
        let variants = variants(method, &config).unwrap();
        let built_up = &variants[PARTS.len() + 2..];
        assert_eq!((built_up[0].name, built_up[0].chosen.name()), ("the papers", "paper"));
        for pair in built_up[1..].windows(2) {
            assert_ne!(pair[0].config.hierarchical, pair[1].config.hierarchical, "{}", pair[1].name);
        }
        // The row before the whole lacks the last step alone.
        let last = without_steps(&STEPS[STEPS.len() - 1..], &config).unwrap();
        assert_eq!(built_up.last().unwrap().config.hierarchical, last.hierarchical);
        assert_eq!(without_steps(&[], &config).unwrap().hierarchical, config.hierarchical);
    }
}
