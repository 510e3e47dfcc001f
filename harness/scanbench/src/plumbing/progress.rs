//! Progress bars.

use std::io::IsTerminal as _;
use std::sync::{Mutex, PoisonError};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use reports::files::shown_text::shown;

use crate::plumbing::standard_streams::{Verbosity, is_said, print_diagnostic};

/// The bar of the work in hand, and what it counts.
static CURRENT: Mutex<Option<(ProgressBar, &str)>> = Mutex::new(None);

/// How far the work in hand is, such as `7 of 60 scans`; `None` if nothing is counted.
pub fn reached() -> Option<String> {
    let current = CURRENT.lock().unwrap_or_else(PoisonError::into_inner);
    let (bar, counted) = current.as_ref()?;
    let n_all = bar.length().filter(|it| *it > 0 && !bar.is_finished())?;
    Some(format!("{} of {n_all} {counted}", bar.position()))
}

/// A bar on stderr over `n_scans` scans, with scans per second and time left; invisible when stderr is no terminal, or the
/// program is to be quiet.
pub fn progress_over_scans(n_scans: usize, label: &str) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() && is_said(Verbosity::Usual) {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let style = style_of("{msg} {wide_bar} {pos}/{len} scans{pace}");
    let bar = ProgressBar::with_draw_target(Some(n_scans as u64), target).with_style(style);
    bar.set_message(shown(label).into_owned());
    set_current(&bar, "scans");
    bar
}

fn set_current(bar: &ProgressBar, counted: &'static str) {
    *CURRENT.lock().unwrap_or_else(PoisonError::into_inner) = Some((bar.clone(), counted));
}

/// Style of a bar; `{pace}` in `template` is results per second and time left, once something is done.
fn style_of(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template).expect("the template is constant and tested by use");
    style.with_key("pace", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        if state.per_sec() > 0.0 {
            // A bar that cannot be written to has no reader.
            let _ = write!(text, ", {:.1}/s, {:#} left", state.per_sec(), HumanDuration(state.eta()));
        }
    })
}

/// As [`progress_over_scans`], over `n_results` results of any kind, of which `n_done` are done; `label` names the work.
pub fn progress_over_results(n_results: usize, n_done: usize, label: &str) -> ProgressBar {
    let bar = progress_over_scans(n_results, label);
    bar.set_style(style_of("{msg} {wide_bar} {pos}/{len}{pace}"));
    bar.set_position(n_done as u64);
    bar.reset_eta();
    set_current(&bar, "results");
    bar
}

/// The bar of a run over one data set after the other, shared by all code that writes to the terminal.
#[derive(Debug, Clone)]
pub struct RunProgress(ProgressBar);

impl RunProgress {
    /// A bar that shows nothing yet.
    pub fn new() -> Self {
        Self(progress_over_scans(0, ""))
    }

    /// Begins anew, over the scans of `dataset`.
    pub fn begin(&self, n_scans: usize, dataset: &str) {
        self.0.reset();
        self.0.set_length(n_scans as u64);
        self.0.set_message(shown(dataset).into_owned());
    }

    pub fn advance(&self) {
        self.0.inc(1);
    }

    /// Takes the bar away until the next one begins.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }

    /// Does `work`, which writes to the terminal, without the bar in its way.
    pub fn suspend<T>(&self, work: impl FnOnce() -> T) -> T {
        self.0.suspend(work)
    }

    /// Prints a warning. Not through the bar itself, which says nothing where it is hidden.
    pub fn warn(&self, warning: &str) {
        self.suspend(|| print_diagnostic(format_args!("warning: {warning}")));
    }
}
