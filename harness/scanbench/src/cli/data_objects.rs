//! Arguments of `scanbench data objects`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use scans::object_cloud::cut_out::CutOutParams;
use scans::object_cloud::cut_out_objects::Registration;
use simulator::object_clouds::open_objects::ObjectOptions;
use simulator::object_clouds::simulated_objects::ObjectPart;

use super::help_text::{DATA, OUTPUT};
use super::scans::SourceArgs;

/// Which objects are taken.
#[derive(Debug, Args)]
pub struct ObjectArgs {
    /// Which part of simulated objects: no object is in two
    #[arg(long, value_enum, value_name = "PART", default_value = "development", help_heading = DATA)]
    pub part: PartName,
    /// Simulated objects of each class
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = DATA)]
    pub per_class: u32,
    /// Put objects of data sets together from all scans that show them
    #[arg(long, help_heading = DATA)]
    pub registered: bool,
}

impl ObjectArgs {
    /// The same as options.
    pub fn options(&self) -> ObjectOptions {
        let registration = if self.registered { Registration::OverScans } else { Registration::EachScan };
        ObjectOptions {
            part: self.part.part(),
            n_per_class: self.per_class,
            registration,
            cut_out: CutOutParams::USUAL,
        }
    }
}

/// A part of simulated objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PartName {
    /// Models are trained on them
    Training,
    /// Choices are made with them
    Development,
    /// Results are measured on them
    Judging,
}

impl PartName {
    fn part(self) -> ObjectPart {
        match self {
            Self::Training => ObjectPart::Training,
            Self::Development => ObjectPart::Development,
            Self::Judging => ObjectPart::Judging,
        }
    }
}

/// Arguments of `scanbench data objects`.
#[derive(Debug, Args)]
#[command(after_help = OBJECTS_EXAMPLES)]
pub struct DataObjectsArgs {
    /// Simulated objects (objects-around, objects-hdl-64e-s2, objects-hdl-32e, objects-vlp-16, objects-os1-128, objects-air or
    /// objects-approach), a folder with a folder for each class, or a data set
    #[arg(value_name = "OBJECTS")]
    pub objects: String,
    /// Which of them.
    #[command(flatten)]
    pub choice: ObjectArgs,
    /// How a data set is opened.
    #[command(flatten)]
    pub source: SourceArgs,
    /// Folder to write, which must not exist
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: PathBuf,
}

const OBJECTS_EXAMPLES: &str = "\
Examples:
  scanbench data objects objects-approach --per-class 50 -o approached
  scanbench data objects ~/data/semantic_kitti --registered -o poles-and-cars

Writes CLASS/ID.npy: rows of x, y, z in metres, z up and the ground at 0, and the
intensity. objects.json says whether they are simulated, and how a cloud grew.";
