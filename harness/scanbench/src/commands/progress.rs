//! Progress bars.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::commands::standard_streams::{Verbosity, is_said};

/// A bar on stderr over `n_scans` scans, with scans per second and time left; invisible when stderr is no terminal, or the
/// program is to be quiet.
pub fn progress_over_scans(n_scans: usize, label: &str) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() && is_said(Verbosity::Usual) {
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

/// The same over `n_results` results of any kind, of which `n_done` were there before; `label` says what is done.
pub fn progress_over_results(n_results: usize, n_done: usize, label: &str) -> ProgressBar {
    let bar = progress_over_scans(n_results, label);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {per_sec}, {eta} left")
        .expect("the template is constant and tested by use");
    bar.set_style(style);
    bar.set_position(n_done as u64);
    bar.reset_eta();
    bar
}
