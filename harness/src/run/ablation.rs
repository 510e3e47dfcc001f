//! The hierarchical detector whole, and without each of its parts.

use std::time::Duration;

use reports::numbers::ablation_score::AblationScore;
use reports::rows::counts::Counts as Scored;
use reports::vocabulary::extent::Extent;
use reports::vocabulary::origin::Origin;
use reports::vocabulary::task::Task;

use crate::annotation::LabeledScan;
use crate::dataset::DatasetDescription;
use crate::metrics::counts::{Counts, FalseDetections};
use crate::metrics::latency::Latencies;
use crate::metrics::segmentation_quality::SegmentationQuality;
use crate::run::config::override_option::OverrideOption;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::side_by_side::DetectorScan;

/// What the method is judged by: its parts are there to find objects, whatever they are.
pub const TASK: Task = Task::Objects;

/// The parts that can be switched off, in the order of the stages, each with the override that does so.
const PARTS: &[(&str, &str)] = &[
    ("terrain", "hierarchical.terrain.enabled=false"),
    ("wall refinement", "hierarchical.walls.enabled=false"),
    ("distance weighting", "hierarchical.density_weighting.enabled=false"),
    ("dense separation", "hierarchical.separation.enabled=false"),
    ("regrouping", "hierarchical.regrouping.enabled=false"),
    ("completion", "hierarchical.completion.enabled=false"),
];

/// The method, or what is left of it.
#[derive(Debug, Clone)]
pub struct Variant {
    /// What is left out, in words.
    pub name: String,
    /// Its parameters.
    pub config: RunConfig,
}

/// The method with the parameters of `config`, then without each of its parts in turn, then without all of them.
///
/// # Errors
///
/// [`ConfigError`] if the switches do not go with the other parameters.
pub fn variants(config: &RunConfig) -> Result<Vec<Variant>, ConfigError> {
    let without = |name: String, parts: &[(&str, &str)]| {
        let switches = parts.iter().map(|(_, off)| off.parse().expect("the list of parts is tested"));
        let switches: Vec<OverrideOption> = switches.collect();
        Ok(Variant { name, config: config.overridden(&switches, &[])? })
    };
    let whole = Variant { name: "whole method".to_owned(), config: config.clone() };
    let lacking = PARTS.iter().map(|part| without(format!("without {}", part.0), &[*part]));
    let bare = without("without all of these".to_owned(), PARTS);
    [Ok(whole)].into_iter().chain(lacking).chain([bare]).collect()
}

/// What all variants reached on one data set, or on several.
#[derive(Debug, Clone)]
pub struct AblationScores {
    extent: Extent,
    origin: Origin,
    n_scans: u64,
    // In the order of the variants.
    variants: Vec<VariantScores>,
}

#[derive(Debug, Clone)]
struct VariantScores {
    name: String,
    scored: Scored,
    segmentation: SegmentationQuality,
    latencies: Vec<Duration>,
}

impl AblationScores {
    /// Nothing measured yet on `dataset`.
    pub fn new(dataset: &DatasetDescription, variants: &[Variant]) -> Self {
        let known = FalseDetections::of(&dataset.annotated, TASK);
        let of_variant = |variant: &Variant| VariantScores {
            name: variant.name.clone(),
            scored: Counts::default().scored(known),
            segmentation: SegmentationQuality::default(),
            latencies: Vec::new(),
        };
        Self {
            extent: Extent::Dataset(dataset.id.clone()),
            origin: if dataset.is_simulated() { Origin::Simulated } else { Origin::Recorded },
            n_scans: 0,
            variants: variants.iter().map(of_variant).collect(),
        }
    }

    /// Adds what the variants made of `scan` of `dataset`.
    pub fn add(&mut self, dataset: &DatasetDescription, scan: &LabeledScan, results: &[DetectorScan]) {
        self.n_scans += 1;
        let known = FalseDetections::of(&dataset.annotated, TASK);
        for (variant, result) in self.variants.iter_mut().zip(results) {
            for assignment in result.assignments.iter().filter(|it| it.task == TASK) {
                variant.scored += Counts::of(assignment).scored(known);
                variant.segmentation += SegmentationQuality::of(scan, &result.output.detections, assignment);
            }
            variant.latencies.push(result.times.first);
        }
    }

    /// All data sets together: counts are summed and times put together. `None` if there are none.
    pub fn overall(datasets: &[Self]) -> Option<Self> {
        let (first, rest) = datasets.split_first()?;
        let mut overall = Self { extent: Extent::Overall, ..first.clone() };
        for dataset in rest {
            overall.n_scans += dataset.n_scans;
            overall.origin = overall.origin.with(dataset.origin);
            for (sum, variant) in overall.variants.iter_mut().zip(&dataset.variants) {
                sum.scored += variant.scored;
                sum.segmentation += variant.segmentation;
                sum.latencies.extend(&variant.latencies);
            }
        }
        Some(overall)
    }

    /// Annotations that counted.
    pub fn n_annotations(&self) -> u64 {
        self.variants.first().map_or(0, |it| it.scored.no())
    }

    /// The numbers of each variant.
    pub fn scores(&self) -> impl Iterator<Item = AblationScore> + '_ {
        self.variants.iter().map(|variant| {
            let latencies = Latencies::new(variant.latencies.clone());
            let in_ms = |percent| latencies.percentile(percent).map(|it| it.as_secs_f64() * 1e3);
            AblationScore {
                extent: self.extent.clone(),
                origin: self.origin,
                variant: variant.name.clone(),
                n_scans: self.n_scans,
                counts: variant.scored,
                n_split: variant.segmentation.n_split,
                n_holding: variant.segmentation.n_holding,
                n_joining: variant.segmentation.n_joining,
                latency_min_ms: in_ms(0),
                latency_p50_ms: in_ms(50),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_there_in_the_whole_and_missing_in_its_variant() {
        let config = RunConfig::load(None).unwrap();
        let variants = variants(&config).unwrap();
        assert_eq!(variants.len(), PARTS.len() + 2);
        let is_on = |variant: &Variant, part: &(&str, &str)| {
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
