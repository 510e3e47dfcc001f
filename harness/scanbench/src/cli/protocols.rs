//! The protocols of others that detections are evaluated under.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use reports::vocabulary::protocol::Protocol;

use super::help_text::JUDGING;

/// The protocols of others that detections are evaluated under.
#[derive(Debug, Args)]
#[command(next_help_heading = JUDGING)]
pub struct ProtocolArgs {
    /// Add the official scores of benchmarks; docs/protocols.md
    ///
    /// A run directory gets `protocols.json`, its rows, and a table for each protocol.
    #[arg(long = "protocol", value_name = "NAMES", value_delimiter = ',', value_parser = protocol_parser(), hide_short_help = true)]
    pub protocols: Vec<Protocol>,
}

/// Takes the names of the protocols there are.
fn protocol_parser() -> impl clap::builder::TypedValueParser<Value = Protocol> {
    let names = Protocol::ALL.map(Protocol::name);
    PossibleValuesParser::new(names)
        .map(|it| Protocol::from_name(&it).expect("only these names are possible"))
}
