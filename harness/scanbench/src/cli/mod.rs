//! Arguments that several files read; those of other verbs are with these.

pub mod help_text;
mod scans;
mod detectors;
mod output;
mod shard;
mod parameters;
mod protocols;
mod timing;
mod results;
pub mod stream;
mod run;
mod compare;
mod gate;
mod serve;
mod experiment;
mod reproduce;
mod data_convert;
mod data_objects;
mod partial;
pub mod data_prelabel;
mod data_check;
mod data_get;
mod sweep;
mod view;
mod data;
mod train;
mod submit;

pub use self::scans::{BlocksArgs, CatalogueArgs, DamageArgs, DatasetArgs, SourceArgs, sensor_help};
pub use compare::CompareArgs;
pub use data::{AddArgs, DataCommand, RealismArgs};
pub use data_check::{CheckArgs, HashArgs};
pub use data_convert::ConvertArgs;
pub use data_get::GetArgs;
pub use data_objects::{DataObjectsArgs, ObjectArgs, object_options};
pub use data_prelabel::PrelabelArgs;
pub use detectors::detector_names;
pub use experiment::{ExperimentArgs, experiment_detectors_help};
pub use gate::{AcceptArgs, BaselineCommand, BaselineInitArgs, GateArgs};
pub use output::{NoRecordingArgs, OutputArgs};
pub use parameters::{ConfigArgs, CriterionName, MatchingArgs};
pub use partial::{LearnedFrom, PartialArgs};
pub use protocols::ProtocolArgs;
pub use reproduce::{ChosenFor, PaperName, ReproduceArgs};
pub use results::{NamedResults, ResultFilesArgs};
pub use run::{CountedBy, RunArgs};
pub use serve::{RESULTS, ServeArgs};
pub use shard::ShardArgs;
pub use stream::StreamArgs;
pub use submit::{KubernetesArgs, SlurmArgs, SubmitCommand};
pub use sweep::SweepArgs;
pub use timing::TimingArgs;
pub use train::{
    BoxTrainingArgs, HeldOutArgs, PartialTrainingArgs, RecordedArgs, SvmTrainingArgs, TrainCommand,
    TreeTrainingArgs,
};
pub use view::{OutcomeName, ViewArgs};
