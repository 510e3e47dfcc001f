//! The arguments of `scanbench data prelabel`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use evaluation::run::detector_list::DETECTORS;
use scans::conversion::proposal_writer::ProposalFormat;

use super::detectors::detector_names;
use super::help_text::{DETECTORS as DETECTORS_HEADING, OUTPUT};
use super::parameters::ConfigArgs;
use super::scans::{DamageArgs, DatasetArgs};

/// Arguments of `scanbench data prelabel`.
#[derive(Debug, Args)]
#[command(after_help = PRELABEL_EXAMPLES)]
pub struct PrelabelArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// The detector.
    #[arg(short, long, value_name = "NAME", help = format!("Detector: {}", detector_names().join(", ")), default_value = DETECTORS[0].name)]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub detector: String,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Folder to write; for several data sets, a folder for all
    #[arg(short, long, help_heading = OUTPUT, value_name = "DIR")]
    pub output: PathBuf,
    /// Annotation tool to write for
    #[arg(long, value_enum, value_name = "TOOL", help_heading = OUTPUT)]
    pub to: ToolName,
    /// Propose only vehicles with at least this score
    #[arg(long, help_heading = OUTPUT, value_name = "SCORE")]
    pub min_score: Option<f32>,
}

/// Annotation tools by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ToolName {
    /// KITTI's object benchmark: `velodyne/*.bin`, `label_2/*.txt`
    Kitti,
    /// labelCloud: `pointclouds/*.bin`, `labels/*.json` in its format `centroid_rel`
    Labelcloud,
    /// `SUSTechPOINTS`: a scene with `lidar/*.pcd` and `label/*.json`
    Sustechpoints,
}

impl ToolName {
    /// The format that it reads.
    pub fn format(self) -> ProposalFormat {
        match self {
            Self::Kitti => ProposalFormat::Kitti,
            Self::Labelcloud => ProposalFormat::Labelcloud,
            Self::Sustechpoints => ProposalFormat::Sustechpoints,
        }
    }
}

const PRELABEL_EXAMPLES: &str = "\
Examples:
  scanbench data prelabel ~/data/my_scans -o project --to labelcloud
  scanbench data prelabel drive.mcap --scans 0..100:10 -o data/drive --to sustechpoints
  scanbench data prelabel capture.pcap -d hierarchical --min-score 0.5 -o drive --to kitti

Writes the scans and a box for each detected vehicle. Correct the boxes in the tool;
what it saves is a data set: scanbench run project.";
