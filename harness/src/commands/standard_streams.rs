//! What the program says: results on stdout, everything else on stderr.
//!
//! The macros of the standard library panic when a stream is closed, which is what `| head` does.

use std::fmt::Display;
use std::io::{ErrorKind, Write as _};

use anyhow::Context as _;

/// Prints a result, which is never coloured. A reader that has seen enough and closed the stream is no error.
///
/// # Errors
///
/// If stdout takes nothing for another reason, such as a full disk.
pub fn print_result(result: impl Display) -> anyhow::Result<()> {
    print_bytes(format!("{result}\n").as_bytes())
}

/// Prints a result that ends as it should, such as the content of a file.
///
/// # Errors
///
/// As [`print_result`].
pub fn print_bytes(result: &[u8]) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(result).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to stdout"),
        _ => Ok(()),
    }
}

/// Prints a line that is no result. Where nobody listens, it is lost.
pub fn print_diagnostic(line: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
