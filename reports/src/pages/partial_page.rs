//! The page of a result of `scanbench partial`: how methods classify objects as more and more of them is seen.

use std::collections::BTreeSet;
use std::path::Path;

use maud::{Markup, html};

use super::again::Made;
use super::document::{Section, document};
use super::markup::{titled_tables, wide_picture};
use crate::files::archive::ArchiveError;
use crate::files::fixed_decimals::fixed_decimals;
use crate::files::whole_file::write_whole;
use crate::partial_study::partial_curves::PartialCurve;
use crate::plots::figure::Figure;
use crate::plots::partial_plot::{partial_accuracy_plot, partial_calibration_plot, partial_error_plot};
use crate::run_folder::manifest::Manifest;
use crate::run_folder::partial_entry::PartialEntry;
use crate::run_folder::run_archive::RunArchive;
use crate::run_folder::run_directory::{PARTIAL_RRD, REPORT_HTML};
use crate::tables::sheet::Tabular as _;
use crate::tables::studies::partial_findings::{judged_objects, partial_findings, partial_heading};
use crate::tables::studies::partial_table::PartialTable;

/// The page of partial clouds.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialPage {
    /// The page.
    pub html: String,
}

impl PartialPage {
    /// The page of the result in `directory`, made of its files alone; it shows more of `method` than of others.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if a file is missing or damaged.
    pub fn of(directory: &Path, method: &str) -> Result<Self, ArchiveError> {
        let RunArchive { manifest, objects, .. } = RunArchive::read(directory)?;
        let partial = manifest.partial.clone().unwrap_or_default();
        let (curves, title) = (PartialCurve::all(&objects), partial.title());
        let n_objects = n_objects(&partial, &curves);
        let found = partial_findings(&partial, &curves, method);
        let has_recording = directory.join(PARTIAL_RRD).is_file();
        let header = html! {
            p.kicker { "scanbench" }
            h1 { "What is it, when only a part has been seen?" }
            p.facts { (title) " " (n_objects) " objects, each in growing parts." }
        };
        let accuracy = picture(
            "accuracy",
            &partial_accuracy_plot(&curves, &title),
            "The mean of recalls over the steps, with 95 % intervals over objects.",
        );
        let calibration = picture(
            "calibration",
            &partial_calibration_plot(&curves, &title),
            "Decisions by the chance that they were given, and the share of them that was right; on the thin line both are the same.",
        );
        let mut sections: Vec<Section> = verdict(&curves, method, &found).into_iter().collect();
        sections.push(Section::new("Accuracy", partial_heading(&curves, method), accuracy));
        sections.push(tables(&title, &curves, method));
        sections.extend(errors(&curves, method));
        sections.push(Section::new("Calibration", "How sure, and how often right", calibration));
        sections.push(reproduction(&manifest, &partial, has_recording));
        Ok(Self { html: document("partial clouds", &header, &sections) })
    }

    /// Writes the page into `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), ArchiveError> {
        write_whole(&directory.join(REPORT_HTML), self.html.as_bytes())
    }
}

fn n_objects(partial: &PartialEntry, curves: &[PartialCurve]) -> u64 {
    let sets: BTreeSet<&str> = partial.sets.iter().map(|it| it.judged.id.as_str()).collect();
    sets.into_iter().flat_map(|it| judged_objects(curves, it).into_values()).sum()
}

/// The mean of recalls when half and when all is seen, in a sentence for each curve of `method`, and the sentences `found`.
fn verdict(curves: &[PartialCurve], method: &str, found: &[String]) -> Option<Section> {
    let said = |curve: &PartialCurve| {
        let at = |step: u32| curve.steps.iter().find(|it| it.step == step)?.mean_recall;
        let [half, whole] = [at(5)?, at(10)?].map(|it| fixed_decimals(100.0 * it, 1));
        let PartialCurve { data, direction, trained_on, .. } = curve;
        Some(format!(
            "{data} from {direction} ({trained_on}): right for {half} % at step 5 and for {whole} % when all is seen."
        ))
    };
    let lines: Vec<String> = curves.iter().filter(|it| it.method == method).filter_map(said).collect();
    let content = html! {
        div.verdict {
            @if !lines.is_empty() { p { "The " (method) ", mean of recalls:" } }
            @for line in lines.iter().chain(found) { p { (line) } }
        }
    };
    (!lines.is_empty() || !found.is_empty()).then(|| Section::without_heading("Verdict", content))
}

fn picture(name: &str, figure: &Figure, caption: &str) -> Markup {
    wide_picture(name, &figure.panel(name.to_owned()).inline(), &html! { (caption) })
}

fn tables(title: &str, curves: &[PartialCurve], method: &str) -> Section {
    let sheet = PartialTable { title, curves, method, found: &[] }.sheet();
    Section::new("Tables", "Tables", titled_tables(&sheet, "Table"))
}

/// The mean errors to each class, as in Figs. 4 to 7 of the paper; `None` if `method` has no curve.
fn errors(curves: &[PartialCurve], method: &str) -> Option<Section> {
    let ours: Vec<&PartialCurve> = curves.iter().filter(|it| it.method == method).collect();
    let content = html! {
        @for curve in &ours {
            @let title = format!("{} from {}, trained on {}", curve.data, curve.direction, curve.trained_on);
            h3 { (title) }
            (picture(&title, &partial_error_plot(curve, &title),
                "Mean L1 distance of bags to the mean bag of each class. The upright line is at the first step at which all objects could be judged."))
        }
    };
    (!ours.is_empty()).then(|| Section::new("Errors", "How far from each class", content))
}

fn reproduction(manifest: &Manifest, partial: &PartialEntry, has_recording: bool) -> Section {
    let content = html! {
        (Made::of(manifest).markup())
        @for model in partial.sets.iter().filter_map(|it| it.model.as_ref()).take(1) {
            p { "The model " (model.name) " was made by " code { (model.made_by) } " of " (model.data.join(", ")) "." }
        }
        @for (name, checksum) in &partial.peers {
            p { "The results of " (name) " are those of another program; SHA-256 of its file: " code { (checksum) } }
        }
        @if has_recording {
            p { "How objects were seen and classified: " a href=(PARTIAL_RRD) { (PARTIAL_RRD) } ", a recording for Rerun." }
        }
    };
    Section::new("Reproduce", "Reproduce", content)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::to_csv_bytes;
    use crate::partial_study::partial_curves::tests::rows;
    use crate::run_folder::manifest::tests::partial_manifest;
    use crate::run_folder::run_directory::PARTIAL_CSV;
    use crate::run_folder::run_target::MANIFEST_JSON;

    fn result() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &[u8]| std::fs::write(folder.path().join(name), content).unwrap();
        write(PARTIAL_CSV, &to_csv_bytes(&rows()).unwrap());
        write(MANIFEST_JSON, partial_manifest().to_json().as_bytes());
        folder
    }

    #[test]
    fn a_page_has_figures_tables_and_how_to_make_it_again() {
        let folder = result();
        let page = PartialPage::of(folder.path(), "graphs").unwrap();
        for part in [
            "street (simulated), classified by the shipped model",
            "3 objects",
            "Mean of recalls in %",
            "claims of the paper",
            "href=\"#errors\"",
            "objects that are: tree",
            "scanbench partial 'it'\\''s &lt;here&gt;'",
        ] {
            let part = part.trim_start_matches("scanbench ");
            assert!(page.html.contains(part), "no {part} in {}", page.html);
        }
        assert!(!page.html.contains("partial.rrd") && !page.html.contains("<script"));
        page.write(folder.path()).unwrap();
        std::fs::write(folder.path().join(PARTIAL_RRD), "").unwrap();
        assert!(PartialPage::of(folder.path(), "graphs").unwrap().html.contains("href=\"partial.rrd\""));
    }

    #[test]
    fn a_damaged_result_is_named_and_other_methods_have_no_errors() {
        let folder = result();
        let html = PartialPage::of(folder.path(), "esf").unwrap().html;
        assert!(!html.contains("id=\"errors\""));
        std::fs::write(folder.path().join(MANIFEST_JSON), "{}").unwrap();
        let error = PartialPage::of(folder.path(), "graphs").unwrap_err().to_string();
        assert!(error.contains(MANIFEST_JSON), "{error}");
    }
}
