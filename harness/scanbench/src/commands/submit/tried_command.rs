//! A command that is tried before it is submitted.

use jiff::Timestamp;

use crate::cli::Command;
use crate::commands::ablation::open_ablation;
use crate::commands::failure::Failure;
use crate::commands::partial::sets::open_all;
use crate::commands::robustness::open_robustness;
use crate::commands::run::setup::ChosenRun;
use crate::commands::submit::sharded_command::ShardedCommand;
use crate::commands::sweep::setup::{Sweep, sweep_plan};

/// Opens data sets, detectors and models as a task would, and looks at nothing else.
pub fn try_here(command: &ShardedCommand) -> Result<(), Failure> {
    let now = Timestamp::now();
    match command.as_parsed()? {
        Command::Run(it) => ChosenRun::of(&it)?.open(&it).map(drop),
        Command::Sweep(it) => Sweep::open(&it, sweep_plan(&it)?, now).map(drop),
        Command::Ablation(it) => open_ablation(&it, now).map(drop),
        Command::Robustness(it) => open_robustness(&it, now).map(drop),
        Command::Partial(it) => open_all(&it).map(drop),
        _ => unreachable!("others have no shards"),
    }
}
