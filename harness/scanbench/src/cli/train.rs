//! Arguments of `scanbench train`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use evaluation::run::config::override_option::OverrideOption;
use evaluation::training::model_odds::ModelOdds;
use evaluation::training::{CHOICE_SEED, HOLD_OUT_EVERY, OTHERS_PER_VEHICLE, PROTOTYPES};

use super::help_text::{JUDGING, TRAINING, with_details};
use super::output::OutputArgs;
use super::scans::{CatalogueArgs, DatasetArgs};

/// What `scanbench train` trains.
#[derive(Debug, Subcommand)]
pub enum TrainCommand {
    /// Train hierarchical: which groups of points are objects, and which vehicles
    #[command(after_help = GROUPINGS_EXAMPLES, after_long_help = with_details(GROUPINGS_EXAMPLES, GROUPINGS_DETAILS))]
    #[command(mut_arg("prototypes", |it| it.help(prototypes_help("those of the shipped model"))))]
    Groupings(Box<TreeTrainingArgs>),
    /// Train the rivals over a kd-tree with trees of their own: kd-tree-trained, kd-tree-tree
    #[command(after_help = RIVALS_EXAMPLES, after_long_help = with_details(RIVALS_EXAMPLES, RIVALS_DETAILS))]
    #[command(mut_arg("prototypes", |it| it.help(prototypes_help("found in the scans"))))]
    Rivals(Box<TreeTrainingArgs>),
    /// Train the model that classifies the clusters of kd-tree, of other detectors, and of yours
    #[command(after_help = CLUSTERS_EXAMPLES, after_long_help = with_details(CLUSTERS_EXAMPLES, CLUSTERS_DETAILS))]
    #[command(mut_arg("prototypes", |it| it.help(prototypes_help("found in the scans"))))]
    Clusters(Box<TreeTrainingArgs>),
    /// Train the classifier of paper
    #[command(after_help = PAPER_EXAMPLES, after_long_help = with_details(PAPER_EXAMPLES, SVM_DETAILS))]
    #[command(mut_arg("nu", |it| it.help(nu_help("0.0377, as printed"))))]
    Paper(Box<SvmTrainingArgs>),
    /// Train the classifier of pca
    #[command(after_help = PCA_EXAMPLES, after_long_help = with_details(PCA_EXAMPLES, SVM_DETAILS))]
    #[command(mut_arg("nu", |it| it.help(nu_help("0.2"))))]
    Pca(Box<SvmTrainingArgs>),
    /// Train the boxes of whole vehicles, for all detectors but paper and pca
    #[command(after_help = BOXES_EXAMPLES, after_long_help = with_details(BOXES_EXAMPLES, BOXES_DETAILS))]
    Boxes(Box<BoxTrainingArgs>),
    /// Train the classifier of partly seen objects
    #[command(after_help = PARTIAL_EXAMPLES)]
    Partial(Box<PartialTrainingArgs>),
}

fn prototypes_help(default: &str) -> String {
    format!("Take the side profiles of vehicles from this model [default: {default}]")
}

fn nu_help(default: &str) -> String {
    format!("Share of training examples allowed inside the margin [default: {default}]")
}

/// Recorded data sets that are trained on beside the others.
#[derive(Debug, Args)]
#[command(next_help_heading = TRAINING)]
pub struct RecordedArgs {
    /// Train on this recorded data set, too, on all of its scans; may be repeated
    ///
    /// Each counts the same, whatever its size, and all together as much as the others: no example of them more than twenty
    /// others. Every object of a vehicle's class has to be labelled: what is not labelled counts as background.
    #[arg(long, value_name = "DATASET")]
    pub recorded: Vec<String>,
    /// Format of data sets of --recorded that are paths [default: recognised by their files]
    #[arg(long, value_name = "FORMAT", requires = "recorded", hide_short_help = true)]
    pub recorded_format: Option<String>,
    /// Scans to take from the data sets of --recorded, written as in --scans [default: all]
    #[arg(long, value_name = "RANGE", requires = "recorded", hide_short_help = true)]
    pub recorded_scans: Option<String>,
}

/// Arguments of training trees.
#[derive(Debug, Args)]
pub struct TreeTrainingArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Recorded scans beside them.
    #[command(flatten)]
    pub recorded: RecordedArgs,
    /// Sensors to simulate, one after the other
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "sensor", help_heading = TRAINING)]
    pub sensors: Vec<String>,
    /// Take the side profiles of vehicles from this model
    #[arg(long, value_name = "FILE", help_heading = TRAINING)]
    pub prototypes: Option<PathBuf>,
    /// Set one parameter of the stages that find the groups; may be repeated
    ///
    /// The models keep it: a run with another value is refused. The last parts of a name are enough if only one parameter
    /// ends in them.
    #[arg(short = 'P', long = "param", value_name = "NAME=VALUE", help_heading = TRAINING)]
    pub parameters: Vec<OverrideOption>,
    /// Take the log odds of this class of a model SLOPE times, and add OFFSET; may be repeated
    ///
    /// MODEL is the name in its file: groupings; clusters, kd-tree-trained or kd-tree-tree. CLASS is vehicles, pedestrians or
    /// cyclists. On streets odds are right as they are; on recorded scans, where more looks like a vehicle and is none, they
    /// are too high.
    #[arg(long, value_name = "MODEL.CLASS=SLOPE,OFFSET", help_heading = TRAINING, hide_short_help = true)]
    pub odds: Vec<ModelOdds>,
    /// What is judged by.
    #[command(flatten)]
    pub judging: HeldOutArgs,
    /// Where the models are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of training boxes.
#[derive(Debug, Args)]
pub struct BoxTrainingArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Sensors to simulate, one after the other
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "sensor", help_heading = TRAINING)]
    pub sensors: Vec<String>,
    /// What is judged by.
    #[command(flatten)]
    pub judging: HeldOutArgs,
    /// Where the model is written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of training a support vector machine.
#[derive(Debug, Args)]
pub struct SvmTrainingArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Most vehicles to train on
    #[arg(long, value_name = "N", default_value_t = DEFAULT_VEHICLES, value_parser = clap::value_parser!(u32).range(2..=20_000))]
    #[arg(help_heading = TRAINING)]
    pub vehicles: u32,
    /// Most other objects to train on, per vehicle
    #[arg(long, value_name = "N", default_value_t = OTHERS_PER_VEHICLE, value_parser = others_per_vehicle)]
    #[arg(help_heading = TRAINING, hide_short_help = true)]
    pub others: f64,
    /// Most side profiles to keep as prototypes of each kind of vehicle; only paper has any
    #[arg(long, value_name = "N", default_value_t = PROTOTYPES, value_parser = clap::value_parser!(u32).range(1..=20))]
    #[arg(help_heading = TRAINING, hide_short_help = true)]
    pub prototypes: u32,
    /// Width of the Gaussian kernel, for standardised features [default: 0.1078, as printed]
    ///
    /// If there are several widths or shares, the pair with the greatest precision-recall area is taken. That is found by
    /// cross-validation over five parts of the training drives.
    #[arg(long, value_name = "X,...", value_delimiter = ',', help_heading = TRAINING)]
    pub gamma: Vec<f32>,
    /// Share of training examples allowed inside the margin
    #[arg(long, value_name = "X,...", value_delimiter = ',', help_heading = TRAINING)]
    pub nu: Vec<f64>,
    /// Seed of the choice of training examples
    #[arg(long, value_name = "N", default_value_t = CHOICE_SEED, help_heading = TRAINING, hide_short_help = true)]
    pub choice_seed: u64,
    /// What is judged by.
    #[command(flatten)]
    pub judging: HeldOutArgs,
    /// Where model, prototypes, curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// What a trained model is judged by.
#[derive(Debug, Args)]
#[command(next_help_heading = JUDGING)]
pub struct HeldOutArgs {
    /// Test on this data set, instead of on held-out drives; may be repeated
    #[arg(long, value_name = "DATASET", conflicts_with = "hold_out_every")]
    pub held_out: Vec<String>,
    /// Format of data sets of --held-out that are paths [default: recognised by their files]
    #[arg(long, value_name = "FORMAT", requires = "held_out", hide_short_help = true)]
    pub held_out_format: Option<String>,
    /// Scans to take from the data sets of --held-out, written as in --scans
    #[arg(long, value_name = "RANGE", requires = "held_out", hide_short_help = true)]
    pub held_out_scans: Option<String>,
    /// Hold out the last of every N drives of each data set
    #[arg(long, value_name = "N", default_value_t = HOLD_OUT_EVERY, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub hold_out_every: u32,
}

/// Vehicles that a model is trained on, unless more are asked for.
const DEFAULT_VEHICLES: u32 = 3000;

fn others_per_vehicle(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.1..=20.0).contains(&number) { Ok(number) } else { Err(format!("{number} is not within 0.1 to 20")) }
}

const GROUPINGS_EXAMPLES: &str = "\
Examples:
  scanbench train groupings training-streets --scans 0..300:6 --sensors vlp-16,os1-128 -o model
  scanbench train groupings training-clutter --scans 0..1000:100 --recorded ~/data/mine -o model
  scanbench run -P vehicle_model.groupings_directory=model";

const GROUPINGS_DETAILS: &str = "\
Trains on all groups of every scan: how well each fits an annotated object, and whether it
shows a vehicle. Three rounds predict the fit; the second and third use what the round before
predicted for the groups around. Writes groupings.model, calibration.csv and manifest.json.
A run refuses a model that none of its detectors reads. The same scans and options write
the same bytes, except the date in the manifest.";

const RIVALS_EXAMPLES: &str = "\
Examples:
  scanbench train rivals training-streets --scans 0..300:6 --sensors vlp-16,os1-128 -o rivals
  scanbench run -d kd-tree-trained,kd-tree-tree -P vehicle_model.rivals_directory=rivals";

const RIVALS_DETAILS: &str = "\
Trains as train groupings does, on the same values, but on components over a kd-tree.
kd_tree_trained.model keeps or drops components at one tolerance, which is chosen for each
sensor: of 0.3 to 1.2 m that at which most annotated objects are a component.
kd_tree_tree.model takes the best cut of components within components, at all ten
tolerances. Writes manifest.json, too.";

const CLUSTERS_EXAMPLES: &str = "\
Examples:
  scanbench train clusters training-streets --scans 0..300:6 --sensors vlp-16,os1-128 -o model
  scanbench run -d kd-tree -P vehicle_model.clusters_directory=model";

const CLUSTERS_DETAILS: &str = "\
Learns from the clusters of kd-tree. clusters.model finds the vehicles, pedestrians and
cyclists among the clusters of kd-tree, kd-tree-same-walls, simple-grid and detectors of your
own. Writes manifest.json, too.";

const PAPER_EXAMPLES: &str = "\
Examples:
  scanbench train paper training-streets --scans 0..300:6 -o model
  scanbench train paper training-streets --nu 0.1,0.2,0.4 --gamma 0.1078,0.2156 -o model
  scanbench run -d paper -P vehicle_model.paper_directory=model";

const PCA_EXAMPLES: &str = "\
Examples:
  scanbench train pca training-streets --scans 0..300:6 --held-out ~/data/kitti_tracking -o model
  scanbench run -d pca -P vehicle_model.pca_directory=model";

const SVM_DETAILS: &str = "\
Examples of vehicles are clusters that match an annotated car, van, truck or bus. Examples
of other objects are clusters without points of any, and regions cut out at random places.
Writes paper.model or pca.model; objects.csv with every held-out object, importance.csv,
curves.csv, curves.svg and manifest.json. The same scans and options write the same bytes,
except the date in the manifest.";

const BOXES_EXAMPLES: &str = "\
Examples:
  scanbench train boxes training-streets --scans 0..300:6 --sensors vlp-16,os1-128 -o model
  scanbench run -P vehicle_model.boxes_directory=model";

const BOXES_DETAILS: &str = "\
Trains on the clusters of hierarchical and of kd-tree that match an annotated car, van, truck
or bus: how far the annotated box reaches beyond what is seen, whether the vehicle is longer
across than along what is seen, which end is its front, and how likely the box is right.
Needs two drives or more. Writes boxes.model and manifest.json. The same scans and options
write the same bytes, except the date in the manifest.";

const PARTIAL_EXAMPLES: &str = "\
Examples:
  scanbench train partial -o model
  scanbench partial --model model/partial.model";

/// Arguments of `scanbench train partial`.
#[derive(Debug, Args)]
pub struct PartialTrainingArgs {
    /// The catalogue.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
    /// Objects to train on, one set after the other [default: simulated ones, as the shipped model]
    ///
    /// Simulated objects, of which the training part is taken, or folders with a folder for each class.
    #[arg(long, value_name = "OBJECTS,...", value_delimiter = ',', help_heading = TRAINING)]
    pub objects: Vec<String>,
    /// Simulated objects of each set and class [default: as the shipped model]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = TRAINING)]
    pub per_class: Option<u32>,
    /// Where the model is written.
    #[command(flatten)]
    pub output: OutputArgs,
}
