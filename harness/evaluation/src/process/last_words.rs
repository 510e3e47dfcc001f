//! The last lines that a detector printed.

use std::collections::VecDeque;
use std::io::{BufRead as _, BufReader, Read};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Lines that are kept.
const MOST_LINES: usize = 20;
/// Of each line this many bytes.
const MOST_LINE_BYTES: u64 = 400;
/// What stands before lines of the [supervisor](super::supervisor), which are no words of the detector.
pub(super) const SUPERVISOR: &str = "\u{1e}scanbench: ";

/// Reads what is printed, on a thread of its own, and keeps the end.
#[derive(Debug)]
pub struct LastWords {
    kept: Arc<Mutex<Kept>>,
    reader: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Kept {
    lines: VecDeque<String>,
    of_supervisor: Vec<String>,
}

impl LastWords {
    /// Begins to read.
    pub fn of(printed: impl Read + Send + 'static) -> Self {
        let kept = Arc::new(Mutex::new(Kept::default()));
        let keeper = Arc::clone(&kept);
        let reader = std::thread::Builder::new().name("last words".to_owned());
        // Without a thread nothing is kept, and the detector works all the same.
        let reader = reader.spawn(move || keep(printed, &keeper)).ok();
        Self { kept, reader }
    }

    /// Up to twenty lines, the last one last. Whoever has just ended has said all of it once [`Self::wait`] returns.
    pub fn lines(&self) -> Vec<String> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).lines.iter().cloned().collect()
    }

    /// What the supervisor says about its end.
    pub fn of_supervisor(&self) -> Vec<String> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).of_supervisor.clone()
    }

    /// Waits until nobody can print any more.
    pub fn wait(&mut self) {
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

fn keep(printed: impl Read, kept: &Mutex<Kept>) {
    let mut printed = BufReader::new(printed);
    let mut line = Vec::new();
    loop {
        line.clear();
        // Lines without an end are taken in pieces.
        match printed.by_ref().take(MOST_LINE_BYTES).read_until(b'\n', &mut line) {
            Ok(1..) => {}
            Ok(0) | Err(_) => return,
        }
        let text = String::from_utf8_lossy(&line);
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(of_supervisor) = text.strip_prefix(SUPERVISOR) {
            kept.of_supervisor.push(of_supervisor.trim_end().to_owned());
            continue;
        }
        if kept.lines.len() == MOST_LINES {
            kept.lines.pop_front();
        }
        kept.lines.push_back(printable(text.trim_end()));
    }
}

/// Without what could draw on the user's terminal.
fn printable(text: &str) -> String {
    text.chars().map(|it| if it.is_control() && it != '\t' { '\u{fffd}' } else { it }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words_of(printed: &str) -> LastWords {
        let mut words = LastWords::of(std::io::Cursor::new(printed.to_owned()));
        words.wait();
        words
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
        let said = words_of(&format!("mine\n{SUPERVISOR}killed 2\n"));
        assert_eq!(
            (said.lines(), said.of_supervisor()),
            (vec!["mine".to_owned()], vec!["killed 2".to_owned()])
        );
    }
}
