//! Processes and their child processes, as the system reports them.

use std::time::Duration;

use nix::sys::time::TimeValLike as _;
use nix::time::clock_getcpuclockid;
use nix::unistd::{Pid, SysconfVar, sysconf};

/// All processes that `pid` has started, directly or indirectly, and that have not been waited for.
pub fn descendants(pid: u32) -> Vec<u32> {
    let mut found = children(pid);
    let mut n_seen = 0;
    while n_seen < found.len() {
        found.extend(children(found[n_seen]));
        n_seen += 1;
    }
    found
}

/// Child processes of `pid` that it has not waited for, those of all its threads.
pub fn children(pid: u32) -> Vec<u32> {
    let Ok(threads) = std::fs::read_dir(format!("/proc/{pid}/task")) else { return Vec::new() };
    let lists = threads.flatten().filter_map(|it| std::fs::read_to_string(it.path().join("children")).ok());
    lists
        .flat_map(|it| it.split_whitespace().filter_map(|pid| pid.parse().ok()).collect::<Vec<u32>>())
        .collect()
}

/// Time on processors, user and system, of these processes. It is exact to the nanosecond for running processes, and to the
/// tick of the system for children that have ended and been waited for. `None` if the system does not report it.
pub fn cpu_time_of(pids: &[u32]) -> Option<Duration> {
    let ticks_per_s = sysconf(SysconfVar::CLK_TCK).ok()??;
    let mut sum = Duration::ZERO;
    let mut is_known = false;
    for &pid in pids {
        // The process may have ended meanwhile.
        let clock = clock_getcpuclockid(Pid::from_raw(pid as i32)).ok();
        let Some(time) = clock.and_then(|it| it.now().ok()) else { continue };
        is_known = true;
        sum += Duration::from_nanos(u64::try_from(time.num_nanoseconds()).unwrap_or(0));
        let n_ticks = ticks_of_ended_children(pid).unwrap_or(0);
        sum += Duration::from_secs_f64(n_ticks as f64 / ticks_per_s as f64);
    }
    is_known.then_some(sum)
}

/// Start of a process, in ticks since the machine started; `None` if the process is gone.
pub fn start_of(pid: u32) -> Option<u64> {
    field_of(pid, 22)
}

/// Sum of `cutime` and `cstime`.
fn ticks_of_ended_children(pid: u32) -> Option<u64> {
    Some(field_of(pid, 16)? + field_of(pid, 17)?)
}

/// A number of `/proc/PID/stat`, by its index in the manual, from 1.
fn field_of(pid: u32, index: usize) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program may hold anything; the fields behind it begin with the third.
    stat.rsplit_once(')')?.1.split_whitespace().nth(index - 3)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;
    use std::time::Instant;

    #[test]
    fn what_a_child_computes_is_seen() {
        let own = std::process::id();
        let mut child = Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap();
        assert!(descendants(own).contains(&child.id()));
        let ends = Instant::now() + Duration::from_secs(20);
        let mut before = cpu_time_of(&descendants(own)).unwrap();
        let mut has_risen = false;
        while !has_risen && Instant::now() < ends {
            std::thread::sleep(Duration::from_millis(20));
            let now = cpu_time_of(&descendants(own)).unwrap();
            (has_risen, before) = (now > before, now);
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(has_risen);
        assert!(!descendants(own).contains(&child.id()));
    }
}
