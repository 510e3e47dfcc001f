//! How far detectors agree where nothing is labelled.

use maud::html;

use super::document::Section;
use super::markup::titled_tables;
use crate::facts::run_facts::RunFacts;
use crate::files::fixed_decimals::fixed_decimals;
use crate::rows::agreement_row::AgreementRow;
use crate::tables::agreement_table::AgreementOfDetectors;
use crate::tables::sheet::Tabular as _;

/// For each data set and task which detector has most to itself, and which least; none of a detector alone.
fn alone_in_words(rows: &[AgreementRow]) -> Vec<String> {
    let of_tasks = rows.chunk_by(|a, b| (&a.dataset, a.task) == (&b.dataset, b.task));
    let sentence = |rows: &[AgreementRow]| {
        let share = |it: &AgreementRow| it.n_alone as f64 / it.n_detections as f64;
        let mut known: Vec<&AgreementRow> =
            rows.iter().filter(|it| it.detector != it.other && it.n_detections > 0).collect();
        known.sort_by(|a, b| share(a).total_cmp(&share(b)));
        let (least, most) = (known.first()?, known.last()?);
        let percent = |it: &AgreementRow| fixed_decimals(100.0 * share(it), 1);
        (least.detector != most.detector).then(|| {
            format!(
                "{}, {}: of the detections of {} no other detector has {} %, of those of {} {} %.",
                least.dataset,
                least.task,
                least.detector,
                percent(least),
                most.detector,
                percent(most)
            )
        })
    };
    of_tasks.filter_map(sentence).collect()
}

/// The section of agreement; `None` if everything is labelled.
pub(super) fn agreement(facts: &RunFacts) -> Option<Section> {
    if facts.agreement.is_empty() {
        return None;
    }
    let sheet = AgreementOfDetectors { rows: &facts.agreement }.sheet();
    let content = html! {
        p.about { "The scans have no labels, so there are no scores." }
        @for sentence in alone_in_words(&facts.agreement) { p { (sentence) } }
        (titled_tables(&sheet, "Agreement"))
        @if !facts.recording_folders.is_empty() {
            p { "The recording shows all detectors side by side, coloured by who agrees: " code { "rerun " (facts.recording_folders.join(" ")) } }
        }
    };
    Some(Section::new("Agreement", "Where detectors agree", content))
}
