//! The command line: one file for the arguments of each verb, after those that verbs share.

mod scans;
mod detectors;
mod output;
mod parameters;
mod timing;
#[cfg(feature = "rerun")]
mod stream;
mod run;
mod detect;
mod ablation;
mod compare;
mod gate;
mod selftest;
mod experiment;
mod gaps;
mod boxes;
mod robustness;
mod data_convert;
mod data_prelabel;
mod data_check;
mod sweep;
mod view;
mod report;
mod data;
mod fit_density;
mod train;
mod program;

pub use ablation::AblationArgs;
pub use boxes::BoxesArgs;
pub use compare::CompareArgs;
pub use data::{DataCommand, RealismArgs};
pub use data_check::{CheckArgs, HashArgs};
pub use data_convert::ConvertArgs;
pub use data_prelabel::PrelabelArgs;
pub use detect::DetectArgs;
pub use experiment::ExperimentArgs;
pub use fit_density::FitDensityArgs;
pub use gaps::GapsArgs;
pub use gate::{AcceptArgs, BaselineCommand, GateArgs};
pub use output::OutputArgs;
pub use parameters::{ConfigArgs, CriterionName, MatchingArgs};
pub use program::{Cli, Command};
pub use report::ReportArgs;
pub use robustness::RobustnessArgs;
pub use run::RunArgs;
pub use scans::{CatalogueArgs, ClassOption, DamageArgs, DatasetArgs, SourceArgs};
pub use selftest::SelftestArgs;
#[cfg(feature = "rerun")]
pub use stream::{StreamArgs, TabName};
pub use sweep::SweepArgs;
pub use timing::TimingArgs;
pub use train::{ModelName, TrainArgs};
pub use view::{OutcomeName, TaskName, ViewArgs};
