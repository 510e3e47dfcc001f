//! Output of the program: results on stdout, everything else on stderr.
//!
//! The macros of the standard library panic when a stream is closed, which is what `| head` does.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::OnceLock;

use crate::plumbing::closed_streams::stdout_was_closed;
use crate::plumbing::failure::Failure;
use reports::files::shown_text::{printable_lines, shown_lines};
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_directory::{REPORT_HTML, recordings_in};
use reports::tables::formats::terminal::Terminal;

/// How much is said on stderr.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verbosity {
    /// Errors.
    Quiet,
    /// Also progress, warnings and where results are.
    Usual,
    /// Also what is done, scan by scan.
    Verbose,
}

// One for the process, as stderr is.
static VERBOSITY: OnceLock<Verbosity> = OnceLock::new();

/// Settles how much is said, once and before anything is.
pub fn set_verbosity(verbosity: Verbosity) {
    VERBOSITY.get_or_init(|| verbosity);
}

/// Whether the program says as much as `least`, or more.
pub fn is_said(least: Verbosity) -> bool {
    *VERBOSITY.get().unwrap_or(&Verbosity::Usual) >= least
}

/// Columns of results that are not printed on a terminal.
const USUAL_WIDTH: usize = 100;

/// Columns that tables have: `COLUMNS` if that is set, else those of the terminal on stdout, else a hundred.
pub fn result_width() -> usize {
    let wanted = std::env::var("COLUMNS").ok().and_then(|it| it.parse().ok()).filter(|it| *it > 0);
    let of_terminal = || {
        let (width, _) = std::io::stdout().is_terminal().then(terminal_size::terminal_size).flatten()?;
        Some(usize::from(width.0))
    };
    wanted.or_else(of_terminal).unwrap_or(USUAL_WIDTH)
}

/// Tables as wide as [`result_width`].
pub fn terminal() -> Terminal {
    Terminal { width: Some(result_width()) }
}

/// Prints a result, which is never coloured. A reader that has seen enough and closed the stream is no error.
pub fn print_result(result: impl Display) -> Result<(), Failure> {
    print_text(&format!("{result}\n"))
}

/// Prints a text with its line end. Control characters from files of others are shown, and not obeyed by the terminal.
pub fn print_text(text: &str) -> Result<(), Failure> {
    // Results are read in full: long tables are not cut.
    print_bytes(printable_lines(text).as_bytes())
}

/// Prints the result of a verb, and then the path of its files, which are `what`. A quiet program prints the path alone.
///
/// If the result cannot be printed, the path is: the files are there.
pub fn print_result_in(what: &str, directory: &Path, result: impl Display) -> Result<(), Failure> {
    if !is_said(Verbosity::Usual) {
        return print_result(directory.display());
    }
    let printed = print_result(result);
    print_diagnostic(format_args!("{what}: {}", directory.display()));
    let page = directory.join(REPORT_HTML);
    if page.is_file() {
        print_diagnostic(format_args!("Page: {}", page.display()));
    }
    let recordings = recordings_in(directory).into_iter();
    let recordings: Vec<String> =
        recordings.map(|it| shell_word(&directory.join(it).display().to_string())).collect();
    if !recordings.is_empty() {
        print_diagnostic(format_args!("Recording: rerun {}", recordings.join(" ")));
    }
    printed
}

/// Prints a result with its line end, such as the content of a file.
pub fn print_bytes(result: &[u8]) -> Result<(), Failure> {
    if stdout_was_closed() {
        return Err(Failure::unwritten("cannot write to stdout", std::io::Error::other("it is closed")));
    }
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(result).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::unwritten("cannot write to stdout", error))
        }
        _ => Ok(()),
    }
}

/// Prints why the program fails. It is lost if stderr is closed.
pub fn print_error(line: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{}", shown_lines(&line.to_string()));
}

/// Prints a line that is no result, unless the program is to be quiet.
pub fn print_diagnostic(line: impl Display) {
    if is_said(Verbosity::Usual) {
        print_error(line);
    }
}

/// Prints a line about what is being done, if the program is to say so.
pub fn print_detail(line: impl Display) {
    if is_said(Verbosity::Verbose) {
        print_error(line);
    }
}
