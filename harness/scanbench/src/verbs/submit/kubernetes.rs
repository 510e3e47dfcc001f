//! `scanbench submit kubernetes`.

use reports::run_folder::command_line::shell_word;
use reports::vocabulary::shard::Shard;

use crate::cli::KubernetesArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::submit::job_folder::{
    MERGED_RUN, SHARDS, SUBMIT_SH, absolute_text, job_name, shard_pattern, write_job_folder,
};
use crate::verbs::submit::sharded_command::ShardedCommand;
use crate::verbs::submit::template::filled;

const SHARDS_YAML: &str = include_str!("kubernetes/shards.yaml");
const MERGE_YAML: &str = include_str!("kubernetes/merge.yaml");
const SUBMIT: &str = include_str!("kubernetes/submit.sh");

/// Writes an indexed job of shards, a job that merges them, and a script that applies one after the other.
pub fn submit_kubernetes(arguments: &KubernetesArgs) -> Result<(), Failure> {
    let submitted = &arguments.submitted;
    let command = ShardedCommand::read(&submitted.command)?;
    let name = job_name(&submitted.output)?;
    let n_shards = submitted.shards.to_string();
    let shards = format!("{name}/{SHARDS}");
    let run = format!("{name}/{MERGED_RUN}");
    let of_shard = yaml_list(&command.after_shard(&shards));
    let merge = yaml_list(&merge_words(&shards, submitted.shards, &run));
    let pattern = shard_pattern(submitted.shards);
    let at_once = submitted.at_once.unwrap_or(submitted.shards).to_string();
    let own = [
        ("n_shards", n_shards.as_str()),
        ("at_once", &at_once),
        ("shards", &shards),
        ("shard", &pattern),
        ("verb", command.verb()),
        ("arguments", &of_shard),
    ];
    let [image, claim, memory] =
        [&arguments.image, &arguments.claim, &arguments.memory].map(|it| yaml_text(it));
    let common = [("name", name.as_str()), ("image", &image), ("claim", &claim), ("memory", &memory)];
    let of_job = |own: &[(&'static str, &str)], template| filled(template, &[&common[..], own].concat());
    let files = [
        ("shards.yaml", of_job(&own, SHARDS_YAML)),
        ("merge.yaml", of_job(&[("arguments", &merge)], MERGE_YAML)),
        (SUBMIT_SH, filled(SUBMIT, &[("name", &name), ("run", &run), ("claim", &arguments.claim)])),
    ];
    let folder = absolute_text(&submitted.output)?;
    write_job_folder(&submitted.output, &files)?;
    let submit_sh = shell_word(&format!("{folder}/{SUBMIT_SH}"));
    print_result(format_args!("{folder}: jobs for {n_shards} shards.\n\n  bash {submit_sh}"))
}

fn merge_words(shards: &str, n_shards: u32, run: &str) -> Vec<String> {
    let shard = |index| Shard::new(index, n_shards).expect("the command line has checked their number");
    let folders = (1..=n_shards).map(|it| format!("{shards}/{}", shard(it).folder_name()));
    let output = ["-o", run, "--overwrite"].map(str::to_owned);
    ["merge".to_owned()].into_iter().chain(folders).chain(output).collect()
}

/// The rest of a list of YAML, a line for each word. Kubernetes replaces `$(NAME)` by variables, and two dollars by one.
fn yaml_list(words: &[String]) -> String {
    let line = |word: &String| format!("            - {}\n", yaml_text(&word.replace('$', "$$")));
    words.iter().map(line).collect::<Vec<_>>().concat()
}

/// `text` in double quotes, as both JSON and YAML read it.
fn yaml_text(text: &str) -> String {
    let quoted = serde_json::Value::from(text).to_string();
    // Control characters that JSON leaves as they are and YAML does not take.
    let escape = |it: char| if it.is_control() { format!("\\u{:04x}", it as u32) } else { it.to_string() };
    quoted.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_what_they_are_in_yaml() {
        let words =
            ["a b", "it's \"x\"", "$(HOME) $$(HOME) $HOME$", "- #: {}", "ü\n\u{7f}\u{85}"].map(str::to_owned);
        assert_eq!(
            yaml_list(&words),
            r#"            - "a b"
            - "it's \"x\""
            - "$$(HOME) $$$$(HOME) $$HOME$$"
            - "- #: {}"
            - "ü\n\u007f\u0085"
"#
        );
    }
}
