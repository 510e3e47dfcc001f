//! Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C (or a request to terminate) sets the returned flag, so that the work in hand can end
/// without leaving anything half-written; the second ends the program at once.
///
/// # Errors
///
/// If the operating system takes no handler, or one is set already.
pub fn interruption_flag() -> Result<&'static AtomicBool, ctrlc::Error> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })?;
    Ok(&INTERRUPTED)
}
