//! What runs beside what.

use clap::Args;

/// What runs beside what, so that times mean something.
#[derive(Debug, Args)]
pub struct TimingArgs {
    /// Scans read or simulated at once; detectors always run alone [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Detections of the first scan that are thrown away before anything is timed
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub warmup: u16,
}

impl TimingArgs {
    /// Scans that are read at once.
    pub fn n_jobs(&self) -> usize {
        let n_cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.jobs.map_or_else(n_cores, usize::from)
    }
}
