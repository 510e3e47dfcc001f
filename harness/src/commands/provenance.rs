//! Where and with what a run was made.

use jiff::Timestamp;
use reports::manifest::{GitState, Machine};

/// The commit the program was built from; `None` if it was built outside of a checkout.
pub fn git_state() -> Option<GitState> {
    let commit = env!("SCANBENCH_GIT_COMMIT");
    (!commit.is_empty())
        .then(|| GitState { commit: commit.to_owned(), dirty: env!("SCANBENCH_GIT_DIRTY") == "true" })
}

/// The compiler that built the program.
pub fn rustc_version() -> String {
    env!("SCANBENCH_RUSTC_VERSION").to_owned()
}

/// The machine the program runs on.
pub fn machine() -> Machine {
    let n_cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    Machine {
        cpu_model: cpu_model(),
        n_cores,
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}

/// The processor's own name where the system tells it, else its architecture.
fn cpu_model() -> String {
    let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu_info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// A time as RFC 3339 writes it, in UTC to the second.
pub fn rfc3339_utc(time: Timestamp) -> String {
    time.strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

/// The same for the name of a file.
pub fn compact_utc(time: Timestamp) -> String {
    time.strftime("%Y%m%dT%H%M%SZ").to_string()
}
