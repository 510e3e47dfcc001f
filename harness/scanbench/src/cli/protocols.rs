//! The protocols of others that detections are evaluated under.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use evaluation::protocols::known_protocols::known_protocols;
use reports::vocabulary::protocol::Protocol;

use super::help_text::JUDGING;

/// The protocols of others that detections are evaluated under.
#[derive(Debug, Args)]
#[command(next_help_heading = JUDGING)]
pub struct ProtocolArgs {
    /// Evaluate as others do, too; docs/protocols.md
    #[arg(
        long = "protocol",
        value_name = "NAMES",
        value_delimiter = ',',
        value_parser = protocol_parser(),
        hide_possible_values = true,
        long_help = protocol_help()
    )]
    pub protocols: Vec<Protocol>,
}

/// Which protocols there are, and what they leave.
fn protocol_help() -> String {
    let names: Vec<String> = known_protocols().map(|it| format!("`{it}`")).collect();
    format!(
        "Evaluate as others do, too: {}; docs/protocols.md\n\n\
         A run directory gets `protocols.json`, the rows of it, and a table for each protocol.",
        names.join(", ")
    )
}

/// Takes the names of the protocols there are.
fn protocol_parser() -> impl clap::builder::TypedValueParser<Value = Protocol> {
    let names = known_protocols().map(Protocol::name);
    PossibleValuesParser::new(names)
        .map(|it| Protocol::from_name(&it).expect("only these names are possible"))
}
