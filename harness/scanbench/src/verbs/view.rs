//! `scanbench view`.

use std::collections::BTreeSet;

use reports::rows::match_outcome::MatchOutcome;
use reports::rows::match_row::MatchRow;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::vocabulary::class::{AnnotationClass, DetectionClass};
use reports::vocabulary::reason::ShownKind;
use reports::worst::mistakes::{MistakeChoice, worst, worst_to_terminal};

use crate::cli::{OutcomeName, ViewArgs};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::open_run::open_run;
use crate::plumbing::standard_streams::print_text;
use crate::verbs::changed_scans::view_changes;
use crate::verbs::worst_scans::{chosen_task, record};

/// Lists the worst mistakes of a detector, and records the scans they are in.
pub fn view(arguments: &ViewArgs) -> Result<(), Failure> {
    let path = &arguments.run;
    if let Some(after) = &arguments.after {
        return view_changes(arguments, after);
    }
    if path.is_dir() && !path.join(MANIFEST_JSON).exists() {
        let (path, word) = (path.display(), shell_word(&path.display().to_string()));
        return Err(Usage(format!(
            "{path} is not the directory of a run; to see scans and labels, record them: `scanbench run {word} --scans 0`"
        ))
        .into());
    }
    let run = open_run(path)?;
    if run.manifest.partial.is_some() {
        let problem = "is a result of `partial`, which has no scans: open its partial.rrd";
        return Err(Usage(format!("{} {problem}", path.display())).into());
    }
    let (detector, task) = chosen_task(arguments, &run)?;
    if let Some(name) = arguments.class.as_deref().filter(|it| !is_class(it)) {
        return Err(Usage(format!(
            "the run has no class {name:?}; its classes are {}",
            classes_of(&run.matches)
        ))
        .into());
    }
    let choice = MistakeChoice {
        detector,
        task,
        at: arguments.at.as_deref(),
        kind: arguments.outcome.map(|it| match it {
            OutcomeName::Missed => ShownKind::Missed,
            OutcomeName::False => ShownKind::False,
            OutcomeName::Alone => ShownKind::Alone,
        }),
        class: arguments.class.as_deref(),
    };
    let mistakes = worst(&run.matches, &choice, arguments.worst as usize);
    if mistakes.is_empty() {
        let at = arguments.at.as_ref().map(|it| format!(" at {it}")).unwrap_or_default();
        return Err(NothingEvaluated { reason: format!("the run has no mistakes of this kind{at}") }.into());
    }
    print_text(&worst_to_terminal(&mistakes))?;
    record(arguments, &run.manifest, task, &mistakes)
}

/// Whether it is the name of a class, or a word of detectors that give none.
fn is_class(name: &str) -> bool {
    let kinds = [DetectionClass::Object, DetectionClass::Vehicle].map(DetectionClass::name);
    kinds.contains(&name) || AnnotationClass::met(name).is_some()
}

/// The annotated classes, separated by commas.
fn classes_of(matches: &[MatchRow]) -> String {
    let annotated = matches.iter().filter_map(|row| match &row.outcome {
        MatchOutcome::Matched { annotation, .. } | MatchOutcome::Missed { annotation, .. } => {
            Some(annotation.class)
        }
        _ => None,
    });
    let classes: BTreeSet<&str> = annotated.map(AnnotationClass::name).collect();
    classes.into_iter().collect::<Vec<_>>().join(", ")
}
