//! How to make the run again, and how to look into it.

use maud::{Markup, html};

use super::again::Made;
use super::document::Section;
use super::markup::commands;
use crate::facts::run_facts::RunFacts;
use crate::run_folder::command_line::shell_word;
use crate::run_folder::manifest::{DatasetEntry, ForeignEntry, Manifest};

pub(super) fn reproduction(facts: &RunFacts) -> Section {
    let manifest = &facts.manifest;
    let content = html! {
        (Made::of(manifest).markup())
        @match &manifest.git {
            Some(git) if git.dirty => p { "The source had uncommitted changes, so the numbers may differ." },
            Some(_) => p { "All numbers are reproduced to the last digit, except times." },
            None => p { "The commit that the program was built from is not known." },
        }
        @if let Some(project) = &manifest.project {
            p {
                "The command ran in a git repository at commit " code { (project.commit) }
                @if project.dirty { ", with uncommitted changes" } "."
            }
        }
        @for entry in &manifest.detectors {
            @if let Some(foreign) = &entry.foreign { (not_built_in(&entry.name, foreign)) }
        }
        (data_table(manifest))
        @if !facts.recording_folders.is_empty() { (recording(manifest, &facts.recording_folders)) }
    };
    Section::new("Reproduce", "Reproduce", content)
}

/// Command or results of a detector that scanbench does not come with, with version and checksums.
fn not_built_in(name: &str, foreign: &ForeignEntry) -> Markup {
    let command: Vec<String> = foreign.command.iter().map(|it| shell_word(it)).collect();
    html! {
        p {
            "scanbench does not come with the detector " code { (name) } ": "
            @match &foreign.results {
                Some(results) => {
                    "its results were read from " code { (results) }
                    @if let Some(checksum) = &foreign.results_checksum { ", SHA-256 " code { (checksum) } }
                },
                None => {
                    "it is " code { (command.join(" ")) }
                    @if let Some(version) = &foreign.version { ", version " (version) }
                    @if foreign.files.is_empty() { ", whose files are not known" }
                    @for (file, checksum) in &foreign.files {
                        ", " code { (file) } " of SHA-256 " code { (checksum) }
                    }
                },
            }
            "."
        }
    }
}

fn data_table(manifest: &Manifest) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Data of the run" {
            table.data {
                caption.hidden { "Data of the run" }
                thead { tr {
                    @for title in ["data set", "scans", "sensor", "source", "licence"] {
                        th scope="col" class=(if title == "scans" { "number" } else { "text" }) { (title) }
                    }
                } }
                tbody {
                    @for entry in &manifest.datasets {
                        tr {
                            th.text scope="row" { (entry.id) @if entry.simulated { " " span.tag { "simulated" } } }
                            td.number { (entry.n_scans) @if !entry.skipped_scans.is_empty() { " (" (entry.skipped_scans.len()) " damaged)" } }
                            td.text { (entry.sensor) }
                            td.text { (made_of(manifest, entry)) }
                            td.text { (entry.licence.as_deref().unwrap_or("–")) }
                        }
                    }
                }
            }
        }
    }
}

fn made_of(manifest: &Manifest, entry: &DatasetEntry) -> Markup {
    let selection = entry.selection.as_ref().map(|it| format!(", scans {it}")).unwrap_or_default();
    html! {
        @match &entry.simulation {
            Some(simulation) => {
                "simulator version " (simulation.simulator_version) ", street " (simulation.street)
                @if let Some(seed) = manifest.seeds.get(&entry.id) { ", seed " (seed) }
            },
            None => { (entry.format) },
        }
        (selection)
        @match &entry.checksum {
            Some(checksum) => { ", SHA-256 " code { (checksum) } },
            None => ", no checksum",
        }
    }
}

fn recording(manifest: &Manifest, folders: &[String]) -> Markup {
    // The library gives its own version, maybe with its name before it.
    let version = manifest.rerun_version.as_deref().unwrap_or_default();
    html! {
        div.recording {
            h3 { "Every stage on every scan" }
            p {
                "Recorded in " @for it in folders { a href=(it) { (it) "/" } " " }
                "for the Rerun viewer. The second line opens it on the desktop, the third one in a browser:"
            }
            (commands(
                &format!("pip install rerun-sdk=={version}\nrerun {folders}\nrerun --web-viewer {folders}", folders = folders.join(" ")),
                "Commands that open the recording"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_detector_of_others_is_named_with_its_files() {
        let program = ForeignEntry {
            command: vec!["python3".to_owned(), "my detector.py".to_owned()],
            files: BTreeMap::from([("my detector.py".to_owned(), "f00d".to_owned())]),
            ..ForeignEntry::default()
        };
        let text = not_built_in("mine", &program).into_string();
        assert!(text.contains("<code>python3 'my detector.py'</code>, <code>my detector.py</code> of SHA-256 <code>f00d</code>"), "{text}");
        let results = ForeignEntry {
            results: Some("out".to_owned()),
            results_checksum: Some("beef".to_owned()),
            ..ForeignEntry::default()
        };
        let text = not_built_in("deep", &results).into_string();
        assert!(text.contains("read from <code>out</code>, SHA-256 <code>beef</code>"), "{text}");
    }
}
