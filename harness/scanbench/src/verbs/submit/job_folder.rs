//! The folder with the files of a submission.

use std::path::Path;

use reports::files::whole_set::WholeSet;

use crate::plumbing::empty_folder::refuse_occupied;
use crate::plumbing::failure::{Failure, Usage};

/// Names of pods are at most 63 characters; an engine adds to ours.
const LONGEST_NAME: usize = 40;

/// Where shards are written, below the folder of the job.
pub const SHARDS: &str = "shards";
/// Where the merged run is written.
pub const MERGED_RUN: &str = "run";
/// The script that hands everything to the engine.
pub const SUBMIT_SH: &str = "submit.sh";

/// The name of a job whose files are in `folder`: lower case letters, digits and hyphens, as Kubernetes wants it.
pub fn job_name(folder: &Path) -> Result<String, Usage> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let plain: String = name.chars().map(|it| if it.is_ascii_alphanumeric() { it } else { '-' }).collect();
    let short: String = plain.trim_matches('-').chars().take(LONGEST_NAME).collect();
    let name = short.trim_end_matches('-');
    if name.is_empty() {
        return Err(Usage(format!(
            "{folder:?} does not end in a name for the job; give one, such as runs/fleet"
        )));
    }
    Ok(name.to_owned())
}

/// `path` from the root, as text.
pub fn absolute_text(path: &Path) -> Result<String, Failure> {
    let path =
        std::path::absolute(path).map_err(|error| Failure::usage(format!("cannot use {path:?}"), error))?;
    let text = path.to_str().filter(|it| !it.contains(char::is_control));
    Ok(text
        .ok_or_else(|| Usage(format!("{path:?} cannot be written in a script; name another folder")))?
        .to_owned())
}

/// The name of the folder of a shard, as `printf` makes it of its number.
pub fn shard_pattern(n_shards: u32) -> String {
    format!("shard-%0{}d-of-{n_shards}", n_shards.to_string().len())
}

/// Writes `files` into `folder`, all of them or none.
pub fn write_job_folder(folder: &Path, files: &[(&str, String)]) -> Result<(), Failure> {
    refuse_occupied(folder)?;
    let set = WholeSet::within(folder)?;
    files.iter().try_for_each(|(name, content)| set.write(name, content.as_bytes()))?;
    Ok(set.finish()?)
}

#[cfg(test)]
mod tests {
    use reports::vocabulary::shard::Shard;

    use super::*;

    #[test]
    fn scripts_name_the_folders_of_shards_as_runs_do() {
        for (index, n_shards) in [(3, 8), (3, 12), (12, 12), (7, 1000)] {
            let n_digits = n_shards.to_string().len();
            let number = format!("{index:0n_digits$}");
            let name = shard_pattern(n_shards).replace(&format!("%0{n_digits}d"), &number);
            assert_eq!(name, Shard::new(index, n_shards).unwrap().folder_name());
        }
    }

    #[test]
    fn jobs_are_named_after_their_folder() {
        for (folder, name) in
            [("runs/fleet", "fleet"), ("runs/2026-03 Fleet_A.b", "2026-03-fleet-a-b"), ("/tmp/-x-", "x")]
        {
            assert_eq!(job_name(Path::new(folder)).unwrap(), name);
        }
        assert_eq!(job_name(Path::new(&"a".repeat(90))).unwrap().len(), LONGEST_NAME);
        for folder in ["/", "runs/..", "runs/ü", "---"] {
            assert!(job_name(Path::new(folder)).is_err(), "{folder}");
        }
    }
}
