//! The workflow that `baseline init` writes.

use std::path::Path;

use reports::files::shown_text::is_printable;
use reports::run_folder::command_line::{command_again, shell_word};
use reports::run_folder::manifest::Manifest;

use crate::plumbing::failure::Usage;

/// Its name beside the baseline.
pub const GATE_WORKFLOW: &str = "scanbench.yml";

const TEMPLATE: &str = include_str!("gate_workflow.yml");

/// A workflow for GitHub that makes the run of `manifest` again and holds it to the baseline in `folder`.
///
/// Words of the command of the run that would end its step, or that GitHub replaces, are refused: the run may be another
/// user's.
pub fn gate_workflow(manifest: &Manifest, folder: &Path) -> Result<String, Usage> {
    let is_more_than_a_word = |it: &&String| !it.chars().all(is_printable) || it.contains("${{");
    if let Some(word) = manifest.argv.iter().find(is_more_than_a_word) {
        return Err(Usage(format!(
            "the command of the run has the word {word:?}, which cannot stand in a workflow"
        )));
    }
    let data = data(manifest) + &recorded_objects(manifest);
    let folder = folder.display().to_string();
    let baseline = shell_word(folder.trim_end_matches('/'));
    let run = command_again(&manifest.argv, "runs/gate");
    // One after the other, because a name that is put in may be the next mark.
    let marks = [("      # DATA\n", data.as_str()), ("RUN", &run), ("BASELINE", &baseline)];
    let mut written = String::new();
    let end = marks.iter().fold(TEMPLATE, |rest, (mark, word)| {
        let (before, after) = rest.split_once(mark).expect("the template has the marks in this order");
        written += before;
        written += word;
        after
    });
    Ok(written + end)
}

/// Comments on sets of objects to fetch before any is judged; empty if all of them are simulated on the way.
fn recorded_objects(manifest: &Manifest) -> String {
    let sets = manifest.partial.iter().flat_map(|it| &it.sets);
    let sets = sets.flat_map(|it| [Some(&it.judged), it.learned_from.as_ref()]).flatten();
    let mut recorded: Vec<&str> = sets.filter(|it| !it.simulated).map(|it| it.id.as_str()).collect();
    recorded.dedup();
    let line = |id: &&str| {
        let id = id.replace(char::is_control, " ");
        format!("      # {id}: the command below names its folder; fetch it to there in a step of its own.\n")
    };
    recorded.iter().map(line).collect()
}

/// Comments on data sets to fetch before the run; empty if all of them are simulated on the way.
fn data(manifest: &Manifest) -> String {
    let recorded = manifest.datasets.iter().filter_map(|it| Some((&it.id, it.root.as_ref()?)));
    let lines = recorded.map(|(id, root)| {
        let root = root.replace(char::is_control, " ");
        format!("      # {id}: the run read it from {root}; fetch it to there in a step of its own.\n")
    });
    lines.collect()
}
