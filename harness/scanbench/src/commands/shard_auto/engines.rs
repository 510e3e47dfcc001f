//! The engines whose variables are known.

use std::collections::BTreeMap;

/// Environment variables by name. One without a value counts as not set.
pub type Variables = BTreeMap<String, String>;

/// An engine that runs one command as many tasks.
#[derive(Debug)]
pub struct Engine {
    /// Its name.
    pub name: &'static str,
    /// Variable with the number of the task.
    pub task: &'static str,
    /// Who numbers them.
    pub numbering: Numbering,
    /// What it sets for a job that is not one of many; `None` for what it does not set then. Nothing if it cannot be told.
    pub alone: &'static [(&'static str, Option<&'static str>)],
}

/// Who numbers the tasks.
#[derive(Debug)]
pub enum Numbering {
    /// The engine.
    ByEngine {
        /// Number of the first task.
        first: u32,
        /// Variable with the number of tasks.
        count: &'static str,
    },
    /// Whoever submits the array, as in `--array=1-8`.
    ByUser(ArrayRange),
}

/// What an engine says about the numbers of an array.
#[derive(Debug)]
pub enum ArrayRange {
    /// Nothing.
    Unsaid,
    /// The last number and the step.
    ToLast {
        /// Variable with the last number.
        last: &'static str,
        /// Variable with the step.
        step: &'static str,
    },
    /// All of it.
    Whole {
        /// Variable with the first number.
        first: &'static str,
        /// Variable with the last number.
        last: &'static str,
        /// Variable with the step.
        step: &'static str,
        /// Variable with how many numbers there are.
        count: &'static str,
    },
}

/// The one that has to be told that its shards are known.
pub const BAZEL: &str = "Bazel";

/// The engines whose variables are known, each as its documentation has it:
///
/// - Slurm: <https://slurm.schedmd.com/job_array.html>. The user numbers tasks, from 0 or any other number on.
/// - Kubernetes, from 0: <https://kubernetes.io/docs/concepts/workloads/controllers/job/#completion-mode>. It says the index alone;
///   `JOB_COMPLETIONS` is in the manifests that `scanbench submit` writes.
/// - AWS Batch, from 0: <https://docs.aws.amazon.com/batch/latest/userguide/job_env_vars.html>
/// - PBS: the chapter on job arrays of its user's guide. The user numbers tasks; how many there are is not said.
/// - Torque: <https://docs.adaptivecomputing.com/torque/4-1-3/Content/topics/2-jobs/multiJobSubmission.htm>, likewise.
/// - LSF: <https://www.ibm.com/docs/en/spectrum-lsf/10.1.0?topic=variables-environment-set-job-execution>. The user numbers tasks, from 1
///   or more on. A job that is no array has the index 0:
///   <https://www.ibm.com/docs/en/SSWRJV_10.1.0/lsf_admin/job_array_cl_args.html>
/// - GitLab, from 1: <https://docs.gitlab.com/ci/variables/predefined_variables/>. A job without `parallel` has the total 1 and no index.
/// - Buildkite, from 0: <https://buildkite.com/docs/pipelines/configure/environment-variables>
/// - CircleCI, from 0: <https://circleci.com/docs/variables/>. A job without `parallelism` is 0 of 1.
/// - Bazel, from 0: <https://bazel.build/reference/test-encyclopedia>
pub const ENGINES: [Engine; 10] = [
    Engine {
        name: "Slurm",
        task: "SLURM_ARRAY_TASK_ID",
        numbering: Numbering::ByUser(ArrayRange::Whole {
            first: "SLURM_ARRAY_TASK_MIN",
            last: "SLURM_ARRAY_TASK_MAX",
            step: "SLURM_ARRAY_TASK_STEP",
            count: "SLURM_ARRAY_TASK_COUNT",
        }),
        alone: &[],
    },
    Engine {
        name: "Kubernetes",
        task: "JOB_COMPLETION_INDEX",
        numbering: Numbering::ByEngine { first: 0, count: "JOB_COMPLETIONS" },
        alone: &[],
    },
    Engine {
        name: "AWS Batch",
        task: "AWS_BATCH_JOB_ARRAY_INDEX",
        numbering: Numbering::ByEngine { first: 0, count: "AWS_BATCH_JOB_ARRAY_SIZE" },
        alone: &[],
    },
    Engine {
        name: "PBS",
        task: "PBS_ARRAY_INDEX",
        numbering: Numbering::ByUser(ArrayRange::Unsaid),
        alone: &[],
    },
    Engine {
        name: "Torque",
        task: "PBS_ARRAYID",
        numbering: Numbering::ByUser(ArrayRange::Unsaid),
        alone: &[],
    },
    Engine {
        name: "LSF",
        task: "LSB_JOBINDEX",
        numbering: Numbering::ByUser(ArrayRange::ToLast {
            last: "LSB_JOBINDEX_END",
            step: "LSB_JOBINDEX_STEP",
        }),
        alone: &[("LSB_JOBINDEX", Some("0"))],
    },
    Engine {
        name: "GitLab",
        task: "CI_NODE_INDEX",
        numbering: Numbering::ByEngine { first: 1, count: "CI_NODE_TOTAL" },
        alone: &[("CI_NODE_INDEX", None), ("CI_NODE_TOTAL", Some("1"))],
    },
    Engine {
        name: "Buildkite",
        task: "BUILDKITE_PARALLEL_JOB",
        numbering: Numbering::ByEngine { first: 0, count: "BUILDKITE_PARALLEL_JOB_COUNT" },
        alone: &[],
    },
    Engine {
        name: "CircleCI",
        task: "CIRCLE_NODE_INDEX",
        numbering: Numbering::ByEngine { first: 0, count: "CIRCLE_NODE_TOTAL" },
        alone: &[("CIRCLE_NODE_INDEX", Some("0")), ("CIRCLE_NODE_TOTAL", Some("1"))],
    },
    Engine {
        name: BAZEL,
        task: "TEST_SHARD_INDEX",
        numbering: Numbering::ByEngine { first: 0, count: "TEST_TOTAL_SHARDS" },
        alone: &[],
    },
];

impl Engine {
    /// Its variables.
    pub fn names(&self) -> Vec<&'static str> {
        let others = match self.numbering {
            Numbering::ByEngine { count, .. } => vec![count],
            Numbering::ByUser(ArrayRange::Unsaid) => Vec::new(),
            Numbering::ByUser(ArrayRange::ToLast { last, step }) => vec![last, step],
            Numbering::ByUser(ArrayRange::Whole { first, last, step, count }) => {
                vec![first, last, step, count]
            }
        };
        std::iter::once(self.task).chain(others).collect()
    }

    /// Those that are set, with their values.
    pub fn said(&self, variables: &Variables) -> String {
        let set = self.names().into_iter().filter_map(|it| Some(format!("{it}={}", variables.get(it)?)));
        set.collect::<Vec<_>>().join(", ")
    }

    /// Whether the job is not one of many, as far as the engine says it.
    pub fn is_alone(&self, variables: &Variables) -> bool {
        let is_so = |(name, value): &(&str, Option<&str>)| variables.get(*name).map(String::as_str) == *value;
        !self.alone.is_empty() && self.alone.iter().all(is_so)
    }
}
