//! The page of `scanbench reproduce`: the claims of the papers, judged.

use std::path::Path;

use maud::{Markup, html};

use super::document::document;
use super::markup::{commands, sentences, table, wide_picture};
use crate::files::archive::ArchiveError;
use crate::files::whole_file::write_whole;
use crate::reproduction::claim::Paper;
use crate::reproduction::judged_claim::JudgedClaim;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::studies::claims_table::{ClaimsTable, lead};

/// What the page shows.
pub struct ReproductionPage<'a> {
    /// The scans, in words.
    pub scans: &'a str,
    /// The claims.
    pub claims: &'a [JudgedClaim],
    /// What has to be said of them.
    pub notes: &'a [String],
    /// Tables below the claims, each with the title of its section.
    pub tables: &'a [(&'a str, &'a dyn Tabular)],
    /// The figure of the settings; `None` if there were none.
    pub settings_svg: Option<&'a str>,
    /// The command that made it.
    pub command: &'a str,
}

/// Name of the file.
pub const REPRODUCTION_HTML: &str = "reproduction.html";

impl ReproductionPage<'_> {
    /// The page.
    pub fn html(&self) -> String {
        let claims = ClaimsTable { claims: self.claims, notes: self.notes }.sheet();
        let sections = html! {
            header {
                p.kicker { "scanbench" }
                h1 { "Do the papers' claims hold?" }
                p.facts { (self.scans) }
                @for paper in Paper::ALL { p.facts { (paper.short_name()) ": " (paper.citation()) } }
            }
            section #verdict aria-label="Verdict" {
                div.verdict {
                    p { (lead(self.claims)) }
                    @for it in self.claims {
                        p { strong { (it.verdict.name()) } ": " (it.claim.says) " (" (it.claim.place) ")" }
                    }
                }
            }
            section #claims aria-label="Claims" {
                h2 { "Claim by claim" }
                @for it in self.claims { (claim(it)) }
                (sentences(&claims.notes))
            }
            @for (title, it) in self.tables { (section(&id_of(title), title, &it.sheet())) }
            @if let Some(svg) = self.settings_svg {
                section #settings aria-label="Settings" {
                    h2 { "Under every setting" }
                    (wide_picture("Rates over all settings", svg, &html! {
                        "The median over all joint settings, with the range of nine in ten of them; of rivals the rate under each criterion."
                    }))
                }
            }
            section #reproduce aria-label="Reproduce" {
                h2 { "Reproduce" }
                (commands(self.command, "The command that made this page"))
                p { "The files of the run lie beside this page: report.html, scans.csv, matches.csv, settings.csv." }
            }
        };
        document("the papers' claims", &SECTIONS, &sections).into_string()
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

/// Where the links at the top lead.
const SECTIONS: [(&str, &str); 8] = [
    ("verdict", "Verdict"),
    ("claims", "Claims"),
    ("table-1-of-hg-objects", "Table 1 of HG"),
    ("table-1-of-vm-vehicles", "Table 1 of VM"),
    ("what-the-data-do-objects", "What the data do"),
    ("open-values", "Open values"),
    ("settings", "Settings"),
    ("reproduce", "Reproduce"),
];

fn id_of(title: &str) -> String {
    if title.contains("open") {
        "open-values".to_owned()
    } else {
        title.to_lowercase().replace(": ", "-").replace(' ', "-")
    }
}

/// A claim with all that was seen of it.
fn claim(judged: &JudgedClaim) -> Markup {
    let JudgedClaim { claim, readings, settings, verdict } = judged;
    html! {
        h3 { (claim.says) }
        p {
            strong { (verdict.name()) }
            @if let Some([n_holding, n]) = settings { " · under " (n_holding) " of " (n) " settings" }
            " · " (claim.paper.short_name()) " " (claim.place) " · printed: " (claim.printed)
        }
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

fn section(id: &str, title: &str, sheet: &Sheet) -> Markup {
    html! {
        section id=(id) aria-label=(title) {
            h2 { (title) }
            @for part in &sheet.parts {
                @let label = part.title.as_deref().unwrap_or(title);
                h3 { (label) }
                (table(&part.grid, &sheet.notes, label))
            }
            (sentences(&sheet.notes))
        }
    }
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
            settings_svg: Some(&svg),
            command,
        };
        // Each panel has its position.
        assert!(page.html().contains(&svg) && svg.matches("<svg x=").count() == 2, "{svg}");
        assert!(!ReproductionPage { settings_svg: None, ..page }.html().contains("#settings"));
    }
}
