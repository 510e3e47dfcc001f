//! The program `scanbench`: arguments, verbs, terminal.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

use std::process::ExitCode;

use clap::Parser as _;

mod cli;
mod commands;

use cli::Cli;
use commands::dispatch::dispatch;
use commands::failure::exit_code_of;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Returning instead of exiting lets recordings and half-written files end properly.
    ExitCode::from(exit_code_of(|| dispatch(&cli)))
}
