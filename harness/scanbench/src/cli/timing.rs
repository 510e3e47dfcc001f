//! What runs beside what.

use clap::Args;

use super::help_text::DETECTORS;

/// What runs beside what, so that times mean something.
#[derive(Debug, Args)]
#[command(next_help_heading = DETECTORS)]
pub struct TimingArgs {
    /// Scans to read or simulate at once; detectors always run one at a time [default: number of cores]
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Untimed detections of the first scan before the timed ones
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 3)]
    pub warmup: u16,
}

impl TimingArgs {
    /// Scans that are read at once.
    pub fn n_jobs(&self) -> usize {
        let n_cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.jobs.map_or_else(n_cores, usize::from)
    }
}
