//! Where and with what a run was made.

use std::process::{Command, Stdio};

use jiff::Timestamp;
use reports::run_folder::manifest::{GitState, Machine};
use scans::dataset::checksum::sha256;

use crate::cli::CompareArgs;

/// The command line, the program's name first.
pub fn command_line() -> Vec<String> {
    std::env::args_os().map(|it| it.to_string_lossy().into_owned()).collect()
}

/// The commit the program was built from; `None` if it was built outside of a checkout.
pub fn git_state() -> Option<GitState> {
    let commit = env!("SCANBENCH_GIT_COMMIT");
    (!commit.is_empty())
        .then(|| GitState { commit: commit.to_owned(), dirty: env!("SCANBENCH_GIT_DIRTY") == "true" })
}

/// The git repository around the working directory, such as that of a user's detector; `None` outside of one, or without git.
/// Files that git does not know are no changes: results of runs are such.
pub fn project_state() -> Option<GitState> {
    let git = |arguments: &[&str]| {
        // A program that watches the files is none of ours, and reading leaves no locks.
        let mut command = Command::new("git");
        command.args(["-c", "core.fsmonitor=false"]).args(arguments).env("GIT_OPTIONAL_LOCKS", "0");
        let ended = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
        ended.status.success().then(|| String::from_utf8_lossy(&ended.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "--verify", "--quiet", "HEAD"])?;
    let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(GitState { commit, dirty: !changes.is_empty() })
}

/// SHA-256 of the program's own bytes: a version, or a commit with changes on top, would not distinguish two builds.
pub fn program_checksum() -> String {
    sha256(std::env::current_exe().and_then(std::fs::read).unwrap_or_default())
}

/// When the program's file was written, and how large it is: distinguishes builds on one machine without reading it.
pub fn program_stamp() -> String {
    let metadata = std::env::current_exe().and_then(std::fs::metadata);
    let written = metadata.and_then(|it| Ok((it.modified()?, it.len())));
    written.map_or_else(
        |_| String::new(),
        |(time, n_bytes)| {
            let time = Timestamp::try_from(time).unwrap_or_default();
            format!("{n_bytes} bytes of {time}")
        },
    )
}

/// The compiler that built the program.
pub fn rustc_version() -> String {
    env!("SCANBENCH_RUSTC_VERSION").to_owned()
}

pub fn machine() -> Machine {
    let n_cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    Machine {
        cpu_model: cpu_model(),
        n_cores,
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}

/// The processor's own name where the system reports it, else its architecture.
fn cpu_model() -> String {
    let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu_info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// A time as RFC 3339 writes it, in UTC to the second.
pub fn rfc3339_utc(time: Timestamp) -> String {
    time.strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

pub fn utc_day(time: Timestamp) -> String {
    time.strftime("%Y-%m-%d").to_string()
}

/// A time in UTC to the second, for the name of a file.
pub fn compact_utc(time: Timestamp) -> String {
    time.strftime("%Y%m%dT%H%M%SZ").to_string()
}

/// The manifest of a comparison: the runs and detectors compared, and the program that compared them.
pub fn comparison_facts(arguments: &CompareArgs) -> serde_json::Value {
    serde_json::json!({
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "argv": command_line(),
        "git": git_state(),
        "before": arguments.run,
        "after": arguments.other,
        "detectors": arguments.detectors,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_utc_to_the_second() {
        let time: Timestamp = "2014-08-24T23:59:58.7+02:00".parse().expect("a time");
        assert_eq!(rfc3339_utc(time), "2014-08-24T21:59:58Z");
        assert_eq!(utc_day(time), "2014-08-24");
        assert_eq!(compact_utc(time), "20140824T215958Z");
    }

    #[test]
    fn the_program_knows_what_it_was_built_from() {
        if let Some(git) = git_state() {
            assert_eq!(git.commit.len(), 40, "{git:?}");
            assert!(git.commit.bytes().all(|byte| byte.is_ascii_hexdigit()), "{git:?}");
        }
        assert!(rustc_version().starts_with("rustc "), "{}", rustc_version());
    }

    #[test]
    fn the_machine_has_a_name_and_cores() {
        let machine = machine();
        assert!(machine.n_cores >= 1 && !machine.cpu_model.is_empty(), "{machine:?}");
        assert!(machine.os.starts_with(std::env::consts::OS), "{machine:?}");
    }
}
