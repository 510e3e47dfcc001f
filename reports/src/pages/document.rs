//! A page: its title, its sections, and links to these at its top.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::plots::theme::theme_css;

/// A part of a page that a link at its top leads to.
pub(super) struct Section {
    name: String,
    heading: Option<String>,
    content: Markup,
}

impl Section {
    /// A section that links call `name`.
    pub(super) fn new(name: &str, heading: &str, content: Markup) -> Self {
        Self { heading: Some(heading.to_owned()), ..Self::without_heading(name, content) }
    }

    /// A section whose content needs no heading.
    pub(super) fn without_heading(name: &str, content: Markup) -> Self {
        Self { name: name.to_owned(), heading: None, content }
    }

    fn id(&self) -> String {
        self.name.to_lowercase().replace(": ", "-").replace(' ', "-")
    }

    fn markup(&self) -> Markup {
        let Self { name, heading, content } = self;
        let id = self.id();
        html! {
            @if let Some(heading) = heading {
                @let heading_id = format!("{id}-title");
                section id=(id) aria-labelledby=(heading_id) {
                    h2 id=(heading_id) { (heading) }
                    (content)
                }
            } @else {
                section id=(id) aria-label=(name) { (content) }
            }
        }
    }
}

/// The page called `title` in tabs of a browser: `header`, then `sections`.
pub(super) fn document(title: &str, header: &Markup, sections: &[Section]) -> String {
    let css = format!("{}{}", theme_css(":root"), include_str!("page.css"));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                // Nothing is loaded and nothing runs, whatever a name in a file contains.
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { "scanbench: " (title) }
                style { (PreEscaped(css)) }
            }
            body {
                a.skip href="#main" { "Skip to the content" }
                nav aria-label="Sections" {
                    ul { @for it in sections { li { a href={ "#" (it.id()) } { (it.name) } } } }
                }
                main #main tabindex="-1" {
                    header { (header) }
                    @for it in sections { (it.markup()) }
                }
            }
        }
    };
    page.into_string()
}
