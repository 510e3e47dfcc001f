//! Why an engine does not say which shard a task is.

use reports::vocabulary::shard::Shard;

/// Why the variables do not say which shard this is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EngineShardError {
    /// There is no engine.
    #[error(
        "--shard auto: no engine says which shard this is, none of {} is set; name it, such as --shard 1/8",
        tasks.join(", ")
    )]
    NoEngine {
        /// The variables with numbers of tasks.
        tasks: Vec<&'static str>,
    },
    /// The job is not one of many.
    #[error(
        "--shard auto: {engine} runs this job once and would run all scans in it ({said}); \
         let it run several, or leave --shard away"
    )]
    Alone {
        /// The engine.
        engine: &'static str,
        /// Its variables.
        said: String,
    },
    /// One variable is there, and another is not.
    #[error("--shard auto: {engine} says half of it: {said}, but {missing} is not set{remedy}")]
    HalfSet {
        /// The engine.
        engine: &'static str,
        /// Its variables that are set.
        said: String,
        /// The one that is not.
        missing: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A value that is no number.
    #[error("--shard auto: {variable}={value:?} is not a whole number")]
    NoNumber {
        /// The variable.
        variable: &'static str,
        /// Its value.
        value: String,
    },
    /// A task that is none of those that there are.
    #[error("--shard auto: {variable}={number} is not a number from {first} to {last}")]
    NoSuchTask {
        /// The variable.
        variable: &'static str,
        /// Its value.
        number: u32,
        /// Number of the first task.
        first: u32,
        /// Number of the last one.
        last: u32,
    },
    /// The user and the engine do not agree.
    #[error("--shards {wanted}, but {variable}={found}")]
    OtherCount {
        /// What `--shards` says.
        wanted: u32,
        /// The variable.
        variable: &'static str,
        /// Its value.
        found: u32,
    },
    /// The array is a part of one, as far as can be told.
    #[error(
        "--shard auto: tasks that are a part of an array look like a whole one, and {engine} says {said}; \
         number the tasks from 1 to N and give --shards N"
    )]
    NotWhole {
        /// The engine.
        engine: &'static str,
        /// Its variables.
        said: String,
    },
    /// Two engines, two shards.
    #[error(
        "--shard auto: {first_engine} says {first} ({first_said}), but {second_engine} says {second} ({second_said})"
    )]
    Disagree {
        /// The one.
        first_engine: &'static str,
        /// Its shard.
        first: Shard,
        /// Its variables.
        first_said: String,
        /// The other.
        second_engine: &'static str,
        /// Its shard.
        second: Shard,
        /// Its variables.
        second_said: String,
    },
}
