//! The workflow that `baseline init` writes.

use std::path::Path;

use reports::run_folder::command_line::shell_word;
use reports::run_folder::manifest::Manifest;

/// Its name beside the baseline.
pub const GATE_WORKFLOW: &str = "scanbench.yml";

const TEMPLATE: &str = include_str!("gate_workflow.yml");

/// A workflow for GitHub that makes the run of `manifest` again and holds it to the baseline in `folder`.
pub fn gate_workflow(manifest: &Manifest, folder: &Path) -> String {
    let folder = folder.display().to_string();
    let baseline = shell_word(folder.trim_end_matches('/'));
    let run = manifest.command_again("runs/gate");
    TEMPLATE.replace("BASELINE", &baseline).replace("      # DATA\n", &data(manifest)).replace("RUN", &run)
}

/// What has to be fetched before the run; nothing if all of it is simulated on the way.
fn data(manifest: &Manifest) -> String {
    let recorded = manifest.datasets.iter().filter_map(|it| Some((&it.id, it.root.as_ref()?)));
    let lines = recorded.map(|(id, root)| {
        let root = root.replace(char::is_control, " ");
        format!("      # {id}: the run read it from {root}; fetch it to there in a step of its own.\n")
    });
    lines.collect()
}
