//! Which shard a task is, as the engine that started it says in environment variables.

use std::num::NonZeroU32;
use std::path::PathBuf;

use reports::vocabulary::shard::Shard;

use crate::commands::shard_auto::engine_shard_error::EngineShardError;
use crate::commands::shard_auto::engines::{ArrayRange, BAZEL, ENGINES, Engine, Numbering, Variables};

/// Variable with the file that a program has to make for Bazel to believe that it knows of shards.
const STATUS_FILE: &str = "TEST_SHARD_STATUS_FILE";

/// What an engine says about this task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EngineShard {
    /// The shard.
    pub shard: Shard,
    /// The engine.
    pub engine: &'static str,
    /// The variables that say so, with their values.
    pub said: String,
    /// A file that has to be made, so that the engine knows that the shard was understood.
    pub status_file: Option<PathBuf>,
}

/// The shard that the engine gave to this task.
///
/// `n_shards` is what the user says, for engines that do not say it. Where the user numbers the tasks of an array, these are the numbers
/// 1 to `n_shards`, so that a part of the array can be run again; without `n_shards` the array has to be a whole one.
///
/// # Errors
///
/// [`EngineShardError`] if no engine says anything, one says half of it, what it says makes no sense, or two disagree. It never falls
/// back to all scans.
pub fn engine_shard(
    variables: &Variables,
    n_shards: Option<NonZeroU32>,
) -> Result<EngineShard, EngineShardError> {
    let is_set = |(_, value): &(&String, &String)| !value.is_empty();
    let variables = variables.iter().filter(is_set).map(|(name, value)| (name.clone(), value.clone()));
    let variables: Variables = variables.collect();
    let mut found = Vec::new();
    let mut alone = None;
    for engine in &ENGINES {
        if engine.is_alone(&variables) {
            alone.get_or_insert(engine);
        } else {
            found.extend(engine.shard(&variables, n_shards)?.map(|shard| (engine, shard)));
        }
    }
    let Some(&(engine, shard)) = found.first() else {
        return Err(match alone {
            Some(it) => EngineShardError::Alone { engine: it.name, said: it.said(&variables) },
            None => EngineShardError::NoEngine { tasks: ENGINES.iter().map(|it| it.task).collect() },
        });
    };
    if let Some((other, second)) = found.iter().find(|it| it.1 != shard) {
        return Err(EngineShardError::Disagree {
            first_engine: engine.name,
            first: shard,
            first_said: engine.said(&variables),
            second_engine: other.name,
            second: *second,
            second_said: other.said(&variables),
        });
    }
    let wants_file = found.iter().any(|it| it.0.name == BAZEL);
    let status_file = variables.get(STATUS_FILE).filter(|_| wants_file).map(PathBuf::from);
    Ok(EngineShard { shard, engine: engine.name, said: engine.said(&variables), status_file })
}

/// What this process has been told by engines.
pub fn variables_of_process() -> Variables {
    let names = ENGINES.iter().flat_map(Engine::names).chain([STATUS_FILE]);
    let values = names.filter_map(|it| Some((it.to_owned(), std::env::var_os(it)?)));
    values.map(|(name, value)| (name, value.to_string_lossy().into_owned())).collect()
}

impl Engine {
    fn half_set(&self, variables: &Variables, missing: &'static str) -> EngineShardError {
        let remedy = if missing == self.task { "" } else { "; give --shards N" };
        EngineShardError::HalfSet { engine: self.name, said: self.said(variables), missing, remedy }
    }

    /// The shard; `None` if the engine says nothing.
    fn shard(
        &self,
        variables: &Variables,
        n_shards: Option<NonZeroU32>,
    ) -> Result<Option<Shard>, EngineShardError> {
        let Some(task) = number(variables, self.task)? else {
            let says_nothing = self.said(variables).is_empty();
            return if says_nothing { Ok(None) } else { Err(self.half_set(variables, self.task)) };
        };
        let n_shards = n_shards.map(NonZeroU32::get);
        let shard = match (&self.numbering, n_shards) {
            (Numbering::ByEngine { first, count }, _) => {
                let said = number(variables, count)?;
                if let (Some(wanted), Some(found)) = (n_shards, said)
                    && wanted != found
                {
                    return Err(EngineShardError::OtherCount { wanted, variable: count, found });
                }
                let count = said.or(n_shards).ok_or_else(|| self.half_set(variables, count))?;
                self.nth(task, *first, 1, count)?
            }
            (Numbering::ByUser(range), Some(count)) => {
                self.check_numbered_from_one(range, variables)?;
                self.nth(task, 1, 1, count)?
            }
            (Numbering::ByUser(range), None) => self.of_whole_array(range, task, variables)?,
        };
        Ok(Some(shard))
    }

    /// An array that begins with 0 has one task more than 1 to `n_shards`, or one number less.
    fn check_numbered_from_one(
        &self,
        range: &ArrayRange,
        variables: &Variables,
    ) -> Result<(), EngineShardError> {
        match range {
            ArrayRange::Whole { first, .. } if number(variables, first)? == Some(0) => {
                Err(EngineShardError::NotWhole { engine: self.name, said: self.said(variables) })
            }
            _ => Ok(()),
        }
    }

    /// The shard of an array that has all tasks, with the same step between their numbers.
    ///
    /// One that begins behind 1, has a single task or has gaps may be what was left of another, and is refused.
    fn of_whole_array(
        &self,
        range: &ArrayRange,
        task: u32,
        variables: &Variables,
    ) -> Result<Shard, EngineShardError> {
        let required =
            |name: &'static str| number(variables, name)?.ok_or_else(|| self.half_set(variables, name));
        let (first, last, step, count) = match *range {
            ArrayRange::Unsaid => {
                return Err(EngineShardError::HalfSet {
                    engine: self.name,
                    said: self.said(variables),
                    missing: "the number of tasks",
                    remedy: "; number the tasks from 1 to N and give --shards N",
                });
            }
            ArrayRange::ToLast { last, step } => (1, required(last)?, required(step)?, None),
            ArrayRange::Whole { first, last, step, count } => {
                (required(first)?, required(last)?, required(step)?, Some(required(count)?))
            }
        };
        let not_whole = || EngineShardError::NotWhole { engine: self.name, said: self.said(variables) };
        let n_steps = last.checked_sub(first).and_then(|it| it.checked_div(step)).ok_or_else(not_whole)?;
        let is_whole = first <= 1
            && n_steps > 0
            && count.is_none_or(|it| Some(it) == n_steps.checked_add(1))
            && u64::from(n_steps) * u64::from(step) == u64::from(last - first);
        if !is_whole {
            return Err(not_whole());
        }
        self.nth(task, first, step, n_steps.checked_add(1).ok_or_else(not_whole)?)
    }

    /// The shard of the task with the number `task`, of `count` that begin at `first` and are `step` apart.
    fn nth(&self, task: u32, first: u32, step: u32, count: u32) -> Result<Shard, EngineShardError> {
        let place = task.checked_sub(first).filter(|it| it % step == 0).map(|it| it / step);
        let shard = place.and_then(|it| Shard::new(it.checked_add(1)?, count).ok());
        let last = u64::from(first) + u64::from(step) * u64::from(count.saturating_sub(1));
        shard.ok_or(EngineShardError::NoSuchTask {
            variable: self.task,
            number: task,
            first,
            last: u32::try_from(last).unwrap_or(u32::MAX),
        })
    }
}

fn number(variables: &Variables, name: &'static str) -> Result<Option<u32>, EngineShardError> {
    let Some(value) = variables.get(name) else { return Ok(None) };
    let number = value.parse();
    number.map(Some).map_err(|_| EngineShardError::NoNumber { variable: name, value: value.clone() })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn variables(text: &str) -> Variables {
        let pairs = text.split_whitespace().map(|it| it.split_once('=').expect("NAME=VALUE"));
        pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
    }

    fn shard_of(text: &str, n_shards: u32) -> Result<EngineShard, EngineShardError> {
        engine_shard(&variables(text), NonZeroU32::new(n_shards))
    }

    /// `n_shards` is what `--shards` says, 0 for nothing.
    #[track_caller]
    fn check(text: &str, n_shards: u32, engine: &str, expected: &str) {
        let found = shard_of(text, n_shards).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!((found.engine, found.shard.to_string().as_str()), (engine, expected), "{text}");
    }

    #[track_caller]
    fn check_refused(text: &str, n_shards: u32, words: &[&str]) {
        let said = shard_of(text, n_shards).expect_err(text).to_string();
        assert!(words.iter().all(|it| said.contains(it)), "{text}: {said}");
    }

    const SLURM: &str =
        "SLURM_ARRAY_TASK_COUNT=8 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=8 SLURM_ARRAY_TASK_STEP=1";

    #[test]
    fn each_engine_counts_in_its_own_way() {
        check(&format!("SLURM_ARRAY_TASK_ID=3 {SLURM}"), 0, "Slurm", "3/8");
        check("JOB_COMPLETION_INDEX=0 JOB_COMPLETIONS=8", 0, "Kubernetes", "1/8");
        check("JOB_COMPLETION_INDEX=7", 8, "Kubernetes", "8/8");
        check("AWS_BATCH_JOB_ARRAY_INDEX=2 AWS_BATCH_JOB_ARRAY_SIZE=4", 4, "AWS Batch", "3/4");
        check("PBS_ARRAY_INDEX=2", 4, "PBS", "2/4");
        check("PBS_ARRAYID=4", 4, "Torque", "4/4");
        check("LSB_JOBINDEX=2 LSB_JOBINDEX_END=4 LSB_JOBINDEX_STEP=1", 0, "LSF", "2/4");
        check("CI_NODE_INDEX=1 CI_NODE_TOTAL=5", 0, "GitLab", "1/5");
        check("BUILDKITE_PARALLEL_JOB=0 BUILDKITE_PARALLEL_JOB_COUNT=5", 0, "Buildkite", "1/5");
        check("CIRCLE_NODE_INDEX=4 CIRCLE_NODE_TOTAL=5", 0, "CircleCI", "5/5");
        check("TEST_SHARD_INDEX=1 TEST_TOTAL_SHARDS=2", 0, "Bazel", "2/2");
    }

    #[test]
    fn an_array_may_begin_with_0_or_take_steps() {
        let steps = "SLURM_ARRAY_TASK_COUNT=4 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=30 SLURM_ARRAY_TASK_STEP=10";
        check(&format!("SLURM_ARRAY_TASK_ID=0 {steps}"), 0, "Slurm", "1/4");
        check(&format!("SLURM_ARRAY_TASK_ID=30 {steps}"), 0, "Slurm", "4/4");
        check_refused(&format!("SLURM_ARRAY_TASK_ID=15 {steps}"), 0, &["SLURM_ARRAY_TASK_ID=15 is not"]);
        check("LSB_JOBINDEX=5 LSB_JOBINDEX_END=7 LSB_JOBINDEX_STEP=2", 0, "LSF", "3/4");
    }

    #[test]
    fn without_an_engine_nothing_is_run() {
        check_refused("", 0, &["no engine says", "SLURM_ARRAY_TASK_ID", "TEST_SHARD_INDEX"]);
        check_refused("", 8, &["no engine says"]);
        check_refused("HOME=/root JOB_COMPLETION_INDEX=", 8, &["no engine says"]);
    }

    #[test]
    fn a_job_that_is_not_one_of_many_is_refused() {
        check_refused("CI_NODE_TOTAL=1", 0, &["GitLab runs this job once", "(CI_NODE_TOTAL=1)"]);
        check_refused("CIRCLE_NODE_INDEX=0 CIRCLE_NODE_TOTAL=1", 0, &["CircleCI runs this job once"]);
        check_refused("LSB_JOBINDEX=0", 8, &["LSF runs this job once", "LSB_JOBINDEX=0"]);
        // A job of GitLab that hands its tasks to Slurm passes its variables on.
        check(&format!("CI_NODE_TOTAL=1 SLURM_ARRAY_TASK_ID=3 {SLURM}"), 0, "Slurm", "3/8");
    }

    #[test]
    fn half_of_the_variables_is_not_enough() {
        check_refused(
            "JOB_COMPLETION_INDEX=3",
            0,
            &["JOB_COMPLETION_INDEX=3, but JOB_COMPLETIONS is", "--shards N"],
        );
        check_refused("JOB_COMPLETIONS=8", 0, &["JOB_COMPLETIONS=8, but JOB_COMPLETION_INDEX is not set"]);
        check_refused("CI_NODE_TOTAL=8", 8, &["CI_NODE_TOTAL=8, but CI_NODE_INDEX is not set"]);
        check_refused(SLURM, 0, &["SLURM_ARRAY_TASK_MIN=1", "but SLURM_ARRAY_TASK_ID is not set"]);
        check_refused("SLURM_ARRAY_TASK_ID=3", 0, &["but SLURM_ARRAY_TASK_MIN is not set; give --shards N"]);
        check_refused("PBS_ARRAY_INDEX=3", 0, &["PBS_ARRAY_INDEX=3, but the number of tasks", "--shards N"]);
        check_refused("LSB_JOBINDEX=3", 0, &["LSB_JOBINDEX_END is not set"]);
    }

    #[test]
    fn a_part_of_an_array_is_no_array_unless_the_user_says_how_many_shards_there_are() {
        let array = |task: u32, count: u32, first: u32, last: u32, step: u32| {
            format!(
                "SLURM_ARRAY_TASK_ID={task} SLURM_ARRAY_TASK_COUNT={count} SLURM_ARRAY_TASK_MIN={first} \
                 SLURM_ARRAY_TASK_MAX={last} SLURM_ARRAY_TASK_STEP={step}"
            )
        };
        // One task again, two tasks again, gaps.
        for part in [array(3, 1, 3, 3, 1), array(1, 1, 1, 1, 1), array(5, 2, 3, 5, 2), array(1, 3, 1, 7, 1)] {
            check_refused(&part, 0, &["look like a whole one", "SLURM_ARRAY_TASK_COUNT=", "--shards N"]);
        }
        check(&array(3, 1, 3, 3, 1), 8, "Slurm", "3/8");
        check(&array(5, 2, 3, 5, 2), 8, "Slurm", "5/8");
        check_refused(&array(9, 1, 9, 9, 1), 8, &["SLURM_ARRAY_TASK_ID=9 is not a number from 1 to 8"]);
        // Numbered from 0, each task would be the shard of its neighbour.
        check_refused(&array(3, 8, 0, 7, 1), 8, &["SLURM_ARRAY_TASK_MIN=0", "from 1 to N"]);
        check_refused(&array(3, 8, 1, 8, 0), 0, &["SLURM_ARRAY_TASK_STEP=0"]);
        check("LSB_JOBINDEX=3 LSB_JOBINDEX_END=3 LSB_JOBINDEX_STEP=1", 8, "LSF", "3/8");
        check_refused("PBS_ARRAY_INDEX=0", 8, &["PBS_ARRAY_INDEX=0 is not a number from 1 to 8"]);
    }

    #[test]
    fn numbers_that_make_no_sense_are_named() {
        check_refused("JOB_COMPLETION_INDEX=x JOB_COMPLETIONS=8", 0, &["JOB_COMPLETION_INDEX=\"x\" is not"]);
        check_refused("JOB_COMPLETION_INDEX=-1 JOB_COMPLETIONS=8", 0, &["JOB_COMPLETION_INDEX=\"-1\""]);
        check_refused("JOB_COMPLETION_INDEX=8 JOB_COMPLETIONS=8", 0, &["=8 is not a number from 0 to 7"]);
        check_refused("CI_NODE_INDEX=0 CI_NODE_TOTAL=8", 0, &["CI_NODE_INDEX=0 is not a number from 1 to 8"]);
        check_refused("JOB_COMPLETION_INDEX=1 JOB_COMPLETIONS=0", 0, &["JOB_COMPLETION_INDEX=1 is not"]);
        check_refused("JOB_COMPLETION_INDEX=1 JOB_COMPLETIONS=4", 8, &["--shards 8, but JOB_COMPLETIONS=4"]);
    }

    #[test]
    fn two_engines_have_to_agree() {
        let batch_on_kubernetes = "JOB_COMPLETION_INDEX=2 AWS_BATCH_JOB_ARRAY_INDEX=2";
        check(batch_on_kubernetes, 4, "Kubernetes", "3/4");
        check_refused(
            "CI_NODE_INDEX=2 CI_NODE_TOTAL=4 BUILDKITE_PARALLEL_JOB=2 BUILDKITE_PARALLEL_JOB_COUNT=4",
            0,
            &["GitLab says 2/4 (CI_NODE_INDEX=2, CI_NODE_TOTAL=4), but Buildkite says 3/4 (BUILDKITE_"],
        );
    }

    #[test]
    fn bazel_is_told_that_its_shards_are_known() {
        let bazel = "TEST_SHARD_INDEX=1 TEST_TOTAL_SHARDS=2 TEST_SHARD_STATUS_FILE=/tmp/known";
        assert_eq!(shard_of(bazel, 0).expect("a shard").status_file, Some("/tmp/known".into()));
        let other = "CI_NODE_INDEX=1 CI_NODE_TOTAL=2 TEST_SHARD_STATUS_FILE=/tmp/known";
        assert_eq!(shard_of(other, 0).expect("a shard").status_file, None);
    }

    /// What `engine` sets for the task at `place` of `count`, numbered from `first`, with `step` between, where users number them.
    fn set_by(engine: &Engine, (place, count): (u32, u32), (first, step): (u32, u32)) -> Variables {
        let (number, others) = match engine.numbering {
            Numbering::ByEngine { first, count: name } => (first + place, vec![(name, count)]),
            Numbering::ByUser(ArrayRange::Unsaid) => (1 + place, Vec::new()),
            Numbering::ByUser(ArrayRange::ToLast { last, step: name }) => {
                (1 + place * step, vec![(last, 1 + (count - 1) * step), (name, step)])
            }
            Numbering::ByUser(ArrayRange::Whole {
                first: name,
                last,
                step: step_name,
                count: count_name,
            }) => {
                let last_number = first + (count - 1) * step;
                let others = [(name, first), (last, last_number), (step_name, step), (count_name, count)];
                (first + place * step, others.to_vec())
            }
        };
        let all = others.into_iter().chain([(engine.task, number)]);
        all.map(|(name, value)| (name.to_owned(), value.to_string())).collect()
    }

    proptest! {
        #[test]
        fn over_all_tasks_each_shard_is_there_once(
            engine_idx in 0..ENGINES.len(), count in 2_u32..60, first in 0_u32..2, step in 1_u32..5
        ) {
            let engine = &ENGINES[engine_idx];
            let said = !matches!(engine.numbering, Numbering::ByUser(ArrayRange::Unsaid));
            let n_shards = if said { None } else { NonZeroU32::new(count) };
            let shards: Vec<String> = (0..count)
                .map(|place| engine_shard(&set_by(engine, (place, count), (first, step)), n_shards))
                .map(|it| it.expect("a shard").shard.to_string())
                .collect();
            let expected: BTreeSet<String> = (1..=count).map(|it| format!("{it}/{count}")).collect();
            prop_assert_eq!(shards.len(), expected.len());
            prop_assert_eq!(shards.into_iter().collect::<BTreeSet<_>>(), expected);
        }

        #[test]
        fn any_part_of_an_array_that_is_numbered_from_1_has_its_own_shards(
            task in 1_u32..60, more in 0_u32..60, first in 1_u32..60, count in 1_u32..9
        ) {
            let n_shards = task + more;
            let part = format!(
                "SLURM_ARRAY_TASK_ID={task} SLURM_ARRAY_TASK_COUNT={count} SLURM_ARRAY_TASK_MIN={first}"
            );
            let shard = shard_of(&part, n_shards).expect("a shard").shard;
            prop_assert_eq!(shard.to_string(), format!("{task}/{n_shards}"));
        }

        #[test]
        fn whatever_is_set_nothing_panics(values in prop::collection::vec("[0-9]{0,10}|x", 26)) {
            let names = ENGINES.iter().flat_map(Engine::names);
            let set: Variables = names.map(str::to_owned).zip(values).collect();
            let _ = engine_shard(&set, None);
            let _ = engine_shard(&set, NonZeroU32::new(3));
        }
    }
}
