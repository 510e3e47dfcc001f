//! The page of `scanbench reproduce`: the claims of the papers, judged.

use std::path::Path;

use maud::{Markup, html};

use super::document::{Section, document};
use super::markup::{commands, sentences, titled_tables, wide_picture};
use crate::files::archive::ArchiveError;
use crate::files::whole_file::write_whole;
use crate::reproduction::claim::Paper;
use crate::reproduction::judged_claim::JudgedClaim;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::studies::claims_table::{ClaimsTable, lead};

/// Content of the page.
pub struct ReproductionPage<'a> {
    /// The scans, in words.
    pub scans: &'a str,
    /// The claims.
    pub claims: &'a [JudgedClaim],
    /// Notes on the claims.
    pub notes: &'a [String],
    /// Tables below the claims, each with the title of its section.
    pub tables: &'a [(&'a str, &'a dyn Tabular)],
    /// Figures below the tables.
    pub figures: &'a [PageFigure<'a>],
    /// The command that made the page.
    pub command: &'a str,
}

/// A figure with a section of its own.
#[derive(Debug, Clone, Copy)]
pub struct PageFigure<'a> {
    /// Title of the section.
    pub title: &'a str,
    /// The document.
    pub svg: &'a str,
    /// Caption of the figure.
    pub about: &'a str,
}

/// Name of the file of the page.
pub const REPRODUCTION_HTML: &str = "reproduction.html";

impl ReproductionPage<'_> {
    /// The page.
    pub fn html(&self) -> String {
        let claims = ClaimsTable { claims: self.claims, notes: self.notes }.sheet();
        let header = html! {
            p.kicker { "scanbench" }
            h1 { "Do the papers' claims hold?" }
            p.facts { (self.scans) }
            @for paper in Paper::ALL { p.facts { (paper.short_name()) ": " (paper.citation()) } }
        };
        let verdict = html! {
            div.verdict {
                p { (lead(self.claims)) }
                @for it in self.claims {
                    p { strong { (it.conclusion()) } ": " (it.claim.says) " (" (it.claim.place) ")" }
                }
            }
        };
        let of_claims = html! {
            @for it in self.claims { (claim(it)) }
            (sentences(&claims.notes))
        };
        let mut sections = vec![
            Section::without_heading("Verdict", verdict),
            Section::new("Claims", "Claim by claim", of_claims),
        ];
        sections.extend(self.tables.iter().map(|(title, it)| section(title, &it.sheet())));
        sections.extend(self.figures.iter().map(|it| {
            Section::new(it.title, it.title, wide_picture(it.title, it.svg, &html! { (it.about) }))
        }));
        let content = html! {
            (commands(self.command, "The command that made this page"))
            p { "The files of the run lie beside this page: report.html, scans.csv, matches.csv, settings.csv." }
        };
        sections.push(Section::new("Reproduce", "Reproduce", content));
        document("the papers' claims", &header, &sections)
    }

    /// Writes the page into `directory`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Write`] if it cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), ArchiveError> {
        write_whole(&directory.join(REPRODUCTION_HTML), self.html().as_bytes())
    }
}

/// A claim with its conclusion, settings and readings.
fn claim(judged: &JudgedClaim) -> Markup {
    let JudgedClaim { claim, readings, settings, .. } = judged;
    html! {
        h3 { (claim.says) }
        p {
            strong { (judged.conclusion()) }
            @if let Some([n_holding, n]) = settings { " · under " (n_holding) " of " (n) " settings" }
            " · " (claim.paper.short_name()) " " (claim.place) " · printed: " (claim.printed)
        }
        @if let Some(rule) = claim.test.rule() { p.about { "It holds if " (rule) "." } }
        ul {
            @for seen in readings {
                li {
                    @if !seen.reading.is_empty() { (seen.reading) ": " }
                    (seen.numbers)
                    @if !seen.difference.is_empty() { " · " (seen.difference) }
                    @match seen.holds {
                        Some(true) => " · holds so",
                        Some(false) => " · does not hold so",
                        None => "",
                    }
                }
            }
        }
    }
}

fn section(title: &str, sheet: &Sheet) -> Section {
    Section::new(title, title, titled_tables(sheet, title))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::ranking_plot::study_plot;

    #[test]
    fn the_figure_of_the_settings_stands_on_the_page_as_it_is_in_its_file() {
        let parts = ["objects", "vehicles"].map(|it| (it.to_owned(), Vec::new()));
        let svg = study_plot("Settings", "F-rate (%)", &parts);
        let (scans, command) = ("12 scans", "scanbench reproduce");
        let page = ReproductionPage {
            scans,
            claims: &[],
            notes: &[],
            tables: &[],
            figures: &[PageFigure { title: "Settings", svg: &svg, about: "All of them." }],
            command,
        };
        // Each panel has its position.
        assert!(page.html().contains(&svg) && svg.matches("<svg x=").count() == 2, "{svg}");
        assert!(!ReproductionPage { figures: &[], ..page }.html().contains("#settings"));
    }
}
