//! `scanbench score`: judges annotations and detections that another program hands over.

use std::io::{BufRead as _, Read as _};

use clap::Args;
use evaluation::scoring::request::ScoreRequest;
use evaluation::scoring::scored::{ScoreError, score as score_request};
use reports::files::csv_rows::to_csv_bytes;
use serde_json::{Value, json};

use crate::cli::ConfigArgs;
use crate::plumbing::config::load;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::standard_streams::print_bytes;

/// Arguments of `scanbench score`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ScoreArgs {
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
}

const EXAMPLES: &str = "\
Examples:
  scanbench score < request.json

Reads a line of JSON and then points from standard input, and prints a line of JSON: the
report, and the rows of scans and matches as CSV. It is what `scanbench.score` of the
package for Python calls; docs/your-detector.md has an example.";

/// The longest line that is read, in bytes: a million boxes.
const MOST_LINE: u64 = 1 << 28;
/// The most bytes of points.
const MOST_POINTS: u64 = 1 << 34;

/// Judges what standard input has, and prints the numbers.
pub fn score(arguments: &ScoreArgs) -> Result<(), Failure> {
    let unread = |error| Failure::internal("cannot read standard input", error);
    let mut input = std::io::stdin().lock();
    let mut line = Vec::new();
    input.by_ref().take(MOST_LINE).read_until(b'\n', &mut line).map_err(unread)?;
    let request: ScoreRequest = serde_json::from_slice(&line)
        .map_err(|problem| Usage(format!("standard input is no request to score: {problem}")))?;
    let mut payload = Vec::new();
    input.take(MOST_POINTS).read_to_end(&mut payload).map_err(unread)?;
    let mut config = load(&arguments.config)?;
    config = config.overridden(&arguments.config.parameters, &[])?;
    let scored = score_request(&request, &payload, config).map_err(|error| match error {
        ScoreError::Request(problem) => Failure::from(Usage(problem)),
        ScoreError::Run(error) => error.into(),
    })?;
    let report = scored.tally.report(scored.scoring_version, &scored.tally.draw())?;
    let report: Value = serde_json::from_str(&report.to_json())
        .map_err(|error| Failure::internal("the report is no JSON", error))?;
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let answer = json!({
        "report": report,
        "scans": text(to_csv_bytes(&scored.scans)?),
        "matches": text(to_csv_bytes(&scored.matches)?),
    });
    print_bytes(format!("{answer}\n").as_bytes())
}
