//! `scanbench compare` and `scanbench gate` over results of `scanbench partial`.

use std::path::Path;

use reports::files::csv_rows::to_csv_bytes;
use reports::files::whole_file::write_whole;
use reports::run_folder::partial_archive::PartialArchive;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::tables::formats::format::Format;
use reports::tables::formats::junit::JUnit;
use reports::tables::formats::markdown::Markdown;
use reports::tables::verdict::partial_comparison::{
    PartialComparison, PartialDifferenceRow, PartialSummary, SummaryExtent, partial_verdict_json,
};
use reports::verdicts::accept::{TOLERANCES_TOML, run_of_baseline};
use reports::verdicts::partial_verdict::{
    PartialTolerances, PartialTolerancesError, PartialVerdict, judge_partial,
};
use reports::verdicts::tolerances::DriftRule;

use crate::cli::{CompareArgs, GateArgs, OutputArgs};
use crate::commands::failure::{Failure, GateClosed, NotOfOneKind, Usage};
use crate::commands::open_run::refuse_shard;
use crate::commands::paper_files::write_table;
use crate::commands::provenance::comparison_facts;
use crate::commands::run_directory::claim_named;
use crate::commands::standard_streams::{print_bytes, print_diagnostic, terminal};
use crate::commands::step_summary::append_to_step_summary;

/// Prints what lies between two results, or two methods of one, and writes it where that is asked for.
pub fn compare_partial(arguments: &CompareArgs) -> Result<(), Failure> {
    let output = OutputArgs { output: arguments.output.clone(), overwrite: arguments.overwrite };
    let directory = claim_named(&output)?;
    if arguments.slices {
        let problem = "--slices is for runs of detectors; every step of partial clouds is compared anyway";
        return Err(Usage(problem.to_owned()).into());
    }
    let result = open_partial(&arguments.run)?;
    let comparison = match (&arguments.other, arguments.detectors.as_deref()) {
        (Some(other), _) => PartialComparison::of_results(&result, &open_partial(other)?)?,
        (None, Some([first, second])) => of_methods(&result, first, second)?,
        (None, _) => {
            return Err(Usage("--detectors takes two names, such as extents,bag of graphs".to_owned()).into());
        }
    };
    if let Some(directory) = directory {
        let directory = RunDirectory::begin(directory)?;
        directory.write_file(MANIFEST_JSON, format!("{:#}\n", comparison_facts(arguments)).as_bytes())?;
        directory.write_file("comparison.csv", &to_csv_bytes(&PartialDifferenceRow::all(&comparison))?)?;
        write_table(&directory, "comparison", &comparison)?;
        print_diagnostic(format_args!("Comparison: {}", directory.finish()?.display()));
    }
    let format: &dyn Format<PartialComparison> = if arguments.markdown { &Markdown } else { &terminal() };
    print_bytes(format.text(&comparison).as_bytes())
}

fn of_methods(result: &PartialArchive, first: &str, second: &str) -> Result<PartialComparison, Failure> {
    let mut known: Vec<&str> =
        result.rows.iter().map(reports::rows::partial_row::PartialRow::method).collect();
    known.sort_unstable();
    known.dedup();
    match [first, second].into_iter().find(|it| !known.contains(it)) {
        Some(unknown) => {
            let known = known.join(", ");
            Err(Usage(format!("the result has no method {unknown:?}; its methods are {known}")).into())
        }
        None => Ok(PartialComparison::of_methods(result, first, second)?),
    }
}

/// Judges a result by an accepted one, and prints and writes the verdict.
pub fn gate_partial(arguments: &GateArgs) -> Result<(), Failure> {
    let directory = &arguments.baseline.baseline;
    if !directory.is_dir() {
        let problem = format!(
            "there is no baseline {}; name a result with --baseline, or make one: scanbench baseline init RESULT -o ci",
            directory.display()
        );
        return Err(Usage(problem).into());
    }
    let baseline = open_partial(&run_of_baseline(directory))?;
    let mut tolerances = partial_tolerances(directory, arguments.tolerances.as_deref())?;
    if let Some(is_allowed) = arguments.allow_drift {
        tolerances.drift = if is_allowed { DriftRule::Warn } else { DriftRule::Fail };
    }
    let verdict = judge_partial(&baseline, &open_partial(&arguments.run)?, &tolerances)?;
    let of_extent = |extent| PartialSummary { verdict: &verdict, extent };
    let in_markdown = Markdown.text(&of_extent(SummaryExtent::Full));
    if let Some(output) = &arguments.output {
        write_verdict(output, &verdict, &in_markdown)?;
    }
    append_to_step_summary(&in_markdown)?;
    let extent = if arguments.full { SummaryExtent::Full } else { SummaryExtent::Brief };
    print_bytes(terminal().text(&of_extent(extent)).as_bytes())?;
    match verdict.conclusion() {
        passed if passed.is_pass() => Ok(()),
        closed => Err(GateClosed(closed).into()),
    }
}

/// Those of the command line, else those beside the baseline in `directory`, else the built-in ones.
pub fn partial_tolerances(
    directory: &Path,
    of_command_line: Option<&Path>,
) -> Result<PartialTolerances, PartialTolerancesError> {
    let beside = directory.join(TOLERANCES_TOML);
    match of_command_line {
        Some(path) => PartialTolerances::read(path),
        None if beside.exists() => PartialTolerances::read(&beside),
        None => Ok(PartialTolerances::built_in()),
    }
}

fn write_verdict(directory: &Path, verdict: &PartialVerdict, in_markdown: &str) -> Result<(), Failure> {
    std::fs::create_dir_all(directory).map_err(|error| {
        Failure::usage(format!("cannot make the directory {}", directory.display()), error)
    })?;
    write_whole(&directory.join("gate.json"), partial_verdict_json(verdict).as_bytes())?;
    let junit: &dyn Format<PartialVerdict> = &JUnit;
    write_whole(&directory.join(junit.file_name("gate")), junit.text(verdict).as_bytes())?;
    Ok(write_whole(&directory.join("gate.md"), in_markdown.as_bytes())?)
}

/// The result in `directory`.
pub fn open_partial(directory: &Path) -> Result<PartialArchive, Failure> {
    if !directory.is_dir() {
        return Err(Usage(format!("there is no directory {}", directory.display())).into());
    }
    if !PartialArchive::is_partial(directory) {
        return Err(NotOfOneKind { directory: directory.display().to_string() }.into());
    }
    refuse_shard(directory)?;
    PartialArchive::read(directory).map_err(|error| Failure::damaged_run(directory, error))
}

impl From<PartialTolerancesError> for Failure {
    fn from(error: PartialTolerancesError) -> Self {
        Self::Usage(error.into())
    }
}

impl From<NotOfOneKind> for Failure {
    fn from(error: NotOfOneKind) -> Self {
        Self::NotComparable(error.into())
    }
}
