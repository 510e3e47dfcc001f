//! Arguments of `scanbench partial`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::data_objects::ObjectArgs;
use super::help_text::{JUDGING, TRAINING, VIEWER, with_details};
use super::output::OutputArgs;
use super::scans::SourceArgs;
use super::shard::ShardArgs;

/// Arguments of `scanbench partial`.
#[derive(Debug, Args)]
#[command(after_help = PARTIAL_EXAMPLES, after_long_help = with_details(PARTIAL_EXAMPLES, PARTIAL_DETAILS))]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
pub struct PartialArgs {
    /// Objects that are judged: simulated ones, a folder with a folder for each class, or a data set
    #[arg(value_name = "OBJECTS", default_value = "objects-around")]
    pub objects: Vec<String>,
    /// Which objects.
    #[command(flatten)]
    pub choice: ObjectArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// How data sets are opened.
    #[command(flatten)]
    pub source: SourceArgs,
    /// Model that classifies [default: the one that comes with the program]
    #[arg(long, value_name = "FILE", conflicts_with = "train", help_heading = TRAINING)]
    pub model: Option<PathBuf>,
    /// Train the bag of graphs and its rivals on these objects, instead of taking a model
    ///
    /// Of simulated objects, the training part is for learning. Of recorded objects that are also judged, every second is
    /// for learning, and the others are judged.
    #[arg(long, value_name = "OBJECTS", help_heading = TRAINING)]
    pub train: Option<String>,
    /// Learn from whole clouds, as the paper does, from parts, or from each in turn [default: whole,parts]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT", requires = "train", hide_possible_values = true, hide_short_help = true, help_heading = TRAINING)]
    pub trained_on: Vec<LearnedFrom>,
    /// Compare the method with itself without each part, instead of with rivals
    #[arg(long, requires = "train", hide_short_help = true, help_heading = JUDGING)]
    pub ablation: bool,
    /// Also judge fences, hedges and the like; methods may reject objects
    #[arg(long, help_heading = JUDGING)]
    pub others: bool,
    /// Show objects of objects-approach as the scanner of the drive sees them, instead of step by step
    #[arg(long, help_heading = JUDGING)]
    pub drives: bool,
    /// Results of another program on the same objects, called NAME in tables; may be repeated
    #[arg(long, value_name = "NAME=FILE", hide_short_help = true, help_heading = JUDGING)]
    pub peer_results: Vec<PeerResults>,
    /// Where everything is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Write no Rerun recording
    #[arg(long, hide_short_help = true, help_heading = VIEWER)]
    #[allow(dead_code, reason = "read by the viewer, where there is one")]
    pub no_rrd: bool,
}

/// What methods learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LearnedFrom {
    /// Whole clouds
    Whole,
    /// All parts of them
    Parts,
}

/// A file of another program, and what it is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PeerResults {
    /// The name used in tables.
    pub name: String,
    /// The file.
    pub file: PathBuf,
}

impl FromStr for PeerResults {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, file)) if !name.is_empty() && !file.is_empty() => {
                Ok(Self { name: name.to_owned(), file: PathBuf::from(file) })
            }
            _ => Err("write NAME=FILE, such as esf=esf-partial.csv".to_owned()),
        }
    }
}

const PARTIAL_EXAMPLES: &str = "\
Examples:
  scanbench partial --per-class 60
  scanbench partial objects-approach --drives --per-class 60 --part judging
  scanbench partial ~/data/object_clouds --others
  scanbench partial objects-around --train objects-around --per-class 60
  scanbench partial ~/data/object_clouds --train ~/data/object_clouds
  scanbench partial --per-class 60 --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards";

const PARTIAL_DETAILS: &str = "\
Every object is uncovered in ten steps, from below and from above. Each step adds a tenth of
its largest extent.

Writes partial.csv with a row for every object, step and method, the tables as
Markdown and LaTeX, figures as SVG and PDF, report.html, and a recording of one
object of each class. `scanbench compare` and `scanbench gate` take the directory.

With --shard it judges some of the objects; every shard learns from all. Shards have no
recording.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peers_have_a_name_and_a_file() {
        let peer: PeerResults = "esf (PCL)=a=b.csv".parse().unwrap();
        assert_eq!((peer.name.as_str(), peer.file), ("esf (PCL)", PathBuf::from("a=b.csv")));
        for text in ["esf.csv", "=esf.csv", "esf="] {
            assert!(text.parse::<PeerResults>().unwrap_err().contains("NAME=FILE"));
        }
    }
}
