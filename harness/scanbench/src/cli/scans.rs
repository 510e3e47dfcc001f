//! Which scans are taken, and how data sets are opened.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::Resettable;
use reports::vocabulary::class::AnnotationClass;
use scans::dataset::class_table::class_of_word;
use scans::dataset::dataset_format::DatasetFormat;
use scans::dataset::point_columns::PointColumns;
use scans::dataset::source::DamagePolicy;
use simulator::sensor::EMBEDDED_SENSORS;

use super::help_text::DATA;

/// Where data sets are looked up.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct CatalogueArgs {
    /// Catalogue of data sets [default: the built-in one]
    #[arg(long, value_name = "FILE", env = "SCANBENCH_DATASETS", hide_short_help = true)]
    pub catalogue: Option<PathBuf>,
}

/// Which scans are taken.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct DatasetArgs {
    /// Data sets: ids of the catalogue, paths, s3://…
    #[arg(value_name = "DATASET", default_value = simulator::catalogue::DEFAULT_DATASETS, help_heading = Resettable::Reset)]
    pub datasets: Vec<String>,
    /// Scans to take from each data set, such as `7`, `0..500` or `0..500:5`
    ///
    /// Scans are counted from 0. `0..500` is without 500, `0..500:5` is every fifth scan. Separate several by commas.
    #[arg(long, value_name = "RANGE")]
    pub scans: Option<String>,
    /// How they are opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Which scans are near one another.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct BlocksArgs {
    /// CSV file with the columns scan and block: intervals are drawn from these blocks of scans
    ///
    /// A scan has its name in tables, such as `training/000310`, or its number if no other scan has that. A block may be a
    /// drive, a place or a day. Without the file, blocks are drives or seconds.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub blocks: Option<PathBuf>,
}

/// How data sets are opened.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct SourceArgs {
    /// Format of data sets given as paths.
    #[arg(long, value_name = "FORMAT", help = format_help(), hide_short_help = true)]
    pub format: Option<String>,
    /// Topic of the clouds in MCAP recordings, or address of the sensor in captures of packets [default: the only one]
    #[arg(long, value_name = "TOPIC", hide_short_help = true)]
    pub topic: Option<String>,
    /// Topic of the annotations in MCAP recordings [default: /annotations, or the only one]
    #[arg(long, value_name = "TOPIC", hide_short_help = true)]
    pub annotation_topic: Option<String>,
    /// Read the class NAME of labels as CLASS, such as `forklift=misc`; may be repeated, ignores case
    #[arg(long = "class", value_name = "NAME=CLASS", hide_short_help = true)]
    pub classes: Vec<ClassOption>,
    /// Seed of simulated data sets [default: the catalogue's]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Number of scans of simulated data sets [default: the catalogue's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), hide_short_help = true)]
    pub simulated_scans: Option<u32>,
    /// Sensor.
    #[arg(long, value_name = "SENSOR", help = format!("{} [default: the catalogue's, or what scans show]", sensor_help()))]
    pub sensor: Option<String>,
    /// Height of the sensor above the road in metres [default: the catalogue's, or as the scans show it]
    #[arg(long, value_name = "M", value_parser = sensor_height_m, hide_short_help = true)]
    pub sensor_height: Option<f32>,
    /// File with the transform from the frame of recorded files to the sensor's: x forward, y left, z up
    ///
    /// A matrix of 4 × 4 or 3 × 4 numbers row by row, or x y z and a quaternion x y z w, or x y z roll pitch yaw as ROS has
    /// them; in metres and radians. It moves points and boxes.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub transform: Option<PathBuf>,
    /// Labels reach only so many degrees to either side of forward, as where a camera's view was labelled; detections beyond are
    /// ignored [default: as the format has it]
    ///
    /// Labels beyond are taken away. The protocols of --protocol, which have their makers' rules, take all labels.
    #[arg(long, value_name = "DEG", value_parser = degrees_to_either_side, hide_short_help = true)]
    pub labels_ahead: Option<f32>,
    /// Columns of points in `.bin` and `.npy` files, such as `x,y,z,intensity,ring` [default: by what the numbers look like]
    ///
    /// x, y, z, intensity and ring in the order of the file; `_` stands for a column that is not read.
    #[arg(long, value_name = "NAMES", hide_short_help = true)]
    pub columns: Option<PointColumns>,
    /// Folder that data sets at addresses are fetched into [default: ~/.cache/scanbench]
    ///
    /// All of a data set is fetched, whatever --scans says; give the address of a drive to fetch less. Only what is new or
    /// has changed is fetched again.
    #[arg(long, value_name = "DIR", env = "SCANBENCH_CACHE", hide_short_help = true)]
    pub cache: Option<PathBuf>,
    /// Where ids are looked up.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
}

/// A name of a class and what it stands for, as `--class` has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassOption {
    /// The name in the labels; empty for labels that say none.
    pub name: String,
    /// The class.
    pub class: AnnotationClass,
}

impl FromStr for ClassOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Names of classes of ours have no `=` in them.
        let (name, class) = text.rsplit_once('=').ok_or("write NAME=CLASS, such as forklift=misc")?;
        Ok(Self { name: name.to_owned(), class: class_of_word(class)? })
    }
}

impl fmt::Display for ClassOption {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}={}", self.name, self.class.name())
    }
}

fn format_help() -> String {
    let names = DatasetFormat::names().join("`, `");
    format!("Format of data sets given as paths [default: recognised by their files]: `{names}`")
}

/// What becomes of damaged scans.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct DamageArgs {
    /// Skip damaged scans with a warning, instead of stopping
    #[arg(long, hide_short_help = true)]
    pub skip_damaged: bool,
}

impl DamageArgs {
    /// What that means for readers.
    pub fn policy(&self) -> DamagePolicy {
        if self.skip_damaged { DamagePolicy::Skip } else { DamagePolicy::Refuse }
    }
}

pub fn sensor_help() -> String {
    let ids = EMBEDDED_SENSORS.map(|(id, _)| id).join(", ");
    format!("Sensor: {ids} or a TOML file")
}

/// A height from that of the road itself, for clouds that are given from there, to that of a house.
fn sensor_height_m(text: &str) -> Result<f32, String> {
    let height_m: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.0..=100.0).contains(&height_m) { Ok(height_m) } else { Err("not within 0 to 100 m".to_owned()) }
}

fn degrees_to_either_side(text: &str) -> Result<f32, String> {
    let degrees: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if degrees > 0.0 && degrees <= 180.0 {
        Ok(degrees)
    } else {
        Err("not within 0 to 180 degrees".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_mapped_to_a_class() {
        let option: ClassOption = "a=b=Truck".parse().unwrap();
        assert_eq!((option.name.as_str(), option.class), ("a=b", AnnotationClass::Truck));
        assert_eq!("=misc".parse::<ClassOption>().unwrap().name, "");
        assert!("forklift".parse::<ClassOption>().unwrap_err().contains("NAME=CLASS"));
        assert!(
            "forklift=mics"
                .parse::<ClassOption>()
                .unwrap_err()
                .starts_with("\"mics\" is not a class; classes are car")
        );
    }
}
