//! Ctrl-C, and requests to terminate.
//!
//! The first signal sets a flag, by which the work in hand ends in good order. Work that does not look at the flag, or not
//! soon enough, is ended a moment later, or by the second signal; unfinished files on the disk are removed then.

use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use reports::files::shown_text::shown_lines;
use reports::files::unfinished;

use crate::plumbing::failure::{Failure, Reason};
use crate::plumbing::progress::reached;
use crate::plumbing::standard_streams::{Verbosity, is_said};

/// Time that work has to end after the first signal, in milliseconds; [`set_grace`] changes it.
static GRACE_MS: AtomicU64 = AtomicU64::new(700);
/// Longest wait for the last words: their reader may have stopped reading.
const LONGEST_WORDS: Duration = Duration::from_millis(100);
/// Shells report a signal as this plus its number.
const SIGNALLED: i32 = 128;
const SIGINT: i32 = 2;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static SIGNAL: AtomicI32 = AtomicI32::new(SIGINT);
static LAST_WORDS: Mutex<String> = Mutex::new(String::new());

/// The flag that is set once the user asks for an end.
pub fn interruption_flag() -> &'static AtomicBool {
    &INTERRUPTED
}

/// The exit code of a program that was interrupted: 130 for Ctrl-C, 143 for a request to terminate.
pub fn interruption_exit_code() -> u8 {
    (SIGNALLED + SIGNAL.load(Ordering::Relaxed)) as u8
}

/// From now on, work that is asked to end has `grace` for it. A second signal still ends it at once.
pub fn set_grace(grace: Duration) {
    GRACE_MS.store(grace.as_millis() as u64, Ordering::Relaxed);
}

/// Sets the words that stderr gets if the program is ended in the middle of its work.
pub fn set_last_words(words: String) {
    *LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

/// From now on signals end the program as this module says.
pub fn watch_for_signals() -> Result<(), Failure> {
    watch().map_err(|error| Failure::internal("cannot watch for signals", error))
}

#[cfg(unix)]
fn watch() -> Result<(), Reason> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // A program that shall outlive the terminal is started with the hangup ignored.
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    if !is_ignored(SIGHUP) {
        signals.add_signal(SIGHUP)?;
    }
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            on_signal(signal);
        }
    })?;
    Ok(())
}

#[cfg(not(unix))]
fn watch() -> Result<(), Reason> {
    Ok(ctrlc::set_handler(|| on_signal(SIGINT))?)
}

/// Whether this program was started so that it does not hear `signal`, as far as the system says.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|it| u64::from_str_radix(it.trim(), 16).ok()).unwrap_or(0);
    ignored >> (signal - 1) & 1 == 1
}

fn on_signal(signal: i32) {
    if INTERRUPTED.load(Ordering::Relaxed) {
        end(signal);
    }
    SIGNAL.store(signal, Ordering::Relaxed);
    INTERRUPTED.store(true, Ordering::Relaxed);
    let end_later = move || {
        std::thread::sleep(Duration::from_millis(GRACE_MS.load(Ordering::Relaxed)));
        end(signal)
    };
    if std::thread::Builder::new().spawn(end_later).is_err() {
        end(signal);
    }
}

fn end(signal: i32) -> ! {
    unfinished::remove_for_good();
    let (said, is_said) = std::sync::mpsc::channel();
    let speaker = std::thread::Builder::new().spawn(move || {
        say_last_words();
        said.send(())
    });
    if speaker.is_ok() {
        let _ = is_said.recv_timeout(LONGEST_WORDS);
    }
    std::process::exit(SIGNALLED + signal)
}

fn say_last_words() {
    let mut stderr = std::io::stderr().lock();
    // Not on the line of a progress bar.
    let new_line = if stderr.is_terminal() { "\n" } else { "" };
    let after = reached().map(|it| format!(" after {it}")).unwrap_or_default();
    let _ = writeln!(stderr, "{new_line}error: interrupted{after}");
    let words = LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner);
    if !words.is_empty() && is_said(Verbosity::Usual) {
        let _ = writeln!(stderr, "{}", shown_lines(&words));
    }
}
