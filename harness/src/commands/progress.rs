//! Progress bars.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar on stderr over `n_scans` scans, with scans per second and time left; invisible when stderr is no terminal.
pub fn progress_over_scans(n_scans: usize, label: &str) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} scans, {per_sec}, {eta} left")
        .expect("the template is constant and tested by use");
    let bar = ProgressBar::with_draw_target(Some(n_scans as u64), target).with_style(style);
    bar.set_message(label.to_owned());
    bar
}
