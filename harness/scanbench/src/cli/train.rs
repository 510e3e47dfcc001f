//! Arguments of `scanbench train`.

use clap::{Args, ValueEnum};
use evaluation::run::detector_list::DETECTORS;
use evaluation::training::{CHOICE_SEED, HOLD_OUT_EVERY, OTHERS_PER_VEHICLE, PROTOTYPES};

use super::help_text::{DETECTORS as DETECTORS_HEADING, JUDGING, TRAINING, with_details};
use super::output::OutputArgs;
use super::scans::DatasetArgs;
use super::train_partial::PartialTrainingArgs;

/// Arguments of `scanbench train`.
#[derive(Debug, Args)]
#[command(after_help = TRAIN_EXAMPLES, after_long_help = with_details(TRAIN_EXAMPLES, TRAIN_DETAILS))]
pub struct TrainArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Detector to train the model for
    #[arg(short, long, value_enum, value_name = "NAME", default_value = "hierarchical")]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub detector: ModelName,
    /// Detector whose clusters are the examples [default: that of --detector; for kd-tree the grid of hierarchical]
    #[arg(long, value_name = "NAME", value_parser = DETECTORS.iter().map(|it| it.name).collect::<Vec<_>>())]
    #[arg(help_heading = DETECTORS_HEADING, hide_short_help = true)]
    pub clusters: Option<String>,
    /// Most vehicles to train on
    #[arg(long, value_name = "N", default_value_t = DEFAULT_VEHICLES, value_parser = clap::value_parser!(u32).range(2..=20_000))]
    #[arg(help_heading = TRAINING)]
    pub vehicles: u32,
    /// Most other objects to train on, per vehicle; parts and pairs of clusters come on top
    #[arg(long, value_name = "N", default_value_t = OTHERS_PER_VEHICLE, value_parser = others_per_vehicle)]
    #[arg(help_heading = TRAINING, hide_short_help = true)]
    pub others: f64,
    /// Train on parts and pairs of clusters, too, as regrouping makes them; always for kd-tree
    #[arg(long, help_heading = TRAINING, hide_short_help = true)]
    pub parts_and_pairs: bool,
    /// Train on objects of any size, even if no vehicle has it; always for paper and pca
    ///
    /// Run such a model with `-P vehicle_bounds.enabled=false`.
    #[arg(long, help_heading = TRAINING, hide_short_help = true)]
    pub any_size: bool,
    /// Most side profiles to keep as prototypes of each kind of vehicle
    #[arg(long, value_name = "N", default_value_t = PROTOTYPES, value_parser = clap::value_parser!(u32).range(1..=20))]
    #[arg(help_heading = TRAINING, hide_short_help = true)]
    pub prototypes: u32,
    /// Width of the Gaussian kernel, for standardised features [default: 0.054; for paper and pca 0.1078, as printed]
    #[arg(long, value_name = "X", help_heading = TRAINING)]
    pub gamma: Option<f32>,
    /// Share of training examples allowed inside the margin [default: 0.12; for paper 0.0377, as printed; for pca 0.2]
    #[arg(long, value_name = "X", help_heading = TRAINING)]
    pub nu: Option<f64>,
    /// Seed of the choice of training examples
    #[arg(long, value_name = "N", default_value_t = CHOICE_SEED, help_heading = TRAINING, hide_short_help = true)]
    pub choice_seed: u64,
    /// Test on this data set, instead of on held-out drives; may be repeated
    #[arg(long, value_name = "DATASET", conflicts_with = "hold_out_every", help_heading = JUDGING)]
    pub held_out: Vec<String>,
    /// Format of data sets of --held-out that are paths [default: recognised by their files]
    #[arg(long, value_name = "FORMAT", requires = "held_out", help_heading = JUDGING, hide_short_help = true)]
    pub held_out_format: Option<String>,
    /// Scans to take from the data sets of --held-out, written as in --scans
    #[arg(long, value_name = "RANGE", requires = "held_out", help_heading = JUDGING, hide_short_help = true)]
    pub held_out_scans: Option<String>,
    /// Sensors to simulate, one after the other; only for hierarchical
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "sensor", help_heading = TRAINING)]
    pub sensors: Vec<String>,
    /// Hold out the last of every N drives of each data set
    #[arg(long, value_name = "N", default_value_t = HOLD_OUT_EVERY, value_parser = clap::value_parser!(u32).range(2..=1000))]
    #[arg(help_heading = JUDGING)]
    pub hold_out_every: u32,
    /// What the model of the task partial learns from.
    #[command(flatten)]
    pub partial: PartialTrainingArgs,
    /// Where model, prototypes, curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Vehicles that a model is trained on, unless more are asked for.
pub const DEFAULT_VEHICLES: u32 = 3000;

/// Detectors with a vehicle model of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelName {
    /// Boosted trees over its tree of groupings: what is an object, and what a vehicle
    #[value(alias = "groupings")]
    Hierarchical,
    /// Features of shape, size and surroundings; kd-tree-same-walls, simple-grid and detectors of your own use this model, too
    KdTree,
    /// The eight values of the paper: box, corner spheres and side profile
    Paper,
    /// Features of size, and of the shape of point neighbourhoods
    Pca,
}

fn others_per_vehicle(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.1..=20.0).contains(&number) { Ok(number) } else { Err(format!("{number} is not within 0.1 to 20")) }
}

const TRAIN_EXAMPLES: &str = "\
Examples:
  scanbench train training-streets --scans 0..300:6 --sensors vlp-16,os1-128 -o model
  scanbench train training-streets --scans 0..300:6 -d kd-tree -o model-clusters
  scanbench train training-streets --seed 3000 --scans 0..300:6 -d kd-tree --nu 0.3 --gamma 0.1078
  scanbench train training-streets --scans 0..300:6 --held-out ~/data/kitti_tracking -d pca
  scanbench train --task partial -o model";

const TRAIN_DETAILS: &str = "\
The model of hierarchical is trained on all groups of every scan: how well each fits an
annotated object, and whether it shows a vehicle. Three looks tell how well: the second and
the third also see what the one before said of the groups around. Writes objects.toml,
objects_second_look.toml, objects_third_look.toml, vehicles.toml, prototypes.toml,
calibration.csv and manifest.json; run them with
-P vehicle_model.groupings_directory=DIR.

The other models are support vector machines. Examples of vehicles are clusters that match
an annotated car, van, truck or bus. Examples of other objects are clusters without points
of any, and regions cut out at random places. Writes model.toml and prototypes.toml,
objects.csv with every held-out object, importance.csv, curves.csv, curves.svg and
manifest.json. To run the model of kd-tree, give -P vehicle_model.directory=DIR; for paper,
give -P vehicle_model.paper_directory=DIR; for pca, which has no prototypes.toml, give
-P vehicle_model.pca_directory=DIR.

A run refuses a model that none of its detectors reads. The same scans and options write
the same bytes, except the date in the manifest.

--task partial trains what tells objects of which a part has been seen. Without
--objects and --per-class this is the model that comes with the program. Writes
model.toml and manifest.json; scanbench partial takes it with --model DIR/model.toml.";
