//! Which scans are taken, and how data sets are opened.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use reports::vocabulary::class::AnnotationClass;
use scans::dataset::class_table::class_of_word;
use scans::dataset::dataset_format::DatasetFormat;
use scans::dataset::source::DamagePolicy;
use simulator::sensor::EMBEDDED_SENSORS;

/// Where data sets are looked up.
#[derive(Debug, Clone, Args)]
pub struct CatalogueArgs {
    /// Catalogue to look ids up in, instead of the built-in one
    #[arg(long, value_name = "FILE", env = "SCANBENCH_DATASETS")]
    pub catalogue: Option<PathBuf>,
}

/// Which scans are taken.
#[derive(Debug, Clone, Args)]
pub struct DatasetArgs {
    /// Ids of the catalogue, or paths of data sets
    #[arg(value_name = "DATASET", default_value = simulator::catalogue::DEFAULT_DATASETS)]
    pub datasets: Vec<String>,
    /// Which scans, by place in each data set, from 0: `7`, `0..500` (without 500), `0..500:5` (every fifth), or several
    /// of these by comma
    #[arg(long, value_name = "RANGE")]
    pub scans: Option<String>,
    /// How they are opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// How data sets are opened.
#[derive(Debug, Clone, Args)]
pub struct SourceArgs {
    /// Format of data sets given as paths, instead of recognising it.
    #[arg(long, value_name = "FORMAT", help = format_help())]
    pub format: Option<String>,
    /// Topic of the clouds in MCAP recordings [default: the only one]
    #[arg(long, value_name = "TOPIC")]
    pub topic: Option<String>,
    /// Topic of the annotations in MCAP recordings [default: /annotations, or the only one]
    #[arg(long, value_name = "TOPIC")]
    pub annotation_topic: Option<String>,
    /// What a name of a class in labels stands for, such as `forklift=misc`; may be repeated. Case does not matter
    #[arg(long = "class", value_name = "NAME=CLASS")]
    pub classes: Vec<ClassOption>,
    /// Seed of simulated data sets, instead of the catalogue's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Number of scans of simulated data sets, instead of the catalogue's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub simulated_scans: Option<u32>,
    /// Sensor of simulated data sets.
    #[arg(long, value_name = "SENSOR", help = sensor_help())]
    pub sensor: Option<String>,
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
    format!("Format of data sets given as paths, instead of recognising it: `{names}`")
}

/// What becomes of damaged scans.
#[derive(Debug, Clone, Args)]
pub struct DamageArgs {
    /// Leave damaged scans out, name each, and go on
    #[arg(long)]
    pub skip_damaged: bool,
}

impl DamageArgs {
    /// What that means for readers.
    pub fn policy(&self) -> DamagePolicy {
        if self.skip_damaged { DamagePolicy::Skip } else { DamagePolicy::Refuse }
    }
}

pub(super) fn sensor_help() -> String {
    let ids = EMBEDDED_SENSORS.map(|(id, _)| format!("`{id}`")).join(", ");
    format!("Sensor of simulated data sets: {ids}, or a TOML file that describes one")
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
                .starts_with("\"mics\" is no class; there are car")
        );
    }
}
