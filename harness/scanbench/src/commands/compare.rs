//! `scanbench compare`.

use reports::run_folder::run_archive::RunArchive;
use reports::tables::formats::format::Format;
use reports::tables::formats::markdown::Markdown;
use reports::tables::formats::terminal::Terminal;
use reports::tables::verdict::comparison::{ComparedSlices, Comparison, compare_detectors, compare_runs};

use crate::cli::CompareArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::open_run::open_run;
use crate::commands::standard_streams::print_bytes;

/// Prints what lies between two runs, or two detectors of one run.
///
/// # Errors
///
/// If a run cannot be read, the two are not of the same scans, or there is no such detector.
pub fn compare(arguments: &CompareArgs) -> Result<(), Failure> {
    let slices = if arguments.slices { ComparedSlices::Each } else { ComparedSlices::All };
    let run = open_run(&arguments.run)?;
    let comparison = match (&arguments.other, arguments.detectors.as_deref()) {
        (Some(other), _) => compare_runs(&run, &open_run(other)?, slices)?,
        (None, Some([first, second])) => of_detectors(&run, first, second, slices)?,
        (None, _) => {
            return Err(Usage("--detectors takes two names, such as kd-tree,hierarchical".to_owned()).into());
        }
    };
    let format: &dyn Format<Comparison> = if arguments.markdown { &Markdown } else { &Terminal::UNFOLDED };
    let text = format.text(&comparison);
    print_bytes(text.as_bytes())
}

fn of_detectors(
    run: &RunArchive,
    first: &str,
    second: &str,
    slices: ComparedSlices,
) -> Result<Comparison, Failure> {
    for name in [first, second] {
        let known: Vec<&str> = run.manifest.detectors.iter().map(|it| it.name.as_str()).collect();
        if !known.contains(&name) {
            return Err(Usage(format!(
                "the run has no detector {name:?}; its detectors are {}",
                known.join(", ")
            ))
            .into());
        }
    }
    Ok(compare_detectors(run, first, second, slices))
}
