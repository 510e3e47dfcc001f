//! `scanbench compare`.

use std::collections::BTreeSet;
use std::path::Path;

use reports::pages::sweep_page::SweepPage;
use reports::rows::partial_row::PartialRow;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;
use reports::tables::verdict::comparison::{
    ComparedSlices, Comparison, DifferenceRow, compare_detectors, compare_runs,
};
use reports::tables::verdict::comparison_in_short::InShort;

use crate::cli::{CompareArgs, OutputArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_run::{open_run, refuse_unknown};
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::provenance::comparison_facts;
use crate::plumbing::run_directory::claim_named;
use crate::plumbing::standard_streams::{print_diagnostic, print_text, terminal};
use reports::files::csv_rows::to_csv_bytes;
use reports::plots::study_plots::comparison_plot;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::MANIFEST_JSON;

/// Prints the differences between two runs, or two detectors of one run, and writes them if that is asked for.
pub fn compare(arguments: &CompareArgs) -> Result<(), Failure> {
    let output = OutputArgs { output: arguments.output.clone(), overwrite: arguments.overwrite };
    let directory = claim_named(&output)?;
    let slices = if arguments.slices { ComparedSlices::Each } else { ComparedSlices::All };
    let run = open_run(&arguments.run)?;
    if run.manifest.partial.is_some() && arguments.slices {
        let problem = "--slices is for runs of detectors; every step of partial clouds is compared anyway";
        return Err(Usage(problem.to_owned()).into());
    }
    let names = arguments.detectors.as_ref().map(|it| whole_names(it, &run));
    let comparison = match (&arguments.other, names.as_deref()) {
        (Some(other), only) => {
            for name in only.unwrap_or_default() {
                check_has(&run, name)?;
            }
            compare_runs(&run, &open_run(other)?, slices, only)?
        }
        (None, Some([first, second])) => of_detectors(&run, first, second, slices)?,
        (None, _) => {
            return Err(Usage("--detectors takes two names, such as kd-tree,hierarchical".to_owned()).into());
        }
    };
    if let Some(directory) = directory {
        let directory = RunDirectory::begin(directory)?;
        directory.write_file(MANIFEST_JSON, format!("{:#}\n", comparison_facts(arguments)).as_bytes())?;
        directory.write_file("comparison.csv", &to_csv_bytes(&DifferenceRow::all(&comparison))?)?;
        write_figure(&directory, "comparison", &comparison_plot(&comparison))?;
        write_table(&directory, "comparison", &comparison)?;
        print_diagnostic(format_args!("Comparison: {}", directory.finish()?.display()));
    }
    print_text(&text_of(&comparison, arguments))?;
    if let (Some(other), Some(most_changed)) = (&arguments.other, &comparison.most_changed) {
        say_how_to_see(&run, [&arguments.run, other], most_changed);
    }
    Ok(())
}

/// The whole comparison where it is asked for; else what is on one screen, and how many more numbers there are.
fn text_of(comparison: &Comparison, arguments: &CompareArgs) -> String {
    if arguments.markdown {
        return Markdown.text(comparison);
    }
    if arguments.full || arguments.slices {
        return terminal().text(comparison);
    }
    terminal().text(&InShort(comparison))
}

/// The names of detectors of `run` among `parts`, which commas have split: a name may have some itself.
fn whole_names(parts: &[String], run: &RunArchive) -> Vec<String> {
    let is_known = |name: &str| run.scans.iter().any(|it| it.detector == name);
    let mut names = Vec::new();
    let mut rest = parts;
    while !rest.is_empty() {
        let longest = (2..=rest.len()).rev().find(|n| is_known(&rest[..*n].join(",")));
        let (name, others) = rest.split_at(longest.unwrap_or(1));
        names.push(name.join(","));
        rest = others;
    }
    names
}

/// Says how the changes from one run to the other are seen; points of sweeps and partial clouds have no scene.
fn say_how_to_see(run: &RunArchive, sides: [&Path; 2], (detector, task): &(String, String)) {
    if run.manifest.partial.is_none() && !SweepPage::is_sweep(sides[0]) {
        let [before, after] = sides.map(|it| shell_word(&it.display().to_string()));
        print_diagnostic(format_args!(
            "Object by object, and in the viewer: scanbench view {before} {after} -d {} --task {}",
            shell_word(detector),
            shell_word(task)
        ));
    }
}

fn of_detectors(
    run: &RunArchive,
    first: &str,
    second: &str,
    slices: ComparedSlices,
) -> Result<Comparison, Failure> {
    for name in [first, second] {
        check_has(run, name)?;
    }
    Ok(compare_detectors(run, first, second, slices)?)
}

/// Checks that `run` has this detector, or this method.
fn check_has(run: &RunArchive, name: &str) -> Result<(), Failure> {
    let (what, known): (_, BTreeSet<&str>) = if run.manifest.partial.is_some() {
        ("method", run.objects.iter().map(PartialRow::method).collect())
    } else {
        ("detector", run.scans.iter().map(|it| it.detector.as_str()).collect())
    };
    Ok(refuse_unknown(what, name, &known.into_iter().collect::<Vec<_>>())?)
}
