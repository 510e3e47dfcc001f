//! Arguments of `scanbench train`.

use clap::{Args, ValueEnum};
use evaluation::run::detector_list::DETECTORS;
use evaluation::training::{CHOICE_SEED, HOLD_OUT_EVERY, OTHERS_PER_VEHICLE, PROTOTYPES};

use super::output::OutputArgs;
use super::scans::DatasetArgs;

/// Arguments of `scanbench train`.
#[derive(Debug, Args)]
#[command(after_help = TRAIN_EXAMPLES)]
pub struct TrainArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// The detector whose model it becomes
    #[arg(short, long, value_enum, value_name = "NAME", default_value = "hierarchical")]
    pub detector: ModelName,
    /// The detector whose clusters are described.
    #[arg(long, value_name = "NAME", value_parser = DETECTORS.iter().map(|it| it.name).collect::<Vec<_>>(), help = clusters_help())]
    pub clusters: Option<String>,
    /// Data set to judge by, all of it, instead of holding out drives of those trained on; may be repeated
    #[arg(long, value_name = "DATASET", conflicts_with = "hold_out_every")]
    pub held_out: Vec<String>,
    /// Format of data sets to judge by that are given as paths
    #[arg(long, value_name = "FORMAT", requires = "held_out")]
    pub held_out_format: Option<String>,
    /// Which of their scans, as `--scans`
    #[arg(long, value_name = "RANGE", requires = "held_out")]
    pub held_out_scans: Option<String>,
    /// Hold out the last of every N drives of each data set to judge by
    #[arg(long, value_name = "N", default_value_t = HOLD_OUT_EVERY, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub hold_out_every: u32,
    /// Most vehicles to train on
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(2..=20_000))]
    pub vehicles: u32,
    /// Most other objects to train on, for each vehicle; parts and pairs of clusters come on top
    #[arg(long, value_name = "N", default_value_t = OTHERS_PER_VEHICLE, value_parser = others_per_vehicle)]
    pub others: f64,
    /// Train with parts and pairs of clusters too, as regrouping makes them; hierarchical always does
    #[arg(long)]
    pub parts_and_pairs: bool,
    /// Train with objects of any size, also those that no vehicle has; pca always does. A run takes such a model with
    /// `-P vehicle_bounds.enabled=false`
    #[arg(long)]
    pub any_size: bool,
    /// Most side profiles of each kind of vehicle to compare with
    #[arg(long, value_name = "N", default_value_t = PROTOTYPES, value_parser = clap::value_parser!(u32).range(1..=20))]
    pub prototypes: u32,
    /// Width of the Gaussian kernel over standardised values; the paper has 0.1078 [default: 0.054; for pca 0.1078]
    #[arg(long, value_name = "X")]
    pub gamma: Option<f32>,
    /// Share of vehicles and background that may lie inside the margin; the paper has 0.0377 [default: 0.12; for pca 0.2]
    #[arg(long, value_name = "X")]
    pub nu: Option<f64>,
    /// Seed of the choice among objects, and of the regions that are cut out
    #[arg(long, value_name = "N", default_value_t = CHOICE_SEED)]
    pub choice_seed: u64,
    /// Where model, prototypes, curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Detectors with a vehicle model of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelName {
    /// By shape: box, corner spheres and side profile; kd-tree and simple-grid take it too
    Hierarchical,
    /// By size, and by how points lie in their neighbourhoods
    Pca,
}

fn others_per_vehicle(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.1..=20.0).contains(&number) { Ok(number) } else { Err(format!("{number} is not within 0.1 to 20")) }
}

fn clusters_help() -> String {
    "Detector whose clusters are trained on and judged; with another one than --detector the same \
     objects can be told by different features [default: that of --detector]"
        .to_owned()
}

const TRAIN_EXAMPLES: &str = "\
Examples:
  scanbench train training-streets --scans 0..300:6 -o model
  scanbench train ~/data/kitti_tracking -o model
  scanbench train training-streets --seed 3000 --scans 0..300:6 --nu 0.3 --gamma 0.1078
  scanbench train training-streets --scans 0..300:6 --held-out ~/data/kitti_tracking -d pca -o model-pca

Objects are what the detector finds: those that match an annotated
car, van, truck or bus, and those without points of any, with regions cut out
anywhere. Leaves in the directory model.toml and prototypes.toml, which a run takes
with -P vehicle_model.directory=DIR (for pca model.toml alone, which it takes with
-P vehicle_model.pca_directory=DIR), objects.csv with every held-out object,
importance.csv, curves.csv, curves.svg and manifest.json. The same scans and options
give the same bytes, but for the date in the manifest.";
