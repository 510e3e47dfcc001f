//! How to make a result again, and how to cite it.

use maud::{Markup, html};

use super::markup::commands;
use crate::run_folder::command_line::shell_word;
use crate::run_folder::manifest::{GitState, Manifest};

/// Provenance of a result: its command, version, time and commit.
pub(super) struct Made<'a> {
    argv: &'a [String],
    version: &'a str,
    created: &'a str,
    git: Option<&'a GitState>,
    /// Further note of a citation.
    note: String,
}

impl<'a> Made<'a> {
    /// Provenance of the result of this manifest.
    pub(super) fn of(it: &'a Manifest) -> Self {
        let Manifest { argv, scanbench_version: version, created, git, scoring_version, partial, .. } = it;
        let note = if partial.is_some() {
            "partial clouds".to_owned()
        } else {
            format!("scoring version {scoring_version}")
        };
        Self { argv, version, created, git: git.as_ref(), note }
    }

    /// The command for the installed program, that for the source, and the entry to cite.
    pub(super) fn markup(&self) -> Markup {
        let arguments: Vec<String> = self.argv.iter().skip(1).map(|it| shell_word(it)).collect();
        let arguments = arguments.join(" ");
        let checkout = self.git.map_or_else(String::new, |it| format!("git checkout {}\n", it.commit));
        html! {
            p { "With scanbench " (self.version) " installed (" code { "scanbench --version" } "):" }
            (commands(&format!("scanbench {arguments}"), "The command that repeats it"))
            details {
                summary { "From the source" }
                (commands(&format!("{checkout}cargo run --release -- {arguments}"), "The same in a checkout"))
            }
            details {
                summary { "Cite it" }
                p { "Put the address of your copy of the program in." }
                (commands(&self.bibtex(), "An entry for BibTeX"))
            }
        }
    }

    fn bibtex(&self) -> String {
        let Self { version, note, .. } = self;
        let date = self.created.split('T').next().unwrap_or_default();
        let year = date.split('-').next().unwrap_or_default();
        let commit = self.git.map_or_else(String::new, |it| format!(", commit {}", it.commit));
        format!(
            "@software{{scanbench,
  author  = {{{{The scanbench developers}}}},
  title   = {{scanbench: evaluation and benchmarking of {{LiDAR}} object detection}},
  version = {{{version}}},
  year    = {{{year}}},
  url     = {{https://HOST/OWNER/scanbench}},
  urldate = {{{date}}},
  note    = {{{note}{commit}}}
}}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::run_folder::manifest::tests::partial_manifest;

    #[test]
    fn whoever_has_the_program_can_repeat_and_cite_it() {
        let mut manifest = partial_manifest();
        manifest.git = Some(GitState { commit: "f00d".to_owned(), dirty: false });
        let made = Made::of(&manifest);
        let text = made.markup().into_string();
        let command = "<code>scanbench partial 'it'\\''s &lt;here&gt;'</code>";
        assert!(text.contains(command) && text.contains("git checkout f00d"), "{text}");
        let bibtex = made.bibtex();
        let parts = ["version = {0.1.0}", "urldate = {2026-01-01}", "year    = {2026}", "commit f00d}"];
        check_holds(&bibtex, &parts);
    }
}
