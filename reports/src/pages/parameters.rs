//! The manifest: everything that determines the numbers.

use maud::html;

use super::document::Section;
use super::markup::commands;
use crate::run_folder::manifest::Manifest;

pub(super) fn parameters(manifest: &Manifest) -> Section {
    let git = manifest.git.as_ref().map_or_else(
        || "not known".to_owned(),
        |it| format!("{}{}", it.commit, if it.dirty { ", with uncommitted changes" } else { "" }),
    );
    // The list of shards would be longer than all the rest.
    let shown = Manifest { shards: Vec::new(), ..manifest.clone() };
    let made_in =
        (!manifest.shards.is_empty()).then(|| ("made in", format!("{} shards", manifest.shards.len())));
    let facts = [
        ("started", manifest.created.clone()),
        (
            "scanbench",
            format!("{}, scoring version {}", manifest.scanbench_version, manifest.scoring_version),
        ),
        ("commit", git),
        ("compiler", manifest.rustc_version.clone()),
        (
            "machine",
            format!(
                "{}, {} cores, {}",
                manifest.machine.cpu_model, manifest.machine.n_cores, manifest.machine.os
            ),
        ),
        ("matched by", manifest.matching_criterion.clone()),
        (
            "ignored",
            format!(
                "annotations with fewer than {} points or beyond {} m",
                manifest.ignored.min_points, manifest.ignored.max_range_m
            ),
        ),
        ("warm-up", format!("{} detections for each detector", manifest.n_warmup_detections)),
        (
            "repetitions",
            match manifest.n_repeats {
                1 => "each scan is timed once".to_owned(),
                n => format!("each scan is timed {n} times; the first time counts"),
            },
        ),
    ];
    let content = html! {
        details {
            summary { "How it was run and judged" }
            dl { @for (name, value) in facts.into_iter().chain(made_in) { div { dt { (name) } dd { (value) } } } }
        }
        details {
            summary { "manifest.json, with every parameter" }
            (commands(shown.to_json().trim_end(), "manifest.json"))
        }
    };
    Section::new("Manifest", "Manifest", content)
}
