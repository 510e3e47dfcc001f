//! The worst mistakes and a few of the best matches, drawn from above.

use std::collections::BTreeSet;

use maud::{Markup, PreEscaped, html};

use super::document::Section;
use super::markup::key;
use crate::facts::gathered_run::Surroundings;
use crate::facts::run_facts::RunFacts;
use crate::facts::seen_boxes::{SeenBox, scan_name};
use crate::plots::scene_plot::{Scene, SceneDetection, scene_keys, scene_plot};
use crate::run_folder::run_directory::VIEWER;
use crate::vocabulary::reason::ShownKind;
use crate::vocabulary::task::Task;
use crate::worst::mistakes::scan_address;
use crate::worst::objects::{MistakeList, WorstObject};
use crate::worst::recorded::RecordedObject;

/// The section of worst mistakes and best matches, and of what one detector alone has where nothing is labelled; `None` if
/// none of them has a position.
pub(super) fn worst(facts: &RunFacts) -> Option<Section> {
    if facts.worst.lists().all(|(_, objects)| objects.is_empty()) {
        return None;
    }
    let tasks: BTreeSet<Task> =
        facts.worst.lists().map(|(list, _)| list.task).filter(|it| it.class().is_none()).collect();
    let lists: Vec<(Task, &str)> =
        tasks.into_iter().flat_map(|task| facts.detectors().into_iter().map(move |it| (task, it))).collect();
    let is_labelled = facts.worst.lists().any(|(list, _)| list.kind != ShownKind::Alone);
    let content = html! {
        p.about {
            @if is_labelled {
                "The missed and false objects with the most points, each object once, and two of the closest matches. "
            } @else {
                "The detections with the most points that no other detector has, each object once. "
            }
            "Forward is up; the wedge at the edge points to the sensor, and a cross (+) is the sensor. "
            "The command below a picture, given in the run directory, opens its scan in the viewer. "
            @if facts.points.is_some() { "Dots are points of the scan: dark above the road, pale on the road." }
        }
        (key(&scene_keys(&facts.detectors(), is_labelled)))
        @if let Some((first, others)) = lists.split_first() {
            (of_detector(facts, *first, true))
            @if !others.is_empty() {
                details.worst {
                    summary { "Other tasks and detectors" }
                    @for it in others { (of_detector(facts, *it, false)) }
                }
            }
        }
    };
    Some(if is_labelled {
        Section::new("Worst", "Worst mistakes and best matches, seen from above", content)
    } else {
        Section::new("Alone", "What one detector alone has, seen from above", content)
    })
}

fn of_detector(facts: &RunFacts, (task, detector): (Task, &str), is_open: bool) -> Markup {
    let lists = ShownKind::ALL.map(|kind| {
        let list = MistakeList { task, detector: detector.to_owned(), kind };
        (kind, facts.worst.of(&list))
    });
    html! {
        @if lists.iter().any(|(_, objects)| !objects.is_empty()) {
            details.worst open[is_open] {
                summary { "Task " (task) ": " (detector) }
                @let label = format!("Mistakes and matches of {detector}, task {task}");
                div.scenes tabindex="0" role="region" aria-label=(label) {
                    @for (kind, objects) in lists {
                        @for worst in objects { (scene(facts, task, detector, kind, worst)) }
                    }
                }
            }
        }
    }
}

fn scene(
    facts: &RunFacts,
    task: Task,
    detector: &str,
    kind: ShownKind,
    worst: &WorstObject<Surroundings>,
) -> Markup {
    let word = kind.name();
    let boxes = facts.boxes.get(&scan_name(worst)).map_or(&[][..], Vec::as_slice);
    let is_near = |it: &&SeenBox| {
        let [x_m, y_m, _] = it.bounding_box.center_m;
        worst.window.holds(x_m, y_m)
    };
    let near = || boxes.iter().filter(is_near);
    let annotations =
        near().filter(|it| it.detector.is_none() && it.task == task).map(|it| it.bounding_box).collect();
    let is_asked = |it: &SeenBox| it.task == task;
    // A detection that counts in another task alone was found, too, and taken for something else.
    let is_elsewhere = |it: &SeenBox| {
        near().any(|other| is_asked(other) && other.detector == it.detector && other.id == it.id)
    };
    let shown = near().filter(|it| it.detector.is_some() && (is_asked(it) || !is_elsewhere(it)));
    let detections = shown.map(|it| SceneDetection {
        detector_idx: facts.detector_idx(it.detector.as_deref().unwrap_or_default()),
        bounding_box: it.bounding_box,
        is_asked: is_asked(it),
    });
    let [x_m, y_m] = worst.window.center_m;
    let range_m = f64::from(x_m).hypot(f64::from(y_m));
    let object = &worst.object;
    let is_simulated = facts.manifest.datasets.iter().any(|it| it.id == object.dataset && it.simulated);
    let label = format!("{word} {} of {detector}, {range_m:.0} m away, seen from above", worst.class);
    let plot = scene_plot(
        &Scene {
            window: worst.window,
            subject: worst.bounding_box,
            cells: facts.points.as_ref().and_then(|it| it.around(object)),
            annotations,
            detections: detections.collect(),
        },
        label,
    );
    html! {
        figure.scene.matched[kind == ShownKind::Matched] {
            (PreEscaped(plot.inline()))
            figcaption {
                strong { @if kind != ShownKind::Alone { (word) " " } (worst.class) } ": " (worst.reason) br;
                (worst.n_points) " points, " (format!("{range_m:.1}")) " m away" br;
                span.where { code { "scanbench view . --at " (scan_address(&object.dataset, &object.sequence, object.scan)) } @if is_simulated { " (simulated)" } }
                @if let Some(RecordedObject { recording, step, .. }) = facts.in_viewer.as_ref().and_then(|it| it.of(object)) {
                    br; a href=(format!("{VIEWER}/index.html#recording={recording}&scan={step}")) target="scanbench-viewer" { "show it in the viewer" }
                }
                @if let Some(recorded) = facts.recordings.as_ref().and_then(|it| it.of(object)) {
                    br; "recorded in " a href=(recorded.recording) { (recorded.recording) } ", at scan " (recorded.step)
                }
            }
        }
    }
}
