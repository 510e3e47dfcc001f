//! From the parsed command line to the verb.

use std::path::Path;

use clap::CommandFactory as _;

use evaluation::training::model_kind::ModelKind;
use reports::files::archive::ArchiveError;

use crate::cli::{BaselineCommand, Cli, Command, DataCommand, SubmitCommand, TrainCommand};
use crate::commands::ablation::ablation;
use crate::commands::baseline::{baseline_accept, baseline_init};
use crate::commands::boxes::boxes;
use crate::commands::compare::compare;
use crate::commands::completions::completions;
use crate::commands::data::add::data_add;
use crate::commands::data::check::data_check;
use crate::commands::data::convert::{data_convert, data_simulate};
use crate::commands::data::get::data_get;
use crate::commands::data::hash::data_hash;
use crate::commands::data::list::data_list;
use crate::commands::data::objects::data_objects;
use crate::commands::data::prelabel::data_prelabel;
use crate::commands::data::realism::data_realism;
use crate::commands::detect::detect;
use crate::commands::failure::Failure;
#[cfg(not(target_os = "linux"))]
use crate::commands::failure::Usage;
use crate::commands::fit_density::fit_density;
use crate::commands::gaps::gaps;
use crate::commands::gate::gate;
use crate::commands::init::init;
use crate::commands::merge::merge;
use crate::commands::params::params;
use crate::commands::partial::partial;
use crate::commands::report::report;
use crate::commands::reproduce::reproduce;
use crate::commands::robustness::robustness;
use crate::commands::run::run;
use crate::commands::selftest::selftest;
#[cfg(target_os = "linux")]
use crate::commands::serve::serve;
use crate::commands::standard_streams::{Verbosity, set_verbosity};
use crate::commands::submit::kubernetes::submit_kubernetes;
use crate::commands::submit::slurm::submit_slurm;
use crate::commands::sweep::sweep;
use crate::commands::train::boxes::train_boxes;
use crate::commands::train::groupings::train_groupings;
use crate::commands::train::partial::train_partial;
use crate::commands::train::rivals::train_rivals;
use crate::commands::train::svm::train_svm;
use crate::commands::view::view;

/// Does what the command line asks for.
pub fn dispatch(cli: &Cli) -> Result<(), Failure> {
    set_verbosity(match (cli.quiet, cli.verbose) {
        (true, _) => Verbosity::Quiet,
        (false, true) => Verbosity::Verbose,
        (false, false) => Verbosity::Usual,
    });
    match &cli.command {
        Command::Run(arguments) => run(arguments),
        Command::Merge(arguments) => merge(arguments),
        Command::Detect(arguments) => detect(arguments),
        Command::Ablation(arguments) => ablation(arguments),
        Command::Data(DataCommand::List(arguments)) => data_list(arguments),
        Command::Data(DataCommand::Get(arguments)) => data_get(arguments),
        Command::Data(DataCommand::Add(arguments)) => data_add(arguments),
        Command::Data(DataCommand::Check(arguments)) => data_check(arguments),
        Command::Data(DataCommand::Hash(arguments)) => data_hash(arguments),
        Command::Data(DataCommand::Convert(arguments)) => data_convert(arguments),
        Command::Data(DataCommand::Prelabel(arguments)) => data_prelabel(arguments),
        Command::Data(DataCommand::Simulate(arguments)) => data_simulate(arguments),
        Command::Data(DataCommand::Objects(arguments)) => data_objects(arguments),
        Command::Data(DataCommand::Realism(arguments)) => data_realism(arguments),
        Command::FitDensity(arguments) => fit_density(arguments),
        Command::Train(TrainCommand::Groupings(arguments)) => train_groupings(arguments),
        Command::Train(TrainCommand::Rivals(arguments)) => train_rivals(arguments),
        Command::Train(TrainCommand::Boxes(arguments)) => train_boxes(arguments),
        Command::Train(TrainCommand::Paper(arguments)) => train_svm(arguments, ModelKind::Paper),
        Command::Train(TrainCommand::Pca(arguments)) => train_svm(arguments, ModelKind::Pca),
        Command::Train(TrainCommand::Partial(arguments)) => train_partial(arguments),
        Command::Gaps(arguments) => gaps(arguments),
        Command::Boxes(arguments) => boxes(arguments),
        Command::Partial(arguments) => partial(arguments),
        Command::Reproduce(arguments) => reproduce(arguments),
        Command::Robustness(arguments) => robustness(arguments),
        Command::Compare(arguments) => compare(arguments),
        Command::Report(arguments) => report(arguments),
        Command::View(arguments) => view(arguments),
        Command::Gate(arguments) => gate(arguments),
        Command::Baseline(BaselineCommand::Init(arguments)) => baseline_init(arguments),
        Command::Baseline(BaselineCommand::Accept(arguments)) => baseline_accept(arguments),
        Command::Selftest(arguments) => selftest(arguments),
        Command::Sweep(arguments) => sweep(arguments),
        Command::Submit(SubmitCommand::Slurm(arguments)) => submit_slurm(arguments),
        Command::Submit(SubmitCommand::Kubernetes(arguments)) => submit_kubernetes(arguments),
        Command::Init(arguments) => init(arguments),
        Command::Params(arguments) => params(arguments),
        #[cfg(target_os = "linux")]
        Command::Serve(arguments) => serve(arguments),
        #[cfg(target_os = "linux")]
        Command::Supervise { .. } => unreachable!("it was begun before"),
        #[cfg(not(target_os = "linux"))]
        Command::Serve(_) | Command::Supervise { .. } => {
            Err(Usage("detectors that are programs of their own need Linux".to_owned()).into())
        }
        Command::Completions { shell: Some(shell), .. } => completions(*shell),
        Command::Completions { man, .. } => manual(man.as_deref().expect("clap asks for one of both")),
    }
}

fn manual(folder: &Path) -> Result<(), Failure> {
    let written =
        std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    written.map_err(|source| ArchiveError::Write { path: folder.to_path_buf(), source }.into())
}
