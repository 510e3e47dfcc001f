//! The program `scanbench`: arguments, verbs, terminal.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

use std::process::ExitCode;

use clap::Parser as _;
use reports::files::unfinished;

mod cli;
mod plumbing;
mod verbs;

use plumbing::exit_code::exit_code_of;
use plumbing::interruption::watch_for_signals;
use verbs::Cli;
#[cfg(target_os = "linux")]
use verbs::Command;
use verbs::dispatch;
#[cfg(target_os = "linux")]
use verbs::serve::supervise;

fn main() -> ExitCode {
    let cli = Cli::parse();
    #[cfg(target_os = "linux")]
    if let Command::Supervise { sandbox, hide, command } = &cli.command {
        // It has its own way with signals.
        supervise(command, sandbox.then_some(hide));
        return ExitCode::SUCCESS;
    }
    // Returning instead of exiting lets recordings and half-written files end properly.
    ExitCode::from(exit_code_of(|| {
        let done = watch_for_signals().and_then(|()| dispatch(&cli));
        // A signal comes too late now.
        unfinished::keep_for_good();
        done
    }))
}
