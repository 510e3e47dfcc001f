//! Where points lie in the frames of labelled boxes.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{Figure, wide_picture};
use crate::facts::run_facts::RunFacts;
use crate::files::new_file::file_stem_of;
use crate::plots::box_points_plot::box_points_plot;

pub(super) fn labels(facts: &RunFacts, files: &mut Vec<Figure>) -> Option<Section> {
    let seen = facts.manifest.datasets.iter().filter_map(|it| Some((&it.id, it.label_points.as_ref()?)));
    let pictures: Vec<Markup> = seen
        .map(|(id, labels)| {
            let title = format!("{id}: points in labelled boxes, from above and from the side");
            let svg = box_points_plot(&[labels.views().into()], &title);
            let picture = wide_picture(&title, &svg, &html! {
                "All " (labels.n_boxes) " boxes of class " (labels.class.name()) " in a few scans of " (id)
                ", laid over one another: the mean box, its front to the right, and the points around it; each shade is half as full as the \
                 next fuller one. From above, points belong along the sides, without those of the ground. From the side, the ground belongs \
                 at the bottom."
            });
            files.push(Figure { file_stem: format!("labels_{}", file_stem_of(id)), svg });
            picture
        })
        .collect();
    (!pictures.is_empty()).then(|| {
        let content = html! {
            details {
                summary { "Points in labelled boxes, from above and from the side" }
                @for picture in &pictures { (picture) }
            }
        };
        Section::new("Labels", "Labels", content)
    })
}
