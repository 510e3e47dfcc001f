//! What is around the sections of a page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::plots::theme::theme_css;

/// A page of `sections`; of `links`, ids and names of sections, those are at its top whose section is there.
pub(super) fn document(title: &str, links: &[(&str, &str)], sections: &Markup) -> Markup {
    let css = format!("{}{}", theme_css(":root"), include_str!("page.css"));
    let content = sections.0.as_str();
    let is_there = |id: &str| content.contains(&format!("<section id=\"{id}\""));
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                // Whatever a name in a file tries: nothing is loaded and nothing runs.
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { "scanbench: " (title) }
                style { (PreEscaped(css)) }
            }
            body {
                a.skip href="#main" { "Skip to the content" }
                nav aria-label="Sections" {
                    ul {
                        @for (id, name) in links.iter().filter(|(id, _)| is_there(id)) {
                            li { a href={ "#" (id) } { (name) } }
                        }
                    }
                }
                main #main tabindex="-1" { (sections) }
            }
        }
    }
}
