//! Results of `scanbench partial` that were accepted.

use std::path::Path;

use crate::files::archive::ArchiveError;
use crate::files::csv_rows::to_csv_bytes;
use crate::files::fixed_decimals::fixed_decimals;
use crate::files::whole_file::write_whole;
use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::run_folder::partial_archive::PartialArchive;
use crate::run_folder::run_directory::{PARTIAL_CSV, RunDirectory};
use crate::run_folder::run_target::{ExistingTarget, LatestPointer, MANIFEST_JSON};
use crate::verdicts::accept::{
    ACCEPTED_RUN, AcceptError, Acceptance, SCORES_MD, forget_program_path, history_line, history_with,
    line_after, predecessor, refuse_uncommitted,
};
use crate::verdicts::partial_difference::check_comparable_results;

const SCORES_HEAD: &str = "# Accepted scores\n\nMeans of recalls in % of the accepted result at its middle and last step, \
    before → after, and why. Written by `scanbench baseline accept`.\n\n";

/// Makes `result` the accepted one of the baseline `directory`, and adds a line to its history, which is returned.
///
/// # Errors
///
/// [`AcceptError`] if the result cannot be made again, or is not of the objects of the one accepted before although it is
/// meant to, or something cannot be written; the earlier baseline is there still.
pub fn accept_partial(
    result: &PartialArchive,
    directory: &Path,
    acceptance: Acceptance<'_>,
) -> Result<String, AcceptError> {
    refuse_uncommitted(result.manifest.git.as_ref())?;
    let target = directory.join(ACCEPTED_RUN);
    let is_comparable = |before: &_| check_comparable_results(before, result);
    let before = predecessor("result", &target, PartialArchive::read, is_comparable);
    let curves = PartialCurve::all(&result.rows);
    let line = line_after(before, acceptance.succession, |before: Option<&PartialArchive>| {
        let before = before.map_or_else(Vec::new, |it| PartialCurve::all(&it.rows));
        history_line(acceptance, result.manifest.git.as_ref(), &scores(&before, &curves))
    })?;
    let history = history_with(&directory.join(SCORES_MD), SCORES_HEAD, &line)?;

    let written = RunDirectory::create(&target, ExistingTarget::Replace, LatestPointer::Leave)?;
    let mut manifest = result.manifest.clone();
    forget_program_path(&mut manifest.argv);
    written.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let rows = to_csv_bytes(&result.rows);
    let rows = rows.map_err(|source| ArchiveError::Csv { path: target.join(PARTIAL_CSV), source })?;
    written.write_file(PARTIAL_CSV, &rows)?;
    written.finish()?;
    write_whole(&directory.join(SCORES_MD), history.as_bytes())?;
    Ok(line)
}

/// Of every curve the numbers at its middle and last step, and what they were before.
fn scores(before: &[PartialCurve], curves: &[PartialCurve]) -> String {
    let of_curve = |curve: &PartialCurve| {
        let PartialCurve { data, direction, method, trained_on, .. } = curve;
        let is_same = |it: &&PartialCurve| {
            (&it.data, &it.direction, &it.method, &it.trained_on) == (data, direction, method, trained_on)
        };
        let earlier = before.iter().find(is_same);
        let of_step = |step: &PartialStep| {
            let now = percent(step)?;
            let old = earlier.and_then(|it| percent(it.steps.iter().find(|it| it.step == step.step)?));
            let old = old.filter(|it| *it != now).map_or_else(String::new, |it| format!("{it} → "));
            Some(format!("{old}{now}"))
        };
        let steps = [curve.steps.len().div_ceil(2), curve.steps.len()];
        let steps = steps.into_iter().filter_map(|it| of_step(curve.steps.get(it.checked_sub(1)?)?));
        let steps: Vec<String> = steps.collect();
        format!("; {data} from {direction}: {method} trained on {trained_on} {}", steps.join(", "))
    };
    curves.iter().map(of_curve).collect()
}

fn percent(step: &PartialStep) -> Option<String> {
    step.mean_recall.map(|it| fixed_decimals(100.0 * it, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdicts::accept::Succession;
    use crate::verdicts::partial_difference::tests::archive;

    fn accepted(
        result: &PartialArchive,
        folder: &Path,
        succession: Succession,
    ) -> Result<String, AcceptError> {
        accept_partial(result, folder, Acceptance { date: "2026-01-01", why: "better\ntrees.", succession })
    }

    #[test]
    fn what_is_accepted_is_read_back_and_has_a_history() {
        let folder = tempfile::tempdir().unwrap();
        let first = accepted(&archive(40), folder.path(), Succession::Comparable).unwrap();
        // One step is the middle one and the last one.
        assert!(
            first.starts_with("- 2026-01-01; street from ") && first.contains(" 100.0, 100.0. better trees."),
            "{first}"
        );
        let later = accepted(&archive(30), folder.path(), Succession::Comparable).unwrap();
        assert!(later.contains("100.0 → 75.0, 100.0 → 75.0. better trees."), "{later}");
        let kept = PartialArchive::read(&folder.path().join(ACCEPTED_RUN)).unwrap();
        assert_eq!((kept.rows, &*kept.manifest.argv[0]), (archive(30).rows, "scanbench"));
        let history = std::fs::read_to_string(folder.path().join(SCORES_MD)).unwrap();
        assert!(
            history.starts_with("# Accepted scores") && history.ends_with(&format!("{first}\n{later}\n")),
            "{history}"
        );
    }

    #[test]
    fn other_objects_and_uncommitted_changes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        accepted(&archive(40), folder.path(), Succession::Comparable).unwrap();
        let mut other = archive(40);
        other.manifest.sets[0].judged.id = "another".to_owned();
        let error = accepted(&other, folder.path(), Succession::Comparable).unwrap_err().to_string();
        assert!(error.contains("judged are not the same; to accept it all the same"), "{error}");
        let line = accepted(&other, folder.path(), Succession::Anew).unwrap();
        assert!(line.contains("New baseline: the result cannot be compared"), "{line}");
        other.manifest.git =
            Some(crate::run_folder::manifest::GitState { commit: "abc".to_owned(), dirty: true });
        assert!(matches!(accepted(&other, folder.path(), Succession::Anew), Err(AcceptError::Dirty { .. })));
    }
}
