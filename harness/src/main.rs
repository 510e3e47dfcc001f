//! The program `scanbench`.

use std::process::ExitCode;

use clap::Parser as _;
use harness::cli::Cli;
use harness::commands::dispatch::dispatch;
use harness::commands::failure::Failure;

fn main() -> ExitCode {
    // Returning instead of exiting lets recordings and half-written files end properly.
    match dispatch(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(Failure::of(&error) as u8)
        }
    }
}
