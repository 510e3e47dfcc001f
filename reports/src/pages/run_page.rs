//! The page of a run.

use std::path::Path;

use super::agreement::agreement;
use super::classes::{classes, slices};
use super::curves::curves;
use super::document::document;
use super::errors::errors;
use super::labels::labels;
use super::markup::Figure;
use super::overview::{header, heading, verdict};
use super::parameters::parameters;
use super::protocols::protocols;
use super::ranges::ranges;
use super::recall_parts::recall_parts;
use super::reproduction::reproduction;
use super::task_tables::task_tables;
use super::times::times;
use super::worst::worst;
use crate::facts::run_facts::RunFacts;
use crate::files::archive::ArchiveError;
use crate::files::new_file::make_folder;
use crate::files::whole_file::write_whole;
use crate::plots::pdf::figure_files;
use crate::run_folder::run_directory::{FIGURES, REPORT_HTML};

/// The page of a run, and its figures as files.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPage {
    /// The page.
    pub html: String,
    /// Figures for the folder [`FIGURES`].
    pub figures: Vec<Figure>,
}

impl RunPage {
    /// The page of a run.
    pub fn of(facts: &RunFacts) -> Self {
        let mut figures = Vec::new();
        let mut sections = vec![verdict(facts, &mut figures)];
        if facts.is_scored() {
            sections.extend(recall_parts(facts));
            sections.extend(classes(facts));
            sections.push(ranges(facts, &mut figures));
            sections.extend(curves(facts, &mut figures));
            sections.extend(slices(facts));
            sections.extend(protocols(facts));
            sections.push(task_tables(&facts.tables));
        }
        sections.extend(agreement(facts));
        if facts.is_scored() {
            sections.push(times(facts, &mut figures));
            sections.extend(errors(facts, &mut figures));
            sections.extend(worst(facts));
        } else {
            sections.extend(worst(facts));
            sections.push(times(facts, &mut figures));
        }
        sections.extend(labels(facts, &mut figures));
        sections.push(reproduction(facts));
        sections.push(parameters(&facts.manifest));
        let html = document(&heading(facts), &header(facts), &sections);
        Self { html, figures }
    }

    /// Writes the page and its figures into `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if they cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), ArchiveError> {
        let folder = make_folder(directory, FIGURES)
            .map_err(|source| ArchiveError::Write { path: directory.join(FIGURES), source })?;
        for figure in &self.figures {
            for (name, content) in figure_files(&figure.file_stem, &figure.svg)? {
                write_whole(&folder.join(name), &content)?;
            }
        }
        write_whole(&directory.join(REPORT_HTML), self.html.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::pages::sample_run::{SampleRun, USUAL};
    use crate::run_folder::run_directory::MATCHES_CSV;
    use crate::vocabulary::task::Task;
    use crate::worst::recorded::{RecordedObject, Recordings};

    /// The page with blanks that may break.
    fn page(run: &SampleRun<'_>) -> RunPage {
        let page = page_in(run.write().path());
        RunPage { html: page.html.replace('\u{a0}', " "), ..page }
    }

    fn page_in(folder: &Path) -> RunPage {
        RunPage::of(&RunFacts::read(folder).unwrap())
    }

    fn names(page: &RunPage) -> Vec<&str> {
        page.figures.iter().map(|it| it.file_stem.as_str()).collect()
    }

    #[test]
    fn a_page_says_who_leads_and_by_how_much() {
        let page = page(&USUAL);
        check_holds(
            &page.html,
            &[
                "Task objects (simulated): hierarchical leads with an F-rate of 90.0 %",
                "5.8 points above kd-tree",
                "10 × faster than kd-tree (40.0 ms) and 100 × faster than pca (400 ms)",
                "<code>scanbench run",
                "cargo run --release -- ",
                "href=\"#curves\"",
            ],
        );
        let drawn = [
            "ranking",
            "range_objects",
            "range_vehicles",
            "precision_recall",
            "reliability",
            "times",
            "stages",
        ];
        let all = [&drawn[..], &["losses_objects", "losses_vehicles"]].concat();
        assert_eq!(names(&page), all);
    }

    #[test]
    fn failures_are_reported_beside_the_verdict() {
        let html = page(&SampleRun { detectors: &["pca", "odd"], n_failed: 3, ..USUAL }).html;
        check_holds(
            &html,
            &[
                "But odd failed at 3 of 12 scans, which count as nothing found.",
                "odd failed at 3 of 12 scans. They count as nothing found. The first was main_road drive/000000: it closed its pipe.",
            ],
        );
        assert!(!page(&USUAL).html.contains("failed"));
    }

    #[test]
    fn names_from_files_are_text_and_never_markup() {
        let hostile = "<script>alert(1)</script>&\"'";
        let page = page(&SampleRun { datasets: &[hostile], detectors: &[hostile], ..USUAL });
        for text in page.figures.iter().map(|it| &it.svg).chain([&page.html]) {
            assert!(!text.contains("<script"), "{text}");
        }
        check_holds(&page.html, &["&lt;script&gt;alert(1)&lt;/script&gt;&amp;"]);
        check_holds(&page.html, &[r"'it'\''s &lt;here&gt;'"]);
    }

    #[test]
    fn nothing_is_loaded_and_no_id_is_given_twice() {
        let html = page(&USUAL).html;
        for part in ["src=", "@import", "href=\"http", "url(", "<script"] {
            assert!(!html.contains(part), "{part}");
        }
        let ids: Vec<&str> =
            html.split(" id=\"").skip(1).map(|it| it.split('"').next().unwrap_or_default()).collect();
        let different: std::collections::BTreeSet<&&str> = ids.iter().collect();
        assert_eq!(ids.len(), different.len(), "{ids:?}");
        for target in html.split("href=\"#").skip(1).map(|it| it.split('"').next().unwrap_or_default()) {
            assert!(ids.contains(&target), "a link leads to {target}, which is nowhere");
        }
    }

    #[test]
    fn what_is_undefined_is_said_to_be() {
        let page = page(&SampleRun { datasets: &["kitti"], ..USUAL });
        check_holds(
            &page.html,
            &[
                "Task objects: hierarchical leads with a recall of 90.0 %",
                "Precision and F-rate are undefined",
                "Annotations that count: 36 within 0–15 m, 24 within 15–30 m,",
                "undefined: not every class of object is annotated",
            ],
        );
        // Recorded scans are not called simulated.
        assert!(!page.html.contains(">simulated<") && !page.html.contains("(simulated)"));
        let of_objects = page.figures.iter().find(|it| it.file_stem == "range_objects").unwrap();
        assert!(!of_objects.svg.contains("precision"));
    }

    #[test]
    fn a_single_detector_needs_no_rival() {
        let html = page(&SampleRun { detectors: &["pca"], ..USUAL }).html;
        check_holds(&html, &["pca has an F-rate of 90.0 %", "pca takes 4.00 ms for a scan (mean)."]);
        assert!(!html.contains("leads with") && !html.contains("× faster"));
    }

    #[test]
    fn nothing_rests_on_times_of_a_busy_machine() {
        let busy = SampleRun { processor_share: 0.6, ..USUAL };
        let page = page(&busy);
        let said = "No statement on speed: the machine was busy, so times are unreliable.";
        check_holds(&page.html, &[said, "250<sup>‖</sup>", "‖ unreliable: the machine was busy."]);
        assert!(!page.html.contains("× faster"), "{}", page.html);
        let verdict = RunFacts::read(busy.write().path()).unwrap().in_short().verdict.join(" ");
        assert!(verdict.contains("Times are unreliable") && !verdict.contains("faster"), "{verdict}");
    }

    #[test]
    fn a_run_without_vehicles_has_no_curves() {
        let page = page(&SampleRun { tasks: &[Task::Objects], ..USUAL });
        assert!(!page.html.contains("#curves") && !page.html.contains("Task vehicles"));
        assert!(!names(&page).contains(&"precision_recall"));
    }

    #[test]
    fn one_block_of_scans_gives_no_interval() {
        let html = page(&SampleRun { n_blocks: 1, ..USUAL }).html;
        check_holds(&html, &["these scans are too few to show which one leads"]);
        assert!(!html.contains("leads with") && !html.contains("95 % interval 8"), "{html}");
    }

    #[test]
    fn intervals_of_few_blocks_are_flagged_in_words_tables_and_pictures() {
        let few = page(&SampleRun { n_blocks: 9, ..USUAL });
        check_holds(
            &few.html,
            &[
                "; 9 blocks of scans are too few to show which one leads.",
                "<sup>§</sup>",
                "§ from fewer than 10 blocks",
                "95 % intervals (bars, from only 9 blocks of scans, too few for conclusions).",
            ],
        );
        assert!(!few.html.contains("leads with"));
        for name in ["ranking", "range_objects", "range_vehicles"] {
            let figure = few.figures.iter().find(|it| it.file_stem == name).unwrap();
            assert!(figure.svg.contains("from only 9 blocks of scans"), "{name}: {}", figure.svg);
        }
        let enough = page(&SampleRun { n_blocks: 10, ..USUAL });
        let text: String =
            enough.figures.iter().map(|it| it.svg.clone()).chain([enough.html.clone()]).collect();
        assert!(!text.contains('§') && !text.contains("from only") && text.contains("leads with"));
    }

    #[test]
    fn several_data_sets_are_summed() {
        let html = page(&SampleRun { datasets: &["north", "south"], ..USUAL }).html;
        check_holds(&html, &["on north", "south", "overall", "above kd-tree"]);
    }

    #[test]
    fn recorded_and_simulated_data_sets_are_separated() {
        let page = page(&SampleRun { datasets: &["north", "kitti", "south"], ..USUAL });
        check_holds(
            &page.html,
            &[
                "Task objects on 2 simulated data sets: hierarchical leads with an F-rate of 90.0 %",
                "Task objects on kitti (recorded): hierarchical leads with a recall of 90.0 %",
                "On 2 simulated data sets: hierarchical takes",
                "On kitti (recorded): hierarchical takes",
                "Task objects, 2 simulated data sets",
            ],
        );
        for name in ["range_objects_simulated", "range_objects_recorded"] {
            assert!(names(&page).contains(&name), "{name}");
        }
    }

    #[test]
    fn published_rows_stand_beside_the_method_of_the_papers_alone() {
        let page_of = |detectors| page(&SampleRun { detectors, ..USUAL }).html;
        let with = page_of(&["hierarchical", "paper"]);
        check_holds(&with, &["published: Budapest #1", "hierarchical grid under paper", "Hollow diamonds"]);
        let without = page_of(&["hierarchical", "kd-tree", "pca"]);
        assert!(!without.contains("published: ") && !without.contains("Hollow diamonds"));
        check_holds(
            &without,
            &["Published numbers of the papers are shown with their own method: -d paper,"],
        );
    }

    #[test]
    fn a_recording_is_linked_where_there_is_one() {
        let folder = USUAL.write();
        assert!(!page_in(folder.path()).html.contains("rerun recording"));
        std::fs::create_dir(folder.path().join("recording")).unwrap();
        let html = page_in(folder.path()).html;
        check_holds(&html, &["href=\"recording\"", "rerun --web-viewer recording"]);
    }

    #[test]
    fn mistakes_lead_to_their_places_in_the_viewer() {
        let folder = USUAL.write();
        assert!(!page_in(folder.path()).html.contains("show it in the viewer"));
        let object = RunFacts::read(folder.path()).unwrap().worst().next().unwrap().1.object.clone();
        let place = RecordedObject { object, recording: "recording-2".to_owned(), step: 7 };
        let viewer = folder.path().join("viewer");
        std::fs::create_dir(&viewer).unwrap();
        std::fs::write(viewer.join("places.json"), Recordings::new(vec![place]).to_json()).unwrap();
        let html = page_in(folder.path()).html;
        check_holds(&html, &["href=\"viewer/index.html#recording=recording-2&amp;scan=7\""]);
    }

    #[test]
    fn the_same_run_gives_the_same_bytes() {
        let folder = USUAL.write();
        let page = page_in(folder.path());
        page.write(folder.path()).unwrap();
        assert_eq!(page_in(folder.path()), page);
        let written = std::fs::read_to_string(folder.path().join(REPORT_HTML)).unwrap();
        assert_eq!(written, page.html);
        for name in ["ranking.svg", "ranking.pdf"] {
            assert!(folder.path().join(FIGURES).join(name).is_file(), "{name}");
        }
    }

    #[test]
    fn a_missing_file_is_an_error_that_names_it() {
        let folder = USUAL.write();
        std::fs::remove_file(folder.path().join(MATCHES_CSV)).unwrap();
        let error = RunFacts::read(folder.path()).unwrap_err();
        assert!(error.to_string().contains(MATCHES_CSV), "{error}");
    }
}
