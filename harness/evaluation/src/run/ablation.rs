//! The hierarchical detector whole, and without each of its parts.

use reports::vocabulary::task::Task;

use crate::run::config::override_option::OverrideOption;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::detector_list::ListedDetector;
use crate::run::entrant::Entrant;

/// What the method is judged by: its parts are there to find objects, whatever they are.
pub const TASK: Task = Task::Objects;

/// The parts that can be switched off, in the order of the stages: what is left, and the override that switches off.
const PARTS: &[(&str, &str)] = &[
    ("without terrain", "hierarchical.terrain.enabled=false"),
    ("without wall refinement", "hierarchical.walls.enabled=false"),
    ("without distance weighting", "hierarchical.density_weighting.enabled=false"),
    ("without dense separation", "hierarchical.separation.enabled=false"),
    ("without regrouping", "hierarchical.regrouping.enabled=false"),
    ("without completion", "hierarchical.completion.enabled=false"),
];

/// `method` with the parameters of `config`, then without each of its parts in turn, then without all of them.
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
    [Ok(whole)].into_iter().chain(lacking).chain([bare]).collect()
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
        assert_eq!(variants.len(), PARTS.len() + 2);
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
}
