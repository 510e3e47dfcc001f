//! The program `scanbench`.

use std::process::ExitCode;

use clap::Parser as _;
use harness::cli::Cli;
use harness::commands::dispatch::dispatch;
use harness::commands::failure::exit_code_of;
use harness::commands::interruption::watch_for_signals;
use reports::files::unfinished;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Returning instead of exiting lets recordings and half-written files end properly.
    ExitCode::from(exit_code_of(|| {
        let done = watch_for_signals().and_then(|()| dispatch(&cli));
        // A signal comes too late now.
        unfinished::keep_for_good();
        done
    }))
}
