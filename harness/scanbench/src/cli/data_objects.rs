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
    /// Which part of simulated objects; the parts share no object [default: development]
    #[arg(long, value_enum, value_name = "PART", help_heading = DATA)]
    pub part: Option<PartName>,
    /// Simulated objects of each class [default: 300]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = DATA)]
    pub per_class: Option<u32>,
    /// Register and join the points of an object from all scans that show it
    #[arg(long, help_heading = DATA)]
    pub registered: bool,
}

/// Simulated objects of each class, unless another number is asked for.
const USUAL_PER_CLASS: u32 = 300;

impl ObjectArgs {
    /// The same as options.
    pub fn options(&self) -> ObjectOptions {
        let part = self.part.unwrap_or(PartName::Development).part();
        let registration = if self.registered { Registration::OverScans } else { Registration::EachScan };
        let n_per_class = self.per_class.unwrap_or(USUAL_PER_CLASS);
        ObjectOptions { registration, ..object_options(part, n_per_class) }
    }
}

/// So many objects of each class of a part of simulated ones; each as one scan shows it, if they are cut out of a data set.
pub fn object_options(part: ObjectPart, n_per_class: u32) -> ObjectOptions {
    ObjectOptions { part, n_per_class, registration: Registration::EachScan, cut_out: CutOutParams::USUAL }
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
    /// Simulated objects (objects-around, objects-hdl-64e-s2, objects-hdl-32e, objects-vlp-16, objects-os1-128, objects-air
    /// or objects-approach), a folder with a folder for each class, or a data set
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
