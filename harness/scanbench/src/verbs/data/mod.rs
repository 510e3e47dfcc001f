//! `scanbench data`.

pub mod list;
pub mod get;
pub mod add;
pub mod check;
pub mod hash;
pub mod convert;
pub mod objects;
pub mod prelabel;
pub mod realism;

use crate::cli::DataCommand;
use crate::plumbing::failure::Failure;

pub fn data(command: &DataCommand) -> Result<(), Failure> {
    match command {
        DataCommand::List(arguments) => list::data_list(arguments),
        DataCommand::Get(arguments) => get::data_get(arguments),
        DataCommand::Add(arguments) => add::data_add(arguments),
        DataCommand::Check(arguments) => check::data_check(arguments),
        DataCommand::Hash(arguments) => hash::data_hash(arguments),
        DataCommand::Convert(arguments) => convert::data_convert(arguments),
        DataCommand::Prelabel(arguments) => prelabel::data_prelabel(arguments),
        DataCommand::Simulate(arguments) => convert::data_simulate(arguments),
        DataCommand::Objects(arguments) => objects::data_objects(arguments),
        DataCommand::Realism(arguments) => realism::data_realism(arguments),
    }
}
