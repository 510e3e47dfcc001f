//! Supervisor of a detector, so that no process of it is left behind, whatever ends us.
//!
//! It is a process of its own that starts the detector, inherits the processes that the detector leaves behind, and kills
//! all of them once the detector has ended, once we ask for it, or once we are gone.

use std::io::{self, Write as _};
use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::ExitStatusExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Signal, WaitOptions};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::processes::children;
use super::sandbox::wall_in;

/// Environment variable with the word with which lines of a supervisor begin on its standard error. Only the supervisor gets
/// it.
pub const TOKEN: &str = "SCANBENCH_SUPERVISOR_TOKEN";
/// The variables with the descriptors of the pipes.
pub const READ_FD: &str = "SCANBENCH_READ_FD";
/// See [`READ_FD`].
pub const WRITE_FD: &str = "SCANBENCH_WRITE_FD";

/// Longest wait for killed processes to end.
const LONGEST_DEATH: Duration = Duration::from_secs(2);

/// Starts `words`, a program and its arguments, and waits for its end. Its messages come in on our standard input and go out
/// on our standard output; its printed lines go to our standard error. Its end is reported there, too, in lines that begin
/// with the [token](TOKEN).
///
/// With `hidden`, there is nothing for it at these paths, and no network.
pub fn supervise(words: &[String], hidden: Option<&[PathBuf]>) {
    let token = std::env::var(TOKEN).unwrap_or_default();
    let walled_in = hidden.map_or(Ok(()), wall_in);
    let says = match walled_in.and_then(|()| start_and_wait(words, &token)) {
        Ok(status) => match (status.code(), status.signal()) {
            (Some(code), _) => format!("{EXIT}{code}"),
            (None, signal) => format!("{SIGNAL}{}", signal.unwrap_or(0)),
        },
        Err(error) => format!("{CANNOT_START}{error}: {:?}", words.first().map_or("", String::as_str)),
    };
    say(&token, &says);
}

/// Prefix of the exit code of the detector.
pub(super) const EXIT: &str = "exit ";
/// Prefix of the number of the signal that ended it.
pub(super) const SIGNAL: &str = "signal ";
/// Prefix of the reason why it was not started.
pub(super) const CANNOT_START: &str = "cannot start ";
/// Prefix of warnings.
pub(super) const WARNING: &str = "warning ";

fn say(token: &str, words: &str) {
    // On a line of its own, whatever the detector printed last.
    let _ = writeln!(io::stderr(), "\n{token} {words}");
}

fn start_and_wait(words: &[String], token: &str) -> io::Result<ExitStatus> {
    // Orphans of the detector become our children instead of those of the first process of the machine.
    rustix::process::set_child_subreaper(Some(rustix::process::getpid()))?;
    let (signalled, asked_to_end) = UnixStream::pair()?;
    for signal in [SIGTERM, SIGINT, SIGHUP] {
        signal_hook::low_level::pipe::register(signal, signalled.try_clone()?)?;
    }
    let mut child = start(words)?;
    let pid = Pid::from_child(&child);
    let ended = rustix::process::pidfd_open(pid, PidfdFlags::empty())?;
    wait_for_any(&[ended.as_fd(), asked_to_end.as_fd()]);
    let has_ended = poll(&mut [PollFd::new(&ended, PollFlags::IN)], Some(&Timespec::default())) == Ok(1);
    if !has_ended {
        child.kill()?;
    }
    let status = child.wait()?;
    let n_left_behind = kill_the_rest();
    if has_ended && n_left_behind > 0 {
        say(token, &format!("{WARNING}left {n_left_behind} processes behind, which were killed"));
    }
    Ok(status)
}

/// Starts the detector, which alone has the ends of the pipes from then on.
fn start(words: &[String]) -> io::Result<Child> {
    let (program, arguments) = words.split_first().ok_or(io::ErrorKind::InvalidInput)?;
    // Duplicates are inherited, unlike files that the standard library opens.
    let reading = rustix::io::dup(io::stdin())?;
    let writing = rustix::io::dup(io::stdout())?;
    let printing = io::stderr().as_fd().try_clone_to_owned()?;
    let child = Command::new(program)
        .args(arguments)
        .env_remove(TOKEN)
        .env(READ_FD, reading.as_raw_fd().to_string())
        .env(WRITE_FD, writing.as_raw_fd().to_string())
        .stdin(Stdio::null())
        .stdout(printing)
        .spawn();
    let nothing = std::fs::OpenOptions::new().read(true).write(true).open("/dev/null")?;
    rustix::stdio::dup2_stdin(&nothing)?;
    rustix::stdio::dup2_stdout(&nothing)?;
    child
}

/// Waits until one of `ends` can be read, or the reader of our standard error, the program that started us, is gone.
fn wait_for_any(ends: &[BorrowedFd<'_>]) {
    let stderr = io::stderr();
    loop {
        let mut all: Vec<PollFd<'_>> = ends.iter().map(|it| PollFd::new(it, PollFlags::IN)).collect();
        // Errors are reported whether or not they are asked for.
        all.push(PollFd::new(&stderr, PollFlags::empty()));
        match poll(&mut all, None) {
            Err(Errno::INTR) => {}
            _ => return,
        }
    }
}

/// Kills all remaining child processes and their orphans. Returns their number.
fn kill_the_rest() -> usize {
    let ends = Instant::now() + LONGEST_DEATH;
    let mut killed = std::collections::BTreeSet::new();
    while Instant::now() < ends {
        for pid in children(std::process::id()) {
            let Some(pid) = Pid::from_raw(pid as i32) else { continue };
            let was_alive = !is_dead(pid);
            if rustix::process::kill_process(pid, Signal::KILL).is_ok() && was_alive {
                killed.insert(pid.as_raw_nonzero());
            }
        }
        match rustix::process::wait(WaitOptions::NOHANG) {
            Err(Errno::CHILD) => break,
            Ok(Some(_)) => {}
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    killed.len()
}

/// Whether a process has ended; it may not have been waited for yet.
fn is_dead(pid: Pid) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", pid.as_raw_nonzero())).unwrap_or_default();
    stat.rsplit_once(") ").is_none_or(|(_, state)| state.starts_with('Z'))
}
