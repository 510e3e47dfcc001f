//! The last lines that a detector printed.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read};
use std::os::fd::{AsFd, OwnedFd};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, poll};

/// Most lines that are kept.
const MOST_LINES: usize = 20;
/// Most bytes of a line.
const MOST_LINE_BYTES: usize = 400;
/// Longest wait for the last lines: a process that the detector left behind may hold the pipe for ever.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Reads the printed lines on a thread of its own, and keeps the last ones.
#[derive(Debug)]
pub struct LastWords {
    kept: Arc<Mutex<Kept>>,
    is_read: Receiver<()>,
    // Another descriptor of the pipe, to ask whether anything is left in it.
    pipe: Option<OwnedFd>,
}

#[derive(Debug, Default)]
struct Kept {
    lines: VecDeque<String>,
    of_supervisor: Vec<String>,
}

impl LastWords {
    /// Begins to read. Lines that begin with `token` are from the [supervisor](super::supervisor).
    pub fn of(printed: impl Read + AsFd + Send + 'static, token: String) -> Self {
        let pipe = printed.as_fd().try_clone_to_owned().ok();
        let kept = Arc::new(Mutex::new(Kept::default()));
        let keeper = Arc::clone(&kept);
        let (ended, is_read) = channel();
        let reader = std::thread::Builder::new().name("last words".to_owned());
        // Without a thread nothing is kept, and the detector works all the same.
        let _ = reader.spawn(move || {
            keep(printed, &token, &keeper);
            let _ = ended.send(());
        });
        Self { kept, is_read, pipe }
    }

    /// Up to twenty lines, the last one last. If the detector has just ended, they are complete once [`Self::wait`] returns.
    pub fn lines(&self) -> Vec<String> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).lines.iter().cloned().collect()
    }

    /// Lines of the supervisor about the end of the detector.
    pub fn of_supervisor(&self) -> Vec<String> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).of_supervisor.clone()
    }

    /// Waits until all that was printed before is read, a second at most.
    pub fn catch_up(&self) {
        let ends = Instant::now() + LONGEST_WAIT;
        while self.is_behind() && Instant::now() < ends {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn is_behind(&self) -> bool {
        let _kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        self.pipe.as_ref().is_some_and(|it| rustix::io::ioctl_fionread(it).is_ok_and(|n_left| n_left > 0))
    }

    /// Waits until no process can print any more, a second at most.
    pub fn wait(&self) {
        let _ = self.is_read.recv_timeout(LONGEST_WAIT);
    }
}

fn keep(mut printed: impl Read + AsFd, token: &str, kept: &Mutex<Kept>) {
    let (mut line, mut bytes) = (Vec::new(), [0; 4096]);
    loop {
        let waited = poll(&mut [PollFd::new(&printed, PollFlags::IN)], None);
        // Bytes are read and kept under the lock of `is_behind`: an empty pipe means that all is kept.
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        let n_read = match waited.map_err(Into::into).and_then(|_| printed.read(&mut bytes)) {
            Ok(n_read) => n_read,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(_) => 0,
        };
        for byte in &bytes[..n_read] {
            line.push(*byte);
            // Lines without an end are taken in pieces.
            if *byte == b'\n' || line.len() == MOST_LINE_BYTES {
                kept.add(&line, token);
                line.clear();
            }
        }
        if n_read == 0 {
            return kept.add(&line, token);
        }
    }
}

impl Kept {
    fn add(&mut self, line: &[u8], token: &str) {
        let text = String::from_utf8_lossy(line);
        if let Some(of_supervisor) = text.strip_prefix(token) {
            if self.of_supervisor.len() < MOST_LINES {
                self.of_supervisor.push(printable(of_supervisor.trim()));
            }
        } else if !text.trim().is_empty() {
            if self.lines.len() == MOST_LINES {
                self.lines.pop_front();
            }
            self.lines.push_back(printable(text.trim_end()));
        }
    }
}

/// Without control characters that could draw on the user's terminal.
fn printable(text: &str) -> String {
    text.chars().map(|it| if it.is_control() && it != '\t' { '\u{fffd}' } else { it }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    fn words_of(printed: &str) -> LastWords {
        let (from, to) = std::io::pipe().unwrap();
        let words = LastWords::of(from, "token-1".to_owned());
        { to }.write_all(printed.as_bytes()).unwrap();
        words.wait();
        words
    }

    #[test]
    fn what_was_printed_is_there_though_the_pipe_stays_open() {
        for round in 0..50 {
            let (from, mut to) = std::io::pipe().unwrap();
            let words = LastWords::of(from, "token-1".to_owned());
            for line in 0..20 {
                writeln!(to, "line {line} of round {round}").unwrap();
            }
            words.catch_up();
            assert_eq!(words.lines().last(), Some(&format!("line 19 of round {round}")));
        }
    }

    #[test]
    fn the_last_lines_are_kept() {
        let printed: Vec<String> = (0..100).map(|it| format!("line {it}")).collect();
        let lines = words_of(&printed.join("\n")).lines();
        assert_eq!((lines.len(), lines[0].as_str(), lines[19].as_str()), (20, "line 80", "line 99"));
    }

    #[test]
    fn endless_lines_and_control_characters_do_no_harm() {
        let words = words_of(&format!("{}\u{1b}[31mred", "x".repeat(1000)));
        assert!(words.lines().iter().all(|it| it.len() <= 410 && !it.contains('\u{1b}')));
        let said = words_of("mine\n\ntoken-1 exit\u{1b} 2\ntoken-2 exit 3\n");
        assert_eq!(said.lines(), ["mine", "token-2 exit 3"]);
        assert_eq!(said.of_supervisor(), ["exit\u{fffd} 2"]);
    }
}
