//! Whether the program was started without a standard output.
//!
//! Before `main`, the standard library opens `/dev/null` in the place of streams that are closed, so that results would be
//! lost without an error. Only before that can it be known.

use std::sync::atomic::{AtomicBool, Ordering};

static STDOUT_WAS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether stdout was closed when the program started.
pub fn stdout_was_closed() -> bool {
    STDOUT_WAS_CLOSED.load(Ordering::Relaxed)
}

#[cfg(target_os = "linux")]
mod before_main {
    use std::sync::atomic::Ordering;

    use super::STDOUT_WAS_CLOSED;

    // SAFETY: the loader calls all functions of this section once, before other threads. This one asks the system about a
    // file descriptor and sets an atomic, for which the standard library need not have begun.
    #[used]
    #[expect(unsafe_code, reason = "nothing else runs before the standard library opens the streams")]
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        let is_closed = rustix::io::fcntl_getfd(rustix::stdio::stdout()) == Err(rustix::io::Errno::BADF);
        STDOUT_WAS_CLOSED.store(is_closed, Ordering::Relaxed);
    }
}
